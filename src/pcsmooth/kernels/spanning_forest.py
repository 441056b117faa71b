"""Signs handed on along a minimum spanning forest of a graph of neighbours."""

import numpy as np
from numba import njit, prange

#: Points per block of those that are joined in parallel; the result does not depend on threads.
BLOCK = 4096

#: Normals of neighbours whose product is at least this hand on their sign without comparison.
_ALIKE = 0.9


@njit(cache=True)
def signs_along_forest(normals, links):
    """Signs that make each normal agree with its parent's in a minimum spanning forest.

    The graph joins each point to the points that its links name, with weights 1 - abs(n_i . n_j).
    normals (d, n), links (n, l) with n for none -> signs (n,), and the lowest number of a point
    in the component of each, (n,).

    Boruvka's algorithm: every component takes the lightest link that leaves it, until there is
    none. Each point knows its sign relative to its root's; joining two components compares only
    the two ends of the link. Of links with the same weight that with the lower numbers is
    lighter, which rules out cycles. Links lighter than 0.1 within a block of points are joined
    before, in the order in which they come: along them the sign is beyond doubt.
    """
    n = normals.shape[1]
    n_links = links.shape[1]
    roots = np.empty(n, np.int32)
    signs = np.empty(n, np.int8)
    _join_alike(normals, links, roots, signs)
    leads_out = np.empty(n, np.bool_)
    _find_exits(links, roots, leads_out)
    border = np.empty(n, np.int32)  # points that may have a link to another component
    n_border = 0
    lightest = np.empty(n)
    for i in range(n):
        lightest[i] = np.inf
        if leads_out[i]:
            border[n_border] = i
            n_border += 1
    link_of = np.empty((n, 2), np.int32)
    while n_border > 0:
        n_left = 0
        n_proposals = 0
        proposals = np.empty((1 + n_links) * n_border, np.int32)  # components with a lightest link
        for b in range(n_border):
            i = border[b]
            root_i, _ = _find(i, roots, signs)
            nearest = np.inf
            other = -1
            for k in range(n_links):
                j = links[i, k]
                if j == n:
                    break
                root_j, _ = _find(j, roots, signs)
                if root_i != root_j:
                    weight = 1.0 - abs(_product(normals, i, j))
                    proposals[n_proposals] = root_j
                    n_proposals += _propose(root_j, weight, i, j, lightest, link_of)
                    if weight < nearest or (weight == nearest and j < other):
                        nearest = weight
                        other = j
            if other >= 0:
                proposals[n_proposals] = root_i
                n_proposals += _propose(root_i, nearest, i, other, lightest, link_of)
                border[n_left] = i
                n_left += 1
        n_border = n_left
        for c in range(n_proposals):
            component = proposals[c]
            if lightest[component] < np.inf:
                lightest[component] = np.inf
                i = link_of[component, 0]
                j = link_of[component, 1]
                _join(i, j, _product(normals, i, j), roots, signs)
    _flatten(0, n, roots, signs)
    return signs, roots


@njit(parallel=True, cache=True)
def _find_exits(links, roots, leads_out):
    """Note whether a point has a link to another component, (n,)."""
    n = roots.size
    for i in prange(n):
        leads_out[i] = False
        for k in range(links.shape[1]):
            j = links[i, k]
            if j < n and roots[i] != roots[j]:
                leads_out[i] = True


@njit(parallel=True, cache=True)
def _join_alike(normals, links, roots, signs):
    """Start with every point on its own, then join those of a block that are alike."""
    n = normals.shape[1]
    for block in prange((n + BLOCK - 1) // BLOCK):
        start = block * BLOCK
        stop = min(start + BLOCK, n)
        for i in range(start, stop):
            roots[i] = i
            signs[i] = 1
        for i in range(start, stop):
            for k in range(links.shape[1]):
                j = links[i, k]
                if start <= j < stop and roots[i] != roots[j]:
                    product = _product(normals, i, j)
                    if abs(product) >= _ALIKE:
                        _join(i, j, product, roots, signs)
        _flatten(start, stop, roots, signs)


@njit(cache=True)
def _flatten(start, stop, roots, signs):
    """Let points refer to their roots directly; a root comes before its points."""
    for i in range(start, stop):
        signs[i] *= signs[roots[i]]
        roots[i] = roots[roots[i]]


@njit(cache=True)
def _product(normals, i, j):
    product = 0.0
    for axis in range(normals.shape[0]):
        product += normals[axis, i] * normals[axis, j]
    return product


@njit(cache=True)
def _propose(component, weight, i, j, lightest, link_of):
    """Make a link the lightest of a component if it is; True if it is its first."""
    is_first = lightest[component] == np.inf
    if not weight <= lightest[component]:  # NaN joins nothing
        return False
    if i > j:
        i, j = j, i
    if weight == lightest[component]:
        if i > link_of[component, 0]:
            return False
        if i == link_of[component, 0] and j >= link_of[component, 1]:
            return False
    lightest[component] = weight
    link_of[component, 0] = i
    link_of[component, 1] = j
    return is_first


@njit(cache=True)
def _join(i, j, product, roots, signs):
    """Join the components of i and j, if they are two, so that their normals agree."""
    root_i, sign_i = _find(i, roots, signs)
    root_j, sign_j = _find(j, roots, signs)
    if root_i == root_j:
        return
    if root_i > root_j:
        root_i, root_j = root_j, root_i
    roots[root_j] = root_i
    signs[root_j] = sign_i * sign_j if product >= 0.0 else -sign_i * sign_j


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
