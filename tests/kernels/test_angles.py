from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from pcsmooth.kernels.arithmetic import simd as typed_simd
from pcsmooth.kernels.arithmetic.angles import angles

#: numba's type hints take an intrinsic for a function with one argument more.
simd: Any = typed_simd


@njit
def angles_of(vectors: np.ndarray, result: np.ndarray) -> None:
    for start in range(0, vectors.shape[1], 8):
        x = simd.load(vectors, 0, start)
        y = simd.load(vectors, 1, start)
        simd.store(result, 0, start, angles(x, y))


def compute(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    result = np.empty((1, len(x)))
    angles_of(np.stack([x, y]), result)
    return np.asarray(result[0])


@pytest.mark.parametrize("size", [1e-150, 1.0, 1e150])
def test_angles_agree_with_the_arctangent_to_two_roundings(size: float) -> None:
    turns = np.linspace(-np.pi, np.pi, 100_000)
    x, y = size * np.cos(turns), size * np.sin(turns)
    expected = np.arctan2(y, x)
    assert np.all(np.abs(compute(x, y) - expected) <= 2 * np.spacing(np.abs(expected)))


def test_small_angles_keep_their_digits() -> None:
    y = np.ldexp(1.5, -np.arange(8))[np.newaxis] * 10.0 ** -np.arange(0, 300, 10)[:, np.newaxis]
    y = y.ravel()
    expected = np.arctan2(y, 1.0)
    np.testing.assert_allclose(compute(np.ones_like(y), y), expected, rtol=4e-16, atol=0)


def test_axes_diagonals_and_zero() -> None:
    x = np.array([1.0, 0.0, -1.0, 0.0, 1.0, -1.0, 0.0, -1.0])
    y = np.array([0.0, 1.0, 0.0, -1.0, 1.0, 1.0, 0.0, -1.0])
    expected = np.pi * np.array([0.0, 0.5, 1.0, -0.5, 0.25, 0.75, 0.0, -0.75])
    np.testing.assert_allclose(compute(x, y), expected, rtol=2e-16, atol=0)
