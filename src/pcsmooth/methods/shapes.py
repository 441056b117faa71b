"""The shapes around the points, whose union is measured."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, get_args

from pcsmooth.energies.balls import BallEnergy
from pcsmooth.energies.protocol import Energy, GradientName, Quantity, UnionName, Weight
from pcsmooth.errors import InvalidInputError
from pcsmooth.lengths import check_radius, local_multiple
from pcsmooth.methods.checks import check_word
from pcsmooth.neighbors.local_radii import LocalRadii

if TYPE_CHECKING:
    from pcsmooth.bodies.convex_body import ConvexBody
    from pcsmooth.energies.polyhedra.union import PolyhedronEnergy


@dataclass(frozen=True, kw_only=True)
class Balls:
    """Balls around the points, and what of their union a flow decreases.

    Attributes
    ----------
    radius : float or str
        Of the balls: a length, ``"3x"`` the spacing, ``"2%"`` of the bounding box's diagonal,
        ``"auto"``, twice the spacing, or for each ball its own: ``"local"``, twice the local
        spacing at the start (see `local_spacings`), ``"local:3x"`` three times. Of the
        filter ``"auto"`` is ``"local"`` where that radius is too small for much of a surface.
    quantity : {"volume", "area"}
        Volume of the union, or measure of its boundary (2D: area, perimeter).
    weight : {"none", "cell", "boundary"}
        What each point's gradient is divided by (see `weigh`).
    gradient : {"analytic", "autodiff"}
        Gradients in closed form, or by automatic differentiation of a slow reference, for at most
        `LARGEST_CLOUD` points; they agree but for rounding.

    Raises
    ------
    InvalidInputError
        A value is none of these, or radii are local and gradients found by automatic
        differentiation.
    """

    radius: float | str = "auto"
    quantity: Quantity = "volume"
    weight: Weight = "cell"
    gradient: GradientName = "analytic"

    def __post_init__(self) -> None:
        """Check the values."""
        check_word("energy", self.quantity, get_args(Quantity))
        check_word("weight", self.weight, get_args(Weight))
        check_word("gradient", self.gradient, get_args(GradientName))
        check_radius(self.radius)
        if self.is_local and self.gradient == "autodiff":
            raise InvalidInputError(
                f"gradient is 'autodiff', which is for shapes of one radius, and the radius is "
                f"{self.radius!r}; choose analytic gradients or another radius"
            )

    @property
    def is_local(self) -> bool:
        """Whether each shape has a radius of its own."""
        return local_multiple(self.radius) is not None

    @property
    def whole_cloud_for(self) -> str:
        """Name what of them needs the whole cloud; nothing if they can be measured in parts."""
        return "automatic differentiation" if self.gradient == "autodiff" else ""

    def energy(self, radius: float, local: LocalRadii | None = None) -> Energy:
        """Make the energy of shapes of a radius, L, or that each have their own."""
        energy = self._in_closed_form(radius, local)
        if self.gradient == "analytic":
            return energy

        from pcsmooth.energies.by_autodiff import AutodiffEnergy

        return AutodiffEnergy(energy)

    def largest_mass(self, radius: float, dimension: int) -> float:
        """Give what no cell of a shape of a radius, L, can be larger than, as a mass.

        In so many dimensions: see `weigh`.
        """
        size = radius * max(1.0, self._circumradius)
        volume = (math.pi if dimension == 2 else 4.0 / 3.0 * math.pi) * size**dimension
        return volume / radius if self.quantity == "area" else volume

    @property
    def _circumradius(self) -> float:
        return 1.0

    def _in_closed_form(
        self, radius: float, local: LocalRadii | None
    ) -> BallEnergy | PolyhedronEnergy:
        return BallEnergy(radius, self.quantity, self.weight, local)


@dataclass(frozen=True, kw_only=True)
class Polyhedra(Balls):
    """Convex polyhedra in place of the balls: a flow turns the surface towards their facets.

    Attributes
    ----------
    body : ConvexBody
        The shape K of radius 1, in d dimensions; the shapes are p_i + radius K.
    union : {"naive", "inclusion-exclusion", "exact"}
        How their union is computed (see `measure_polyhedra`).
    radius, quantity, weight, gradient
        As those of `Balls`.
    """

    body: ConvexBody
    union: UnionName = "exact"

    def __post_init__(self) -> None:
        """Check the values."""
        super().__post_init__()
        check_word("union", self.union, get_args(UnionName))

    @property
    def whole_cloud_for(self) -> str:
        """Name what of them needs the whole cloud; nothing if they can be measured in parts."""
        return "a local radius of polyhedra" if self.is_local else super().whole_cloud_for

    @property
    def _circumradius(self) -> float:
        return self.body.circumradius

    def _in_closed_form(
        self, radius: float, local: LocalRadii | None
    ) -> BallEnergy | PolyhedronEnergy:
        from pcsmooth.energies.polyhedra.union import PolyhedronEnergy

        return PolyhedronEnergy(radius, self.body, self.union, self.quantity, self.weight, local)
