"""Mean distance from some points of a grid to their k nearest points."""

import math

import numpy as np

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS, MOST_RANGES, adjacent_ranges, cell_of_point
from pcsmooth.kernels.threads import shared_out


@shared_out("samples")
@kernel("f2 cells i i f i1 f1 i i", cells=CELLS)
def mean_k_nearest_distances(
    coordinates, cells, dimension, count, reach, samples, means, first, last
):  # fmt: skip
    """Mean distance to the `count` nearest others, NaN where fewer are nearer than `reach`.

    Parameters: coordinates (3, n) of distinct points in grid order (cells of side >= reach); d;
    places of the samples in grid order (s,). Fills means (s,).
    """
    for s in range(first, last):
        means[s] = _mean_distance(coordinates, cells, dimension, count, reach, samples[s])


@inner
def _mean_distance(coordinates, cells, dimension, count, reach, i):
    """Do it for the point at place i, keeping the nearest so far in order."""
    ranges = np.empty((2, MOST_RANGES), np.int64)
    cell = np.int64(cell_of_point(cells, i))
    n_ranges = adjacent_ranges(cells, cell, dimension, ranges)
    squares = np.empty(count)
    for k in range(count):
        squares[k] = reach * reach
    for r in range(n_ranges):
        for j in range(ranges[0, r], ranges[1, r]):
            dx = coordinates[0, j] - coordinates[0, i]
            dy = coordinates[1, j] - coordinates[1, i]
            dz = coordinates[2, j] - coordinates[2, i]
            square = dx * dx + dy * dy + dz * dz
            if square < squares[count - 1] and j != i:
                place = count - 1
                while place > 0 and squares[place - 1] > square:
                    squares[place] = squares[place - 1]
                    place -= 1
                squares[place] = square
    if squares[count - 1] >= reach * reach:
        return np.nan
    total = 0.0
    for k in range(count):
        total += math.sqrt(squares[k])
    return total / count
