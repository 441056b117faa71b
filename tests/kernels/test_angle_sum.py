from __future__ import annotations

from math import atan2, fsum, pi

import numpy as np
import pytest

from kernels.alone import alone
from oracles import Array
from pcsmooth.kernels.arithmetic.angle_sum import add_angle, total_angle

add_angle, total_angle = alone(add_angle), alone(total_angle)


def sum_of_angles(factors: Array) -> float:
    state = (1.0, 0.0, 0)
    for re, im in factors:
        state = add_angle(*state, re, im)
    return float(total_angle(*state))


def polar(angles: Array, sizes: Array | float = 1.0) -> Array:
    return np.asarray(np.c_[sizes * np.cos(angles), sizes * np.sin(angles)])


def test_empty_sum_is_zero() -> None:
    assert sum_of_angles(np.empty((0, 2))) == 0.0


@pytest.mark.parametrize("angle", [3.1, pi / 2, 1e-3, 1e-300, 0.0, -1e-300, -1e-3, -pi / 2, -3.1])
def test_one_factor_is_its_angle(angle: float) -> None:
    assert sum_of_angles(polar(np.array([angle]))) == pytest.approx(angle, rel=1e-15, abs=4.5e-16)


@pytest.mark.parametrize("count", [2, 10, 1000, 20_000])
@pytest.mark.parametrize("sign", [(-1, 1), (0, 1), (-1, 0)])
@pytest.mark.parametrize("exponents", [(0, 0), (-1, 1), (-150, 150), (100, 150), (-150, -100)])
def test_sum_equals_that_of_arctangents(
    count: int, sign: tuple[int, int], exponents: tuple[int, int]
) -> None:
    rng = np.random.default_rng(count)
    sizes = 10.0 ** rng.uniform(*exponents, count)
    factors = polar(pi * rng.uniform(*sign, count), sizes)
    expected = fsum(atan2(im, re) for re, im in factors)
    # each product rounds its angle by 2 ulp of 1 at most
    assert sum_of_angles(factors) == pytest.approx(expected, abs=4.5e-16 * (count + 2))


@pytest.mark.parametrize("turns", [1, -1, 5, -5])
@pytest.mark.parametrize("parts", [3, 4, 7, 100])
def test_whole_turns_are_counted(turns: int, parts: int) -> None:
    """On whole and half turns rounding may fall on either side: no half turn is lost or won."""
    angles = np.full(abs(turns) * parts, np.sign(turns) * 2 * pi / parts)
    assert sum_of_angles(polar(angles)) == pytest.approx(2 * pi * turns, abs=5e-16 * angles.size)


def test_quarter_turns_are_exact() -> None:
    assert sum_of_angles(np.array([[0.0, 1.0]] * 6)) == 3 * pi
    assert sum_of_angles(np.array([[0.0, -1.0]] * 6)) == -3 * pi


def test_turns_forth_and_back_cancel() -> None:
    rng = np.random.default_rng(0)
    angles = rng.uniform(-pi, pi, 500)
    there_and_back = np.concatenate([polar(angles), polar(-rng.permutation(angles))])
    assert sum_of_angles(there_and_back) == pytest.approx(0.0, abs=4.5e-13)
