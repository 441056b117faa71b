"""Sums over neighbourhoods, and signs along a spanning tree."""

import numpy as np
from numba import njit, prange


@njit(parallel=True, cache=True)
def sum_over_neighbors(values, neighbors):
    """Row sums over neighbours: values (n, c), neighbors (m, k) with n for "none" -> (m, c)."""
    n, columns = values.shape
    count, width = neighbors.shape
    sums = np.zeros((count, columns))
    for i in prange(count):
        for k in range(width):
            j = neighbors[i, k]
            if j < n:
                for c in range(columns):
                    sums[i, c] += values[j, c]
    return sums


@njit(cache=True)
def signs_along_tree(order, parents, normals):
    """Signs that make each normal agree with its parent's.

    order: nodes, parents first; parents (n,), negative at a root; normals (n, d) -> (n,).
    """
    signs = np.ones(normals.shape[0])
    for node in order:
        parent = parents[node]
        if parent >= 0:
            product = 0.0
            for axis in range(normals.shape[1]):
                product += normals[node, axis] * normals[parent, axis]
            signs[node] = signs[parent] if product >= 0.0 else -signs[parent]
    return signs
