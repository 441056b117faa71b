"""Cables, told from lines of a scan, and left as they are."""

from __future__ import annotations

import numpy as np
import pytest
from known_clouds import KNOWN_CLOUDS, cables, scan_lines

import pcsmooth
from filters.whole import surroundings_of
from oracles import Array
from pcsmooth.filters.cables import on_cables
from pcsmooth.filters.design import DESIGN


def line(sag: float, across: tuple[float, float]) -> Array:
    """Points of a hanging line, off it by so much to the side and upwards."""
    rng = np.random.default_rng(6)
    x = np.linspace(-5.0, 5.0, 1000)
    points = np.stack([x, np.zeros_like(x), sag * x**2], axis=1)
    return np.asarray(points + rng.normal(size=points.shape) * [0.002, *across])


def share_on_cables(points: Array) -> float:
    return float(on_cables(surroundings_of(points), DESIGN).mean())


@pytest.mark.parametrize("sag", [0.0, 0.05])
@pytest.mark.parametrize("noise", [0.002, 0.01])
def test_lines_with_noise_all_around_are_cables(sag: float, noise: float) -> None:
    assert share_on_cables(line(sag, (noise, noise))) > 0.9


@pytest.mark.parametrize("sag", [0.0, 0.05, 0.3])
def test_lines_with_noise_along_the_beam_are_of_a_scan(sag: float) -> None:
    """However they bend."""
    assert share_on_cables(line(sag, (0.01, 0.0))) == 0.0
    assert share_on_cables(line(sag, (0.0, 0.01))) == 0.0


@pytest.mark.parametrize("across", [10, 20, 60])
def test_scans_in_lines_have_no_cables(across: int) -> None:
    assert share_on_cables(scan_lines(across, 3).points) == 0.0


@pytest.mark.parametrize("name", ["rings in a room", "ball, 1% outliers", "plate 20 noises thick"])
def test_surfaces_have_no_cables(name: str) -> None:
    assert share_on_cables(KNOWN_CLOUDS[name](3).points) == 0.0


def test_exact_lines_and_few_points_are_none() -> None:
    assert share_on_cables(line(0.0, (0.0, 0.0))) == 0.0
    assert share_on_cables(line(0.0, (0.01, 0.01))[:30]) == 0.0
    assert share_on_cables(line(0.0, (0.01, 0.01))[:, :2]) == 0.0


def test_cables_stay_and_the_ground_does_not() -> None:
    cloud = cables(3)
    result = pcsmooth.denoise(cloud.points)
    marks = cloud.classes["cables"]
    assert np.mean(result.displacement[marks] == 0.0) > 0.99
    assert result.sigma is not None
    assert result.sigma_after is not None
    np.testing.assert_array_equal(result.sigma_after[marks][0], result.sigma[marks][0])
    after, before = cloud.distances(result.points), cloud.errors
    assert np.sqrt(np.mean(after[~marks] ** 2)) < 0.2 * np.sqrt(np.mean(before[~marks] ** 2))
