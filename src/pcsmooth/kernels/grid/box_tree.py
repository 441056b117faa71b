"""Tree of boxes around points in Morton order, and the points nearest to a position.

A leaf is a run of points. Node k has the children 2 k and 2 k + 1, the root is 1, and the leaves
are the last half of the nodes; those without a point have a box infinitely far from everything.
Points that are close in space are mostly in one subtree, however the density varies, so that a
search looks at few boxes anywhere.
"""

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.arithmetic.simd import WIDTH, bits, count_bits, load
from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.within_reach import NUMBER, SQUARE, sort_by_distance, store_chosen
from pcsmooth.kernels.threads import MANY, shared_out

#: Points of a leaf.
LEAF = 8

#: Nodes that can be waiting to be looked at: one of each generation, and two of the last.
STACK = 64


def build_box_tree(coordinates: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Put boxes around points (3, n) in Morton order: (2 m, 6) corners of the nodes, m leaves."""
    n_leaves = 1
    while n_leaves * LEAF < coordinates.shape[1]:
        n_leaves *= 2
    boxes = np.full((2 * n_leaves, 6), np.inf)
    boxes[:, 3:] = -np.inf
    _box_leaves(coordinates, boxes[n_leaves:])
    while n_leaves > 1:
        children = boxes[n_leaves : 2 * n_leaves]
        n_leaves //= 2
        parents = boxes[n_leaves : 2 * n_leaves]
        np.minimum(children[::2, :3], children[1::2, :3], out=parents[:, :3])
        np.maximum(children[::2, 3:], children[1::2, 3:], out=parents[:, 3:])
    return boxes


def least_in_boxes(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Least of the values (n,) of the points in each node, (2 m,); infinite where there is none."""
    n_leaves = 1
    while n_leaves * LEAF < len(values):
        n_leaves *= 2
    least = np.full(2 * n_leaves, np.inf)
    starts = np.arange(0, len(values), LEAF)
    least[n_leaves : n_leaves + len(starts)] = np.minimum.reduceat(values, starts)
    while n_leaves > 1:
        children = least[n_leaves : 2 * n_leaves]
        n_leaves //= 2
        np.minimum(children[::2], children[1::2], out=least[n_leaves : 2 * n_leaves])
    return least


@shared_out("boxes", MANY // LEAF)
@kernel("f2 f2 i i")
def _box_leaves(coordinates, boxes, first, last):
    """Put boxes (m, 6) around the points of leaves; those of others are left as they are."""
    for leaf in range(first, last):
        for k in range(leaf * LEAF, min((leaf + 1) * LEAF, coordinates.shape[1])):
            for axis in range(3):
                boxes[leaf, axis] = min(boxes[leaf, axis], coordinates[axis, k])
                boxes[leaf, axis + 3] = max(boxes[leaf, axis + 3], coordinates[axis, k])


@inner
def square_to_box(boxes, node, x, y, z):
    """Square of the distance from (x, y, z) to the box of a node."""
    dx = max(boxes[node, 0] - x, x - boxes[node, 3], 0.0)
    dy = max(boxes[node, 1] - y, y - boxes[node, 4], 0.0)
    dz = max(boxes[node, 2] - z, z - boxes[node, 5], 0.0)
    return dx * dx + dy * dy + dz * dz


@inner
def square_between_boxes(boxes, node, other):
    """Square of the distance between the boxes of two nodes."""
    square = 0.0
    for axis in range(3):
        below = boxes[other, axis] - boxes[node, axis + 3]
        above = boxes[node, axis] - boxes[other, axis + 3]
        gap = max(below, above, 0.0)
        square += gap * gap
    return square


@inner
def find_nearest(coordinates, boxes, x, y, z, itself, count, found, squares, stack):
    """Find the `count` points that are nearest to (x, y, z).

    itself: number of the point that is there and does not count. Into
    found go the numbers and into squares those of the distances, increasing; of equal distances
    the lower number counts as the nearer. Where there are fewer points: n and infinity.
    """
    n_leaves = boxes.shape[0] // 2
    for k in range(count):
        squares[k] = np.inf
        found[k] = coordinates.shape[1]
    # From the point's own leaf upwards, and down on the other side of each node on the way: what is
    # nearest comes first (four times as fast as down from the root).
    top = n_leaves + itself // LEAF
    stack[0] = top
    size = 1
    while True:
        while size > 0:
            size -= 1
            node = stack[size]
            if square_to_box(boxes, node, x, y, z) > squares[count - 1]:
                continue
            if node >= n_leaves:
                _take_leaf(coordinates, node - n_leaves, itself, x, y, z, count, found, squares)
                continue
            nearer = 2 * node
            if square_to_box(boxes, nearer + 1, x, y, z) < square_to_box(boxes, nearer, x, y, z):
                nearer += 1
            stack[size] = nearer ^ 1
            stack[size + 1] = nearer
            size += 2
        if top == 1:
            break
        stack[0] = top ^ 1
        size = 1
        top >>= 1


@inner
def collect_around(coordinates, boxes, leaf, reach, candidates, stack):
    """Collect the points of the leaves nearer than `reach` to the box of a leaf, by number.

    Fills candidates: x, y, z, number; infinities follow. Returns how many there are, or 0 if there
    are more than there is room for.
    """
    n_leaves = boxes.shape[0] // 2
    most = candidates.shape[1] - WIDTH - LEAF
    own = n_leaves + leaf
    count = np.int64(0)
    stack[0] = 1
    size = 1
    while size > 0:
        size -= 1
        node = stack[size]
        if square_between_boxes(boxes, node, own) >= reach * reach:
            continue
        if node < n_leaves:
            stack[size] = 2 * node + 1
            stack[size + 1] = 2 * node
            size += 2
            continue
        if count > most:
            return np.int64(0)
        start = (node - n_leaves) * LEAF
        for k in range(start, min(start + LEAF, coordinates.shape[1])):
            candidates[0, count] = coordinates[0, k]
            candidates[1, count] = coordinates[1, k]
            candidates[2, count] = coordinates[2, k]
            candidates[3, count] = k
            count += 1
    for k in range(count, count + WIDTH):
        candidates[0, k] = np.inf
        candidates[1, k] = np.inf
        candidates[2, k] = np.inf
    return count


@inner
def find_among(
    candidates, n_candidates, x, y, z, itself, reach, count, near, spare, found, squares
):  # fmt: skip
    """Find the `count` nearest points as `find_nearest` does, if so many are nearer than `reach`.

    Among candidates that hold all these; near and spare have N_ROWS and room for them. Returns
    whether there are so many.
    """
    own = float(itself)
    n_near = np.int64(0)
    for c in range(0, n_candidates, WIDTH):
        dx = load(candidates, 0, c) - x
        dy = load(candidates, 1, c) - y
        dz = load(candidates, 2, c) - z
        square = dx * dx + dy * dy + dz * dz  # to the last bit as one by one
        number = load(candidates, 3, c)
        within = (square < reach * reach) & ((number < own) | (number > own))
        if bits(within) == 0:
            continue
        store_chosen(near, n_near, dx, dy, dz, square, number, within)
        n_near += count_bits(bits(within))
    if n_near < count:
        return False
    sort_by_distance(near, n_near, spare)
    for k in range(count):
        found[k] = int(spare[NUMBER, k])
        squares[k] = spare[SQUARE, k]
    return True


@inner
def _take_leaf(coordinates, leaf, itself, x, y, z, count, found, squares):
    """Put the points of a leaf among the nearest so far, if they belong there."""
    for k in range(leaf * LEAF, min((leaf + 1) * LEAF, coordinates.shape[1])):
        dx = coordinates[0, k] - x
        dy = coordinates[1, k] - y
        dz = coordinates[2, k] - z
        square = dx * dx + dy * dy + dz * dz
        place = count - 1
        if k == itself or not _is_nearer(square, k, squares[place], found[place]):
            continue
        while place > 0 and _is_nearer(square, k, squares[place - 1], found[place - 1]):
            squares[place] = squares[place - 1]
            found[place] = found[place - 1]
            place -= 1
        squares[place] = square
        found[place] = k


@inner
def _is_nearer(square, k, other_square, other):
    """Tell which of two points comes first, by distance and then by number."""
    return square < other_square or (square == other_square and k < other)
