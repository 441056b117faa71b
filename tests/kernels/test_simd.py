from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import product
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt
import pytest
from numba import njit

import pcsmooth.kernels.arithmetic.simd
from oracles import Array

Integers = npt.NDArray[np.int64]
Kernel = TypeVar("Kernel", bound=Callable[..., None])

#: The module without its types: mypy takes intrinsics for what they are in Python.
simd: Any = pcsmooth.kernels.arithmetic.simd
WIDTH: int = simd.WIDTH


def kernel(function: Kernel) -> Kernel:
    return cast("Kernel", njit(function))


#: Numbers on which rounding, signs of zero, overflow and NaN show.
VALUES = np.array(
    [
        *(0.0, -0.0, 1.0, -1.0, 0.1, -2.5, 3.0, -7.7, 1e17),
        *(1e308, -1e308, 5e-324, 1e-300, np.inf, -np.inf, np.nan),
    ]
)

#: Each value and each value, in no order: eight of the pairs fill a register.
PAIRS = np.random.default_rng(0).permutation(list(product(VALUES, VALUES))).T
LEFT, RIGHT = np.split(np.ascontiguousarray(PAIRS), 2)

#: The flags of every mask: row m has bit k of m in column k.
MASKS = np.arange(1 << WIDTH)
FLAGS = np.unpackbits(MASKS.astype(np.uint8)[:, np.newaxis], axis=1, bitorder="little") == 1


def as_numbers(flags: npt.NDArray[np.bool_]) -> Integers:
    """Number of the mask of each group of eight flags."""
    packed = np.packbits(flags.reshape(-1, WIDTH), axis=1, bitorder="little")
    return packed[:, 0].astype(np.int64)


def assert_identical(actual: Array, expected: Array) -> None:
    """Equal, NaN to NaN, and zeros of equal sign."""
    np.testing.assert_array_equal(actual, expected)
    known = ~np.isnan(expected)
    np.testing.assert_array_equal(np.signbit(actual[known]), np.signbit(expected[known]))


# --- numbers --------------------------------------------------------------------------------


@kernel
def calculate(left: Array, right: Array, number: float, results: Array) -> None:
    for c in range(0, left.shape[1], WIDTH):
        a = simd.load(left, 0, c)
        b = simd.load(right, 0, c)
        simd.store(results, 0, c, a + b)
        simd.store(results, 1, c, a - b)
        simd.store(results, 2, c, a * b)
        simd.store(results, 3, c, a / b)
        simd.store(results, 4, c, a + number)
        simd.store(results, 5, c, a - number)
        simd.store(results, 6, c, a * number)
        simd.store(results, 7, c, a / number)
        simd.store(results, 8, c, number + b)
        simd.store(results, 9, c, number - b)
        simd.store(results, 10, c, number * b)
        simd.store(results, 11, c, number / b)
        simd.store(results, 12, c, simd.everywhere(number))
        simd.store(results, 13, c, simd.lane_numbers())
        simd.store(results, 14, c, simd.absolute(a))
        simd.store(results, 15, c, simd.square_root(a))


@pytest.mark.slow
@pytest.mark.parametrize("number", VALUES)
def test_calculations_are_those_of_each_lane(number: float) -> None:
    results = np.empty((16, LEFT.size))
    calculate(LEFT, RIGHT, number, results)
    expected, everywhere = [], np.full_like(LEFT, number)
    with np.errstate(all="ignore"):
        for a, b in [(LEFT, RIGHT), (LEFT, everywhere), (everywhere, RIGHT)]:
            expected += [a + b, a - b, a * b, a / b]
        expected += [everywhere, np.arange(LEFT.size) % 8.0]
        expected += [np.abs(LEFT), np.sqrt(LEFT)]
    for actual, row in zip(results, expected, strict=True):
        assert_identical(actual, row.ravel())


@kernel
def store_whole(values: Array, numbers: npt.NDArray[np.int32]) -> None:
    simd.store_numbers(numbers, 3, simd.load(values, 0, 0))


def test_whole_numbers_are_stored_as_integers() -> None:
    values = np.array([[0.0, 1.0, -1.0, 7.0, 2.0**31 - 1, -(2.0**31), 1e6, 12345.0]])
    numbers = np.full(12, -9, np.int32)
    store_whole(values, numbers)
    np.testing.assert_array_equal(numbers[3:11], values[0])
    np.testing.assert_array_equal(numbers[[0, 1, 2, 11]], -9)


