"""Points at exactly the same position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid.grid import match_in_cells
from pcsmooth.neighbors.grid import Grid
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts

#: Points of a cell beyond which hashing finds the coincident ones sooner than comparing pairs.
_CROWD = 64


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
    match_in_cells(grid.coordinates, grid.order, grid.cells.fine_starts, _CROWD, first)
    sizes = np.diff(grid.cells.fine_starts)
    if sizes.max() > _CROWD:
        crowded = np.repeat(sizes > _CROWD, sizes)
        numbers = grid.order[crowded]  # they increase within a cell
        first[numbers] = numbers[first_coincident(grid.coordinates[:, crowded].T)]
    return first


@dataclass(frozen=True, eq=False)
class Distinct:
    """The points of a cloud in parts that are the first at their position.

    Attributes
    ----------
    marks : Column
        Which points they are.
    count : int
        How many.
    """

    marks: Column
    count: int


def mark_distinct(parts: Parts) -> Distinct:
    """Find the points that are the first at their position, at the start."""
    marks = parts.create("distinct", np.bool_)
    count = sum(parts.map("coincident points", _MarkDistinct(marks), parts.start))
    return Distinct(marks, count)


@dataclass(frozen=True, eq=False)
class _MarkDistinct:
    """Mark the own points that are the first at their position; all at one place share a part."""

    marks: Column

    reach = 0.0

    def __call__(self, part: Part) -> int:
        distinct = first_coincident(part.points) == np.arange(len(part.points))
        part.write(self.marks, distinct)
        return int(np.count_nonzero(distinct))
