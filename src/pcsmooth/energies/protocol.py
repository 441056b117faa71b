"""What every energy offers to the flow, whatever the shapes whose union it measures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.local_reach import LocalReach
from pcsmooth.neighbors.local_radii import LocalRadii

Quantity = Literal["volume", "area"]
Weight = Literal["none", "cell", "boundary"]

#: How the union of polyhedra is computed.
UnionName = Literal["naive", "inclusion-exclusion", "exact"]

#: How gradients are found.
GradientName = Literal["analytic", "autodiff"]


class UnionMeasures(Protocol):
    """Measures of a union of shapes centred on n points in d dimensions."""

    @property
    def radius(self) -> float:
        """Radius of the shapes, L; the largest if they are unequal."""

    @property
    def radii(self) -> npt.NDArray[np.float64] | None:
        """Radius of each shape, (n,), L, if they are unequal."""

    @property
    def volume(self) -> float:
        """Volume of the union, L^d."""

    @property
    def area(self) -> float:
        """Measure of its boundary, L^(d-1)."""

    @property
    def volume_shares(self) -> npt.NDArray[np.float64]:
        """What the points add to the volume, (n,), L^d; only the sum has a meaning."""

    @property
    def cell_volumes(self) -> npt.NDArray[np.float64]:
        """Volume of each restricted cell, (n,), L^d."""

    @property
    def visible_areas(self) -> npt.NDArray[np.float64]:
        """Measure of the visible boundary of each point, (n,), L^(d-1)."""

    @property
    def volume_gradient(self) -> npt.NDArray[np.float64]:
        """Gradient of the volume, (n, d), L^(d-1)."""

    @property
    def area_gradient(self) -> npt.NDArray[np.float64]:
        """Gradient of the boundary's measure, (n, d), L^(d-2)."""

    @property
    def volume_diagonal(self) -> npt.NDArray[np.float64]:
        """Stiffness of the volume, (n,), L^(d-2): see `Evaluation.diagonal`."""

    @property
    def area_diagonal(self) -> npt.NDArray[np.float64]:
        """Stiffness of the boundary's measure, (n,), L^(d-3)."""

    @property
    def carriers(self) -> npt.NDArray[np.int64]:
        """Number of the point that carries the measures of each point's position, (n,)."""


@dataclass(frozen=True)
class Evaluation:
    """An energy at one cloud.

    Attributes
    ----------
    union : UnionMeasures
        The measures behind it.
    value : float
        The energy.
    gradient : ndarray, shape (n, d)
        Its gradient; zero for points that do not carry their position.
    diagonal : ndarray, shape (n,)
        Stiffness: what the gradient of each point is divided by at least in an automatic step. If
        the gradient is a weighted graph Laplacian, gradient_i = sum_j w_ij (p_i - p_j), it is the
        sum of the weights.
    masses : ndarray, shape (n,)
        What the gradient of each point is divided by; where it is 0 the point rests.
    quantity : {"volume", "area"}
        Whose gradient it is.
    weight : {"none", "cell", "boundary"}
        What the masses are (see `weigh`).
    paces : ndarray, shape (n,), or 1.0
        How many times faster time goes for each point, by which the masses have been divided.
    """

    union: UnionMeasures
    value: float
    gradient: npt.NDArray[np.float64]
    diagonal: npt.NDArray[np.float64]
    masses: npt.NDArray[np.float64]
    quantity: Quantity
    weight: Weight
    paces: npt.NDArray[np.float64] | float = 1.0


class Energy(Protocol):
    """A function of a cloud that a flow can decrease."""

    @property
    def radius(self) -> float:
        """Radius of the shapes, L; the median of local ones."""

    @property
    def local(self) -> LocalRadii | None:
        """Radii of the shapes, if each has its own."""

    def reach(self, dimension: int) -> float | LocalReach:
        """How far what it is at a point may depend on other points, along an axis, L.

        In so many dimensions.
        """

    def evaluate(
        self, points: npt.NDArray[np.float64], box: npt.NDArray[np.float64] | None = None
    ) -> Evaluation:
        """Evaluate the energy at finite points.

        Parameters
        ----------
        points : ndarray, shape (n, d)
            Finite positions, L, n >= 1.
        box : ndarray, shape (2, d), optional
            Bounding box of the whole cloud, L, if the points are a part of one. Measures of
            points that have all the others around them are then those of the whole cloud.
        """
