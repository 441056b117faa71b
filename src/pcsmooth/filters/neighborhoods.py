"""Neighbourhoods wide enough for the noise, with their planes, and means over them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.neighbor_lists import MOST_KEPT, NOT_KEPT, NeighborLists
from pcsmooth.filters.scales import Scales, lattice_spacing
from pcsmooth.kernels.surface.neighborhood_means import (
    ALONG_NORMAL,
    HEIGHT,
    NORMAL,
    NUMBER_OF,
    neighborhood_means,
)
from pcsmooth.kernels.surface.neighborhood_planes import fit_planes
from pcsmooth.neighbors.grid import Grid, build_grid, levels_of

_Value = TypeVar("_Value", bound=np.generic)

_NO_VALUES = np.empty(0)


@dataclass(frozen=True)
class Width:
    """How wide neighbourhoods are.

    The radius R of N points is the least for which N (1 - (thickness / R)^(d - 1)) >= count.
    Without noise that makes `count` points. A sheet of points as thick as the noise needs a
    radius of a few times the noise, however many points that takes.

    Attributes
    ----------
    count : float
        Points, >= 1.
    deviations : float
        Thickness in units of the noise.
    thickness : float
        The same of the cloud's noise, L.
    max_radius : float
        Most that a radius can be, L, in a cloud of one noise and spacing.
    slack : float
        In others, how much larger than expected a radius can be, as a factor.
    cell_size : float
        Of the least cells that points are sorted into in such a cloud, L: the same in all parts.
    """

    count: float
    deviations: float
    thickness: float
    max_radius: float
    slack: float
    cell_size: float

    def radii(self, scales: Scales, dimension: int) -> Radii:
        """Bound the radii at points by the noise and the spacing there."""
        thickness = self.deviations * scales.noise
        if dimension == 2:
            expected = thickness + 0.5 * self.count * scales.spacing
        else:
            expected = np.hypot(thickness, math.sqrt(self.count / math.pi) * scales.spacing)
        return Radii(thickness, scales.cover, self.slack * np.maximum(expected, scales.cover))

    def radii_of_all(self, count: int) -> Radii:
        """Bound the radii at so many points of a cloud of one noise and spacing."""
        return Radii(*(np.full(count, length) for length in (self.thickness, 0.0, self.max_radius)))

    def scaled(self, factor: float) -> Width:
        """Return the same of a cloud times a factor."""
        lengths = (self.thickness, self.max_radius, self.cell_size)
        thickness, max_radius, cell_size = (length * factor for length in lengths)
        return replace(self, thickness=thickness, max_radius=max_radius, cell_size=cell_size)


@dataclass(frozen=True)
class Radii:
    """Bounds of the radii of neighbourhoods.

    Attributes
    ----------
    thickness, least, most : ndarray, shape (n,)
        Thickness of the sheet of points (see `Width`), least and largest radius, L.
    """

    thickness: npt.NDArray[np.float64]
    least: npt.NDArray[np.float64]
    most: npt.NDArray[np.float64]


@dataclass(frozen=True)
class Heights:
    """Heights of the neighbours over the tangent plane of each point, in grid order.

    Attributes
    ----------
    means : ndarray, shape (n,)
        L.
    variances : ndarray, shape (n,)
        About these means, L^2.
    """

    means: npt.NDArray[np.float64]
    variances: npt.NDArray[np.float64]


@dataclass(frozen=True)
class Neighborhoods:
    """The neighbourhoods of all points of a cloud, in grid order.

    Attributes
    ----------
    grid : Grid
        The points.
    dimension : int
        d.
    normals : ndarray, shape (3, n)
        Unit normals of the planes, of either sign; 0 where there is none.
    squares : ndarray, shape (n,)
        Squared radii, L^2.
    sizes : ndarray, shape (n,)
        Points in them, the point itself included.
    offsets : ndarray, shape (n,)
        Distance of a point from the centroid of its neighbourhood, in units of the radius: 0.42
        on the straight border of a surface, 0.5 at the end of a curve, and near 0 within.
    farthest : ndarray, shape (n,)
        How far each point may look in the grid, L.
    lists : NeighborLists
        Who is in them, if that is kept.
    one_sided : bool
        Whether normals show outwards, and points that show the other way do not count in means.
    """

    grid: Grid
    dimension: int
    normals: npt.NDArray[np.float64]
    squares: npt.NDArray[np.float64]
    sizes: npt.NDArray[np.float64]
    offsets: npt.NDArray[np.float64]
    farthest: npt.NDArray[np.float64]
    lists: NeighborLists
    one_sided: bool = False

    def spacings(self) -> npt.NDArray[np.float64]:
        """Spacing of the points around each point as if on a square lattice, (n,), L."""
        return lattice_spacing(np.sqrt(self.squares), self.sizes, self.dimension)

    def in_order(self, values: npt.NDArray[_Value]) -> npt.NDArray[_Value]:
        """Values (n,) in the order of the points instead of that of the grid."""
        ordered = np.empty_like(values)
        ordered[self.grid.order] = values
        return ordered

    def facing(self, outward: npt.NDArray[np.float64]) -> Neighborhoods:
        """Turn normals outwards, and leave points that show the other way out of all means.

        outward: vectors (n, d) to the side that is outside, in the order of the points.
        """
        ordered = outward[self.grid.order].T
        agreement = np.einsum("ij,ij->j", self.normals[: self.dimension], ordered)
        normals = np.where(agreement < 0.0, -self.normals, self.normals)
        return replace(self, normals=normals, one_sided=True)

    def heights(self, exponent: int) -> Heights:
        """Heights of the neighbours over the tangent plane of each point.

        Neighbours weigh abs(n_i . n_j)^exponent, in this and all other means, but those that show
        the other way 0 if normals show outwards.
        """
        variances = np.empty(len(self.squares))
        means = self._means(HEIGHT, exponent, _NO_VALUES, self.squares, variances)
        return Heights(means[0], variances)

    def means_along_normals(
        self, values: npt.NDArray[np.float64], exponent: int
    ) -> npt.NDArray[np.float64]:
        """Mean of lengths along the neighbours' normals, (n,), as a length along each normal."""
        return np.asarray(self._means(ALONG_NORMAL, exponent, values, self.squares)[0])

    def with_averaged_normals(self, exponent: int) -> Neighborhoods:
        """Average the normals over the neighbourhoods, whatever their signs.

        Neighbours weigh abs(n_i . n_j)^exponent.
        """
        sums = self._means(NORMAL, exponent, _NO_VALUES, self.squares)
        lengths = np.sqrt(np.einsum("ij,ij->j", sums, sums))
        np.divide(sums, lengths, out=sums, where=lengths > 0.0)
        return replace(self, normals=sums)

    def means(
        self, values: npt.NDArray[np.float64], exponent: int, share: float
    ) -> npt.NDArray[np.float64]:
        """Mean of numbers (n,) over the given share of each neighbourhood's area."""
        return np.asarray(self._means(NUMBER_OF, exponent, values, self.squares * share)[0])

    def _means(
        self,
        kind: int,
        exponent: int,
        values: npt.NDArray[np.float64],
        squares: npt.NDArray[np.float64],
        variances: npt.NDArray[np.float64] = _NO_VALUES,
    ) -> npt.NDArray[np.float64]:
        means = np.empty((3 if kind == NORMAL else 1, len(squares)))
        neighborhood_means(
            self.grid.coordinates,
            self.grid.cells,
            self.dimension,
            self.normals,
            int(self.one_sided),
            squares,
            self.lists.numbers,
            self.lists.ends,
            exponent,
            kind,
            values,
            means,
            variances,
        )
        return means


