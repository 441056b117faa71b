"""Points sorted into cubic cells along a Morton curve, and the blocks that kernels take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid.grid import (
    CELL_OF_ZERO,
    CELLS_PER_AXIS,
    bounding_box,
    code_points,
    gather_points,
)
from pcsmooth.kernels.grid.radix_sort import sort_pairs

#: Cells are wider than asked by this share, so that rounding never parts two neighbours.
_CELL_MARGIN = 1e-6

#: Cells along a cube, as a power of two, by dimension, and points beyond which a cube is cut up:
#: large enough that few facets leave it, small enough to stay in a core's cache.
CUBE_LEVEL = {2: 6, 3: 3}
FULL_CUBE = 3000


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
