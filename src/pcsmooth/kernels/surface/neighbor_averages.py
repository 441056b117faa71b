"""Medians and means of values over points and their neighbours."""

import numpy as np

from pcsmooth.kernels.compiled import kernel
from pcsmooth.kernels.threads import MANY, shared_out


@shared_out("values", MANY)
@kernel("f1 j2 f1 i i")
def take_medians(values, neighbors, medians, first, last):
    """Median of the values (n,) of each point and its neighbours (n, m), the lower one of two."""
    ordered = np.empty(neighbors.shape[1] + 1)
    for i in range(first, last):
        ordered[0] = values[i]
        for k in range(neighbors.shape[1]):
            value = values[neighbors[i, k]]
            place = k + 1
            while place > 0 and ordered[place - 1] > value:
                ordered[place] = ordered[place - 1]
                place -= 1
            ordered[place] = value
        medians[i] = ordered[neighbors.shape[1] // 2]


@shared_out("values", MANY)
@kernel("f1 j2 f1 i i")
def take_means(values, neighbors, means, first, last):
    """Mean of the values (n,) of each point and its neighbours (n, m)."""
    for i in range(first, last):
        total = values[i]
        for k in range(neighbors.shape[1]):
            total += values[neighbors[i, k]]
        means[i] = total / (neighbors.shape[1] + 1)
