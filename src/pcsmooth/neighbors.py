"""Who is near whom: coincident points, spacing, nearest neighbours, the grid of the kernels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid.grid import (
    CELL_OF_ZERO,
    CELLS_PER_AXIS,
    bounding_box,
    code_points,
    gather_points,
    match_in_cells,
)
from pcsmooth.kernels.grid.nearest_points import mean_nearest_distances
from pcsmooth.kernels.grid.radix_sort import sort_pairs
from pcsmooth.point_order import scattered_ranks

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

#: Neighbours whose mean distance is a point's spacing, by dimension: those around it on a curve
#: and on a surface.
SPACING_NEIGHBORS = {2: 2, 3: 6}

#: Points at which the spacing is sampled.
_SPACING_SAMPLES = 20_000

#: A point whose own spacing is larger than this times the median is an outlier.
_OUTLIER_SPACING = 4.0

#: Cells in which spacings are looked for first, in units of the spacing that the extent suggests,
#: and mean number of points in a point's cell beyond which there would be too many to look at.
_GUESS = 5.0
_CROWDING = 1000.0

#: Cells are wider than asked by this share, so that rounding never parts two neighbours.
_CELL_MARGIN = 1e-6

#: Cells along a cube, as a power of two, by dimension, and points beyond which a cube is cut up:
#: large enough that few facets leave it, small enough to stay in a core's cache.
CUBE_LEVEL = {2: 6, 3: 3}
FULL_CUBE = 3000

#: Points of a cell beyond which hashing finds the coincident ones sooner than comparing pairs.
_CROWD = 64


@dataclass(frozen=True)
class Grid:
    """Points in Morton order of cubic cells, as the kernels take them.

    Attributes
    ----------
    coordinates : ndarray, shape (3, n)
        Rows x, y, z in grid order (z = 0 in 2D).
    order : ndarray of int, shape (n,)
        Original number of each point in grid order.
    cell_codes : ndarray of int, shape (m,)
        Morton codes of the occupied cells, increasing.
    cell_starts : ndarray of int, shape (m + 1,)
        Where each cell's points begin in grid order.
    """

    coordinates: npt.NDArray[np.float64]
    order: npt.NDArray[np.int64]
    cell_codes: npt.NDArray[np.int64]
    cell_starts: npt.NDArray[np.int64]


def build_grid(
    points: npt.NDArray[np.float64],
    cell_size: float,
    corner: npt.NDArray[np.float64] | None = None,
) -> Grid:
    """Sort points into cubic cells so that points nearer than `cell_size` share or adjoin cells.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions, n >= 1.
    cell_size : float
        Side of a cell, > 0.
    corner : ndarray, shape (d,), optional
        Where a cell begins; by default 0.

    Returns
    -------
    Grid
        The points of a cell are in the order of their numbers. Cells and their order are the same
        for every part of a cloud, unless it is wider than some hundred thousand cells.
    """
    points = np.ascontiguousarray(points)
    size = cell_size * (1.0 + _CELL_MARGIN)
    n, dimension = points.shape
    corner = np.zeros(dimension) if corner is None else corner
    pairs = np.empty((n, 2), np.int64)
    offsets = _numbers_of_corner(points, corner, size)
    lowest, highest = code_points(points, corner, size, offsets, pairs)
    pairs = sort_pairs(pairs, (lowest ^ highest).bit_length())
    order, coordinates, begins = np.empty(n, np.int64), np.empty((3, n)), np.empty(n, np.bool_)
    gather_points(points, pairs, order, coordinates, begins)
    starts = np.flatnonzero(begins)
    return Grid(coordinates, order, pairs[starts, 0], np.append(starts, n))


def _numbers_of_corner(
    points: npt.NDArray[np.float64], corner: npt.NDArray[np.float64], size: float
) -> npt.NDArray[np.float64]:
    """Cell numbers of the corner that bring the points (n, d) into range, (d,)."""
    dimension = points.shape[1]
    low, high = np.floor((np.array(bounding_box(points))[:, :dimension] - corner) / size)
    numbers = np.full(dimension, float(CELL_OF_ZERO))
    for axis in np.flatnonzero((low < -numbers) | (high >= CELLS_PER_AXIS - numbers)):
        # Far from 0, or with far outliers: give the range of cells to the bulk of the points.
        middle = low[axis]
        if high[axis] - low[axis] >= CELLS_PER_AXIS - CELL_OF_ZERO:
            middle = np.floor((np.median(points[:, axis]) - corner[axis]) / size)
        numbers[axis] = CELL_OF_ZERO - middle
    return numbers


def is_in_range(
    box: npt.NDArray[np.float64], cell_size: float, corner: npt.NDArray[np.float64] | None = None
) -> bool:
    """Whether parts of a cloud in a box (2, d) get the same cells as the whole.

    Clouds that are too wide get cells of their own, and points far outside share one.
    """
    corner = np.zeros(box.shape[1]) if corner is None else corner
    numbers = (box - corner) / (cell_size * (1.0 + _CELL_MARGIN)) + CELL_OF_ZERO
    return bool(np.all(numbers >= 1.0) and np.all(numbers < CELLS_PER_AXIS - 1.0))


def cube_starts(grid: Grid, dimension: int) -> npt.NDArray[np.int64]:
    """Cut points in grid order into blocks, each the points of a cube of cells.

    Parameters
    ----------
    grid : Grid
        Grid of n points.
    dimension : int
        d.

    Returns
    -------
    ndarray of int, shape (b + 1,)
        Where the blocks begin in grid order, and n. What a block is depends on nothing but the
        points in its cube, of 8 cells along each axis, in the plane 64; of cubes that hold more
        than some thousands the eighths (quarters) are blocks, and so on down to single cells.
    """
    codes, starts = grid.cell_codes, grid.cell_starts
    level = CUBE_LEVEL[dimension]
    differing = codes[1:] ^ codes[:-1]
    begins = np.r_[True, differing >> (dimension * level) != 0]
    while True:
        blocks = np.append(starts[:-1][begins], starts[-1])
        crowded = np.diff(blocks) > FULL_CUBE
        if level == 0 or not crowded.any():
            return blocks
        level -= 1
        in_crowd = crowded[np.cumsum(begins) - 1]
        begins[1:] |= in_crowd[1:] & (differing >> (dimension * level) != 0)


def first_coincident(points: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    """For each point, the lowest number of a point at exactly the same position.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions.

    Returns
    -------
    ndarray of int, shape (n,)
        Its own number for a point that is alone or the first at its place.
    """
    first = np.arange(len(points))
    bits = (points + 0.0).view(np.uint64)  # + 0.0 turns -0.0 into 0.0
    hashes = np.zeros(len(points), np.uint64)
    for column in bits.T:
        hashes ^= column
        hashes *= np.uint64(0x9E3779B97F4A7C15)
        hashes ^= hashes >> np.uint64(29)
    ordered = np.sort(hashes)
    repeated = np.unique(ordered[1:][ordered[1:] == ordered[:-1]])
    if repeated.size == 0:
        return first
    suspects = np.flatnonzero(np.isin(hashes, repeated))
    # Equal hashes only point at candidates: compare the positions themselves.
    by_position = suspects[np.lexsort(points[suspects].T)]
    new_place = np.any(points[by_position[1:]] != points[by_position[:-1]], axis=1)
    group = np.cumsum(np.r_[0, new_place])
    lowest = np.full(group[-1] + 1, len(points))
    np.minimum.at(lowest, group, by_position)
    first[by_position] = lowest[group]
    return first


def first_coincident_in(grid: Grid) -> npt.NDArray[np.int64]:
    """Like `first_coincident` of a grid's points, but faster: such points share a cell.

    Parameters
    ----------
    grid : Grid
        Grid of n points.

    Returns
    -------
    ndarray of int, shape (n,)
        By original number, its own number for a point that is alone or the first at its place.
    """
    first = np.arange(len(grid.order))
    match_in_cells(grid.coordinates, grid.order, grid.cell_starts, _CROWD, first)
    sizes = np.diff(grid.cell_starts)
    if sizes.max() > _CROWD:
        crowded = np.repeat(sizes > _CROWD, sizes)
        numbers = grid.order[crowded]  # they increase within a cell
        first[numbers] = numbers[first_coincident(grid.coordinates[:, crowded].T)]
    return first


def _build_tree(points: npt.NDArray[np.float64]) -> cKDTree:
    from scipy.spatial import cKDTree

    return cKDTree(points, balanced_tree=False, compact_nodes=False)


def nearest_points(
    points: npt.NDArray[np.float64],
    queries: npt.NDArray[np.float64],
    count: int,
    threads: int = 1,
    farthest: float = math.inf,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Find the points that are nearest to some positions.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions, n >= 1.
    queries : ndarray, shape (m, d)
        Finite positions.
    count : int
        Nearest points of each, >= 2.
    threads : int
        Threads of the search.
    farthest : float
        Points not nearer than this are left out, L.

    Returns
    -------
    distances : ndarray, shape (m, count)
        Increasing; infinite where there are fewer points.
    nearest : ndarray of int, shape (m, count)
        Their numbers, increasing among equal distances; n where there are fewer points. Which of
        several points at the distance of the last are left out is not defined.
    """
    tree = _build_tree(points)
    found = tree.query(queries, count, distance_upper_bound=farthest, workers=threads)
    distances, nearest = in_order_of_distance(*found)
    return distances, nearest


