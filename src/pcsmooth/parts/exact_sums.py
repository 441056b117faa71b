"""Sums that do not depend on the order of what is added, nor on the parts it comes in."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import chain

import numpy as np
import numpy.typing as npt

#: Values that are summed up at a time, so that they stay in a cache.
_BLOCK = 1 << 14

#: Larger powers of two leave no room for sums of floats.
_LARGEST_POWER = 1000


def exact_sum(values: npt.NDArray[np.float64]) -> tuple[float, ...]:
    """Sum up values without any rounding, as long as they and their sum are no near-infinities.

    Parameters
    ----------
    values : ndarray
        Of any shape.

    Returns
    -------
    tuple of float
        A few numbers for every 16,384 values, whose exact sum is that of the values; of those that
        are not all finite, or near the largest floats, one, their sum as it comes.

    Notes
    -----
    From all values the leading bits are taken, down to the same place, and so few of them that
    their sum is a float; then again of what is left (Rump, Ogita and Oishi 2008, "Accurate
    floating-point summation", extraction of vectors). Many times as fast as `math.fsum`.
    """
    found: list[float] = []
    rows = values.reshape(-1)
    for start in range(0, len(rows), _BLOCK):
        found.extend(_sums_of_block(rows[start : start + _BLOCK]))
    return tuple(found)


def _sums_of_block(rest: npt.NDArray[np.float64]) -> Iterator[float]:
    """Give the sums of the leading bits, of the next, and so on."""
    room = math.ceil(math.log2(len(rest) + 2))
    while True:
        largest = float(np.abs(rest).max())
        if largest == 0.0:
            return
        if not math.isfinite(largest) or math.frexp(largest)[1] + room > _LARGEST_POWER:
            yield float(rest.sum())
            return
        ruler = 2.0 ** (math.frexp(largest)[1] + room)
        leading = (ruler + rest) - ruler
        yield float(leading.sum())
        rest = rest - leading


def total_of(sums: Iterable[tuple[float, ...]]) -> float:
    """Add up what `exact_sum` gave of several parts, and round once."""
    return math.fsum(chain.from_iterable(sums))
