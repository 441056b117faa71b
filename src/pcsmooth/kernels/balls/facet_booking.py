"""Facets booked for their points: added to the sums that become a cell's measures."""

import math

from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    everywhere,
    load,
    multiply_add,
    square_root,
    store,
    store_transposed,
)
from pcsmooth.kernels.compiled import inner

#: Columns of the sums, and of the measures that they become.
CELL_VOLUME = 0
VISIBLE_AREA = 1
VOLUME_GRADIENT = 2  # and the next two
AREA_GRADIENT = 5  # and the next two
NORMAL_TENSOR = 8  # xx, xy, xz, yy, yz, zz
VOLUME_DIAGONAL = 14
AREA_DIAGONAL = 15
N_MEASURES = 16

#: Rows of the terms of eight facets, one facet a row: for its first point, for its second one.
N_BOOKING_ROWS = 2 * WIDTH


@inner
def store_booking_terms(
    terms, x, y, z, area, height, other_height, angle, other_angle, rim, mx, my, mz, sx, sy, sz
):
    """Store what eight facets add to the sums of their two points.

    (x, y, z) = u, from the first point to the second; area; height over either point; angle seen
    from either; weight of the unit vector in the area's gradient; first moment about the foot O;
    what the area's gradient of the first point has across u.

    With Omega the solid angles of the facets and h their heights: S = r^(d-1) (full - sum
    Omega), |C| = (r S + sum h A) / d, T = (|C| I - sum A u (x) c) / r, A c = A h u + m.
    """
    inverse = 1.0 / square_root(multiply_add(z, z, multiply_add(y, y, x * x)))
    x = x * inverse
    y = y * inverse
    z = z * inverse
    moment = height * area
    other_moment = other_height * area
    ax = area * x
    ay = area * y
    az = area * z
    rx = rim * x
    ry = rim * y
    rz = rim * z
    zero = area * 0.0
    gx = zero - rx + sx
    gy = zero - ry + sy
    gz = zero - rz + sz
    store_transposed(terms, 0, 0, moment, angle, zero - ax, zero - ay, zero - az, gx, gy, gz)
    store_transposed(
        terms, WIDTH, 0, other_moment, other_angle, ax, ay, az, rx - sx, ry - sy, rz - sz
    )
    # u (x) A c, made symmetric (its sum over the facets is); m changes sides with u.
    xx = x * mx
    xy = (x * my + y * mx) * 0.5
    xz = (x * mz + z * mx) * 0.5
    yy = y * my
    yz = (y * mz + z * my) * 0.5
    zz = z * mz
    va = area * inverse
    vr = rim * inverse
    hx = moment * x
    hy = moment * y
    hz = moment * z
    store_transposed(
        terms, 0, WIDTH,
        hx * x + xx, hx * y + xy, hx * z + xz, hy * y + yy, hy * z + yz, hz * z + zz, va, vr,
    )  # fmt: skip
    hx = other_moment * x
    hy = other_moment * y
    hz = other_moment * z
    store_transposed(
        terms, WIDTH, WIDTH,
        hx * x - xx, hx * y - xy, hx * z - xz, hy * y - yy, hy * z - yz, hz * z - zz, va, vr,
    )  # fmt: skip


@inner
def half_length(x, y, z):
    """Height of the bisectors of eight pairs of equal balls over either point."""
    return square_root(multiply_add(z, z, multiply_add(y, y, x * x))) * 0.5


@inner
def book(terms, row, sums, target):
    """Add a row of terms to the sums of a point."""
    for column in range(0, N_MEASURES, WIDTH):
        store(sums, target, column, load(sums, target, column) + load(terms, row, column))


@inner
def book_one(terms, sums, target, x, y, z, area, height, radii, angle, rim, mx, my, mz, sx, sy, sz):
    """Add a single facet to the sums of its first point."""
    nothing = everywhere(0.0)
    heights = everywhere(height)
    if radii is None:
        heights = half_length(everywhere(x), everywhere(y), everywhere(z))
    store_booking_terms(
        terms,
        everywhere(x),
        everywhere(y),
        everywhere(z),
        everywhere(area),
        heights,
        nothing,
        everywhere(angle),
        nothing,
        everywhere(rim),
        everywhere(mx),
        everywhere(my),
        everywhere(mz),
        everywhere(sx),
        everywhere(sy),
        everywhere(sz),
    )
    book(terms, 0, sums, target)


@inner
def book_outside(sums, target, dimension):
    """Let the facets of a point outside its cell be seen under another full angle.

    Theirs are signed, as their heights are, and add up to what is hidden of the sphere if the
    point is inside, and to minus what is visible if not.
    """
    sums[target, VISIBLE_AREA] += 4.0 * math.pi if dimension == 3 else 2.0 * math.pi


@inner
def close_fans(sums, target):
    """Let the fans of a 3D cell make up what is hidden of the sphere, in full angles.

    They do up to multiples of the full angle. Of the sphere of a point that planes pass through
    little more than a half is visible.
    """
    full = 4.0 * math.pi
    visible = (0.0 - sums[target, VISIBLE_AREA]) % full
    sums[target, VISIBLE_AREA] = full - visible if visible < 0.75 * full else full
