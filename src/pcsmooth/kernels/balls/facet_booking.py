"""Facets booked for their points: added to the sums that become a cell's measures."""

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
def store_booking_terms(terms, x, y, z, area, angle, rim, mx, my, mz):
    """Store what eight facets add to the sums of their two points.

    (x, y, z) = u, from the first point to the second; area; angle seen from the points; weight
    of the unit vector in the area's gradient; first moment about the foot O.

    With Omega the solid angles of the facets and h their distances: S = r^(d-1) (full - sum
    Omega), |C| = (r S + sum h A) / d, T = (|C| I - sum A u (x) c) / r, A c = A h u + m.
    """
    length = square_root(multiply_add(z, z, multiply_add(y, y, x * x)))
    inverse = 1.0 / length
    x = x * inverse
    y = y * inverse
    z = z * inverse
    moment = length * area * 0.5
    ax = area * x
    ay = area * y
    az = area * z
    rx = rim * x
    ry = rim * y
    rz = rim * z
    zero = area * 0.0
    store_transposed(
        terms, 0, 0, moment, angle, zero - ax, zero - ay, zero - az, zero - rx, zero - ry, zero - rz
    )
    store_transposed(terms, WIDTH, 0, moment, angle, ax, ay, az, rx, ry, rz)
    # u (x) A c, made symmetric (its sum over the facets is); m changes sides with u.
    hx = moment * x
    hy = moment * y
    hz = moment * z
    xx = x * mx
    xy = (x * my + y * mx) * 0.5
    xz = (x * mz + z * mx) * 0.5
    yy = y * my
    yz = (y * mz + z * my) * 0.5
    zz = z * mz
    va = area * inverse
    vr = rim * inverse
    hxx = hx * x
    hxy = hx * y
    hxz = hx * z
    hyy = hy * y
    hyz = hy * z
    hzz = hz * z
    store_transposed(
        terms, 0, WIDTH, hxx + xx, hxy + xy, hxz + xz, hyy + yy, hyz + yz, hzz + zz, va, vr
    )
    store_transposed(
        terms, WIDTH, WIDTH, hxx - xx, hxy - xy, hxz - xz, hyy - yy, hyz - yz, hzz - zz, va, vr
    )


@inner
def book(terms, row, sums, target):
    """Add a row of terms to the sums of a point."""
    for column in range(0, N_MEASURES, WIDTH):
        store(sums, target, column, load(sums, target, column) + load(terms, row, column))


@inner
def book_one(terms, sums, target, x, y, z, area, angle, rim, mx, my, mz):
    """Add a single facet to the sums of its first point; the second one's are in row WIDTH."""
    store_booking_terms(
        terms,
        everywhere(x),
        everywhere(y),
        everywhere(z),
        everywhere(area),
        everywhere(angle),
        everywhere(rim),
        everywhere(mx),
        everywhere(my),
        everywhere(mz),
    )
    book(terms, 0, sums, target)
