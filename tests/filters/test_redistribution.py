from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

import oracles
from filters.whole import plan_of
from oracles import Array
from pcsmooth.filters.redistribution import redistribute


def redistributed(points: Array, noise: float) -> Array:
    plan = plan_of(points, noise)
    assert plan is not None
    return redistribute(points, plan, np.zeros(len(points), np.bool_), None)


def variation(points: Array) -> float:
    """Relative deviation of the distances to the nearest other point."""
    nearest = cKDTree(points).query(points, 2)[0][:, 1]
    return float(nearest.std() / nearest.mean())


@pytest.mark.parametrize("dimension", [2, 3])
def test_distances_to_the_nearest_become_more_even(dimension: int) -> None:
    points = oracles.random_sphere(3000, dimension=dimension)
    noise = 0.5 * (oracles.sphere_area(1, dimension) / 3000) ** (1 / (dimension - 1))
    after = redistributed(points, noise)
    assert variation(after) < 0.75 * variation(points)
    moves = np.linalg.norm(after - points, axis=1)
    assert moves.max() <= noise * (1 + 1e-12)
    assert np.median(moves) > 0.1 * noise
    # along the surface: a tangent of that length is this far off
    assert np.abs(np.linalg.norm(after, axis=1) - 1).max() < 0.2 * noise


def test_the_border_of_a_disc_stays() -> None:
    rng = np.random.default_rng(0)
    angles, radii = rng.uniform(0, 2 * np.pi, 5000), np.sqrt(rng.random(5000))
    disc = np.c_[radii * np.cos(angles), radii * np.sin(angles), np.zeros(5000)]
    noise = 0.7 * np.sqrt(np.pi / 5000)
    after = np.linalg.norm(redistributed(disc, noise), axis=1)
    assert after.max() < 1 + noise
    outmost = radii > 1 - noise
    assert abs(np.mean(after[outmost] - radii[outmost])) < 0.15 * noise


def test_fixed_points_stay_and_push() -> None:
    points = oracles.random_sphere(500)
    plan = plan_of(points, 0.05)
    assert plan is not None
    fixed = np.arange(500) % 2 == 0
    after = redistribute(points, plan, fixed, None)
    np.testing.assert_array_equal(after[fixed], points[fixed])
    assert (np.linalg.norm(after - points, axis=1)[~fixed] > 0).mean() > 0.8
    alone = redistribute(points[~fixed], plan, np.zeros(250, np.bool_), None)
    assert np.abs(alone - after[~fixed]).max() > 1e-3


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("noise", [0.2, 1.0])
def test_lists_for_all_steps_change_no_bit(
    dimension: int, noise: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = oracles.random_sphere(2000, dimension=dimension)
    noise *= (oracles.sphere_area(1, dimension) / 2000) ** (1 / (dimension - 1))
    results: list[Array] = []
    for most in (0, 1000):
        monkeypatch.setattr("pcsmooth.filters.redistribution.MOST_KEPT", most)
        results.append(redistributed(points, noise))
    np.testing.assert_array_equal(results[0], results[1])
    assert np.abs(results[0] - points).max() > 0.5 * noise
