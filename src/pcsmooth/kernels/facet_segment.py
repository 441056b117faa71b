"""Facet of a 2D restricted cell: a segment of a bisector, inside the disk."""

import math

from numba import njit

from pcsmooth.kernels.lanes import (
    WIDTH,
    bits,
    everywhere,
    largest,
    least,
    load,
    select,
)
from pcsmooth.kernels.near_points import SQUARE, X, Y


@njit(cache=True, error_model="numpy")
def measure_segment(near, count, j, radius):
    """Measure F_ij, the part of the bisector of p_i and p_j in both restricted cells.

    Parameters: the `count` neighbours of p_i as in `near_points`, padded, p_j being number j; r.
    Returns (length, angle seen from p_i, weight of u in the perimeter's gradient, first moment
    about the foot of the perpendicular from p_i: x, y). The bisector is cut by the half-planes
    of the other neighbours k: for the point at abscissa t along the bisector,
    t (w . tangent) <= u_k . w / 2 with w = p_k - p_j.
    """
    xj = near[X, j]
    yj = near[Y, j]
    distance = math.sqrt(near[SQUARE, j])
    height = 0.5 * distance
    rho = math.sqrt(max(0.0, (radius - height) * (radius + height)))
    tx = -yj / distance
    ty = xj / distance
    starts = everywhere(-rho)
    ends = everywhere(rho)
    for c in range(0, count, WIDTH):
        x = load(near, X, c)
        y = load(near, Y, c)
        wx = x - xj
        wy = y - yj
        slope = wx * tx + wy * ty
        level = (x * wx + y * wy) * 0.5
        place = level / slope
        exists = load(near, SQUARE, c) < math.inf
        ends = select(exists & (slope > 0.0) & (place < ends), place, ends)
        starts = select(exists & (slope < 0.0) & (place > starts), place, starts)
        if bits(exists & (slope == 0.0) & (level < 0.0)):
            return 0.0, 0.0, 0.0, 0.0, 0.0
    low = largest(starts)
    high = least(ends)
    if low >= high:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    length = high - low
    angle = math.atan2(height * length, height * height + low * high)
    ends_on_circle = (1 if high == rho else 0) + (1 if low == -rho else 0)
    rim = ends_on_circle * radius / rho if ends_on_circle > 0 else 0.0
    moment = 0.5 * (high * high - low * low)
    return length, angle, rim, moment * tx, moment * ty
