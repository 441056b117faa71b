"""Facet of a 2D restricted cell: a segment of a bisector, inside the disk."""

import math

from numba import njit


@njit(cache=True, error_model="numpy")
def measure_segment(xi, yi, j, count, near, radius):
    """Measure F_ij, the part of the bisector of p_i and p_j in both restricted cells.

    Parameters: p_i; the neighbours x, y (the first `count`), p_j being number j; r.
    Returns (length, angle seen from p_i, weight of u in the perimeter's gradient, first moment
    about the foot of the perpendicular from p_i: x, y, 0). The bisector is cut by the
    half-planes of the other neighbours k: for the point at abscissa t along the bisector,
    t (w . tangent) <= u_k . w / 2 with w = p_k - p_j.
    """
    xj = near[0, j]
    yj = near[1, j]
    ux = xj - xi
    uy = yj - yi
    distance = math.sqrt(ux * ux + uy * uy)
    height = 0.5 * distance
    rho = math.sqrt(max(0.0, (radius - height) * (radius + height)))
    tx = -uy / distance
    ty = ux / distance
    low = -rho
    high = rho
    for k in range(count):
        if k == j:
            continue
        wx = near[0, k] - xj
        wy = near[1, k] - yj
        slope = wx * tx + wy * ty
        level = 0.5 * ((near[0, k] - xi) * wx + (near[1, k] - yi) * wy)
        if slope > 0.0:
            high = min(high, level / slope)
        elif slope < 0.0:
            low = max(low, level / slope)
        elif level < 0.0:
            return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if low >= high:
            return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    length = high - low
    angle = math.atan2(height * length, height * height + low * high)
    ends_on_circle = (1 if high == rho else 0) + (1 if low == -rho else 0)
    rim = ends_on_circle * radius / rho if ends_on_circle > 0 else 0.0
    moment = 0.5 * (high * high - low * low)
    return length, angle, rim, moment * tx, moment * ty, 0.0
