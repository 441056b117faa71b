"""Facets of a 2D restricted cell: segments of bisectors, inside the disk."""

import math

import numpy as np

from pcsmooth.kernels.arithmetic.angles import angles
from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    absolute,
    bits,
    everywhere,
    load,
    multiply_add,
    select,
    square_root,
    store,
)
from pcsmooth.kernels.cells.radical_planes import (
    CHORD2,
    HALF,
    RADIUS,
    difference_of_squares,
    half_chord2,
    heights_over,
)
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.within_reach import SQUARE, X, Y

#: Bisectors this close, as an angle and in units of the radius, are one.
_SAME = 1e-10


@inner
def cut_bisectors(others, n_others, first, near, count, radius, radii, ends):
    """Cut the bisectors of others[first .. first + 7] by those of all `count` neighbours of p_i.

    near and others: neighbours as in `within_reach`, the others padded; if radii are unequal, from
    `place_neighbors`. Facet F_ij runs from abscissa ends[0] to ends[1] along its bisector, counted
    from the foot of the perpendicular from p_i, in direction (-u_y, u_x): a point of it is on p_j's
    side of the bisector of p_j and p_k if t (w . direction) <= u_k . w / 2 with w = p_k - p_j.
    Returns the bits of those not empty.
    """
    x = load(others, X, first)
    y = load(others, Y, first)
    square = x * x + y * y
    scale = 1.0 / square_root(square)
    tx = 0.0 - y * scale
    ty = x * scale
    if radii is not None:
        square = load(others, SQUARE, first)
        other_radius = load(others, RADIUS, first)
        half = load(others, HALF, first)
        height, other_height = heights_over(square, radius, other_radius)
        high = square_root(half_chord2(height, other_height, everywhere(radius), other_radius))
        step = difference_of_squares(radius, other_radius) * 0.5 / square
    else:
        high = square_root(radius * radius - square * 0.25)
    low = 0.0 - high
    for k in range(count):
        wx = near[X, k] - x
        wy = near[Y, k] - y
        slope = wx * tx + wy * ty
        level = (wx * near[X, k] + wy * near[Y, k]) * 0.5
        if radii is not None:
            # In terms of w nothing cancels where that is short, in terms of the bisectors nothing
            # where both are near p_i.
            along = wx * x + wy * y
            change = along * step
            gain = difference_of_squares(other_radius, near[RADIUS, k]) * 0.5
            shift = (1.0 + along / square) * half
            size = absolute(level) + absolute(gain) + absolute(change)
            is_short = size < absolute(shift) + abs(near[HALF, k])
            level = select(is_short, level + gain - change, near[HALF, k] - shift)
            # One bisector for both, as of disks that share two points: the near one takes the
            # facet. (If they are on both sides of p_i, its cell is flat.)
            square_k = near[SQUARE, k]
            limit = _SAME * math.sqrt(square_k)
            is_same = (absolute(slope) < limit) & (absolute(level) < limit * radius)
            is_behind = (along + square > 0.0) & (square > square_k)
            level = select(is_same, select(is_behind, 0.0 - everywhere(math.inf), math.inf), level)
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


@inner
def measure_unequal_segments(x, y, low, high, radius, other_radius):
    """Measure eight facets of disks of unequal radii that run from low to high, (x, y) = u.

    Returns (length, heights over p_i and p_j, angles seen from p_i and p_j, weight of the unit
    vector in the perimeter's gradient, first moment about the foot of the perpendicular from p_i:
    x, y, what the perimeter's gradient has across u: x, y).
    """
    square = multiply_add(y, y, x * x)  # as `place_neighbors` has it
    distance = square_root(square)
    height, other_height = heights_over(square, radius, other_radius)
    rho = square_root(half_chord2(height, other_height, radius, other_radius))
    length = high - low
    angle = angles(height * height + low * high, height * length)
    other_angle = angles(other_height * other_height + low * high, other_height * length)
    zero = length * 0.0
    at_high = select(high == rho, 1.0, zero)
    at_low = select(low == 0.0 - rho, 1.0, zero)
    ends = at_high + at_low
    weight = (radius * other_height + other_radius * height) / (rho * distance)
    rim = select(ends > 0.0, ends * weight, 0.0)
    moment = (high + low) * length * 0.5 / distance
    across = (at_high - at_low) * (radius - other_radius) / square
    return (
        length,
        height,
        other_height,
        angle,
        other_angle,
        rim,
        0.0 - moment * y,
        moment * x,
        0.0 - across * y,
        across * x,
    )


@inner
def sum_visible_arcs(near, count):
    """Sum the angles of the arcs of p_i's circle that no neighbour's disk hides.

    near: from `place_neighbors`.
    """
    turn = 2.0 * math.pi
    starts = np.empty(count)
    widths = np.empty(count)
    for k in range(count):
        height = near[HALF, k] / math.sqrt(near[SQUARE, k])
        widths[k] = 2.0 * math.atan2(math.sqrt(near[CHORD2, k]), height)
        starts[k] = (math.atan2(near[Y, k], near[X, k]) - 0.5 * widths[k]) % turn
    reached = 0.0
    for k in range(count):
        reached = max(reached, starts[k] + widths[k] - turn)
    visible = 0.0
    for k in np.argsort(starts):
        visible += max(0.0, starts[k] - reached)
        reached = max(reached, starts[k] + widths[k])
    return visible + max(0.0, turn - reached)
