"""Angles of eight plane vectors at a time."""

import math

from pcsmooth.kernels.arithmetic.simd import absolute, everywhere, multiply_add, select
from pcsmooth.kernels.compiled import inner

#: (arctan(t) / t - 1) / t^2 as a polynomial in t^2 for t <= tan(pi / 8), interpolated at the
#: Chebyshev nodes in 60 digits; highest power first. What it adds to t is off by less than 1e-18 t.
_ARCTANGENT = (
    -0.019176885636589053,
    0.039231657085083686,
    -0.050854496960392584,
    0.05858148904795124,
    -0.0666451144646022,
    0.07692183190760651,
    -0.09090904578121085,
    0.11111111015256292,
    -0.14285714284666542,
    0.1999999999999552,
    -0.3333333333333333,
)

_TAN_EIGHTH_TURN = math.sqrt(2.0) - 1.0


@inner
def angles(x, y):
    """Angles of the vectors (x, y) from the first axis, in (-pi, pi]; 0 for the vector 0."""
    ax = absolute(x)
    ay = absolute(y)
    steep = ay > ax
    small = select(steep, ax, ay)
    large = select(steep, ay, ax)
    # Beyond pi / 8, measure from pi / 4: arctan(s / l) = pi / 4 - arctan((l - s) / (l + s)).
    turned = small > large * _TAN_EIGHTH_TURN
    numerator = select(turned, small - large, small)
    denominator = select(turned, small + large, large)
    ratio = numerator / select(denominator > 0.0, denominator, 1.0)
    square = ratio * ratio
    series = everywhere(_ARCTANGENT[0])
    for coefficient in _ARCTANGENT[1:]:
        series = multiply_add(series, square, coefficient)
    angle = multiply_add(ratio * square, series, ratio)
    angle = select(turned, angle + 0.25 * math.pi, angle)
    angle = select(steep, 0.5 * math.pi - angle, angle)
    angle = select(x < 0.0, math.pi - angle, angle)
    return select(y < 0.0, 0.0 - angle, angle)