def in_order_of_distance(
    distances: npt.NDArray[np.float64], numbers: npt.NDArray[np.int64], *others: npt.NDArray[Any]
) -> tuple[npt.NDArray[Any], ...]:
    """Sort the columns (m, k) of each row by distance, then by number, and others (m, k) along."""
    order = np.lexsort((numbers, distances), axis=1)
    return tuple(np.take_along_axis(each, order, axis=1) for each in (distances, numbers, *others))


def distinct_points(points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Take the first of the points (n, d) at each position, in their order."""
    is_first = first_coincident(points) == np.arange(len(points))
    return points if is_first.all() else points[is_first]


def mean_spacing(points: npt.NDArray[np.float64], threads: int = 1) -> float:
    """Mean distance between neighbouring points, L.

    The spacing at a point is the mean distance to its 6 nearest distinct points (2 in 2D). The
    result is the mean over up to 20,000 points, one in each of as many runs of equal length,
    leaving out the points whose own spacing exceeds four times the median (outliers).

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions; coincident points count once. Runs are of points in their order: that
        of their positions, if the order of rows shall not matter (see `take_in_order`).
    threads : int
        Threads of the search.

    Returns
    -------
    float
        0.0 if there are fewer than two distinct points.
    """
    distinct = distinct_points(points)
    n, dimension = distinct.shape
    if n < 2:
        return 0.0
    count = min(SPACING_NEIGHBORS[dimension], n - 1)
    return mean_without_outliers(_own_spacings(distinct, spacing_samples(n), count, threads))


def spacing_samples(n: int) -> npt.NDArray[np.int64]:
    """Ranks of the points, of n distinct ones, whose spacings make the mean, increasing."""
    return scattered_ranks(n, _SPACING_SAMPLES)


def mean_without_outliers(spacings: npt.NDArray[np.float64]) -> float:
    """Mean of the spacings (s,) of some points that are not four times the median, L."""
    return float(spacings[spacings <= _OUTLIER_SPACING * np.median(spacings)].mean())


def spacing_cell(box: npt.NDArray[np.float64], n: int) -> float:
    """Choose cells in which to look for the nearest of n points in a box (2, d), L; 0 for none."""
    dimension = box.shape[1]
    extents = np.sort(box[1] - box[0])[::-1]
    cell_size = _GUESS * float(np.prod(extents[: dimension - 1]) / n) ** (1.0 / (dimension - 1))
    return cell_size if cell_size > extents[0] / CELLS_PER_AXIS else 0.0


def is_crowded(within_cells: int, n: int) -> bool:
    """Whether cells hold so many of n points, summed over the points, that a tree is faster."""
    return within_cells >= _CROWDING * n


def spacings_in_cells(
    grid: Grid, dimension: int, cell_size: float, count: int, samples: npt.NDArray[np.int64]
) -> npt.NDArray[np.float64]:
    """Mean distance from some distinct points of a grid to their nearest others, (samples,), L.

    NaN for those that have fewer than `count` others nearer than the cell size.
    """
    places = np.empty(len(grid.order), np.int64)
    places[grid.order] = np.arange(len(places))
    spacings = np.empty(len(samples))
    mean_nearest_distances(
        grid.coordinates,
        grid.cell_codes,
        grid.cell_starts,
        dimension,
        count,
        cell_size,
        places[samples],
        spacings,
    )
    return spacings


def _own_spacings(
    points: npt.NDArray[np.float64], samples: npt.NDArray[np.int64], count: int, threads: int
) -> npt.NDArray[np.float64]:
    """Mean distance from some distinct points to their nearest others, shape (samples,).

    A grid as wide as the spacing would be if the points filled a rectangle (in the plane, a
    line) finds it for most at little cost; a k-d tree finds the others.
    """
    n, dimension = points.shape
    spacings = np.full(len(samples), np.nan)
    cell_size = spacing_cell(np.array(bounding_box(points))[:, :dimension], n)
    if cell_size > 0.0:
        grid = build_grid(points, cell_size)
        sizes = np.diff(grid.cell_starts)
        if not is_crowded(int(sizes @ sizes), n):
            spacings = spacings_in_cells(grid, dimension, cell_size, count, samples)
    left = np.flatnonzero(np.isnan(spacings))
    if left.size:
        distances, _ = _build_tree(points).query(points[samples[left]], count + 1, workers=threads)
        spacings[left] = distances[:, 1:].mean(axis=1)
    return spacings
