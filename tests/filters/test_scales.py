"""Noise and spacing that differ from place to place: how they are measured, and what they do."""

from __future__ import annotations

import numpy as np
import pytest

import oracles
from filters.whole import filter_whole, plan_of
from oracles import Array
from pcsmooth.filters.design import DESIGN
from pcsmooth.filters.neighborhoods import find_neighborhoods
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.filters.scale_measuring import are_uneven
from pcsmooth.filters.scales import ScaleMap, Scales


def planned(points: Array, noise: float | None = None) -> FilterPlan:
    plan = plan_of(points, noise)
    assert plan is not None
    return plan


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def quieter_and_louder(n: int, dimension: int, most: float) -> tuple[Array, Array]:
    """A plane's square (in the plane, a line), noisier at one side; the noise of its points."""
    rng = np.random.default_rng(0)
    sheet = np.zeros((n, dimension))
    sheet[:, :-1] = rng.random((n, dimension - 1))
    noise = 0.2 * (1 / n) ** (1 / (dimension - 1)) * most ** sheet[:, 0]
    sheet[:, -1] = noise * rng.normal(size=n)
    return sheet, noise


def far_and_near(n: int, ratio: float) -> Array:
    """A plane's points on a lattice, jittered, with a spacing that grows to the right."""
    rng = np.random.default_rng(1)
    x = ratio ** np.linspace(0, 1, n)
    x, y = np.meshgrid(x, np.linspace(0, 1, n))
    spacing = np.log(ratio) / n * x
    points = np.stack([x, y * x * np.log(ratio), np.zeros_like(x)], axis=2).reshape(-1, 3)
    jitter = rng.uniform(-1, 1, (n * n, 3)) * [1.0, 1.0, 0.0]
    return np.asarray(points + 0.3 * spacing.reshape(-1, 1) * jitter)


def lines(across: float, noise: float) -> Array:
    """A plane in lines so many times farther apart than the points on them, 1."""
    rng = np.random.default_rng(2)
    x, y = np.meshgrid(np.arange(200.0), across * np.arange(30.0))
    points = np.stack([x, y, np.zeros_like(x)], axis=2).reshape(-1, 3)
    return np.asarray(points + rng.normal(size=points.shape) * [0.2, 0.0, noise])


@pytest.mark.parametrize("dimension", [2, 3])
def test_noise_is_what_it_is_where_it_is(dimension: int) -> None:
    points, noise = quieter_and_louder(6000, dimension, 8.0)
    plan = planned(points)
    scales = plan.scales_at(points)
    assert scales is not None
    np.testing.assert_allclose(np.median(scales.noise / noise), 1.0, atol=0.08)
    assert np.quantile(np.abs(np.log(scales.noise / noise)), 0.95) < 0.35
    assert plan.noise.deviation == pytest.approx(np.median(noise), rel=0.1)
    assert 0.8 * noise.max() < plan.largest_noise < 1.5 * noise.max()


def test_spacing_is_what_it_is_where_it_is() -> None:
    n, ratio = 70, 20.0
    points = far_and_near(n, ratio)
    scales = planned(points).scales_at(points)
    assert scales is not None
    true = np.log(ratio) / n * points[:, 0]
    assert np.quantile(np.abs(np.log(scales.spacing / true)), 0.95) < 0.3
    ratios = scales.cover / scales.spacing
    assert (np.median(ratios) > 1.3) & (np.median(ratios) < 2.4)


@pytest.mark.parametrize("across", [8.0, 12.0, 20.0])
def test_neighborhoods_cover_lines(across: float) -> None:
    """What is nearest lies along a line, and has neither the noise nor a normal."""
    points = lines(across, noise=0.5)
    plan = planned(points)
    assert plan.noise.deviation == pytest.approx(0.5, rel=0.1)
    scales = plan.scales_at(points)
    assert scales is not None
    assert np.median(scales.cover) > 0.9 * across
    neighborhoods = find_neighborhoods(points, plan.passes[0], scales).with_averaged_normals(4)
    normals = neighborhoods.in_order(neighborhoods.normals[2])
    inside = np.abs(points[:, 1] - 14.5 * across) < 12 * across
    assert (np.abs(normals[inside]) > 0.97).mean() > 0.95
    assert rms(filter_whole(points, plan).points[inside, 2]) < 0.3 * 0.5


