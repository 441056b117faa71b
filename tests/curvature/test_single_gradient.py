from __future__ import annotations

from math import asin, pi, sin, sqrt

import numpy as np
import pytest

import oracles
from oracles import Array, Expected
from pcsmooth.curvature.estimate import CurvatureEstimate
from pcsmooth.curvature.single_gradient import curvature_vectors
from pcsmooth.energies.balls import measure_balls
from pcsmooth.energies.protocol import Quantity
from pcsmooth.python.estimating import estimate_curvature

TRIANGLE = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.2], [0.4, 0.9, -0.1]])

FEW = {
    "two balls": (TRIANGLE[:2], oracles.two_balls),
    "three balls": (TRIANGLE, oracles.three_balls),
    "two disks": (TRIANGLE[:2, :2], oracles.two_balls),
    "three disks": (TRIANGLE[:, :2], oracles.three_disks),
}


def expected_vectors(expected: Expected, radius: float, quantity: Quantity) -> Array:
    areas = expected.visible_areas[:, np.newaxis] * (expected.volume_gradient.shape[1] - 1)
    if quantity == "volume":
        return np.asarray(expected.volume_gradient / (radius * areas))
    return np.asarray(expected.area_gradient / areas)


def by_report(points: Array, radius: float | str, quantity: Quantity) -> CurvatureEstimate:
    return estimate_curvature(points, radius=radius, estimator="gradient", energy=quantity)


@pytest.mark.parametrize("quantity", ["volume", "area"])
@pytest.mark.parametrize("name", FEW)
def test_vectors_of_few_balls_are_gradients_over_areas(name: str, quantity: Quantity) -> None:
    points, closed_form = FEW[name]
    radius = 0.8
    expected = expected_vectors(closed_form(points, radius), radius, quantity)
    oracles.assert_close(
        curvature_vectors(measure_balls(points, radius), quantity), expected, 1e-12
    )
    estimate = by_report(points, radius, quantity)
    lengths = np.linalg.norm(expected, axis=1)
    oracles.assert_close(np.abs(estimate.mean_curvature), lengths, 1e-12)


def even_circle_curvature(n: int, radius: float, quantity: Quantity) -> float:
    """n disks on a unit circle that meet only their neighbours; facets point at its centre."""
    half = sin(pi / n)
    rho = sqrt(radius**2 - half**2)
    visible = 4 * radius * asin(half / radius)
    if quantity == "volume":
        return 4 * rho * half / (radius * visible)
    return 4 * radius / rho * half / visible


@pytest.mark.parametrize("quantity", ["volume", "area"])
@pytest.mark.parametrize("spacings", [0.8, 2.0, 5.0])
@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_even_circles_are_as_the_closed_form_says(
    quantity: Quantity, spacings: float, scale: float
) -> None:
    n = 300
    radius = spacings * 2 * pi / n
    points = oracles.even_circle(n, scale)
    estimate = by_report(points, scale * radius, quantity)
    expected = even_circle_curvature(n, radius, quantity) / scale
    np.testing.assert_allclose(estimate.mean_curvature, expected, rtol=1e-11)
    np.testing.assert_allclose(estimate.normals, points / scale, atol=1e-12)
    np.testing.assert_allclose(estimate.confidence, 1, rtol=1e-12)


@pytest.mark.parametrize("quantity", ["volume", "area"])
def test_dense_even_circles_tend_to_one_over_the_radius(quantity: Quantity) -> None:
    for n, spacings, error in ((500, 2.0, 0.05), (2000, 5.0, 0.01), (5000, 12.0, 0.002)):
        estimate = by_report(oracles.even_circle(n), spacings * 2 * pi / n, quantity)
        np.testing.assert_allclose(estimate.mean_curvature, 1, rtol=error)


@pytest.mark.parametrize("quantity", ["volume", "area"])
@pytest.mark.parametrize("radius", [0.5, 1.0, 2.0])
@pytest.mark.parametrize(
    ("sample", "error"), [(oracles.even_sphere, 0.1), (oracles.random_sphere, 0.1)]
)
def test_spheres_bend_by_about_one_over_their_radius(
    sample: type, error: float, radius: float, quantity: Quantity
) -> None:
    estimate = by_report(sample(2000, radius), "auto", quantity)
    assert np.median(abs(estimate.mean_curvature * radius - 1)) < error


@pytest.mark.parametrize("quantity", ["volume", "area"])
def test_a_covered_point_has_no_curvature(quantity: Quantity) -> None:
    points = np.r_[oracles.even_sphere(200), [[0.0, 0.0, 0.0]]]
    union = measure_balls(points, 1.2)
    assert union.visible_areas[-1] == pytest.approx(0, abs=1e-12)
    vectors = curvature_vectors(union, quantity)
    assert not vectors[-1].any()
    assert vectors[:-1].any(axis=1).all()
    estimate = by_report(points, 1.2, quantity)
    assert estimate.mean_curvature[-1] == 0
    assert estimate.confidence[-1] == 0


@pytest.mark.parametrize("quantity", ["volume", "area"])
def test_only_the_mean_curvature_is_known_in_space(quantity: Quantity) -> None:
    estimate = by_report(oracles.random_sphere(500), "auto", quantity)
    assert np.isnan(estimate.gaussian_curvature).all()
    assert np.isnan(estimate.principal_curvatures).all()
    assert estimate.principal_curvatures.shape == (500, 2)
    assert np.median(estimate.confidence) > 0.95
    assert (estimate.confidence <= 1 + 1e-12).all()


@pytest.mark.parametrize("quantity", ["volume", "area"])
def test_all_curvatures_are_one_in_the_plane(quantity: Quantity) -> None:
    estimate = by_report(oracles.random_sphere(200, dimension=2), "8x", quantity)
    np.testing.assert_array_equal(estimate.gaussian_curvature, estimate.mean_curvature)
    np.testing.assert_array_equal(estimate.principal_curvatures[:, 0], estimate.mean_curvature)


@pytest.mark.parametrize("orient", ["outward", "direction=0,0,1"])
def test_signs_are_those_of_the_normals(orient: str) -> None:
    points = oracles.random_sphere(2000)
    points = points[points[:, 2] < 0.5]
    estimate = estimate_curvature(points, estimator="gradient", orient=orient)
    inside = points[:, 2] < 0.3
    turned = np.sign(np.einsum("ij,ij->i", estimate.normals, points))
    assert (np.sign(estimate.mean_curvature) == turned)[inside].all()
    vectors = estimate.mean_curvature_vectors[inside]
    assert (np.einsum("ij,ij->i", vectors, points[inside]) > 0).all()


def test_coincident_points_share_their_vectors() -> None:
    points = oracles.random_sphere(300)
    repeated = by_report(np.r_[points, points[:50]], 0.3, "volume")
    alone = by_report(points, 0.3, "volume")
    np.testing.assert_array_equal(repeated.mean_curvature[300:], repeated.mean_curvature[:50])
    oracles.assert_close(repeated.mean_curvature[:300], alone.mean_curvature, 1e-10)
