"""The largest values below given ones that change slowly from point to point."""

import math

import numpy as np

from pcsmooth.kernels.arithmetic.simd import WIDTH, load, square_root
from pcsmooth.kernels.arithmetic.simd import least as least_lane
from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.box_tree import LEAF, STACK, square_between_boxes, square_to_box
from pcsmooth.kernels.threads import shared_out

#: Points that are collected for those of a leaf; apart from all others there are more.
_ROOM = 512


@shared_out("lowered")
@kernel("f2 f2 f1 f1 f f1 i i")
def lower_to_envelope(coordinates, boxes, values, least, slope, lowered, first, last):
    """Lower values (n,) until they rise by no more than `slope` times the distance, > 0.

    Parameters: coordinates (3, n) in Morton order; boxes of their tree (2 m, 6), and the least of
    the values in each (2 m,). Fills lowered (n,): the least of value_j + slope |p_i - p_j|, for
    which one pass does, by the triangle inequality.
    """
    n_leaves = boxes.shape[0] // 2
    stack = np.empty(STACK, np.int64)
    others = np.zeros((4, _ROOM + WIDTH))
    leaf = np.int64(-1)
    count = np.int64(0)
    for i in range(first, last):
        if i // LEAF != leaf:
            leaf = i // LEAF
            count = _points_that_lower(
                coordinates, boxes, values, least, slope, leaf, others, stack
            )
        x = coordinates[0, i]
        y = coordinates[1, i]
        z = coordinates[2, i]
        best = values[i]
        for c in range(0, count, WIDTH):
            dx = load(others, 0, c) - x
            dy = load(others, 1, c) - y
            dz = load(others, 2, c) - z
            distance = square_root(dx * dx + dy * dy + dz * dz)
            best = min(best, least_lane(load(others, 3, c) + distance * slope))
        top = n_leaves + leaf
        stack[0] = top
        size = 1
        while count > _ROOM:
            while size > 0:
                size -= 1
                node = stack[size]
                room = (best - least[node]) / slope  # nearer points can lower it
                if not room > 0.0 or square_to_box(boxes, node, x, y, z) >= room * room:
                    continue
                if node < n_leaves:
                    stack[size] = 2 * node
                    stack[size + 1] = 2 * node + 1
                    size += 2
                    continue
                start = (node - n_leaves) * LEAF
                for k in range(start, min(start + LEAF, coordinates.shape[1])):
                    dx = coordinates[0, k] - x
                    dy = coordinates[1, k] - y
                    dz = coordinates[2, k] - z
                    best = min(best, values[k] + slope * math.sqrt(dx * dx + dy * dy + dz * dz))
            if top == 1:
                break
            stack[0] = top ^ 1
            size = 1
            top >>= 1
        lowered[i] = best


@inner
def _points_that_lower(coordinates, boxes, values, least, slope, leaf, others, stack):
    """Collect the points that may lower the largest value of a leaf: x, y, z, value.

    Infinities follow. Returns how many there are; if there are more than _ROOM they are not all.
    """
    n_leaves = boxes.shape[0] // 2
    own = n_leaves + leaf
    largest = 0.0
    for k in range(leaf * LEAF, min((leaf + 1) * LEAF, values.size)):
        largest = max(largest, values[k])
    count = np.int64(0)
    stack[0] = 1
    size = 1
    while size > 0 and count <= _ROOM:
        size -= 1
        node = stack[size]
        room = (largest - least[node]) / slope
        if not room > 0.0 or square_between_boxes(boxes, node, own) >= room * room:
            continue
        if node < n_leaves:
            stack[size] = 2 * node
            stack[size + 1] = 2 * node + 1
            size += 2
            continue
        start = (node - n_leaves) * LEAF
        for k in range(start, min(start + LEAF, values.size)):
            x = coordinates[0, k]
            y = coordinates[1, k]
            z = coordinates[2, k]
            room = (largest - values[k]) / slope
            if room > 0.0 and square_to_box(boxes, own, x, y, z) < room * room:
                others[0, count] = x
                others[1, count] = y
                others[2, count] = z
                others[3, count] = values[k]
                count += 1
    for k in range(count, min(count, _ROOM) + WIDTH):
        others[3, k] = np.inf
    return count
