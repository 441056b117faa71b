from __future__ import annotations

import numpy as np
import pytest

import oracles
from oracles import Array
from pcsmooth.curvature import estimate_normals_and_curvature
from pcsmooth.energies.balls import measure_balls


def estimate(points: Array, radius: float) -> tuple[Array, Array]:
    return estimate_normals_and_curvature(points, measure_balls(points, radius), radius)


def sphere_spacing(n: int, radius: float) -> float:
    return float(np.sqrt(oracles.sphere_area(radius, 3) / n))


def degrees_between(normals: Array, expected: Array) -> Array:
    cosines = np.einsum("ij,ij->i", normals, expected)
    return np.asarray(np.degrees(np.arccos(np.clip(cosines, -1, 1))))


@pytest.mark.parametrize("radius", [0.5, 1.0, 2.0])
@pytest.mark.parametrize(
    ("sample", "curvature_error", "angle"),
    [(oracles.even_sphere, 0.032, 0.6), (oracles.random_sphere, 0.06, 1.0)],
)
def test_sphere_bends_by_one_over_its_radius(
    sample: type, curvature_error: float, angle: float, radius: float
) -> None:
    points = sample(2000, radius)
    normals, curvature = estimate(points, 2 * sphere_spacing(2000, radius))
    assert np.median(abs(curvature * radius - 1)) < curvature_error
    errors = degrees_between(normals, points / radius)
    assert np.median(errors) < angle
    assert errors.max() < 4
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, rtol=1e-14)


@pytest.mark.parametrize("radius", [0.5, 1.0, 2.0])
def test_circle_bends_by_one_over_its_radius(radius: float) -> None:
    points = oracles.even_circle(500, radius)
    normals, curvature = estimate(points, 4 * np.pi * radius / 500)
    np.testing.assert_allclose(curvature, 1 / radius, rtol=0.025)
    np.testing.assert_allclose(normals, points / radius, atol=1e-10)


def test_curvature_of_a_torus_is_the_mean_of_its_principal_curvatures() -> None:
    points, outward = oracles.random_torus(5000)
    normals, curvature = estimate(points, 2 * np.sqrt(4 * np.pi**2 * 0.4 / 5000))
    cosine = outward[:, 0] * np.cos(np.arctan2(points[:, 1], points[:, 0]))
    cosine += outward[:, 1] * np.sin(np.arctan2(points[:, 1], points[:, 0]))
    expected = (1 / 0.4 + cosine / (1 + 0.4 * cosine)) / 2
    assert np.median(abs(curvature / expected - 1)) < 0.07
    assert degrees_between(normals, outward).max() < 8


@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_plane_does_not_bend(tilt: float) -> None:
    flat = np.c_[oracles.uniform_cloud(1000, 2), np.zeros(1000)]
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    normals, curvature = estimate(flat @ turn.T, 0.07)
    np.testing.assert_allclose(normals, np.broadcast_to(turn[:, 2], normals.shape), atol=1e-12)
    np.testing.assert_allclose(curvature, 0, atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_nothing_is_known_at_an_isolated_point(dimension: int) -> None:
    circle = np.c_[oracles.even_circle(100), np.zeros(100)][:, :dimension]
    far = np.full((1, dimension), 5.0)
    normals, curvature = estimate(np.r_[circle, far], 0.1)
    assert not normals[-1].any()
    assert curvature[-1] == 0
    assert (np.linalg.norm(normals[:-1], axis=1) > 0.99).all()


def test_one_point_has_no_normal() -> None:
    normals, curvature = estimate(np.ones((1, 3)), 1.0)
    assert not normals.any()
    assert not curvature.any()


def test_coincident_points_share_their_estimates() -> None:
    points = oracles.random_sphere(500)
    of = np.r_[np.arange(500), np.random.default_rng(3).integers(0, 500, 200)]
    alone = estimate(points, 0.3)
    for repeated, expected in zip(estimate(points[of], 0.3), alone, strict=True):
        np.testing.assert_array_equal(repeated[500:], repeated[of[500:]])
        np.testing.assert_allclose(repeated, expected[of], rtol=0, atol=1e-10)
