"""Points that go a share of their way."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pcsmooth
from pcsmooth import InvalidInputError, Motion
from tiling.whole_and_tiled import compare

RNG = np.random.default_rng(11)
SHEET = np.c_[RNG.uniform(0, 4, (2500, 2)), RNG.normal(0, 0.05, 2500)]
METHODS: dict[str, dict[str, Any]] = {
    "filter": {},
    "filter, volume kept": {"keep_volume": True},
    "euler": {"scheme": "euler", "iterations": 2},
    "implicit": {"scheme": "implicit", "order": 1, "iterations": 1},
}


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("strength", [0.0, 0.3])
def test_a_share_of_the_way(name: str, strength: float) -> None:
    points = SHEET[:700] + np.array([5e5, 0.0, 0.0])
    whole = pcsmooth.denoise(points, **METHODS[name])
    part = pcsmooth.denoise(points, strength=strength, **METHODS[name])
    wanted = points + strength * (whole.points - points)
    np.testing.assert_allclose(part.points, wanted, rtol=0, atol=2e-10)  # rounding at 5e5
    if strength == 0.0:
        assert part.points.tobytes() == points.tobytes()
    assert len(part.history) == len(whole.history)
    assert part.stopped_early == whole.stopped_early
    # Normals are those of where the points are.
    there = pcsmooth.estimate_curvature(part.points)
    assert np.median(np.abs(np.sum(there.normals * part.normals, axis=1))) > 0.999


def test_all_of_the_way_is_the_same_to_the_last_bit() -> None:
    points = SHEET[:700]
    told = pcsmooth.denoise(points, motion=Motion(strength=1))
    assert told.points.tobytes() == pcsmooth.denoise(points).points.tobytes()


def test_the_error_that_is_left_is_that_of_the_share() -> None:
    left: list[Any] = []
    for strength in (1.0, 0.5, 0.0):
        result = pcsmooth.denoise(SHEET, strength=strength)
        left.append(result.sigma_after)
    assert result.sigma is not None
    np.testing.assert_allclose(left[2], result.sigma, rtol=1e-12)
    moved = pcsmooth.denoise(SHEET).displacement > 0.0
    expected = np.hypot(0.5 * left[0], 0.5 * left[2])
    np.testing.assert_allclose(left[1][moved], expected[moved], rtol=1e-12)
    np.testing.assert_array_equal(left[1][~moved], left[0][~moved])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["filter", "euler"])
def test_in_tiles(name: str, tmp_path: Path) -> None:
    unlike, whole, _ = compare(SHEET, 900, tmp_path, strength=0.4, scheme=name)
    assert unlike == []
    assert whole.displacement.max() > 0.0


@pytest.mark.parametrize("strength", [-0.1, 1.5, np.nan, "all", True])
def test_what_is_no_share(strength: Any) -> None:
    with pytest.raises(InvalidInputError, match=r"strength is .*; it must be a number from 0 to 1"):
        Motion(strength=strength)
