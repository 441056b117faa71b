"""Radical planes of balls of unequal radii, in the place of the bisectors of equal ones.

The points that have the same power for two balls, |x - p|^2 - r^2, form the plane
u . x = (|u|^2 + r_i^2 - r_j^2) / 2, u = p_j - p_i, which is at the signed distance
h = (|u|^2 + r_i^2 - r_j^2) / (2 |u|) from p_i: beyond p_i, h < 0, if p_j's ball is much larger.
"""

import numpy as np

from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    absolute,
    bits,
    compress,
    count_bits,
    everywhere,
    load,
    mask_of,
    multiply_add,
    select,
    square_root,
    store,
)
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.within_reach import (
    NUMBER,
    SQUARE,
    X,
    Y,
    Z,
    pad_neighbors,
    store_chosen,
)

#: Rows of an array of neighbours that hold u . x of the plane and, of unequal balls, the radius and
#: the squared radius of the circle in which the spheres meet.
HALF = 5
RADIUS = 7
CHORD2 = 8

#: Row of an array of candidates that holds their radii.
CANDIDATE_RADIUS = 4

#: A plane nearer to p_i than this, in units of the radius, passes through it.
THROUGH = 1e-5

#: A plane nearer to p_i than this, in units of the radius, is taken to be so far: an image needs
#: a direction.
LEAST_HEIGHT = 1e-14


@inner
def difference_of_squares(a, b):
    """Return a^2 - b^2, exact to rounding where they are close."""
    return (a - b) * (a + b)


@inner
def collect_radii(radii, candidates, n_candidates):
    """Put the radii of the candidates beside them."""
    for c in range(n_candidates):
        candidates[CANDIDATE_RADIUS, c] = radii[int(candidates[3, c])]


@inner
def select_images(candidates, n_candidates, x, y, z, radius, least_gap2, near):
    """Put images of the candidates whose plane meets the ball of p_i = (x, y, z) into near.

    An image lies where a ball of p_i's own radius has this plane for a bisector, so that cells are
    found as if all balls were equal. SQUARE has the sign of h: a plane with h < 0 is that of the
    image at the distance 2 |h| in direction u, and leaves the side image . x <= SQUARE / 2 too.

    Returns how many there are, none if one of the planes leaves nothing of the ball; whether p_i
    lies outside its cell; whether some of them are nearer than the root of least_gap2.
    """
    n_near = np.int64(0)
    for c in range(0, n_candidates, WIDTH):
        dx = load(candidates, 0, c) - x
        dy = load(candidates, 1, c) - y
        dz = load(candidates, 2, c) - z
        square = multiply_add(dz, dz, multiply_add(dy, dy, dx * dx))
        other = load(candidates, CANDIDATE_RADIUS, c)
        reach = other + radius
        within = (square < reach * reach) & (square > 0.0)
        if bits(within) == 0:
            continue
        store_chosen(near, n_near, dx, dy, dz, square, load(candidates, 3, c), within)
        store(near, RADIUS, n_near, compress(other, within))
        n_near += count_bits(bits(within))
    count = np.int64(0)
    outside = np.int64(0)
    close = np.int64(0)
    for c in range(0, n_near, WIDTH):
        inside = (1 << min(WIDTH, n_near - c)) - 1
        square = load(near, SQUARE, c)
        other = load(near, RADIUS, c)
        own = everywhere(radius)
        height, other_height = heights_over(square, own, other)
        meet = bits(half_chord2(height, other_height, own, other) > 0.0) & inside
        behind = bits(height < 0.0) & inside
        if behind & ~meet != 0:
            return np.int64(0), True, False
        outside |= behind
        close |= bits(square < least_gap2) & meet
        power = square + difference_of_squares(radius, other)
        least = square_root(square) * (2.0 * radius * LEAST_HEIGHT)
        power = select(absolute(power) < least, least, power)
        scale = absolute(power) / square
        image_x = load(near, X, c) * scale
        image_y = load(near, Y, c) * scale
        image_z = load(near, Z, c) * scale
        store_chosen(
            near, count, image_x, image_y, image_z, power * scale, load(near, NUMBER, c),
            mask_of(meet),
        )  # fmt: skip
        count += count_bits(meet)
    return count, outside != 0, close != 0


@inner
def place_neighbors(coordinates, radii, i, near, count):
    """Put the neighbours of p_i themselves in the place of their images, padded.

    Fills the rows HALF, RADIUS and CHORD2, too.
    """
    for k in range(count):
        number = int(near[NUMBER, k])
        near[X, k] = coordinates[0, number] - coordinates[0, i]
        near[Y, k] = coordinates[1, number] - coordinates[1, i]
        near[Z, k] = coordinates[2, number] - coordinates[2, i]
        near[RADIUS, k] = radii[number]
    for k in range(count, count + WIDTH):
        near[RADIUS, k] = radii[i]
    pad_neighbors(near, count)
    for c in range(0, count, WIDTH):
        x = load(near, X, c)
        y = load(near, Y, c)
        z = load(near, Z, c)
        # As in `select_images`, so that signs are the same; 0 only for padding.
        square = multiply_add(z, z, multiply_add(y, y, x * x))
        square = select(square > 0.0, square, load(near, SQUARE, c))
        own = everywhere(radii[i])
        other = load(near, RADIUS, c)
        height, other_height = heights_over(square, own, other)
        store(near, SQUARE, c, square)
        store(near, HALF, c, (square + difference_of_squares(own, other)) * 0.5)
        store(near, CHORD2, c, half_chord2(height, other_height, own, other))


@inner
def heights_over(square, radius, other_radius):
    """Heights of eight radical planes over either point, square being the points' |u|^2."""
    double = square_root(square) * 2.0
    own = square + difference_of_squares(radius, other_radius)
    others = square + difference_of_squares(other_radius, radius)
    return own / double, others / double


@inner
def half_chord2(height, other_height, radius, other_radius):
    """Squared radius of the circle in which two spheres meet, as the smaller one has it best.

    Heights of the plane over either centre, and radii, each for eight pairs.
    """
    own = (radius - height) * (radius + height)
    others = (other_radius - other_height) * (other_radius + other_height)
    return select(other_radius < radius, others, own)
