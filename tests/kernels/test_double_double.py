from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from kernels.alone import all_alone
from pcsmooth.kernels.arithmetic import double_double as pairs

double_double = all_alone(pairs)

Pair = tuple[float, float]
Vector = tuple[Pair, Pair, Pair]

#: What the module promises, relative to the terms.
TOLERANCE = Fraction(1, 10**30)


def exact(pair: Pair) -> Fraction:
    return Fraction(pair[0]) + Fraction(pair[1])


def make_pair(rng: np.random.Generator, exponents: int) -> Pair:
    """Make a random pair whose size is 2^-exponents to 2^exponents; a few have no low part."""
    high = float(np.ldexp(rng.uniform(-1, 1), rng.integers(-exponents, exponents + 1)))
    low = rng.uniform(-0.5, 0.5) * float(np.spacing(high)) * float(rng.random() < 0.8)
    return high, float(np.ldexp(low, -int(rng.integers(0, 20))))


def pairs_of_pairs(count: int = 2000) -> Iterator[tuple[Pair, Pair]]:
    """Pairs of all sizes, and such that nearly cancel in the sum or in the difference."""
    rng = np.random.default_rng(0)
    for number in range(count):
        first = make_pair(rng, 60)
        second = make_pair(rng, 60)
        if number % 2:
            sign = rng.choice([-1.0, 1.0])
            shift = np.ldexp(rng.uniform(-1, 1), -int(rng.integers(40, 110)))
            second = (sign * first[0], sign * first[1] + float(shift) * first[0])
            second = double_double.sum_of(*second)
        yield first, second


def assert_normal(pair: Pair) -> None:
    """Its low part is what the high part leaves over."""
    assert pair[0] + pair[1] == pair[0]


@pytest.mark.parametrize("exponents", [0, 50, 300])
def test_sum_of_floats_is_exact(exponents: int) -> None:
    rng = np.random.default_rng(exponents)
    for _ in range(1000):
        a, b = (
            float(np.ldexp(rng.uniform(-1, 1), e))
            for e in rng.integers(-exponents, exponents + 1, 2)
        )
        pair = double_double.sum_of(a, b)
        assert exact(pair) == Fraction(a) + Fraction(b)
        assert_normal(pair)


@pytest.mark.parametrize("exponents", [0, 50, 300])
def test_product_of_floats_is_exact(exponents: int) -> None:
    rng = np.random.default_rng(exponents)
    for _ in range(1000):
        a, b = (
            float(np.ldexp(rng.uniform(-1, 1), e))
            for e in rng.integers(-exponents, exponents + 1, 2)
        )
        pair = double_double.product_of(a, b)
        assert exact(pair) == Fraction(a) * Fraction(b)
        assert_normal(pair)


def test_floats_with_few_or_all_digits() -> None:
    floats = [0.0, 1.0, -1.0 - 2.0**-52, 1.0 - 2.0**-53, 2.0**27 + 1.0, 2.0**53 - 1.0]
    for a, b in product(floats, repeat=2):
        assert exact(double_double.sum_of(a, b)) == Fraction(a) + Fraction(b)
        assert exact(double_double.product_of(a, b)) == Fraction(a) * Fraction(b)


def test_add_and_subtract() -> None:
    for a, b in pairs_of_pairs():
        limit = TOLERANCE * (abs(exact(a)) + abs(exact(b)))
        total, difference = double_double.add(a, b), double_double.subtract(a, b)
        assert abs(exact(total) - (exact(a) + exact(b))) <= limit
        assert abs(exact(difference) - (exact(a) - exact(b))) <= limit
        assert_normal(total)
        assert_normal(difference)


def test_multiply() -> None:
    for a, b in pairs_of_pairs():
        found, expected = double_double.multiply(a, b), exact(a) * exact(b)
        assert abs(exact(found) - expected) <= TOLERANCE * abs(expected)
        assert_normal(found)


def vectors(count: int = 300) -> Iterator[tuple[Vector, Vector]]:
    """Vectors, every other one nearly parallel to its partner or at right angles to it."""
    rng = np.random.default_rng(1)
    for number in range(count):
        x, y, z, *second = (make_pair(rng, 3) for _ in range(6))
        if number % 4 == 1:
            x, y, z = (double_double.sum_of(float(v), 0.0) for v in rng.integers(-9, 10, 3))
            factor = float(1 + rng.integers(1, 9))
            second = [(factor * v[0] * (1 + 2.0**-50), 0.0) for v in (x, y, z)]
        elif number % 4 == 3:
            second = [(-y[0], -y[1]), x, (float(z[0] * 2.0**-60), 0.0)]
        yield (x, y, z), (second[0], second[1], second[2])


def test_dot() -> None:
    for a, b in vectors():
        terms = [exact(p) * exact(q) for p, q in zip(a, b, strict=True)]
        error = exact(double_double.dot(a, b)) - sum(terms)
        assert abs(error) <= TOLERANCE * sum(map(abs, terms))


def test_cross() -> None:
    for a, b in vectors():
        found = double_double.cross(a, b)
        for k in range(3):
            y, z = (k + 1) % 3, (k + 2) % 3
            left, right = exact(a[y]) * exact(b[z]), exact(a[z]) * exact(b[y])
            error = exact(found[k]) - (left - right)
            assert abs(error) <= TOLERANCE * (abs(left) + abs(right))
