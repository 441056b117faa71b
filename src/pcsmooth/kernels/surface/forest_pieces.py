"""A minimum spanning forest of a graph of neighbours of which tiles know parts.

The graph joins each point to the points that its links name, with weights 1 - abs(n_i . n_j). The
lighter of two links is that with the lower weight, then that with the lower of its ends' numbers,
then that with the lower number of the other end: there are no ties, and no cycles. Signs are handed
on along the forest, so that the normals at the two ends of each of its links agree.

Each tile joins the points of its blocks that are alike (`spanning_forest.join_alike`), names what
came out (`parity_union_find.refer_to_lowest`) and finds the lightest links in between
(`exit_edges`). What all tiles found is joined at last (`span`). Components and signs are the same
whatever the tiles, as long as each has all of the blocks of its own points and of those they have
links to.
"""

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.surface.parity_union_find import flatten, join
from pcsmooth.kernels.surface.spanning_forest import find_exits, product_of_normals

#: A link between two roots: what orders it (its weight, then the lower and the higher number of
#: its ends), the roots, a < b, and sign_a sign_b if the normals at its ends agree.
EDGE = np.dtype(
    [
        ("weight", np.float64),
        ("low", np.int64),
        ("high", np.int64),
        ("root_a", np.int64),
        ("root_b", np.int64),
        ("sign", np.int8),
    ],
    align=True,
)

#: Edges for which there is room at first.
_ROOM = 1024

#: Odd numbers that spread the numbers of roots over a table (SplitMix64's).
_MIX_A = np.uint64(0x9E3779B97F4A7C15)
_MIX_B = np.uint64(0xBF58476D1CE4E5B9)


def exit_edges(
    normals: npt.NDArray[np.float64],
    links: npt.NDArray[np.int32],
    numbers: npt.NDArray[np.int64],
    roots: npt.NDArray[np.int64],
    signs: npt.NDArray[np.int8],
    own: npt.NDArray[np.bool_],
) -> npt.NDArray[np.void]:
    """Find the lightest link between every two roots that links of a tile's own points join.

    Parameters
    ----------
    normals : ndarray, shape (d, n)
        Normals of the points of a tile and of all to which its own points have links.
    links : ndarray of int32, shape (n, l)
        Links of each point by place, n for none.
    numbers : ndarray of int64, shape (n,)
        Numbers of the points in the whole cloud.
    roots : ndarray of int64, shape (n,)
        What each point is joined to already, by a number that is the same in all tiles: the lowest
        of its points', for the signs of the whole.
    signs : ndarray of int8, shape (n,)
        Signs relative to the root's.
    own : ndarray of bool, shape (n,)
        Points whose links count.

    Returns
    -------
    ndarray of `EDGE`, shape (m,)
        One for each unordered pair of roots.
    """
    leads_out = find_exits(links, roots)
    leads_out &= own
    edges = np.empty(_ROOM, EDGE)
    table = np.full(2 * _ROOM, -1)
    begin = 0
    count = 0
    while True:
        begin, count = _collect_edges(
            normals, links, numbers, roots, signs, leads_out, begin, edges, count, table
        )
        if begin == len(own):
            return edges[:count].copy()
        edges = np.concatenate([edges[:count], np.empty(len(edges) * 2 - count, EDGE)])
        table = np.full(2 * len(edges), -1)
        _fill_table(edges, count, table)


def span(
    edges: npt.NDArray[np.void],
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int8]]:
    """Join roots along a minimum spanning forest of the edges between them.

    Parameters
    ----------
    edges : ndarray of `EDGE`, shape (m,)
        Those of all tiles in any order; a pair of roots may have several.

    Returns
    -------
    roots : ndarray of int64, shape (r,)
        Roots that have an edge, increasing.
    root_of : ndarray of int64, shape (r,)
        The lowest root in the component of each.
    sign_of : ndarray of int8, shape (r,)
        Its sign relative to that.
    """
    roots, parents, signs, _ = _join_edges(edges)
    return roots, roots[parents], signs