@kernel
def compare(left: Array, right: Array, number: float, masks: Integers) -> None:
    for c in range(0, left.shape[1], WIDTH):
        a = simd.load(left, 0, c)
        b = simd.load(right, 0, c)
        row = c // WIDTH
        masks[0, row] = simd.bits(a < b)
        masks[1, row] = simd.bits(a <= b)
        masks[2, row] = simd.bits(a > b)
        masks[3, row] = simd.bits(a >= b)
        masks[4, row] = simd.bits(a == b)
        masks[5, row] = simd.bits(a < number)
        masks[6, row] = simd.bits(a <= number)
        masks[7, row] = simd.bits(a > number)
        masks[8, row] = simd.bits(a >= number)
        masks[9, row] = simd.bits(a == number)
        masks[10, row] = simd.bits(number < b)
        masks[11, row] = simd.bits(number <= b)
        masks[12, row] = simd.bits(number > b)
        masks[13, row] = simd.bits(number >= b)
        masks[14, row] = simd.bits(number == b)


@pytest.mark.slow
@pytest.mark.parametrize("number", VALUES)
def test_comparisons_are_those_of_each_lane_and_false_for_nan(number: float) -> None:
    masks = np.empty((15, LEFT.size // WIDTH), np.int64)
    compare(LEFT, RIGHT, number, masks)
    expected, everywhere = [], np.full_like(LEFT, number)
    for a, b in [(LEFT, RIGHT), (LEFT, everywhere), (everywhere, RIGHT)]:
        expected += [a < b, a <= b, a > b, a >= b, a == b]
    np.testing.assert_array_equal(masks, [as_numbers(flags) for flags in expected])


@kernel
def multiply_and_add(factors: Array, number: float, results: Array) -> None:
    a = simd.load(factors, 0, 0)
    b = simd.load(factors, 1, 0)
    c = simd.load(factors, 2, 0)
    simd.store(results, 0, 0, simd.multiply_add(a, b, c))
    simd.store(results, 1, 0, simd.multiply_add(number, b, c))
    simd.store(results, 2, 0, simd.multiply_add(a, number, c))
    simd.store(results, 3, 0, simd.multiply_add(a, b, number))


@pytest.mark.parametrize("seed", range(10))
def test_multiply_add_is_rounded_once_or_twice(seed: int) -> None:
    rng = np.random.default_rng(seed)
    factors = rng.normal(size=(3, WIDTH))
    factors[2, ::2] = -factors[0, ::2] * factors[1, ::2]  # what is left is the rounding
    number = -factors[0, 1] * factors[1, 1]
    results = np.empty((4, WIDTH))
    multiply_and_add(factors, number, results)
    for row, replaced in zip(results, (None, 0, 1, 2), strict=True):
        terms = factors.copy()
        if replaced is not None:
            terms[replaced] = number
        once = [float(Fraction(a) * Fraction(b) + Fraction(c)) for a, b, c in terms.T.tolist()]
        twice = terms[0] * terms[1] + terms[2]
        assert np.all((row == once) | (row == twice))


@kernel
def reduce(rows: Array, extremes: Array) -> None:
    for k in range(len(rows)):
        extremes[k, 0] = simd.least(simd.load(rows, k, 0))
        extremes[k, 1] = simd.largest(simd.load(rows, k, 0))


@pytest.mark.parametrize(
    "numbers",
    [
        [-5.5, -3.0, -0.1, 0.0, 1.0, 2.0, 7.0, 6.0],
        [1e308, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 5e-324],
        [-1e308, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0, -5e-324],
        [np.inf, 1.0, 0.0, -1.0, 2.0, 5.0, 3.0, -np.inf],
        [np.inf] * 8,
        [-np.inf] * 8,
    ],
)
def test_least_and_largest_are_found_in_any_lane(numbers: list[float]) -> None:
    rows = np.array([np.roll(numbers, lane) for lane in range(WIDTH)])
    extremes = np.empty((WIDTH, 2))
    reduce(rows, extremes)
    np.testing.assert_array_equal(extremes, [[min(numbers), max(numbers)]] * WIDTH)


# --- memory ---------------------------------------------------------------------------------


@kernel
def copy_eight(
    source: Array, row: int, start: int, target: Array, to_row: int, to_start: int
) -> None:
    simd.store(target, to_row, to_start, simd.load(source, row, start))


@pytest.mark.parametrize("to_row", range(4))
@pytest.mark.parametrize("row", range(3))
def test_eight_numbers_are_copied_between_any_places_and_no_more(row: int, to_row: int) -> None:
    source = np.arange(3 * 17.0).reshape(3, 17)
    for start, to_start in product(range(17 - WIDTH + 1), range(13 - WIDTH + 1)):
        target = -np.ones((4, 13))
        copy_eight(source, row, start, target, to_row, to_start)
        expected = -np.ones((4, 13))
        expected[to_row, to_start : to_start + WIDTH] = source[row, start : start + WIDTH]
        np.testing.assert_array_equal(target, expected)


# --- masks ----------------------------------------------------------------------------------


@kernel
def combine(numbers: Integers, back: Integers, both: Integers, either: Integers) -> None:
    for k in range(numbers.size):
        back[k] = simd.bits(simd.mask_of(numbers[k]))
        for j in range(numbers.size):
            both[k, j] = simd.bits(simd.mask_of(numbers[k]) & simd.mask_of(numbers[j]))
            either[k, j] = simd.bits(simd.mask_of(numbers[k]) | simd.mask_of(numbers[j]))


@pytest.mark.parametrize("higher_bits", [0, 0x5500, -256])
def test_masks_are_the_lowest_eight_bits(higher_bits: int) -> None:
    back = np.empty(MASKS.size, np.int64)
    both, either = np.empty((2, MASKS.size, MASKS.size), np.int64)
    combine(MASKS + higher_bits, back, both, either)
    np.testing.assert_array_equal(back, MASKS)
    np.testing.assert_array_equal(both, MASKS[:, np.newaxis] & MASKS)
    np.testing.assert_array_equal(either, MASKS[:, np.newaxis] | MASKS)


@kernel
def take(pair: Array, number: float, results: Array) -> None:
    a = simd.load(pair, 0, 0)
    b = simd.load(pair, 1, 0)
    for m in range(1 << WIDTH):
        mask = simd.mask_of(m)
        simd.store(results[0], m, 0, simd.select(mask, a, b))
        simd.store(results[1], m, 0, simd.select(mask, number, b))
        simd.store(results[2], m, 0, simd.select(mask, a, number))
        simd.store(results[3], m, 0, simd.select(mask, number, -number))
        simd.store(results[4], m, 0, simd.compress(a, mask))


def taken(pair: Array, number: float) -> Array:
    results = np.empty((5, MASKS.size, WIDTH))
    take(pair, number, results)
    return results


PAIR = np.array([[1.5, np.nan, -0.0, np.inf, 5.0, -np.inf, 7.0, 1e-310], np.arange(10.0, 18.0)])


def test_select_takes_each_lane_from_one_side() -> None:
    sides = [(PAIR[0], PAIR[1]), (42.0, PAIR[1]), (PAIR[0], 42.0), (42.0, -42.0)]
    for actual, (yes, no) in zip(taken(PAIR, 42.0), sides, strict=False):
        assert_identical(actual, np.where(FLAGS, yes, no))


def test_compress_moves_the_lanes_of_every_mask_to_the_front_in_order() -> None:
    for row, flags in zip(taken(PAIR, 42.0)[4], FLAGS, strict=True):
        assert_identical(row[: flags.sum()], PAIR[0, flags])


@kernel
def count(numbers: Integers, counts: Integers, lowest: Integers) -> None:
    for k in range(numbers.size):
        counts[k] = simd.count_bits(numbers[k])
        lowest[k] = simd.lowest_bit(numbers[k])


def test_bits_are_counted_and_the_lowest_is_found() -> None:
    rng = np.random.default_rng(0)
    single = np.int64(1) << np.arange(64)
    numbers = np.r_[MASKS[1:], single, -single, rng.integers(-(2**63), 2**63, 500)]
    counts, lowest = np.empty((2, numbers.size), np.int64)
    count(numbers, counts, lowest)
    digits = [np.binary_repr(number, 64)[::-1] for number in numbers]
    assert counts.tolist() == [number.count("1") for number in digits]
    assert lowest.tolist() == [number.index("1") for number in digits]
