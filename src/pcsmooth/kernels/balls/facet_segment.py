"""Facets of a 2D restricted cell: segments of bisectors, inside the disk."""

from pcsmooth.kernels.arithmetic.angles import angles
from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    absolute,
    bits,
    load,
    select,
    square_root,
    store,
)
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.within_reach import X, Y


@inner
def cut_bisectors(others, n_others, first, near, count, radius, ends):
    """Cut the bisectors of others[first .. first + 7] by those of all `count` neighbours of p_i.

    near and others: neighbours as in `within_reach`, the others padded. Facet F_ij runs from
    abscissa ends[0] to ends[1] along its bisector, counted from the foot of the perpendicular
    from p_i, in direction (-u_y, u_x): a point of it is on p_j's side of the bisector of p_j and
    p_k if t (w . direction) <= u_k . w / 2 with w = p_k - p_j. Returns the bits of those not empty.
    """
    x = load(others, X, first)
    y = load(others, Y, first)
    square = x * x + y * y
    scale = 1.0 / square_root(square)
    tx = 0.0 - y * scale
    ty = x * scale
    high = square_root(radius * radius - square * 0.25)
    low = 0.0 - high
    for k in range(count):
        wx = near[X, k] - x
        wy = near[Y, k] - y
        slope = wx * tx + wy * ty
        level = (wx * near[X, k] + wy * near[Y, k]) * 0.5
        # A parallel bisector, slope 0, cuts nothing or, at minus infinity, everything; for k = j
        # it is 0 / 0, which compares as false.
        place = level / absolute(slope)
        high = select((slope >= 0.0) & (place < high), place, high)
        place = 0.0 - place
        low = select((slope < 0.0) & (place > low), place, low)
    store(ends, 0, 0, low)
    store(ends, 1, 0, high)
    inside = (1 << min(WIDTH, n_others - first)) - 1
    return bits(low < high) & inside


@inner
def measure_segments(x, y, low, high, radius):
    """Measure eight facets that run from low to high, (x, y) = u.

    Returns (length, angle seen from p_i, weight of the unit vector in the perimeter's gradient,
    first moment about the foot of the perpendicular from p_i: x, y).
    """
    square = x * x + y * y
    distance = square_root(square)
    height = distance * 0.5
    rho = square_root(radius * radius - square * 0.25)
    length = high - low
    angle = angles(height * height + low * high, height * length)
    zero = length * 0.0
    ends = select(high == rho, 1.0, zero) + select(low == 0.0 - rho, 1.0, zero)
    rim = select(ends > 0.0, ends * radius / rho, 0.0)
    moment = (high + low) * length * 0.5 / distance
    return length, angle, rim, 0.0 - moment * y, moment * x
