"""The error that the filter leaves, as it tells it, against the true one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from known_clouds import KNOWN_CLOUDS
from simulated_scans import SIMULATED_SCANS

import pcsmooth
from oracles import Array
from pcsmooth.filters import errors_left
from pcsmooth.filters.design import DESIGN


def within(points: Array, distances: Callable[[Array], Array], **options: float) -> Array:
    """Whether the true error of each point is less than what is told."""
    result = pcsmooth.denoise(points, **options)  # type: ignore[arg-type]
    assert result.sigma_after is not None
    return np.asarray(distances(result.points) <= result.sigma_after)


def level(points: Array) -> Array:
    return np.asarray(np.abs(points[:, -1]))


def plane(n: int, dimension: int, noise: float) -> Array:
    """Random points in a unit square (in the plane, on a line), noise in units of the spacing."""
    rng = np.random.default_rng(7)
    points = rng.random((n, dimension))
    points[:, -1] = noise * (1.0 / n) ** (1.0 / (dimension - 1)) * rng.normal(size=n)
    return points


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("noise", [0.2, 0.5, 1.0])
def test_about_68_percent_are_within_on_planes(dimension: int, noise: float) -> None:
    found = within(plane(6000, dimension, noise), level)
    assert 0.6 < found.mean() < 0.8


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "classes"),
    [
        ("rings in a room", ()),
        ("ground from a tripod", ()),
        ("ball, 10% outliers", ()),
        ("depth camera", ("near", "far", "smooth")),
        ("rotating laser in a street", ("near", "far", "smooth", "edges")),
    ],
)
def test_about_68_percent_are_within_on_scans(name: str, classes: tuple[str, ...]) -> None:
    cloud = {**KNOWN_CLOUDS, **SIMULATED_SCANS}[name](5)
    found = within(cloud.points, cloud.distances)
    good = ~cloud.outliers
    assert 0.6 < found[good].mean() < 0.76
    for part in classes:
        assert 0.58 < found[good & cloud.classes[part]].mean() < 0.8, part


def test_two_sheets_leave_more() -> None:
    """Between sheets as far apart as points little is taken, and that is told."""
    cloud = KNOWN_CLOUDS["two walls 20 noises apart"](5)
    result = pcsmooth.denoise(cloud.points)
    assert result.sigma_after is not None
    assert result.sigma is not None
    assert 0.45 < np.median(result.sigma_after / result.sigma) < 1.0
    assert np.mean(cloud.distances(result.points) <= result.sigma_after) > 0.5


def test_where_there_is_nothing_to_take_nothing_is_told() -> None:
    result = pcsmooth.denoise(plane(3, 3, 0.1))
    assert result.sigma_after is None
    clean = pcsmooth.denoise(plane(2000, 3, 0.0))
    assert clean.sigma_after is not None
    assert not clean.sigma_after.any()


def test_the_parts_of_what_is_left() -> None:
    one = np.ones(3)
    untouched = errors_left.after_pass(4.0 * one, 0.0 * one, 9.0 * one, DESIGN)
    np.testing.assert_allclose(untouched, 4.0)
    taken = errors_left.after_pass(4.0 * one, one, 9.0 * one, DESIGN)
    np.testing.assert_allclose(taken, 4.0 * DESIGN.left_kept + 9.0 * DESIGN.left_heights)

    def last(shares: float, heights: float) -> float:
        sizes = 16.0 * one, 100.0 * one
        left = errors_left.after_last_step(
            0.0 * one, 2.0 * one, sizes, shares * one, heights * one, 3, DESIGN
        )
        return float(left[0])

    assert last(0.0, 0.0) == pytest.approx(2.0 * np.sqrt(DESIGN.left_pass / 16.0))
    assert last(1.0, 0.0) == pytest.approx(2.0 * np.sqrt(DESIGN.left_last[3] / 100.0))
    assert last(1.0, 4.0) == last(1.0, 99.0) > last(1.0, 1.0)
    held = errors_left.where_held_back(3.0 * one, 4.0 * one, np.array([0.0, 0.5, 1.0]))
    np.testing.assert_allclose(held, [4.0, 2.5, 3.0])
