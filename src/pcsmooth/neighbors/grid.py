"""Points sorted into cubic cells along a Morton curve, and the blocks that kernels take."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid.grid import (
    CELL_BITS,
    CELL_OF_ZERO,
    CELLS_PER_AXIS,
    Cells,
    bounding_box,
    code_points,
    gather_points,
    look_back,
)
from pcsmooth.kernels.grid.radix_sort import sort_pairs

#: Cells are wider than asked by this share, so that rounding never parts two neighbours.
_CELL_MARGIN = 1e-6

#: Cells along a cube, as a power of two, by dimension, and points beyond which a cube is cut up:
#: large enough that few facets leave it, small enough to stay in a core's cache.
CUBE_LEVEL = {2: 6, 3: 3}
FULL_CUBE = 3000

#: The same of points that look differently far: what a point's sums depend on is then not much
#: wider than what it sees. Cubes of 2 take a twentieth longer (40,000 points), those of 8 as long.
UNEQUAL_CUBE_LEVEL = {2: 3, 3: 2}


@dataclass(frozen=True)
class Grid:
    """Points in Morton order of cubic cells, as the kernels take them.

    Attributes
    ----------
    coordinates : ndarray, shape (3, n)
        Rows x, y, z in grid order (z = 0 in 2D).
    order : ndarray of int, shape (n,)
        Original number of each point in grid order.
    cells : Cells
        Those that are occupied.
    """

    coordinates: npt.NDArray[np.float64]
    order: npt.NDArray[np.int64]
    cells: Cells


def build_grid(
    points: npt.NDArray[np.float64],
    cell_size: float,
    corner: npt.NDArray[np.float64] | None = None,
    levels: npt.NDArray[np.int8] | None = None,
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
    levels : ndarray of int8, shape (n,), optional
        How far each point looks: `cell_size` times 2 to this power; by default 0 for all. The work
        for a point then depends on how many points there are within its own cubes, not on how
        dense the cloud is elsewhere.

    Returns
    -------
    Grid
        The points of a cell of level 0 are in the order of their numbers. Cells and their order
        are the same for every part of a cloud, unless it is wider than some hundred thousand
        cells.
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
    cells = cells_of_one_size(pairs[starts, 0], np.append(starts, n))
    if levels is not None:
        cells = _cells_of_levels(cells, levels[order], dimension)
    return Grid(coordinates, order, cells)


def cells_of_one_size(codes: npt.NDArray[np.int64], starts: npt.NDArray[np.int64]) -> Cells:
    """Give cells of one size by their codes (m,) and the starts of their points (m + 1,)."""
    return Cells(codes, starts, np.zeros(len(codes), np.int8), codes, starts)


def levels_of(reaches: npt.NDArray[np.float64], cell_size: float) -> npt.NDArray[np.int8]:
    """Levels at which points (n,) that look so far, L, are put into a grid: see `build_grid`."""
    doublings = np.ceil(np.log2(np.maximum(reaches / cell_size, 1.0)))
    return np.minimum(doublings, CELL_BITS - 1).astype(np.int8)


def see_what_touches(
    grid: Grid, radii: npt.NDArray[np.float64], cell_size: float, dimension: int
) -> Grid:
    """Let points look as far as the centres of the balls that touch theirs.

    Parameters
    ----------
    grid : Grid
        Grid of n points that look as far as twice their own radius.
    radii : ndarray, shape (n,)
        Their radii in the order of the grid.
    cell_size : float
        Side of a cell of level 0.
    dimension : int
        d.
    """
    levels = np.repeat(grid.cells.levels, np.diff(grid.cells.starts))
    # No two balls that touch are farther apart than the largest one is wide.
    highest = int(levels_of(np.array([2.0 * radii.max()]), cell_size)[0])
    seen = cell_size * 2.0 ** np.arange(highest + 1)
    marks = np.zeros((highest + 1, len(radii)), np.bool_)
    look_back(grid.coordinates, grid.cells, dimension, radii, seen, marks)
    for level, is_raised in enumerate(marks):
        levels[is_raised] = level
    fine = cells_of_one_size(grid.cells.fine_codes, grid.cells.fine_starts)
    return replace(grid, cells=_cells_of_levels(fine, levels, dimension))


def _cells_of_levels(fine: Cells, levels: npt.NDArray[np.int8], dimension: int) -> Cells:
    """Put points of some levels (n,), in grid order, into cells of these."""
    shifts = dimension * levels.astype(np.int64)
    codes = np.repeat(fine.codes, np.diff(fine.starts)) >> shifts << shifts
    begins = np.flatnonzero(np.r_[True, (codes[1:] != codes[:-1]) | (levels[1:] != levels[:-1])])
    starts = np.append(begins, len(levels))
    return Cells(codes[begins], starts, levels[begins], fine.codes, fine.starts)


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


def cube_starts(grid: Grid, dimension: int, *, are_unequal: bool = False) -> npt.NDArray[np.int64]:
    """Cut points in grid order into blocks, each the points of a cube of cells.

    Parameters
    ----------
    grid : Grid
        Grid of n points.
    dimension : int
        d.
    are_unequal : bool
        Whether points look differently far, here or in another part of the cloud.

    Returns
    -------
    ndarray of int, shape (b + 1,)
        Where the blocks begin in grid order, and n. What a block is depends on nothing but the
        points in its cube, of 8 cells along each axis, in the plane 64; of cubes that hold more
        than some thousands the eighths (quarters) are blocks, and so on down to single cells. If
        points look differently far it is a cube of 4 (in the plane 8) of the smallest cells in it,
        or of fewer.
    """
    codes, starts, levels = grid.cells.codes, grid.cells.starts, grid.cells.levels
    width = (UNEQUAL_CUBE_LEVEL if are_unequal else CUBE_LEVEL)[dimension]
    begins = np.ones(len(codes), np.bool_)
    # Cubes that are whole blocks are made of such, so that the largest ones come last.
    for level in range(int(levels.max()) + width + 1):
        cubes = codes >> (dimension * level)
        firsts = np.flatnonzero(np.r_[True, cubes[1:] != cubes[:-1]])
        is_whole = np.minimum.reduceat(levels, firsts) >= level - width
        is_whole &= np.diff(np.append(starts[firsts], starts[-1])) <= FULL_CUBE
        begins &= ~np.repeat(is_whole, np.diff(np.append(firsts, len(codes))))
        begins[firsts] = True
    return np.append(starts[:-1][begins], starts[-1])
