"""The union of balls (disks in 2D): its measures, and the energies made of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.cell_reach import cell_reach
from pcsmooth.energies.centers import Centers, place_centers
from pcsmooth.energies.local_reach import LocalReach
from pcsmooth.energies.protocol import Evaluation, Quantity, Weight
from pcsmooth.energies.unequal_radii import unequal_radii
from pcsmooth.energies.weighting import weigh_at_own_pace
from pcsmooth.kernels.balls import facet_booking as columns
from pcsmooth.kernels.balls.restricted_cells import measure_restricted_cells
from pcsmooth.neighbors.grid import Grid, cube_starts
from pcsmooth.neighbors.local_radii import LocalRadii, UnequalRadii
from pcsmooth.unit_of_length import unit_near


@dataclass(frozen=True)
class BallUnion:
    """Measures of a union of balls in d = 2 or 3 dimensions, and their gradients.

    In 2D read area for volume and length for area. Of coincident points the first carries the
    cell, if radii differ the first of the largest; the measures and gradients of the others are 0.

    Attributes
    ----------
    radius : float
        Radius of the balls, L; the largest if they are unequal.
    carriers : ndarray of int, shape (n,)
        Number of the point that carries the cell at the same position.
    measures : ndarray, shape (n, N_MEASURES)
        What the kernel returns, by the columns of `pcsmooth.kernels.balls.facet_booking`.
    dimension : int
        d.
    grid : Grid
        The distinct positions in cells not smaller than the diameter, numbered among themselves.
    radii : ndarray, shape (n,), optional
        Radius of each ball, L, if they are unequal; the gradients are those at fixed radii.
    """

    radius: float
    carriers: npt.NDArray[np.int64]
    measures: npt.NDArray[np.float64]
    dimension: int
    grid: Grid
    radii: npt.NDArray[np.float64] | None = None

    @cached_property
    def volume(self) -> float:
        """Volume of the union, L^d."""
        return float(self.volume_shares.sum())

    @cached_property
    def area(self) -> float:
        """Measure of the boundary of the union, L^(d-1)."""
        return float(self.visible_areas.sum())

    @cached_property
    def numbers(self) -> npt.NDArray[np.int64]:
        """Numbers of the points that carry a cell, in the order of the grid."""
        if len(self.grid.order) == len(self.carriers):
            return self.grid.order
        return np.flatnonzero(self.carriers == np.arange(len(self.carriers)))[self.grid.order]

    @cached_property
    def grid_radii(self) -> npt.NDArray[np.float64] | None:
        """Unequal radii of the points that carry a cell, in the order of the grid."""
        return None if self.radii is None else self.radii[self.numbers]

    @property
    def grid_reaches(self) -> npt.NDArray[np.float64]:
        """Distance from these points at which equal balls touch theirs; (1,) if radii are equal."""
        radii = self.grid_radii
        return np.array([2.0 * self.radius]) if radii is None else 2.0 * radii

    @property
    def volume_shares(self) -> npt.NDArray[np.float64]:
        """Volumes that add up to that of the union, those of the cells, (n,), L^d."""
        return self.cell_volumes

    @property
    def cell_volumes(self) -> npt.NDArray[np.float64]:
        """Volume of each restricted cell V_i and B(p_i, r), (n,), L^d."""
        return self.measures[:, columns.CELL_VOLUME]

    @property
    def visible_areas(self) -> npt.NDArray[np.float64]:
        """Measure of the part of each sphere that is on the union's boundary, (n,), L^(d-1)."""
        return self.measures[:, columns.VISIBLE_AREA]

    @property
    def volume_gradient(self) -> npt.NDArray[np.float64]:
        """Gradient of the volume, (n, d), L^(d-1)."""
        return self.measures[:, columns.VOLUME_GRADIENT : columns.VOLUME_GRADIENT + self.dimension]

    @property
    def area_gradient(self) -> npt.NDArray[np.float64]:
        """Gradient of the boundary's measure, (n, d), L^(d-2)."""
        return self.measures[:, columns.AREA_GRADIENT : columns.AREA_GRADIENT + self.dimension]

    @property
    def tensor_entries(self) -> npt.NDArray[np.float64]:
        """Upper triangles of the normal tensors, (n, 6): xx, xy, xz, yy, yz, zz."""
        return self.measures[:, columns.NORMAL_TENSOR : columns.NORMAL_TENSOR + 6]

    @property
    def normal_tensors(self) -> npt.NDArray[np.float64]:
        """Integral of n n^T over each point's visible boundary, (n, d, d), L^(d-1)."""
        full = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]]) + columns.NORMAL_TENSOR
        return self.measures[:, full[: self.dimension, : self.dimension]]

    @property
    def volume_diagonal(self) -> npt.NDArray[np.float64]:
        """Sum over the facets of area / distance, (n,): see `Evaluation.diagonal`."""
        return self.measures[:, columns.VOLUME_DIAGONAL]

    @property
    def area_diagonal(self) -> npt.NDArray[np.float64]:
        """Sum over the facets of the area gradient's weights, (n,)."""
        return self.measures[:, columns.AREA_DIAGONAL]


