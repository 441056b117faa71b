"""Signs handed on along a minimum spanning forest of a graph of neighbours."""

import numpy as np
from numba import njit


@njit(cache=True)
def signs_along_forest(normals, neighbors, links):
    """Signs that make each normal agree with its parent's in a minimum spanning forest.

    The graph joins each point to its first neighbours after itself, `links` at most, with
    weights 1 - abs(n_i . n_j). normals (n, d), neighbors (n, k) with n for none -> signs (n,),
    and the lowest number of a point in the component of each, (n,).

    Boruvka's algorithm: every component takes the lightest link that leaves it, until there is
    none. Each point knows its sign relative to its root's; joining two components compares only
    the two ends of the link. Of links with the same weight that with the lower numbers is
    lighter, which rules out cycles.
    """
    n = normals.shape[0]
    links = min(links, neighbors.shape[1] - 1)
    roots = np.empty(n, np.int32)
    signs = np.empty(n, np.int8)
    border = np.empty(n, np.int32)  # points that may have a link to another component
    for i in range(n):
        roots[i] = i
        signs[i] = 1
        border[i] = i
    n_border = n
    lightest = np.empty(n)
    link_of = np.empty((n, 2), np.int32)
    joined = True
    while joined:
        lightest[:] = np.inf
        n_left = 0
        for b in range(n_border):
            i = border[b]
            nearest = np.inf
            other = -1
            for k in range(1, links + 1):
                j = neighbors[i, k]
                if j == n:
                    break
                if roots[i] != roots[j]:
                    weight = 1.0 - abs(_product(normals, i, j))
                    _propose(roots[j], weight, i, j, lightest, link_of)
                    if weight < nearest or (weight == nearest and j < other):
                        nearest = weight
                        other = j
            if other >= 0:
                _propose(roots[i], nearest, i, other, lightest, link_of)
                border[n_left] = i
                n_left += 1
        n_border = n_left

        joined = False
        for component in range(n):
            if lightest[component] < np.inf:
                i = link_of[component, 0]
                j = link_of[component, 1]
                joined |= _join(i, j, _product(normals, i, j), roots, signs)
        for i in range(n):  # a root comes before its points, so one pass flattens
            signs[i] *= signs[roots[i]]
            roots[i] = roots[roots[i]]
    return signs, roots


@njit(cache=True)
def _product(normals, i, j):
    product = 0.0
    for axis in range(normals.shape[1]):
        product += normals[i, axis] * normals[j, axis]
    return product


@njit(cache=True)
def _propose(component, weight, i, j, lightest, link_of):
    """Make a link the lightest of a component if it is."""
    if not weight <= lightest[component]:  # NaN joins nothing
        return
    if i > j:
        i, j = j, i
    if weight == lightest[component]:
        if i > link_of[component, 0]:
            return
        if i == link_of[component, 0] and j >= link_of[component, 1]:
            return
    lightest[component] = weight
    link_of[component, 0] = i
    link_of[component, 1] = j


@njit(cache=True)
def _join(i, j, product, roots, signs):
    """Join the components of i and j so that their normals agree; False if they are one."""
    root_i, sign_i = _find(i, roots, signs)
    root_j, sign_j = _find(j, roots, signs)
    if root_i == root_j:
        return False
    if root_i > root_j:
        root_i, root_j = root_j, root_i
    roots[root_j] = root_i
    signs[root_j] = sign_i * sign_j if product >= 0.0 else -sign_i * sign_j
    return True


@njit(cache=True)
def _find(i, roots, signs):
    """Root of a point and its sign relative to it; halves the path on the way."""
    sign = 1
    while roots[i] != i:
        above = roots[i]
        signs[i] *= signs[above]
        roots[i] = roots[above]
        sign *= signs[i]
        i = roots[i]
    return i, sign
