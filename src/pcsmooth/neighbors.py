"""Who is near whom: coincident points, spacing, nearest neighbours, the grid of the kernels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid import CELLS_PER_AXIS, morton_codes, sorted_coordinates

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

#: Neighbours whose mean distance is a point's spacing, by dimension: those around it on a curve
#: and on a surface.
SPACING_NEIGHBORS = {2: 2, 3: 6}

#: Points at which the spacing is sampled.
_SPACING_SAMPLES = 20_000

#: A point whose own spacing is larger than this times the median is an outlier.
_OUTLIER_SPACING = 4.0

#: Points searched at a time, to bound memory.
_CHUNK = 1 << 16

#: Cells are wider than asked by this share, so that rounding never parts two neighbours.
_CELL_MARGIN = 1e-6


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


def build_grid(points: npt.NDArray[np.float64], cell_size: float) -> Grid:
    """Sort points into cubic cells so that points nearer than `cell_size` share or adjoin cells.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions, n >= 1.
    cell_size : float
        Side of a cell, > 0.
    """
    size = cell_size * (1.0 + _CELL_MARGIN)
    origin = points.min(axis=0)
    if np.any(points.max(axis=0) - origin >= size * CELLS_PER_AXIS):
        # Far outliers: give the range of cells to the bulk of the points.
        origin = np.median(points, axis=0) - 0.5 * CELLS_PER_AXIS * size
    codes = morton_codes(points, origin, size)
    order = np.argsort(codes, kind="stable")
    codes = codes[order]
    starts = np.flatnonzero(np.r_[True, codes[1:] != codes[:-1]])
    return Grid(
        coordinates=sorted_coordinates(points, order),
        order=order,
        cell_codes=codes[starts],
        cell_starts=np.append(starts, len(points)),
    )


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
        hashes = (hashes ^ column) * np.uint64(0x9E3779B97F4A7C15)
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


def nearest_neighbors(
    points: npt.NDArray[np.float64], count: int, reach: float, threads: int = 1
) -> npt.NDArray[np.int32]:
    """Find the nearest points within reach of each point.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions.
    count : int
        Neighbours wanted, the point itself included, >= 2.
    reach : float
        Largest distance, L; may be infinite.
    threads : int
        Threads of the search.

    Returns
    -------
    ndarray of int32, shape (n, count)
        Numbers of the points, nearest first; n where there are no more within reach.
    """
    tree = _build_tree(points)
    neighbors = np.empty((len(points), count), np.int32)
    for start in range(0, len(points), _CHUNK):
        chunk = slice(start, start + _CHUNK)
        neighbors[chunk] = tree.query(
            points[chunk], count, distance_upper_bound=reach, workers=threads
        )[1]
    return neighbors


def _build_tree(points: npt.NDArray[np.float64]) -> cKDTree:
    from scipy.spatial import cKDTree

    return cKDTree(points, balanced_tree=False, compact_nodes=False)


def mean_spacing(points: npt.NDArray[np.float64], threads: int = 1) -> float:
    """Mean distance between neighbouring points, L.

    The spacing at a point is the mean distance to its 6 nearest distinct points (2 in 2D). The
    result is the mean over up to 20,000 points taken at regular ranks, leaving out the points
    whose own spacing exceeds four times the median (outliers).

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions; coincident points count once.
    threads : int
        Threads of the search.

    Returns
    -------
    float
        0.0 if there are fewer than two distinct points.
    """
    distinct = points[first_coincident(points) == np.arange(len(points))]
    n, dimension = distinct.shape
    if n < 2:
        return 0.0
    k = min(SPACING_NEIGHBORS[dimension], n - 1)
    samples = distinct[:: -(-n // _SPACING_SAMPLES)]
    distances, _ = _build_tree(distinct).query(samples, k + 1, workers=threads)
    local = distances[:, 1:].mean(axis=1)
    return float(local[local <= _OUTLIER_SPACING * np.median(local)].mean())
