"""Signs handed on along a minimum spanning forest of a graph of neighbours.

The graph joins each point to the points that its links name, with weights 1 - abs(n_i . n_j). The
lighter of two links is that with the lower weight, then that with the lower of its ends' numbers,
then that with the lower number of the other end: there are no ties, and no cycles.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.surface.signed_sets import find, flatten, join, refer_to_lowest
from pcsmooth.kernels.threads import MANY, shared_out

#: Normals of neighbours whose product is at least this hand on their sign without comparison.
_ALIKE = 0.9


def signs_along_forest(
    normals: npt.NDArray[np.float64],
    links: npt.NDArray[np.int32],
    numbers: npt.NDArray[np.int64],
    block_starts: npt.NDArray[np.int64],
) -> tuple[npt.NDArray[np.int8], npt.NDArray[np.int32]]:
    """Signs that make each normal agree with its parent's in a minimum spanning forest.

    normals (d, n), links (n, l) with n for none, numbers (n,) that order links of equal weight,
    block_starts (b + 1,) from 0 to n -> signs (n,), 1 for the lowest number of a component, and the
    first point in the component of each, (n,).

    Boruvka's algorithm: every component takes the lightest link that leaves it, until there is
    none. Each point knows its sign relative to its root's; joining two components compares only
    the two ends of the link. Links lighter than 0.1 within a block of points are joined before:
    see `join_alike`.
    """
    roots, signs = join_alike(normals, links, block_starts)
    leads_out = find_exits(links, roots)
    _join_along_lightest(normals, links, numbers, roots, signs, leads_out)
    _, signs = refer_to_lowest(roots, signs, numbers)
    return signs, roots


@kernel("f2 j2 i1 j1 s1 b1")
def _join_along_lightest(normals, links, numbers, roots, signs, leads_out):
    """Go on until no link leads out of a component.

    roots (n,) and signs (n,) are those of `join_alike` and change, leads_out (n,) is that of
    `find_exits`.
    """
    n = normals.shape[1]
    n_links = links.shape[1]
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
            root_i, _ = find(i, roots, signs)
            nearest = np.inf
            other = -1
            for k in range(n_links):
                j = links[i, k]
                if j == n:
                    break
                root_j, _ = find(j, roots, signs)
                if root_i != root_j:
                    weight = 1.0 - abs(product_of_normals(normals, i, j))
                    if weight <= lightest[root_j]:  # NaN joins nothing
                        proposals[n_proposals] = root_j
                        n_proposals += _propose(root_j, weight, i, j, numbers, lightest, link_of)
                    if weight < nearest or (weight == nearest and numbers[j] < numbers[other]):
                        nearest = weight
                        other = j
            if other >= 0:
                if nearest <= lightest[root_i]:
                    proposals[n_proposals] = root_i
                    n_proposals += _propose(root_i, nearest, i, other, numbers, lightest, link_of)
                border[n_left] = i
                n_left += 1
        n_border = n_left
        for c in range(n_proposals):
            component = proposals[c]
            if lightest[component] < np.inf:
                lightest[component] = np.inf
                i = link_of[component, 0]
                j = link_of[component, 1]
                relation = 1 if product_of_normals(normals, i, j) >= 0.0 else -1
                join(i, j, relation, roots, signs)
    flatten(0, n, roots, signs)


def join_alike(
    normals: npt.NDArray[np.float64],
    links: npt.NDArray[np.int32],
    block_starts: npt.NDArray[np.int64],
) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int8]]:
    """Start with every point on its own, then join those of a block that are alike.

    normals (d, n), links (n, l) with n for none, block_starts (b + 1,) from 0 to n -> the first
    point in the component of each, (n,), and its sign relative to that, (n,).

    They are joined in the order in which they and their links come: along links between normals
    that are alike the sign is beyond doubt. What comes out for a block depends on its own points
    only, and not on where it begins.
    """
    roots = np.empty(normals.shape[1], np.int32)
    signs = np.empty(normals.shape[1], np.int8)
    _join_blocks(normals, links, block_starts, roots, signs)
    return roots, signs


@shared_out("block_starts")
@kernel("f2 j2 i1 j1 s1 i i")
def _join_blocks(normals, links, block_starts, roots, signs, first, last):
    """Do it for some blocks."""
    for block in range(first, last):
        start = block_starts[block]
        stop = block_starts[block + 1]
        for i in range(start, stop):
            roots[i] = i
            signs[i] = 1
        for i in range(start, stop):
            for k in range(links.shape[1]):
                j = links[i, k]
                if start <= j < stop and roots[i] != roots[j]:
                    product = product_of_normals(normals, i, j)
                    if abs(product) >= _ALIKE:
                        join(i, j, 1 if product >= 0.0 else -1, roots, signs)
        flatten(start, stop, roots, signs)


def find_exits(
    links: npt.NDArray[np.int32], roots: npt.NDArray[np.signedinteger[Any]]
) -> npt.NDArray[np.bool_]:
    """Note whether a point has a link to another component, (n,)."""
    leads_out = np.empty(roots.size, np.bool_)
    _note_exits(links, roots, leads_out)
    return leads_out


@shared_out("roots", MANY // 8)
@kernel("j2 j1 b1 i i", "j2 i1 b1 i i")
def _note_exits(links, roots, leads_out, first, last):
    """Do it for some points."""
    n = roots.size
    for i in range(first, last):
        leads_out[i] = False
        for k in range(links.shape[1]):
            j = links[i, k]
            if j < n and roots[i] != roots[j]:
                leads_out[i] = True


@inner
def product_of_normals(normals, i, j):
    """Scalar product of two of the normals (d, n), the same bits if they change places."""
    product = 0.0
    for axis in range(normals.shape[0]):
        product += normals[axis, i] * normals[axis, j]
    return product


@inner
def _propose(component, weight, i, j, numbers, lightest, link_of):
    """Make a link that is no heavier the lightest of a component if it is; True if it is its first.

    That it is no heavier is for the caller to see, who mostly sees the opposite.
    """
    is_first = lightest[component] == np.inf
    if i > j:
        i, j = j, i
    if weight == lightest[component]:
        first = link_of[component, 0]
        second = link_of[component, 1]
        if i == first and j == second:  # known from its other end
            return False
        low = min(numbers[i], numbers[j])
        least = min(numbers[first], numbers[second])
        if low > least:
            return False
        if low == least and max(numbers[i], numbers[j]) > max(numbers[first], numbers[second]):
            return False
    lightest[component] = weight
    link_of[component, 0] = i
    link_of[component, 1] = j
    return is_first
