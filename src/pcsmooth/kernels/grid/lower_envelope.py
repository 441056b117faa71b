"""The largest values below given ones that change slowly from point to point."""

import math

import numpy as np

from pcsmooth.kernels.compiled import kernel
from pcsmooth.kernels.grid.box_tree import LEAF, STACK, square_to_box
from pcsmooth.kernels.threads import shared_out


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
    for i in range(first, last):
        x = coordinates[0, i]
        y = coordinates[1, i]
        z = coordinates[2, i]
        best = values[i]
        top = n_leaves + i // LEAF
        stack[0] = top
        size = 1
        while True:
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
