"""Order statistics of values that do not fit in memory, exactly."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError

#: Gives chunks of values, of any shape; the same ones at each call.
Reader = Callable[[], Iterable[npt.NDArray[np.float64]]]

_KEY_BITS = 64

#: Bits of the keys that a pass settles.
_DIGIT_BITS = 16
_DIGITS = 1 << _DIGIT_BITS

#: Values that are sorted in memory as soon as no more are left to choose from.
_FEW = 1 << 22

#: Values at a time, so that what is computed of them stays in a cache.
_BLOCK = 1 << 15

_ALL_BUT_SIGN = np.int64(0x7FFFFFFFFFFFFFFF)


def streamed_median(read: Reader) -> float:
    """Compute the median of streamed values, as `numpy.median` of all of them would.

    Parameters
    ----------
    read : callable
        Gives the values in chunks; called up to four times.

    Returns
    -------
    float
        Bit for bit the same, except that a median of zero has no sign.

    Raises
    ------
    InvalidInputError
        There are no values, a value is NaN, or the values change between calls.
    """
    middle = streamed_order_statistics(
        read, lambda count: [count // 2] if count % 2 else [count // 2 - 1, count // 2]
    )
    return float(np.mean(middle))


def streamed_percentile(read: Reader, percent: float) -> float:
    """Compute a percentile of streamed values, as `numpy.percentile` of all of them would.

    Parameters
    ----------
    read : callable
        Gives the values in chunks; called up to four times.
    percent : float
        From 0 to 100.

    Returns
    -------
    float
        Between the two values nearest to that place, in proportion.

    Raises
    ------
    InvalidInputError
        As `streamed_median`.
    """
    place = 0.0

    def ranks(count: int) -> list[int]:
        nonlocal place
        place = percent / 100.0 * (count - 1)
        return [int(place), min(int(place) + 1, count - 1)]

    found = streamed_order_statistics(read, ranks)
    return float(np.quantile(found, place - int(place)))


def streamed_order_statistics(
    read: Reader, ranks: Callable[[int], Sequence[int]]
) -> npt.NDArray[np.float64]:
    """Find the values that have given places in sorted order.

    Each pass over the values counts the next 16 bits of those that agree so far with what is
    looked for; when few are left they are sorted.

    Parameters
    ----------
    read : callable
        Gives the values in chunks; called up to four times.
    ranks : callable
        From the number of all values, the places, each at least 0 and below that number.

    Returns
    -------
    ndarray, shape (k,)
        The value at each place; zeros have no sign.

    Raises
    ------
    InvalidInputError
        There are no values, a value is NaN, or the values change between calls.
    """
    table = np.zeros(_DIGITS, np.int64)
    shift = _KEY_BITS - _DIGIT_BITS
    for keys in _keys(read, check=True):
        table += np.bincount((keys >> shift) + _DIGITS // 2, minlength=_DIGITS)
    if not table.any():
        raise InvalidInputError("there are no values to take the median of")
    places = np.array(ranks(int(table.sum())), np.int64)
    prefixes, places, sizes = _settle(table, places)
    prefixes -= _DIGITS // 2
    while shift:
        left = dict(zip(prefixes.tolist(), sizes.tolist(), strict=True))
        if sum(left.values()) <= _FEW:
            few = _gather(read, left, shift)
            found = [few[p][k] for p, k in zip(prefixes.tolist(), places, strict=True)]
            return _values(np.array(found, np.int64))
        shift -= _DIGIT_BITS
        tables = _tabulate(read, left, shift)
        for i, prefix in enumerate(prefixes.tolist()):
            digit, places[i : i + 1], sizes[i : i + 1] = _settle(tables[prefix], places[i : i + 1])
            prefixes[i] = (prefix << _DIGIT_BITS) + digit[0]
    return _values(prefixes)


def _keys(read: Reader, check: bool = False) -> Iterator[npt.NDArray[np.int64]]:
    """Give integers (b,) that are ordered as the values are."""
    for chunk in read():
        values = chunk.reshape(-1)
        for start in range(0, len(values), _BLOCK):
            # Adding 0.0 turns -0.0 into 0.0.
            block = np.add(values[start : start + _BLOCK], 0.0, dtype=np.float64)
            if check and np.isnan(block.min()):
                raise InvalidInputError("there is no median of values that are not numbers")
            yield _flip_negative(block.view(np.int64))


def _values(keys: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    return _flip_negative(keys).view(np.float64)


def _flip_negative(bits: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Turn around the order of negative numbers, whose bits grow with their size; its own inverse.

    Positive numbers have bits in the order of their values.
    """
    return bits ^ ((bits >> (_KEY_BITS - 1)) & _ALL_BUT_SIGN)


def _settle(
    table: npt.NDArray[np.int64], places: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """For places in sorted order, the digits there, by how many keys have each digit.

    Returns the digits, the places among the keys of the same digit, and how many these are.
    """
    ends = np.cumsum(table)
    digits = np.searchsorted(ends, places, side="right")
    return digits, places - (ends - table)[digits], table[digits]


def _tabulate(read: Reader, left: dict[int, int], shift: int) -> dict[int, npt.NDArray[np.int64]]:
    """Count, for each prefix, the digits above the lowest `shift` bits that follow it."""
    tables = {prefix: np.zeros(_DIGITS, np.int64) for prefix in left}
    for keys in _keys(read):
        prefixes = keys >> (shift + _DIGIT_BITS)
        for prefix, table in tables.items():
            digits = (keys[prefixes == prefix] >> shift) & (_DIGITS - 1)
            if len(digits):
                table += np.bincount(digits, minlength=_DIGITS)
    _check_unchanged(left, {prefix: int(table.sum()) for prefix, table in tables.items()})
    return tables


def _gather(read: Reader, left: dict[int, int], shift: int) -> dict[int, npt.NDArray[np.int64]]:
    """Collect, for each prefix, the sorted keys that have it above their lowest `shift` bits."""
    pieces: dict[int, list[npt.NDArray[np.int64]]] = {prefix: [] for prefix in left}
    for keys in _keys(read):
        prefixes = keys >> shift
        for prefix, kept in pieces.items():
            kept.append(keys[prefixes == prefix])
    few = {prefix: np.sort(np.concatenate(kept)) for prefix, kept in pieces.items()}
    _check_unchanged(left, {prefix: len(keys) for prefix, keys in few.items()})
    return few


def _check_unchanged(before: dict[int, int], now: dict[int, int]) -> None:
    if before != now:
        raise InvalidInputError("values changed while their median was being looked for")
