"""Numbers packed for a page, unpacked again as the page does it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.plots.point_blocks import (
    bits_for,
    normal_numbers,
    packed,
    value_numbers,
    whole_numbers,
)
from plots.blocks import unpacked, unpacked_normals, unpacked_places, unpacked_values

Floats = npt.NDArray[np.float64]


@pytest.mark.parametrize("bits", [8, 16, 24])
@pytest.mark.parametrize("columns", [1, 3])
@pytest.mark.parametrize("is_running", [False, True])
def test_numbers_come_back(bits: int, columns: int, is_running: bool) -> None:
    numbers = np.random.default_rng(0).integers(0, 2**bits, (500, columns)).astype(np.uint32)
    block = packed(numbers, bits, is_running=is_running)
    np.testing.assert_array_equal(unpacked(block), numbers)
    assert packed(numbers, bits, is_running=is_running) == block


def test_differences_along_a_curve_are_short() -> None:
    angles = np.linspace(0.0, 6.0, 5000)
    numbers = whole_numbers(np.stack([np.cos(angles), np.sin(angles)], axis=1), 16)
    short = packed(numbers, 16, is_running=True)
    assert len(short.text) < 0.6 * len(packed(numbers, 16).text)


@pytest.mark.parametrize("bits", [16, 24])
def test_places_are_within_half_a_step(bits: int) -> None:
    places = np.random.default_rng(1).uniform(-1.0, 1.0, (1000, 3))
    places[:2] = [[-1.0] * 3, [1.0] * 3]
    found = unpacked_places(whole_numbers(places, bits), bits)
    step = 2.0 / (2**bits - 1)
    assert np.abs(found - places).max() <= 0.5001 * step
    np.testing.assert_allclose(found[:2], places[:2], atol=1e-12)


def test_steps_are_short_beside_the_spacing() -> None:
    for spacing in (0.1, 0.0016, 0.0015, 1e-5):
        step = 2.0 / (2 ** bits_for(spacing) - 1)
        assert step <= 0.02 * spacing


def test_normals_of_either_sign() -> None:
    normals = np.random.default_rng(2).normal(size=(2000, 3))
    normals[:3] = [[1e-9, 0.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, -1.0]]
    units = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    numbers = normal_numbers(normals)
    assert numbers.max() <= 254
    cosines = np.abs(np.einsum("ij,ij->i", unpacked_normals(numbers), units))
    assert np.degrees(np.arccos(np.clip(cosines, 0.0, 1.0))).max() < 0.8


def test_unknown_normals() -> None:
    normals = np.array([[0.0, 0.0, 0.0], [np.nan] * 3, [0.0, 0.0, 1.0]])
    assert (normal_numbers(normals) == 255).all(axis=1).tolist() == [True, True, False]


@pytest.mark.parametrize("limits", [(0.0, 2.0), (-3.0, 3.0), (1e-90, 3e-90), (1e6, 2e6)])
def test_values(limits: tuple[float, float]) -> None:
    low, high = limits
    values = np.linspace(low, high, 300)
    values[7] = np.nan
    found = unpacked_values(value_numbers(values, limits), limits)
    assert np.flatnonzero(np.isnan(found)).tolist() == [7]
    assert np.nanmax(np.abs(found - values)) <= 0.0005 * (high - low)


def test_values_far_beyond_the_scale_are_known() -> None:
    found = unpacked_values(value_numbers(np.array([1e300, -1e300, 5.0]), (0.0, 1.0)), (0.0, 1.0))
    assert found[0] > 1e4
    assert found[1] < -1e4
    assert found[2] == pytest.approx(5.0, rel=1e-3)
