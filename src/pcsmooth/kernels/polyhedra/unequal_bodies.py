"""Neighbours of a convex polyhedron among homothetic ones of other sizes.

Body i is p_i + s_i K, its size s_i in units of that of the tables. With r the radius of the ball
that K holds, space is shared out by power, |x - p_i|^2 - (r s_i)^2: see
`pcsmooth.kernels.cells.radical_planes`. In 2D all prisms are of one height, whatever their sizes.
"""

import numpy as np

from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    absolute,
    bits,
    count_bits,
    everywhere,
    load,
    multiply_add,
    select,
    square_root,
)
from pcsmooth.kernels.cells.radical_planes import (
    CANDIDATE_RADIUS,
    LEAST_HEIGHT,
    difference_of_squares,
)
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.within_reach import store_chosen


@inner
def scale_vertices(vertices, n, size, dimension):
    """Give a body its size, along the axes that it has."""
    for axis in range(dimension):
        for t in range(n):
            vertices[axis, t] *= size


@inner
def select_touching(candidates, n_candidates, x, y, z, size, reach, near):
    """Put the candidates into near whose balls, of radius size times reach, touch that of p_i.

    The candidates have their sizes beside them. Returns how many there are; near has room for
    WIDTH more.
    """
    count = 0
    for c in range(0, n_candidates, WIDTH):
        dx = load(candidates, 0, c) - x
        dy = load(candidates, 1, c) - y
        dz = load(candidates, 2, c) - z
        square = multiply_add(dz, dz, multiply_add(dy, dy, dx * dx))
        both = (load(candidates, CANDIDATE_RADIUS, c) + size) * reach
        within = (square < both * both) & (square > 0.0)
        chosen = bits(within)
        if chosen == 0:
            continue
        store_chosen(near, count, dx, dy, dz, square, load(candidates, 3, c), within)
        count += count_bits(chosen)
    return count


@inner
def select_cutting(candidates, n_candidates, x, y, z, size, inradius, reach, near):
    """Put images of the candidates into near whose radical plane with p_i comes within its reach.

    Images are those of `select_images`, the radii being `inradius` times the sizes, and the reach
    `reach` times p_i's own. Returns how many there are, and whether there are none since one of the
    planes leaves nothing of what is within reach.
    """
    count = np.int64(0)
    limit = 4.0 * (size * reach) * (size * reach)
    least_height = 2.0 * (size * reach) * LEAST_HEIGHT
    own = everywhere(size)
    for c in range(0, n_candidates, WIDTH):
        dx = load(candidates, 0, c) - x
        dy = load(candidates, 1, c) - y
        dz = load(candidates, 2, c) - z
        square = multiply_add(dz, dz, multiply_add(dy, dy, dx * dx))
        other = load(candidates, CANDIDATE_RADIUS, c)
        power = square + difference_of_squares(own, other) * (inradius * inradius)
        cutting = power * power < square * limit  # not itself: 0 is not below 0
        chosen = bits(cutting)
        if bits(power < 0.0) & ~chosen != 0:
            return np.int64(0), True
        if chosen == 0:
            continue
        least = square_root(square) * least_height
        power = select(absolute(power) < least, least, power)
        scale = absolute(power) / square
        number = load(candidates, 3, c)
        store_chosen(
            near, count, dx * scale, dy * scale, dz * scale, power * scale, number, cutting
        )
        count += count_bits(chosen)
    return count, False
