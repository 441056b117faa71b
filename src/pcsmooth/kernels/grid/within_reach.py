"""The points within reach of a point, from the cells of the grid around it, and their order."""

import numpy as np

from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    bits,
    compress,
    count_bits,
    load,
    multiply_add,
    store,
    store_numbers,
)
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.grid import adjacent_ranges

#: Rows of an array of neighbours u_j = p_j - p_i: u, |u|^2, number of the point in grid order.
X, Y, Z = 0, 1, 2
SQUARE = 3
NUMBER = 4
N_ROWS = 5

#: Rows that the kernels of the cells add.
N_CELL_ROWS = 9

#: Rows of an array of candidates: x, y, z, number, and one for what else selects them.
N_CANDIDATE_ROWS = 5

#: Neighbours that are sorted at a time before what is sorted is merged; near a surface there are
#: hardly more.
_RUN = 64

#: Neighbours that an array of hiders has room for.
MOST_HIDERS = 72


@inner
def neighbor_arrays(capacity):
    """Make room for candidates, neighbours, and two more arrays of neighbours."""
    room = capacity + WIDTH
    return (
        np.empty((N_CANDIDATE_ROWS, room)),
        np.empty((N_CELL_ROWS, room)),
        np.empty((N_CELL_ROWS, room)),
        np.empty((N_CELL_ROWS, MOST_HIDERS + WIDTH)),
    )


@inner
def count_points(ranges, n_ranges):
    """Count the points of some ranges."""
    count = 0
    for r in range(n_ranges):
        count += ranges[1, r] - ranges[0, r]
    return count


@inner
def collect_points(coordinates, ranges, n_ranges, candidates):
    """Copy the points of some ranges into candidates: x, y, z, number; infinities follow."""
    c = 0
    for r in range(n_ranges):
        for k in range(ranges[0, r], ranges[1, r]):
            candidates[0, c] = coordinates[0, k]
            candidates[1, c] = coordinates[1, k]
            candidates[2, c] = coordinates[2, k]
            candidates[3, c] = k
            c += 1
    for k in range(c, c + WIDTH):
        candidates[0, k] = np.inf
        candidates[1, k] = np.inf
        candidates[2, k] = np.inf
    return c


@inner
def collect_around(coordinates, cells, cell, dimension, ranges, candidates):
    """Collect the points of a cell and of those that adjoin it, with room for the ranges.

    Returns the array of candidates, another one if they were too many for it, and their number.
    """
    n_ranges = adjacent_ranges(cells, cell, dimension, ranges)
    room = count_points(ranges, n_ranges) + WIDTH
    if room > candidates.shape[1]:
        candidates = np.empty((4, room + room // 2))
    return candidates, collect_points(coordinates, ranges, n_ranges, candidates)


@inner
def list_within_reach(candidates, n_candidates, x, y, z, square, numbers, place):
    """Put the numbers of candidates into `numbers`, int32, from `place` on.

    These are nearer to (x, y, z) than the root of `square`, itself excluded. Returns the place
    after the last of them; numbers has room for WIDTH more.
    """
    for c in range(0, n_candidates, WIDTH):
        dx = load(candidates, 0, c) - x
        dy = load(candidates, 1, c) - y
        dz = load(candidates, 2, c) - z
        found = multiply_add(dz, dz, multiply_add(dy, dy, dx * dx))
        within = (found < square) & (found > 0.0)
        store_numbers(numbers, place, compress(load(candidates, 3, c), within))
        place += count_bits(bits(within))
    return place


@inner
def select_within_reach(candidates, n_candidates, x, y, z, reach, near):
    """Put the candidates nearer than `reach` to (x, y, z), itself excluded, into near.

    Returns how many there are; near has room for WIDTH more.
    """
    reach2 = reach * reach
    count = 0
    for c in range(0, n_candidates, WIDTH):
        dx = load(candidates, 0, c) - x
        dy = load(candidates, 1, c) - y
        dz = load(candidates, 2, c) - z
        square = multiply_add(dz, dz, multiply_add(dy, dy, dx * dx))
        # Points are distinct: only the point itself is at distance 0.
        within = (square < reach2) & (square > 0.0)
        chosen = bits(within)
        if chosen == 0:  # as nearly always where many points are within the cells
            continue
        store_chosen(near, count, dx, dy, dz, square, load(candidates, 3, c), within)
        count += count_bits(chosen)
    return count


@inner
def store_chosen(near, place, x, y, z, square, number, chosen):
    """Put the chosen ones of a register's worth of neighbours into near, from `place` on."""
    store(near, X, place, compress(x, chosen))
    store(near, Y, place, compress(y, chosen))
    store(near, Z, place, compress(z, chosen))
    store(near, SQUARE, place, compress(square, chosen))
    store(near, NUMBER, place, compress(number, chosen))


@inner
def pad_neighbors(near, count):
    """Let a register's worth of neighbours at infinity follow the last: no plane of theirs cuts."""
    for k in range(count, count + WIDTH):
        near[X, k] = 0.0
        near[Y, k] = 0.0
        near[Z, k] = 0.0
        near[SQUARE, k] = np.inf
        near[NUMBER, k] = -1.0


@inner
def sort_by_distance(source, count, target):
    """Copy neighbours in order of distance, ties as they come; source gets used up."""
    for first in range(0, count, _RUN):
        _sort_run(source, first, min(first + _RUN, count), target)
    length = np.int64(_RUN)
    while length < count:
        for first in range(0, count, 2 * length):
            middle = min(first + length, count)
            _merge_runs(target, first, middle, min(middle + length, count), source)
        for row in range(N_ROWS):
            for k in range(count):
                target[row, k] = source[row, k]
        length *= 2


@inner
def _sort_run(source, first, stop, target):
    """Copy neighbours first .. stop - 1 in order of distance.

    Each place is found by counting the nearer ones, eight at a time: there are few.
    """
    for k in range(first, stop):
        square = source[SQUARE, k]
        place = first
        for c in range(first, stop, WIDTH):
            others = load(source, SQUARE, c)
            earlier = (1 << min(max(k - c, 0), WIDTH)) - 1
            inside = (1 << min(stop - c, WIDTH)) - 1
            nearer = bits(others < square) | (bits(others == square) & earlier)
            place += count_bits(nearer & inside)
        for row in range(N_ROWS):
            target[row, place] = source[row, k]


@inner
def _merge_runs(source, first, middle, stop, target):
    """Merge neighbours first .. middle - 1 and middle .. stop - 1, both in order."""
    left = first
    right = middle
    for place in range(first, stop):
        if right == stop or (left < middle and source[SQUARE, left] <= source[SQUARE, right]):
            taken = left
            left += 1
        else:
            taken = right
            right += 1
        for row in range(N_ROWS):
            target[row, place] = source[row, taken]


@inner
def select_open(near, count, i, start, target):
    """Copy the neighbours with which p_i has a facet to find: all but start .. i - 1.

    Returns how many there are; near is padded, and so is target then.
    """
    number_i = float(i)
    number_start = float(start)
    n_open = 0
    for c in range(0, count, WIDTH):
        number = load(near, NUMBER, c)
        is_open = (number > number_i) | ((number < number_start) & (number >= 0.0))
        x = load(near, X, c)
        y = load(near, Y, c)
        z = load(near, Z, c)
        store_chosen(target, n_open, x, y, z, load(near, SQUARE, c), number, is_open)
        n_open += count_bits(bits(is_open))
    pad_neighbors(target, n_open)
    return n_open
