"""Stands in for `pcsmooth.kernels.arithmetic.simd` where nothing is compiled: arrays of eight."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Lanes = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

WIDTH = 8


def load(array: Lanes, row: int, start: int) -> Lanes:
    return _eight(array, row, start).copy()


def store(array: Lanes, row: int, start: int, value: Lanes) -> None:
    _eight(array, row, start)[:] = value


def store_numbers(array: npt.NDArray[np.int32], start: int, value: Lanes) -> None:
    """Arbitrary lanes become arbitrary numbers: here such as are no place in any array."""
    numbers = np.where(np.isnan(value), np.iinfo(np.int32).min, value)
    _eight(array[np.newaxis], 0, start)[:] = numbers.astype(np.int32)


def _eight(array: npt.NDArray[Any], row: int, start: int) -> npt.NDArray[Any]:
    if not (0 <= row < array.shape[0] and 0 <= start <= array.shape[1] - WIDTH):
        raise IndexError(f"lanes {start} to {start + 7} of row {row} in shape {array.shape}")
    return array[row, start : start + WIDTH]


def everywhere(number: float) -> Lanes:
    return np.full(WIDTH, number)


def lane_numbers() -> Lanes:
    return np.arange(float(WIDTH))


def multiply_add(a: Lanes, b: Lanes, c: Lanes) -> Lanes:
    return a * b + c


def square_root(a: Lanes) -> Lanes:
    return np.sqrt(a)


def absolute(a: Lanes) -> Lanes:
    return np.abs(a)


def select(mask: Mask, a: Lanes | float, b: Lanes | float) -> Lanes:
    return np.where(mask, a, b)


def compress(value: Lanes, mask: Mask) -> Lanes:
    """The lanes that are left over are arbitrary: here NaN, so that whoever uses them shows."""
    chosen = value[mask]
    return np.concatenate([chosen, np.full(WIDTH - len(chosen), np.nan)])


def bits(mask: Mask) -> int:
    return int(mask @ (1 << np.arange(WIDTH)))


def mask_of(number: int) -> Mask:
    return np.asarray((int(number) >> np.arange(WIDTH)) & 1 == 1)


def count_bits(number: int) -> int:
    return int(number).bit_count()


def lowest_bit(number: int) -> int:
    return (int(number) & -int(number)).bit_length() - 1


def least(a: Lanes) -> float:
    return float(a.min())


def largest(a: Lanes) -> float:
    return float(a.max())


def transpose(*rows: Lanes) -> tuple[Lanes, ...]:
    return tuple(np.array(rows).T.copy())


def store_transposed(array: Lanes, row: int, start: int, *columns: Lanes) -> None:
    for k, column in enumerate(transpose(*columns)):
        store(array, row + k, start, column)


def load_transposed(array: Lanes, row: int, start: int) -> tuple[Lanes, ...]:
    return transpose(*(load(array, row + k, start) for k in range(WIDTH)))
