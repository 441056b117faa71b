"""The unit in which a cloud is measured: near its own lengths, so that floats hold their powers.

Measures have up to the third power of a length, and what they are made of up to the eighth. A unit
is a power of two, so that going over to it and back is exact: a cloud times a power of two has the
same results, times powers of that, to the last bit.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.positions import LARGEST

#: Shortest and longest length that is measured, L: their cubes are floats, those of the shortest
#: with 50 of 53 bits, so that clouds as small as 1e-100 have their spacing.
SHORTEST, LONGEST = 1e-103, 1e100

#: Lengths between the inverse of this and this are measured as they are: their powers are floats.
_ORDINARY = 2.0**32


def unit_near(length: float) -> float:
    """Choose the unit for lengths of about this size, L; 1.0 if they are ordinary, or not > 0.

    Raises
    ------
    InvalidInputError
        The length is finite, positive, and shorter than `SHORTEST` or longer than `LONGEST`.
    """
    if not 0.0 < length < math.inf:
        return 1.0
    if not is_measurable(length):
        raise InvalidInputError(
            f"lengths of {length:.3g} are not between {SHORTEST:g} and {LONGEST:g}; "
            "give the cloud in another unit"
        )
    return 1.0 if 1.0 / _ORDINARY <= length <= _ORDINARY else power_of_two_near(length)


def unit_for(points: npt.NDArray[np.float64], spacing: float) -> float:
    """Choose the unit for points (n, d) with a mean spacing, L: near that.

    Larger where a stray point would otherwise be farther than `LARGEST` from 0.

    Raises
    ------
    InvalidInputError
        The spacing is positive, and too short or too long to be measured.
    """
    unit = unit_near(spacing)
    farthest = float(np.abs(points).max())
    return unit if farthest <= LARGEST * unit else power_of_two_near(farthest / LARGEST)


def power_of_two_near(size: float) -> float:
    """Return the power of two next above a number > 0; 1.0 for 0."""
    return 2.0 ** math.frexp(size)[1]


def is_measurable(length: float) -> bool:
    """Whether floats hold the measures of shapes of this size."""
    return SHORTEST <= length <= LONGEST