def measure_balls(
    points: npt.ArrayLike, radius: npt.ArrayLike, box: npt.NDArray[np.float64] | None = None
) -> BallUnion:
    """Measure the union of balls centred on points, and its first variation.

    Parameters
    ----------
    points : array_like of float, shape (n, 2) or (n, 3)
        Centres, L; n >= 1, finite.
    radius : float or array_like of float, shape (n,)
        Common radius, or radius of each ball, L; finite and > 0.
    box : ndarray, shape (2, d), optional
        Bounding box of the whole cloud, L, if the points are a part of one.

    Returns
    -------
    BallUnion
        volume and area of the union, cell_volumes and visible_areas (n,), volume_gradient and
        area_gradient (n, d), normal_tensors (n, d, d).

    Raises
    ------
    InvalidInputError
        If the points have another shape, there are none, a coordinate is not finite (the first
        such row is named), or a radius is not finite and positive, or there are not as many as
        points.

    Notes
    -----
    A point of space belongs to the cell of the ball for which it has the least power,
    abs(x - p_i)^2 - r_i^2: if radii are equal, of the nearest centre. With facets F_ij of measure
    A_ij at the signed height h_ij over p_i, seen from there under the signed solid angle Omega_ij,
    and u the unit vector from p_i to p_j::

        h_ij = (d^2 + r_i^2 - r_j^2) / (2 d)          (d: distance of p_i and p_j)
        S_i = r_i^(d-1) (full angle - sum_j Omega_ij) (0 in its place if some h_ij < 0)
        |C_i| = (r_i S_i + sum_j h_ij A_ij) / d
        volume_gradient_i = -sum_j A_ij u             (report, Prop. 5)
        area_gradient_i = -sum_j (r_i h_ji + r_j h_ij) / d phi_ij u + (r_j - r_i) / d s_ij
        normal_tensor_i = (|C_i| I - sum_j A_ij u (x) c_ij) / r_i

    phi_ij is the visible angle of F_ij's circle, and s_ij the integral over it of the vector to
    its middle. If radii are equal, the area's gradient is -r sum_j phi_ij u.

    Only points nearer than the sum of the radii matter to a cell, so time and memory grow linearly
    with n.

    Examples
    --------
    >>> union = measure_balls([[0, 0, 0], [1, 0, 0]], radius=1.0)
    >>> bool(np.isclose(union.volume, 9 * np.pi / 4))
    True
    >>> bool(np.isclose(union.visible_areas[0], 3 * np.pi))
    True
    >>> union = measure_balls([[0, 0, 0], [1, 0, 0]], radius=[1.0, 0.5])
    >>> bool(np.isclose(union.visible_areas[0], 3.75 * np.pi))
    True
    """
    radii = unequal_radii(points, radius)
    return _measure(points, float(np.max(radius)), radii, box)


