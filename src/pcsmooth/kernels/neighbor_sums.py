"""Sums over neighbourhoods."""

import numpy as np
from numba import njit


@njit(cache=True)
def sum_over_neighbors(values, neighbors):
    """Row sums over neighbours: values (n, c), neighbors (m, k) with n for "none" -> (m, c)."""
    n, columns = values.shape
    count, width = neighbors.shape
    sums = np.zeros((count, columns))
    for i in range(count):
        for k in range(width):
            j = neighbors[i, k]
            if j < n:
                for c in range(columns):
                    sums[i, c] += values[j, c]
    return sums
