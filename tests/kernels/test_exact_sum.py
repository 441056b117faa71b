from __future__ import annotations

from fractions import Fraction
from math import prod

import numpy as np
import pytest

from kernels.alone import alone
from oracles import Array
from pcsmooth.kernels.arithmetic.exact_sum import add_exactly, add_product

add_exactly, add_product = alone(add_exactly), alone(add_product)


Factors = tuple[float, float, float, float]


class Sum:
    """An expansion, and what it should be."""

    def __init__(self) -> None:
        self.room = np.full(2000, np.nan)
        self.n = 0
        self.expected = Fraction(0)

    def add(self, value: float) -> None:
        self.n = add_exactly(self.room, self.n, value)
        self.expected += Fraction(value)

    def add_product(self, factors: Factors) -> None:
        self.n = add_product(self.room, self.n, *factors)
        self.expected += prod(map(Fraction, factors))

    def check(self) -> None:
        parts = [Fraction(part) for part in self.room[: self.n].tolist()]
        assert sum(parts) == self.expected
        assert 0 not in parts
        below = Fraction(0)
        for part in parts:  # each is larger than all before it together: no digits overlap
            assert abs(part) > abs(below)
            below += part
        sign = np.sign(self.room[self.n - 1]) if self.n > 0 else 0
        assert sign == (self.expected > 0) - (self.expected < 0)


def products(rng: np.random.Generator, count: int, exponents: int) -> list[Factors]:
    floats = np.ldexp(
        rng.uniform(-1, 1, (count, 4)), rng.integers(-exponents, exponents + 1, (count, 4))
    )
    return [(row[0], row[1], row[2], row[3]) for row in floats.tolist()]


def nudged(factors: Factors, digits: int) -> Factors:
    a, b, c, d = factors
    return a, b, c, d * (1 + 2.0**-digits)


@pytest.mark.parametrize("exponents", [0, 10, 40])
def test_random_products(exponents: int) -> None:
    rng = np.random.default_rng(exponents)
    for count in (1, 2, 5, 24):
        total = Sum()
        for factors in products(rng, count, exponents):
            total.add_product(factors)
            total.check()


@pytest.mark.parametrize("seed", range(20))
def test_products_that_cancel_but_for_the_last_digits(seed: int) -> None:
    """24 products as a determinant has them, and all of them again with the sign turned."""
    rng = np.random.default_rng(seed)
    total = Sum()
    terms = products(rng, 24, 5)
    turned = [(-a, d, c, b) for a, b, c, d in terms]
    turned[0] = nudged(turned[0], 52)
    both = terms + turned
    for k in rng.permutation(len(both)):
        total.add_product(both[k])
    total.check()
    assert 0 < abs(total.expected) < 2.0**-30


@pytest.mark.parametrize("seed", range(20))
def test_products_that_cancel_leave_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    total = Sum()
    terms = products(rng, 24, 5)
    both = terms + [(b, -c, a, d) for a, b, c, d in terms]
    for k in rng.permutation(len(both)):
        total.add_product(both[k])
    total.check()
    assert total.n == 0
    total.add_product((0.0, 1.0, -2.0, 3.0))
    assert total.n == 0


@pytest.mark.parametrize("size", [2.0**-60, 2.0**-200, 2.0**60])
def test_a_float_decides_the_sign(size: float) -> None:
    """What is left of products that cancel may be far below all of their terms."""
    for sign in (-1.0, 1.0):
        total = Sum()
        terms = products(np.random.default_rng(1), 10, 3)
        for factors in terms:
            total.add_product(factors)
        total.add(sign * size)
        for a, b, c, d in terms:
            total.add_product((c, a, -b, d))
        total.check()
        assert total.room[: total.n].tolist() == [sign * size]


def test_floats_of_all_sizes() -> None:
    rng = np.random.default_rng(0)
    values: Array = np.ldexp(rng.uniform(-1, 1, 300), rng.integers(-250, 250, 300))
    total = Sum()
    for value in values.tolist():
        total.add(value)
        total.check()
    for value in rng.permutation(-values).tolist():
        total.add(value)
    total.check()
    assert total.n == 0
