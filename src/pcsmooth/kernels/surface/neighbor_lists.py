"""The neighbours of every point: read from lists that are kept, or looked for."""

import numpy as np

from pcsmooth.kernels.arithmetic.simd import WIDTH
from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS, MOST_RANGES
from pcsmooth.kernels.grid.within_reach import collect_around, list_within_reach
from pcsmooth.kernels.threads import shared_out

#: Neighbours of each point for which there is room at first.
_ROOM = 24


@shared_out("cells.codes")
@kernel("f2 cells i f1 i1 i i", cells=CELLS)
def list_neighbors(coordinates, cells, dimension, squares, ends, first, last):
    """List the points nearer to each point than a radius.

    Parameters: coordinates (3, n) in grid order; cells of side >= the radii; d; squares (n,) of the
    radii. Fills ends (n,): where the neighbours of each point end in the list of its block; they
    begin where those of the point before it end.

    Returns the first point of the block, the one after its last, and the list.
    """
    start = cells.starts[first]
    stop = cells.starts[last]
    ranges, candidates = no_candidates()
    numbers = np.empty(_ROOM * (stop - start) + WIDTH, np.int32)
    place = 0
    for cell in range(first, last):
        candidates, n_candidates = collect_around(
            coordinates, cells, cell, dimension, ranges, candidates
        )
        for i in range(cells.starts[cell], cells.starts[cell + 1]):
            numbers = with_room(numbers, place, n_candidates)
            place = list_within_reach(
                candidates, n_candidates, coordinates[0, i], coordinates[1, i], coordinates[2, i],
                squares[i], numbers, place,
            )  # fmt: skip
            ends[i] = place
    return start, stop, numbers


@inner
def no_candidates():
    """Make room for the ranges around a cell, and an array of candidates that holds none."""
    return np.empty((2, MOST_RANGES), np.int64), np.empty((4, 0))


@inner
def with_room(numbers, place, count):
    """Give a list, or a larger one that begins with it, that has room for so many from a place."""
    if place + count + WIDTH <= numbers.size:
        return numbers
    larger = np.empty(numbers.size + numbers.size // 2 + count + WIDTH, np.int32)
    for k in range(place):
        larger[k] = numbers[k]
    return larger
