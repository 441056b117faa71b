from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import oracles
from filters.whole import plan_of, surroundings_of
from oracles import Array
from pcsmooth.filters.design import DESIGN
from pcsmooth.filters.flatness import thicknesses
from pcsmooth.filters.strays import find_strays, has_crowd, leave_out_strays


def sphere_among(share: float, n: int = 8000) -> tuple[Array, float]:
    """A sphere among random points, and the noise of its points."""
    surface = oracles.sphere_surface(n)
    rng = np.random.default_rng(0)
    strays = rng.uniform(-1.5, 1.5, (int(share * n), 3))
    return np.concatenate([surface.noisy(0.3), strays]), 0.3 * surface.spacing


def canopy(n: int = 8000) -> Array:
    """Ground, and crowns of trees over half of it: as many points on either, seen from above."""
    rng = np.random.default_rng(1)
    points = np.zeros((n, 3))
    points[:, :2] = np.sqrt(n) * rng.random((n, 2))
    is_tree = (points[:, 0] < 0.5 * np.sqrt(n)) & (rng.random(n) < 0.6)
    points[:, 2] = 0.1 * rng.normal(size=n)
    points[is_tree, 2] += 20 * rng.random(is_tree.sum()) ** 0.5
    return points


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_strays_are_told_from_a_surface(share: float) -> None:
    points, noise = sphere_among(share)
    around = surroundings_of(points)
    distances = np.abs(np.linalg.norm(around.positions[:, 0], axis=1) - 1)
    found = np.zeros(len(distances), np.bool_)
    found[find_strays(around, DESIGN)] = True
    assert has_crowd(around, DESIGN)
    assert not found[distances < 4 * noise].any()
    assert found[distances > 0.2].mean() > 0.9
    left = leave_out_strays(around, DESIGN)
    np.testing.assert_array_equal(left.distances, around.distances[~found])
    np.testing.assert_array_equal(left.positions, around.positions[~found])
    assert left.count == around.count


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_a_crowd_of_strays_does_not_spoil_the_plan(share: float) -> None:
    points, noise = sphere_among(share)
    plan, clean = plan_of(points), plan_of(sphere_among(0.0)[0])
    assert plan is not None
    assert clean is not None
    assert plan.noise.deviation == pytest.approx(noise, rel=0.08)
    assert plan.scale_map is None
    assert plan.passes[0].max_radius == pytest.approx(clean.passes[0].max_radius, rel=0.1)
    assert 0.5 * share < plan.stray_share < share
    assert plan.scaled(2.0).stray_share == plan.stray_share
    assert clean.stray_share == 0.0
    let_be = plan_of(points, design=replace(DESIGN, stray_min_share=1.0))
    assert let_be is not None
    assert let_be.passes[0].max_radius > 1.5 * clean.passes[0].max_radius


def far_ground(n: int = 6000) -> Array:
    """Flat ground from a tripod 2 m high, from 2 to 60 m away: 30 times sparser there."""
    rng = np.random.default_rng(2)
    angles, turns = rng.uniform(np.arctan(2 / 60), np.arctan(1), n), rng.random(n)
    ranges = 2 / np.tan(angles)
    heights = 0.002 * ranges * rng.normal(size=n)
    return np.stack([ranges * np.cos(turns), ranges * np.sin(turns), heights], axis=1)


def scan_lines(n: int = 6000) -> Array:
    rng = np.random.default_rng(3)
    x, y = np.meshgrid(np.arange(n // 20), np.arange(20.0) * 15)
    points = np.stack([x.ravel(), y.ravel(), 0.3 * rng.normal(size=x.size)], axis=1)
    points[:, 0] += rng.uniform(-0.3, 0.3, x.size)
    return points


@pytest.mark.parametrize("make", [far_ground, scan_lines, canopy])
def test_sparse_parts_are_no_crowd(make: Callable[[], Array]) -> None:
    assert not has_crowd(surroundings_of(make()), DESIGN)


def test_few_samples_tell_nothing() -> None:
    assert not len(find_strays(surroundings_of(np.eye(3)), DESIGN))
    assert not has_crowd(surroundings_of(np.eye(3)), DESIGN)


def test_thickness_is_that_across_or_how_far_the_first_lies_off() -> None:
    x, y = np.meshgrid(np.arange(-2.0, 3), np.arange(-1.0, 2))
    others = np.c_[x.ravel(), y.ravel(), np.tile([0.1, -0.1], 8)[:15]]
    tilt = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    across = np.var(others[:, 2])
    for height, expected in ((0.0, across / 2.0), (1.5, 1.5**2 / 2.0)):
        first = np.array([[0.0, 0.0, height + others[:, 2].mean()]])
        neighborhood = np.concatenate([first, others]) @ tilt
        found = thicknesses(neighborhood[np.newaxis])[0]
        assert found == pytest.approx(expected, rel=2e-3)
