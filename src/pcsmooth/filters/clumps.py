"""Clumps: a few points close to each other and far from all others."""

from __future__ import annotations

from itertools import product

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid.grid import CELL_BITS
from pcsmooth.neighbors.grid import Grid

#: How many times cells are doubled, by dimension. Gaps between random points of a curve are wider
#: than twelve spacings at one place of 10^5.
_DOUBLINGS = {2: 2, 3: 0}

#: Cells that a clump may extend over.
_EXTENT = 3

#: Cells are wider than asked by this share (see `build_grid`), and a bit.
_CELL_MARGIN = 1e-5


def clump_reach(cell_size: float, dimension: int) -> float:
    """How far, along an axis, a point of a clump depends on others: on what adjoins it, too, L.

    cell_size: side of the largest cells that points are in, L.
    """
    return (1.0 + _CELL_MARGIN) * (_EXTENT + 2) * cell_size * 2.0 ** _DOUBLINGS[dimension]


def mark_clumps(grid: Grid, cell_size: float, most: int, dimension: int) -> npt.NDArray[np.bool_]:
    """Find points whose cell and those that adjoin it, and so on, hold only a few.

    Parameters
    ----------
    grid : Grid
        Grid of n points.
    cell_size : float
        Side of a cell of level 0, L.
    most : int
        Points of a clump, at most.
    dimension : int
        d.

    Returns
    -------
    ndarray of bool, shape (n,)
        In grid order. A clump extends over three cells at most. Between it and all others is a
        cell's side at least, and no more than two cells' diagonals.
    """
    cells, count = grid.cells, len(grid.order)
    found = np.zeros(count, np.bool_)
    level_of = np.repeat(cells.levels, np.diff(cells.starts))
    for level in np.unique(cells.levels).tolist():
        doubled = level + _DOUBLINGS[dimension]
        codes = cells.fine_codes >> (dimension * doubled)
        begins = np.flatnonzero(np.r_[True, codes[1:] != codes[:-1]])
        starts = np.append(cells.fine_starts[begins], count)
        groups = _joined(codes[begins], dimension)
        sizes = np.diff(starts)
        is_few = np.bincount(groups, weights=sizes) <= most
        places = np.flatnonzero(np.repeat(is_few[groups], sizes))
        if len(places):
            group = np.repeat(groups, sizes)[places]
            is_small = _extents(grid.coordinates[:, places], group) <= (
                _EXTENT * cell_size * 2.0**doubled
            )
            found[places[is_small & (level_of[places] == level)]] = True
    return found


def _joined(codes: npt.NDArray[np.int64], dimension: int) -> npt.NDArray[np.int64]:
    """Find the group of cells that adjoin each other of each, (m,): Morton codes, increasing."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    # Numbers along the axes are added with the bits of the other axes filled or left out.
    axes = [
        sum(1 << (dimension * bit + axis) for bit in range(CELL_BITS)) for axis in range(dimension)
    ]
    here, there = [], []
    for steps in product((-1, 0, 1), repeat=dimension):
        if steps <= (0,) * dimension:
            continue  # each pair is seen once
        moved = np.zeros_like(codes)
        for axis, step in zip(axes, steps, strict=True):
            along = codes & axis
            if step > 0:
                along = ((codes | ~axis) + 1) & axis
            elif step < 0:
                along = (along - (axis & -axis)) & axis
            moved |= along
        places = np.minimum(np.searchsorted(codes, moved), len(codes) - 1)
        adjoining = np.flatnonzero(codes[places] == moved)
        here.append(adjoining)
        there.append(places[adjoining])
    pairs = np.concatenate(here), np.concatenate(there)
    graph = coo_array((np.ones(len(pairs[0]), np.bool_), pairs), shape=(len(codes),) * 2)
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)


def _extents(
    coordinates: npt.NDArray[np.float64], groups: npt.NDArray[np.int64]
) -> npt.NDArray[np.float64]:
    """Largest extent along an axis of the group of each point: coordinates (3, k), groups (k,)."""
    _, numbers = np.unique(groups, return_inverse=True)
    extents = np.zeros(numbers.max() + 1)
    for axis in coordinates:
        lowest, highest = np.full(len(extents), np.inf), np.full(len(extents), -np.inf)
        np.minimum.at(lowest, numbers, axis)
        np.maximum.at(highest, numbers, axis)
        np.maximum(extents, highest - lowest, out=extents)
    return np.asarray(extents[numbers])
