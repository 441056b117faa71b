"""Both sides of thin parts of closed surfaces."""

from __future__ import annotations

import numpy as np
import pytest

import oracles
from curvature.test_winding_field import box_surface
from filters.whole import filter_whole, plan_of
from oracles import Array
from pcsmooth.filters.plan import FilterPlan

THICKNESS = 0.1


def slab(noise: float, seed: int = 1) -> Array:
    points, _ = box_surface(8000, (1.0, 0.7, THICKNESS))
    return np.asarray(points + noise * np.random.default_rng(seed).normal(size=points.shape))


def errors(points: Array) -> Array:
    """Distances from the large faces of the slab, where only they are near."""
    inner = (np.abs(points[:, :2]) < [0.4, 0.25]).all(axis=1)
    return np.asarray(np.abs(np.abs(points[inner, 2]) - 0.5 * THICKNESS))


def left_of(points: Array, plan: FilterPlan | None) -> float:
    return float(np.sqrt((errors(filter_whole(points, plan).points) ** 2).mean()))


@pytest.mark.parametrize("deviations", [3.0, 4.0, 5.0])
def test_both_sides_of_a_slab_stay_apart(deviations: float) -> None:
    """Three to five noises thick; without sides more is left, if the noise is told, too."""
    noise = THICKNESS / deviations
    points = slab(noise)
    plan, blind = plan_of(points, noise, closed=True), plan_of(points, noise)
    assert plan is not None
    assert plan.tells_sides_apart
    assert left_of(points, plan) < min(0.6 * noise, 0.95 * left_of(points, blind))


@pytest.mark.parametrize("deviations", [3.0, 4.0])
def test_the_thickness_of_a_slab_is_not_taken_for_noise(deviations: float) -> None:
    """As it is without sides: 1.6 and 2.0 times the noise, and nothing gets better."""
    noise = THICKNESS / deviations
    points = slab(noise)
    plan, blind = plan_of(points, closed=True), plan_of(points)
    assert plan is not None
    assert blind is not None
    assert plan.noise.deviation == pytest.approx(noise, rel=0.12)
    assert blind.noise.deviation > 1.5 * noise
    assert left_of(points, plan) < 0.5 * left_of(points, blind)


def test_thick_shapes_are_denoised_as_well() -> None:
    """Sides that are far apart are in no neighbourhood together."""
    points = oracles.torus_surface(6000).noisy(0.5)
    told, blind = (
        oracles.distance_to_torus(filter_whole(points, plan_of(points, 0.02, closed=closed)).points)
        for closed in (True, False)
    )
    assert np.linalg.norm(told) == pytest.approx(np.linalg.norm(blind), rel=1e-3)


def test_noise_that_is_a_tenth_of_the_size_leaves_no_sides() -> None:
    points = oracles.random_sphere(3000)
    points = points + 0.1 * np.random.default_rng(0).normal(size=points.shape)
    plan = plan_of(points, 0.1, closed=True)
    assert plan is not None
    assert plan.tells_sides_apart is False


def test_little_noise_needs_no_sides() -> None:
    """The lattice would be coarser than the parts whose sides are in one neighbourhood."""
    points = oracles.torus_surface(3000).points
    points = points + 0.002 * np.random.default_rng(0).normal(size=points.shape)
    plan = plan_of(points, 0.002, closed=True)
    assert plan is not None
    assert plan.tells_sides_apart is False
    blind = plan_of(points, 0.002)
    assert blind is not None
    assert blind.tells_sides_apart is None


def test_outliers_that_are_many_do_not_matter() -> None:
    points = slab(0.02)
    rng = np.random.default_rng(3)
    strays = rng.uniform(-1.0, 1.0, (1600, 3))
    plan = plan_of(np.r_[points, strays], 0.02, closed=True)
    assert plan is not None
    assert plan.stray_share > 0.0
    moved = filter_whole(np.r_[points, strays], plan).points[: len(points)]
    assert np.sqrt((errors(moved) ** 2).mean()) < 0.6 * 0.02


def test_a_few_points_far_away_do_not_matter() -> None:
    points = slab(0.02)
    strays = [[1e5, 0.0, 0.0], [0.0, -300.0, 20.0]]
    plan, as_ever = (plan_of(cloud, 0.02, closed=True) for cloud in (np.r_[points, strays], points))
    assert plan is not None
    assert plan.tells_sides_apart
    moved = filter_whole(np.r_[points, strays], plan).points
    assert np.array_equal(moved[-2:], strays)
    expected = left_of(points, as_ever)
    assert np.sqrt((errors(moved[:-2]) ** 2).mean()) == pytest.approx(expected, rel=0.01)


def test_a_plan_can_be_scaled() -> None:
    points = slab(0.02)
    plan = plan_of(points, 0.02, closed=True)
    assert plan is not None
    moved, scaled = filter_whole(points, plan), filter_whole(8.0 * points, plan.scaled(8.0))
    np.testing.assert_allclose(scaled.points, 8.0 * moved.points, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("dimension", [2, 3])
def test_few_points_have_sides(dimension: int) -> None:
    points = oracles.random_sphere(15, dimension=dimension)
    plan = plan_of(points, 0.05, closed=True)
    assert plan is not None
    assert np.isfinite(filter_whole(points, plan).points).all()
