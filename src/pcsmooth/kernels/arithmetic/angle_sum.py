"""Sum of many angles with one arctangent: multiply complex numbers, count half turns."""

import math

from pcsmooth.kernels.compiled import inner

#: Products are rescaled before they leave this range (its square must not under- or overflow).
_SMALL = 1e-100
_LARGE = 1e100


@inner
def add_angle(re, im, half_turns, factor_re, factor_im):
    """Add the angle of a complex factor, in (-pi, pi), to a running sum.

    The sum is arg(re + i im) + pi half_turns with im >= 0; it starts as (1, 0, 0).
    """
    new_re = re * factor_re - im * factor_im
    new_im = re * factor_im + im * factor_re
    if new_im < 0.0:
        new_re = -new_re
        new_im = -new_im
        half_turns += 1 if factor_im >= 0.0 else -1
    size = abs(new_re) + new_im
    if size < _SMALL or size > _LARGE:
        new_re /= size
        new_im /= size
    return new_re, new_im, half_turns


@inner
def total_angle(re, im, half_turns):
    """Value of a running sum of `add_angle`."""
    return math.atan2(abs(im), re) + math.pi * half_turns
