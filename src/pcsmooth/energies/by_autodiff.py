"""Any energy of a union, with gradients by automatic differentiation of the reference."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from pcsmooth.autodiff.cell_edges import intersection_edges, restricted_cell_edges
from pcsmooth.autodiff.derivatives import Derivatives, differentiate
from pcsmooth.autodiff.shape import Shape, ball_shape
from pcsmooth.autodiff.visible_edges import visible_edges
from pcsmooth.energies.balls import BallEnergy
from pcsmooth.energies.local_reach import LocalReach
from pcsmooth.energies.polyhedra.alpha_complex import find_simplices
from pcsmooth.energies.polyhedra.union import PolyhedronEnergy
from pcsmooth.energies.protocol import Evaluation, UnionMeasures
from pcsmooth.energies.weighting import weigh
from pcsmooth.errors import InvalidInputError

LARGEST_CLOUD = 1000
"""Most distinct points that are differentiated automatically: a matter of minutes for a flow."""


@dataclass(frozen=True)
class AutodiffUnion:
    """Measures of a union by the reference, and their gradients by dual numbers.

    Attributes
    ----------
    analytic : UnionMeasures
        The same union measured by the kernels, of which the step size and the carriers of
        positions are taken.
    union : Derivatives
        Of the distinct points.
    cells : Derivatives
        Of their restricted cells; the same for balls and naive unions.
    """

    analytic: UnionMeasures
    union: Derivatives
    cells: Derivatives

    @property
    def radius(self) -> float:
        """Radius of the shapes, L."""
        return self.analytic.radius

    @property
    def radii(self) -> npt.NDArray[np.float64] | None:
        """Radius of each shape, (n,), L, if they are unequal."""
        return self.analytic.radii

    @property
    def carriers(self) -> npt.NDArray[np.int64]:
        """Number of the point that carries the measures of each point's position, (n,)."""
        return self.analytic.carriers

    @property
    def volume(self) -> float:
        """Volume of the union, L^d."""
        return float(self.union.volumes.sum())

    @property
    def area(self) -> float:
        """Measure of its boundary, L^(d-1)."""
        return float(self.union.areas.sum())

    @property
    def volume_shares(self) -> npt.NDArray[np.float64]:
        """Volumes that add up to that of the union, (n,), L^d."""
        return self.analytic.volume_shares

    @cached_property
    def cell_volumes(self) -> npt.NDArray[np.float64]:
        """Volume of each restricted cell, (n,), L^d."""
        return self._spread(self.cells.volumes)

    @cached_property
    def visible_areas(self) -> npt.NDArray[np.float64]:
        """Measure of the visible boundary of each point, (n,), L^(d-1)."""
        return self._spread(self.union.areas)

    @cached_property
    def volume_gradient(self) -> npt.NDArray[np.float64]:
        """Gradient of the volume, (n, d), L^(d-1)."""
        return self._spread(self.union.volume_gradient)

    @cached_property
    def area_gradient(self) -> npt.NDArray[np.float64]:
        """Gradient of the boundary's measure, (n, d), L^(d-2)."""
        return self._spread(self.union.area_gradient)

    @property
    def volume_diagonal(self) -> npt.NDArray[np.float64]:
        """Stiffness of the volume, (n,): see `Evaluation.diagonal`."""
        return self.analytic.volume_diagonal

    @property
    def area_diagonal(self) -> npt.NDArray[np.float64]:
        """Stiffness of the boundary's measure, (n,)."""
        return self.analytic.area_diagonal

    def _spread(self, values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        spread = np.zeros((len(self.carriers), *values.shape[1:]))
        spread[self.carriers == np.arange(len(spread))] = values
        return spread


@dataclass(frozen=True)
class AutodiffEnergy:
    """An energy as the thesis computes it: from its value alone, by automatic differentiation.

    It is the energy of balls or polyhedra that it is made of, measured by a reference of its own
    that is slow and short; the gradients agree but for rounding.

    Attributes
    ----------
    energy : BallEnergy or PolyhedronEnergy
        The energy.
    """

    energy: BallEnergy | PolyhedronEnergy

    local: ClassVar[None] = None

    @property
    def radius(self) -> float:
        """Radius of the shapes, L."""
        return self.energy.radius

    def reach(self, dimension: int) -> float | LocalReach:
        """How far it looks from a point, L: as far as the energy."""
        return self.energy.reach(dimension)

    def evaluate(
        self, points: npt.NDArray[np.float64], box: npt.NDArray[np.float64] | None = None
    ) -> Evaluation:
        """Evaluate the energy at finite points, shape (n, d), n >= 1 (see `Energy`).

        Raises
        ------
        InvalidInputError
            If there are more than `LARGEST_CLOUD` distinct points.
        """
        analytic = self.energy.evaluate(points, box).union
        distinct = points[analytic.carriers == np.arange(len(points))]
        if len(distinct) > LARGEST_CLOUD:
            raise InvalidInputError(
                f"there are {len(distinct)} distinct points, and gradients by automatic "
                f"differentiation are for {LARGEST_CLOUD} at most; take analytic gradients, which "
                "are the same"
            )
        union, cells = _differentiated(self.energy, distinct)
        return weigh(
            AutodiffUnion(analytic, union, cells), self.energy.quantity, self.energy.weight
        )


def _differentiated(
    energy: BallEnergy | PolyhedronEnergy, points: npt.NDArray[np.float64]
) -> tuple[Derivatives, Derivatives]:
    """Differentiate the union, and the restricted cells, which may be the same."""
    if isinstance(energy, BallEnergy):
        shape = ball_shape(energy.radius, points.shape[1])
    else:
        shape = Shape(energy.body.normals, energy.body.offsets * energy.radius)
    cells = differentiate(points, shape, restricted_cell_edges(points, shape))
    if isinstance(energy, BallEnergy) or energy.union == "naive":
        return cells, cells
    if energy.union == "exact":
        return differentiate(points, shape, visible_edges(points, shape)), cells
    simplices = [(point,) for point in range(len(points))]
    for found in find_simplices(points, energy.radius):
        simplices += map(tuple, found.tolist())
    return differentiate(points, shape, intersection_edges(points, shape, simplices)), cells