@pytest.mark.parametrize("noise", [0.1, 0.7, 1.5])
def test_even_clouds_need_no_map(noise: float) -> None:
    for surface in (oracles.sphere_surface(4000), oracles.torus_surface(4000)):
        assert planned(surface.noisy(noise)).scale_map is None
    circle = oracles.random_sphere(2000, dimension=2)
    circle *= 1 + noise * np.pi / 1000 * np.random.default_rng(5).normal(size=(2000, 1))
    assert planned(circle).scale_map is None


def test_any_of_three_makes_a_cloud_uneven() -> None:
    even = np.ones(100)
    varied = np.geomspace(0.3, 3, 100)
    assert not are_uneven(Scales(even, even, 1.7 * even, even), 3, DESIGN)
    assert are_uneven(Scales(varied, even, 1.7 * even, even), 3, DESIGN)
    assert are_uneven(Scales(even, varied, 1.7 * varied, even), 3, DESIGN)
    assert are_uneven(Scales(even, even, 2.5 * even, even), 3, DESIGN)


def test_a_point_gets_a_mean_of_the_samples_around() -> None:
    rng = np.random.default_rng(3)
    samples = rng.random((50, 3))
    scales = Scales(*rng.uniform(1, 2, (4, 50)))
    found = ScaleMap(samples, scales, 6, 1.0).at(samples + 1e-9)
    for name, values in vars(scales).items():
        assert vars(found)[name].min() >= values.min()
        assert vars(found)[name].max() <= values.max() * (1 + 1e-12)
    # A linear function is nearly kept.
    linear = samples @ [1.0, 2.0, 3.0] + 1
    found = ScaleMap(samples, Scales(linear, linear, linear, linear), 6, 1.0).at(samples)
    assert np.corrcoef(found.noise, linear)[0, 1] > 0.95


def test_a_map_scales_with_the_cloud() -> None:
    points = far_and_near(40, 20.0)
    known = planned(points).scale_map
    assert known is not None
    twice = known.scaled(2.0).at(2.0 * points)
    for name, values in vars(known.at(points)).items():
        np.testing.assert_array_equal(vars(twice)[name], 2.0 * values)


def test_noise_that_is_told_is_that_of_all_points() -> None:
    points = far_and_near(40, 20.0)
    plan = planned(points, 0.01)
    scales = plan.scales_at(points)
    assert scales is not None
    np.testing.assert_allclose(scales.noise, 0.01)
    assert plan.noise.deviation == 0.01


def test_no_point_goes_farther_than_its_own_noise_explains() -> None:
    points, noise = quieter_and_louder(6000, 3, 8.0)
    plan = planned(points)
    scales = plan.scales_at(points)
    assert scales is not None
    moves = np.linalg.norm(filter_whole(points, plan).points - points, axis=1)
    assert (moves <= DESIGN.max_move_by_map * scales.noise * (1 + 1e-12)).all()
    assert moves[noise > 4 * noise.min()].max() > DESIGN.max_move_by_map * noise.min()


def test_near_and_far_lose_as_much_of_their_noise() -> None:
    points = far_and_near(70, 20.0)
    spacing = np.log(20.0) / 70 * points[:, 0]
    noise = 0.3 * spacing
    points[:, 2] += noise * np.random.default_rng(4).normal(size=len(points))
    after = filter_whole(points, planned(points)).points[:, 2]
    for side in (spacing < np.quantile(spacing, 0.3), spacing > np.quantile(spacing, 0.7)):
        assert rms(after[side] / noise[side]) < 0.4


def test_the_range_of_the_noise_is_that_of_nine_points_in_ten() -> None:
    points, noise = quieter_and_louder(6000, 3, 4.0)
    found = planned(points).noise_range
    assert found is not None
    assert found == pytest.approx(tuple(np.quantile(noise, (0.05, 0.95))), rel=0.15)
    assert planned(oracles.torus_surface(3000).noisy(0.3)).noise_range is None


@pytest.mark.parametrize("by_map", [False, True])
def test_points_at_their_limit_are_counted(by_map: bool) -> None:
    points = (
        quieter_and_louder(6000, 3, 8.0)[0] if by_map else oracles.sphere_surface(2000).noisy(0.3)
    )
    plan = planned(points)
    scales = plan.scales_at(points)
    assert (scales is not None) == by_map
    limits = plan.max_move * plan.noise_at(scales, len(points))
    shares = np.linspace(0.0, 1.0, len(points))
    shares[::10] = 1.0
    expected = len(shares[::10]) + 1
    noise = plan.noise_at(scales, len(points)) if by_map else plan.noise.deviation
    assert plan.count_at_limit(noise, shares * limits) == expected
    assert plan.count_at_limit(noise, np.zeros(len(points))) == 0
