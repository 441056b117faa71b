"""Mean distance from some points of a grid to their k nearest points."""

import math

import numpy as np

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import adjacent_cells, cell_of_point
from pcsmooth.kernels.threads import shared_out


@shared_out("samples")
@kernel("f2 i1 i1 i i f i1 f1 i i")
def mean_k_nearest_distances(
    coordinates, cell_codes, cell_starts, dimension, count, reach, samples, means, first, last
):  # fmt: skip
    """Mean distance to the `count` nearest others, NaN where fewer are nearer than `reach`.

    Parameters: coordinates (3, n) of distinct points in grid order (cells of side >= reach);
    codes (m,) and starts (m + 1,) of the occupied cells; d; places of the samples in grid order
    (s,). Fills means (s,).
    """
    for s in range(first, last):
        means[s] = _mean_distance(
            coordinates, cell_codes, cell_starts, dimension, count, reach, samples[s]
        )


@inner
def _mean_distance(coordinates, cell_codes, cell_starts, dimension, count, reach, i):
    """Do it for the point at place i, keeping the nearest so far in order."""
    found = np.empty(27, np.int64)
    cell = np.int64(cell_of_point(cell_starts, i))
    n_found = adjacent_cells(cell_codes, cell, dimension, found)
    squares = np.empty(count)
    for k in range(count):
        squares[k] = reach * reach
    for f in range(n_found):
        for j in range(cell_starts[found[f]], cell_starts[found[f] + 1]):
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
