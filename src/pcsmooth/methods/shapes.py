"""The shapes around the points, whose union is measured."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, get_args

from pcsmooth.energies.balls import BallEnergy
from pcsmooth.energies.protocol import Energy, GradientName, Quantity, UnionName, Weight
from pcsmooth.lengths import check_radius
from pcsmooth.methods.checks import check_word

if TYPE_CHECKING:
    from pcsmooth.bodies.convex_body import ConvexBody
    from pcsmooth.energies.polyhedra.union import PolyhedronEnergy


@dataclass(frozen=True, kw_only=True)
class Balls:
    """Balls around the points, and what of their union a flow decreases.

    Attributes
    ----------
    radius : float or str
        Of the balls: a length, ``"3x"`` the spacing, ``"2%"`` of the bounding box's diagonal, or
        ``"auto"``, twice the spacing.
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
        A value is none of these.
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

    def energy(self, radius: float) -> Energy:
        """Make the energy of shapes of a radius, L."""
        energy = self._in_closed_form(radius)
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

    def _in_closed_form(self, radius: float) -> BallEnergy | PolyhedronEnergy:
        return BallEnergy(radius, self.quantity, self.weight)


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
    def _circumradius(self) -> float:
        return self.body.circumradius

    def _in_closed_form(self, radius: float) -> BallEnergy | PolyhedronEnergy:
        from pcsmooth.energies.polyhedra.union import PolyhedronEnergy

        return PolyhedronEnergy(radius, self.body, self.union, self.quantity, self.weight)
