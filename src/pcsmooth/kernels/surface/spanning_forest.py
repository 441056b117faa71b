"""The start of a minimum spanning forest of a graph of neighbours: what is alike is joined.

The graph joins each point to the points that its links name, with weights 1 - abs(n_i . n_j).
Links lighter than 0.1 within a block of points are joined first, in the order in which they come;
how the others go on is told in `forest_pieces`.
"""

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.surface.parity_union_find import flatten, join
from pcsmooth.kernels.threads import MANY, shared_out

#: Normals of neighbours whose product is at least this hand on their sign without comparison.
_ALIKE = 0.9


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


def find_exits(links: npt.NDArray[np.int32], roots: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Note whether a point has a link to another component, (n,)."""
    leads_out = np.empty(roots.size, np.bool_)
    _note_exits(links, roots, leads_out)
    return leads_out


@shared_out("roots", MANY // 8)
@kernel("j2 i1 b1 i i")
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