def find_neighborhoods(
    points: npt.NDArray[np.float64],
    width: Width,
    scales: Scales | None = None,
    *,
    listed: bool = True,
) -> Neighborhoods:
    """Find the neighbourhood of every point and its normal.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite, distinct positions, L.
    width : Width
        How wide.
    scales : Scales, optional
        Noise and spacing at the points, if they differ.
    listed : bool
        Whether to keep lists of who is in them, if these are short.

    Returns
    -------
    Neighborhoods
        With the normals of the planes of least squares (principal component analysis).
    """
    n, dimension = points.shape
    if scales is None:
        grid, radii = build_grid(points, width.max_radius), width.radii_of_all(n)
    else:
        radii = width.radii(scales, dimension)
        grid = build_grid(points, width.cell_size, levels=levels_of(radii.most, width.cell_size))
        radii = Radii(*(values[grid.order] for values in vars(radii).values()))
    normals, squares, sizes, offsets = np.empty((3, n)), np.empty(n), np.empty(n), np.empty(n)
    ends, most = np.empty(n, np.int64), MOST_KEPT if listed else 0
    blocks = fit_planes(
        grid.coordinates, grid.cells, dimension, width.count, radii.thickness, radii.least,
        radii.most, most, normals, squares, sizes, offsets, ends,
    )  # fmt: skip
    lists = NOT_KEPT
    if all(are_kept for *_, are_kept in blocks):
        lists = NeighborLists.of_blocks(blocks, ends)
    return Neighborhoods(grid, dimension, normals, squares, sizes, offsets, radii.most, lists)
