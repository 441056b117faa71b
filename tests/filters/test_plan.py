from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import oracles
from filters.whole import plan_of
from oracles import Array
from pcsmooth.filters.neighborhoods import find_neighborhoods


@pytest.mark.parametrize(("dimension", "too_few"), [(2, 3), (3, 11)])
def test_too_few_points_have_no_plan(dimension: int, too_few: int) -> None:
    points = np.random.default_rng(0).normal(size=(too_few + 1, dimension))
    assert plan_of(points[:-1]) is None
    assert plan_of(points) is not None


def test_noise_that_is_told_is_taken() -> None:
    plan = plan_of(oracles.sphere_surface(2000).noisy(0.3), noise=0.25)
    assert plan is not None
    assert plan.noise.deviation == 0.25


def test_the_spacing_is_that_of_the_surface() -> None:
    for surface in (oracles.sphere_surface(5000), oracles.torus_surface(5000)):
        plan = plan_of(surface.noisy(0.3))
        assert plan is not None
        assert plan.spacing == pytest.approx(surface.spacing, rel=0.06)
        assert 1.2 < plan.density_variation < 2.5


@pytest.mark.parametrize("noise", [0.1, 0.7, 1.5])
def test_nearly_all_points_reach_their_neighborhood(noise: float) -> None:
    points = oracles.torus_surface(5000).noisy(noise)
    plan = plan_of(points)
    assert plan is not None
    for width in (plan.passes[0], plan.last):
        neighborhoods = find_neighborhoods(points, width)
        covered = neighborhoods.sizes * (1 - width.thickness**2 / neighborhoods.squares)
        assert (covered >= width.count).mean() > 0.95
    first = find_neighborhoods(points, plan.passes[0])
    assert np.median(first.sizes) == pytest.approx(plan.support, rel=0.1)


def test_noise_that_is_told_is_taken_from_a_volume_too() -> None:
    points = np.random.default_rng(1).random((1000, 3))
    measured, told = plan_of(points), plan_of(points, noise=0.01)
    assert measured is not None
    assert told is not None
    assert (measured.has_surface, measured.moves_points) == (False, False)
    assert (told.has_surface, told.moves_points) == (True, True)


def dense_and_sparse(n: int, share_of_area: float) -> Array:
    """A plane's square, and as many points again in a small square in its corner."""
    rng = np.random.default_rng(0)
    square = rng.random((n, 2))
    square[n // 2 :] *= np.sqrt(share_of_area)
    return np.asarray(np.c_[square, np.zeros(n)])


@pytest.mark.slow
def test_reach_is_bounded_by_the_number_of_points_within() -> None:
    n = 10_000
    plan = plan_of(dense_and_sparse(n, 1e-4), noise=1e-5)
    assert plan is not None
    for width in (*plan.passes, plan.last):
        wide = replace(width, count=float(n), thickness=0.0)  # all within its radius
        sizes = find_neighborhoods(dense_and_sparse(n, 1e-4), wide).sizes
        assert sizes.mean() < 2500


def test_regions_a_hundred_times_sparser_are_reached() -> None:
    points = dense_and_sparse(10_000, 1e-2)
    plan = plan_of(points, noise=1e-4)
    assert plan is not None
    neighborhoods = find_neighborhoods(points, plan.passes[0])
    assert (neighborhoods.sizes >= 12).mean() > 0.95
