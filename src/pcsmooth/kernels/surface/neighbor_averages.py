"""Medians and means of values over points and their neighbours."""

import numpy as np

from pcsmooth.kernels.arithmetic.simd import WIDTH, bits, count_bits, load
from pcsmooth.kernels.compiled import kernel
from pcsmooth.kernels.threads import MANY, shared_out


@shared_out("values", MANY)
@kernel("f1 j2 f1 i i")
def take_medians(values, neighbors, medians, first, last):
    """Median of the values (n,) of each point and its neighbours (n, m), the lower one of two."""
    count = neighbors.shape[1] + 1
    others = np.full((1, count + WIDTH), np.inf)
    for i in range(first, last):
        others[0, 0] = values[i]
        for k in range(neighbors.shape[1]):
            others[0, k + 1] = values[neighbors[i, k]]
        for k in range(count):
            value = others[0, k]
            below = upto = 0
            for c in range(0, count, WIDTH):
                some = load(others, 0, c)
                below += count_bits(bits(some < value))
                upto += count_bits(bits(some <= value))
            if below <= neighbors.shape[1] // 2 < upto:
                medians[i] = value
                break


@shared_out("values", MANY)
@kernel("f1 j2 f1 i i")
def take_means(values, neighbors, means, first, last):
    """Mean of the values (n,) of each point and its neighbours (n, m)."""
    for i in range(first, last):
        total = values[i]
        for k in range(neighbors.shape[1]):
            total += values[neighbors[i, k]]
        means[i] = total / (neighbors.shape[1] + 1)