def measure_balls_in_part(
    points: npt.NDArray[np.float64], radii: UnequalRadii, box: npt.NDArray[np.float64] | None
) -> BallUnion:
    """Measure the union of balls of a part of a cloud: see `measure_balls`.

    They are measured as unequal ones if any of the cloud are.
    """
    return _measure(points, radii.largest, radii if radii.least < radii.largest else None, box)


def _measure(
    points: npt.ArrayLike,
    largest: float,
    radii: UnequalRadii | None,
    box: npt.NDArray[np.float64] | None,
) -> BallUnion:
    """Measure balls whose radii have been checked: the largest one, or their own if given."""
    unit = unit_near(largest)
    centers = place_centers(points, largest, reach=largest, radii=radii, unit=unit, box=box)
    grid, distinct = centers.grid, centers.distinct
    measures = np.empty((len(distinct), columns.N_MEASURES))
    measure_restricted_cells(
        grid.coordinates,
        grid.order,
        grid.cells,
        cube_starts(grid, centers.dimension, are_unequal=radii is not None),
        centers.dimension,
        largest / unit,
        None if radii is None else radii.values[distinct][grid.order] / unit,
        measures,
    )
    if unit != 1.0:
        measures *= unit ** _powers_of_length(centers.dimension)
        grid = replace(grid, coordinates=grid.coordinates * unit)
    return BallUnion(
        largest, centers.carriers, centers.spread(measures), centers.dimension, grid,
        None if radii is None else radii.values,
    )  # fmt: skip


def centers_of(union: BallUnion) -> Centers:
    """Give the centres of a union, as `place_centers` sorts them."""
    carriers = union.carriers
    distinct = np.flatnonzero(carriers == np.arange(len(carriers)))
    return Centers(union.grid, carriers, distinct, union.dimension)


def _powers_of_length(dimension: int) -> npt.NDArray[np.float64]:
    """Powers of length in the columns of the measures, (N_MEASURES,)."""
    powers = np.full(columns.N_MEASURES, dimension - 1.0)
    powers[columns.CELL_VOLUME] = dimension
    powers[columns.AREA_GRADIENT : columns.AREA_GRADIENT + 3] = dimension - 2
    powers[columns.VOLUME_DIAGONAL] = dimension - 2
    powers[columns.AREA_DIAGONAL] = dimension - 3
    return powers


@dataclass(frozen=True)
class BallEnergy:
    """Volume of a union of balls or measure of its boundary, plain or weighted.

    Attributes
    ----------
    radius : float
        Radius of the balls, L; the median of local ones.
    quantity : {"volume", "area"}
        What is measured; in 2D area and perimeter.
    weight : {"none", "cell", "boundary"}
        What the gradients are divided by (see `weigh`). The weighted flows move by mean curvature
        in units of time L^2.
    local : LocalRadii, optional
        Radii of the balls around all points, if each has its own.

    Notes
    -----
    Local radii do not change when points move: gradients are those at fixed radii. Each ball then
    has a time of its own, so that a step smooths over as many local spacings everywhere: where the
    radius is r_i it is (r_i / radius)^2 times as long (not weighted, the power that time has of
    length in place of 2), by which the masses are divided.
    """

    radius: float
    quantity: Quantity = "volume"
    weight: Weight = "cell"
    local: LocalRadii | None = None

    def reach(self, dimension: int) -> float | LocalReach:
        """How far it looks from a point, L: as far as the cells do.

        If radii are local, as far as normals from cells and links between them, too.
        """
        if self.local is not None:
            return LocalReach(self.local, dimension)
        return cell_reach(self.radius, dimension)

    def evaluate(
        self, points: npt.NDArray[np.float64], box: npt.NDArray[np.float64] | None = None
    ) -> Evaluation:
        """Evaluate the energy at finite points, shape (n, d), n >= 1 (see `Energy`).

        If radii are local, at all points of a cloud in memory.
        """
        radius = self.radius if self.local is None else self.local.values
        return self.of_union(measure_balls(points, radius, box))

    def of_union(self, union: BallUnion) -> Evaluation:
        """Evaluate the energy of a union of these balls that has been measured."""
        return weigh_at_own_pace(union, self.quantity, self.weight, self.radius)
