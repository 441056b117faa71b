"""The nearest points of every point of a grid, in order of distance."""

import numpy as np
from numba import njit, prange

from pcsmooth.kernels.grid import adjacent_cells


@njit(parallel=True, cache=True)
def nearest_points(coordinates, cell_codes, cell_starts, dimension, count, reach):
    """Find the nearest points of each point, itself first, among those nearer than `reach`.

    Parameters: coordinates (3, n) in grid order (cells of side >= reach); codes (m,) and starts
    (m + 1,) of the occupied cells; d. Returns numbers in grid order (n, count), n for none.
    """
    n = coordinates.shape[1]
    neighbors = np.full((n, count), n, np.int32)
    for cell in prange(cell_codes.size):
        _search_cell(
            coordinates, cell_codes, cell_starts, np.int64(cell), dimension, reach, neighbors
        )
    return neighbors


@njit(cache=True)
def _search_cell(coordinates, cell_codes, cell_starts, cell, dimension, reach, neighbors):
    """Find the neighbours of the points of one cell."""
    count = neighbors.shape[1]
    found = np.empty(27, np.int64)
    n_found = adjacent_cells(cell_codes, cell, dimension, found)
    distances2 = np.empty(count)
    for i in range(cell_starts[cell], cell_starts[cell + 1]):
        nearest = neighbors[i]
        nearest[0] = i
        filled = 1
        limit = reach * reach
        for f in range(n_found):
            for j in range(cell_starts[found[f]], cell_starts[found[f] + 1]):
                dx = coordinates[0, j] - coordinates[0, i]
                dy = coordinates[1, j] - coordinates[1, i]
                dz = coordinates[2, j] - coordinates[2, i]
                distance2 = dx * dx + dy * dy + dz * dz
                if distance2 < limit and j != i:
                    if filled < count:
                        filled += 1
                    place = filled - 1
                    while place > 1 and distances2[place - 1] > distance2:
                        distances2[place] = distances2[place - 1]
                        nearest[place] = nearest[place - 1]
                        place -= 1
                    distances2[place] = distance2
                    nearest[place] = j
                    if filled == count:
                        limit = distances2[count - 1]
