"""Ellipses: curvature, lengths, nearest points, fits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipe

from experiments.thesis_clouds import distances_to_curve
from oracles import random_rotation
from pcsmooth_experiments.plane.ellipse import (
    REPORT_ELLIPSE,
    Ellipse,
    fit_ellipse,
    sampling_parameters,
)

ELLIPSES = [Ellipse(180.0, 120.0), Ellipse(1.0, 3.0, (5.0, -2.0)), Ellipse(2.0, 2.0, (0.0, 1.0))]


@pytest.mark.parametrize("ellipse", ELLIPSES, ids=str)
def test_normals_and_curvatures_are_those_of_the_curve(ellipse: Ellipse) -> None:
    t, step = np.linspace(0, 2 * np.pi, 40), 1e-4
    velocity = (ellipse.at(t + step) - ellipse.at(t - step)) / (2 * step)
    acceleration = (ellipse.at(t + step) - 2 * ellipse.at(t) + ellipse.at(t - step)) / step**2
    turning = velocity[:, 0] * acceleration[:, 1] - velocity[:, 1] * acceleration[:, 0]
    speed = np.linalg.norm(velocity, axis=1)
    np.testing.assert_allclose(ellipse.curvatures(t), turning / speed**3, rtol=1e-5)
    normals = ellipse.normals(t)
    expected = np.stack([velocity[:, 1], -velocity[:, 0]], axis=1) / speed[:, np.newaxis]
    np.testing.assert_allclose(normals, expected, atol=1e-6)


def test_the_sharp_ends_of_the_report_ellipse() -> None:
    ends = REPORT_ELLIPSE.curvatures(np.array([0.0, np.pi / 2]))
    np.testing.assert_allclose(ends, [180 / 120**2, 120 / 180**2])


@pytest.mark.parametrize("ellipse", ELLIPSES, ids=str)
def test_lengths(ellipse: Ellipse) -> None:
    longer, shorter = max(ellipse.a, ellipse.b), min(ellipse.a, ellipse.b)
    quarter = longer * ellipe(1 - (shorter / longer) ** 2)
    assert ellipse.perimeter == pytest.approx(4 * quarter, rel=1e-7)
    quarters = ellipse.lengths_to(np.arange(5) * np.pi / 2)
    np.testing.assert_allclose(quarters, quarter * np.arange(5), rtol=1e-7)


def test_even_parameters_are_even() -> None:
    n = 2000
    points = REPORT_ELLIPSE.at(REPORT_ELLIPSE.even_parameters(n))
    gaps = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    assert gaps.std() < 1e-4 * gaps.mean()
    assert gaps.sum() == pytest.approx(REPORT_ELLIPSE.perimeter, rel=1e-5)
    uneven = REPORT_ELLIPSE.at(sampling_parameters(n))
    assert np.ptp(np.linalg.norm(np.diff(uneven, axis=0), axis=1)) > 0.3 * gaps.mean()


@pytest.mark.parametrize("ellipse", ELLIPSES, ids=str)
def test_distances_are_those_of_a_dense_curve(ellipse: Ellipse) -> None:
    rng = np.random.default_rng(3)
    size = min(ellipse.a, ellipse.b)
    points = ellipse.at(rng.uniform(0, 2 * np.pi, 60)) + rng.uniform(-0.3, 0.3, (60, 2)) * size
    found = ellipse.distances(points)
    curve = ellipse.at(np.linspace(0, 2 * np.pi, 100_000))
    np.testing.assert_allclose(np.abs(found), distances_to_curve(points, curve), atol=1e-5 * size)
    outside = (((points - ellipse.center) / [ellipse.a, ellipse.b]) ** 2).sum(axis=1) > 1
    np.testing.assert_array_equal(found > 0, outside)
    assert 5 < np.count_nonzero(outside) < 55


@pytest.mark.parametrize("ellipse", ELLIPSES[:2], ids=str)
def test_points_on_an_ellipse_give_it_back(ellipse: Ellipse) -> None:
    found = fit_ellipse(ellipse.at(np.random.default_rng(0).uniform(0, 2 * np.pi, 80)))
    expected = [ellipse.a, ellipse.b, *ellipse.center]
    np.testing.assert_allclose([found.a, found.b, *found.center], expected, atol=1e-6)


def test_no_ellipse_nearby_fits_better() -> None:
    rng = np.random.default_rng(1)
    points = REPORT_ELLIPSE.at(rng.uniform(0, 2 * np.pi, 120)) + rng.normal(size=(120, 2), scale=6)
    best = fit_ellipse(points)
    least = (best.distances(points) ** 2).sum()
    directions = random_rotation(4, rng)
    tried = 0
    for x, y, a, b in [*directions, *-directions]:
        other = Ellipse(best.a + a, best.b + b, (best.center[0] + x, best.center[1] + y))
        curve = other.at(np.linspace(0, 2 * np.pi, 20_000))
        assert (distances_to_curve(points, curve) ** 2).sum() > least
        tried += 1
    assert tried == 8