def thin(edges: npt.NDArray[np.void]) -> npt.NDArray[np.void]:
    """Leave out the edges that are in no minimum spanning forest, whatever edges are added.

    The heaviest of the edges that close a cycle is none of the whole's either: of r roots at most
    r - 1 edges are left. `span` comes out the same.

    Parameters
    ----------
    edges : ndarray of `EDGE`, shape (m,)
        Those of one or more tiles.

    Returns
    -------
    ndarray of `EDGE`
        The edges of their minimum spanning forest, lightest first.
    """
    _, _, _, joining = _join_edges(edges)
    return edges[joining]


def _join_edges(
    edges: npt.NDArray[np.void],
) -> tuple[
    npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int8], npt.NDArray[np.int64]
]:
    """Kruskal's algorithm: roots (r,), places of their components' lowest, signs, edges used."""
    roots, ends = np.unique(np.r_[edges["root_a"], edges["root_b"]], return_inverse=True)
    order = np.lexsort((edges["high"], edges["low"], edges["weight"]))
    parents = np.arange(len(roots))
    signs = np.ones(len(roots), np.int8)
    joins = _join_in_order(order, ends.reshape(2, -1), edges["sign"], parents, signs)
    return roots, parents, signs, order[joins]


@kernel("i1 i2 s1 i1 s1", "i1 i2 s1~ i1 s1")
def _join_in_order(order, ends, relations, roots, signs):
    """Join the ends (2, m) of edges in an order (m,); returns which of them joined two, (m,)."""
    joins = np.empty(order.size, np.bool_)
    for k in range(order.size):
        e = order[k]
        joins[k] = join(ends[0, e], ends[1, e], relations[e], roots, signs)
    flatten(0, roots.size, roots, signs)
    return joins


@kernel("f2 j2 i1 i1 s1 b1 i edge1 i i1", edge=EDGE)
def _collect_edges(
    normals, links, numbers, roots, signs, leads_out, begin, edges, count, table,
):  # fmt: skip
    """Add the links of points from `begin` on to the edges while there is room for a point's.

    Returns the point to go on with, and how many edges there are.
    """
    n, n_links = links.shape
    for i in range(begin, n):
        if not leads_out[i]:
            continue
        if count + n_links > edges.size:
            return i, count
        for k in range(n_links):
            j = links[i, k]
            if j == n or roots[i] == roots[j]:
                continue
            product = product_of_normals(normals, i, j)
            weight = 1.0 - abs(product)
            if np.isnan(weight):  # joins nothing
                continue
            low = min(numbers[i], numbers[j])
            high = max(numbers[i], numbers[j])
            a = min(roots[i], roots[j])
            b = max(roots[i], roots[j])
            slot = _slot(a, b, edges, table)
            e = table[slot]
            if e < 0:
                e = count
                table[slot] = e
                count += 1
            elif not _is_lighter(weight, low, high, edges[e]):
                continue
            edge = edges[e]
            edge.weight = weight
            edge.low = low
            edge.high = high
            edge.root_a = a
            edge.root_b = b
            edge.sign = signs[i] * signs[j] * (1 if product >= 0.0 else -1)
    return n, count


@kernel("edge1 i i1", edge=EDGE)
def _fill_table(edges, count, table):
    """Enter edges into an empty table."""
    for e in range(count):
        table[_slot(edges[e].root_a, edges[e].root_b, edges, table)] = e


@inner
def _slot(a, b, edges, table):
    """Place of a pair of roots in a table of edges, whose size is a power of 2; -1 where free."""
    mixed = (np.uint64(a) * _MIX_A + np.uint64(b)) * _MIX_B
    mixed ^= mixed >> np.uint64(31)
    mask = np.uint64(table.size - 1)
    slot = mixed & mask
    while table[slot] >= 0:
        edge = edges[table[slot]]
        if edge.root_a == a and edge.root_b == b:
            break
        slot = (slot + np.uint64(1)) & mask
    return slot


@inner
def _is_lighter(weight, low, high, edge):
    """Whether a link comes before an edge."""
    if weight != edge.weight:
        return weight < edge.weight
    return low < edge.low or (low == edge.low and high < edge.high)
