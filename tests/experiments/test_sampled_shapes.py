"""Shapes whose measures are known, and their points."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial import cKDTree
from scipy.special import ellipe

import oracles
from pcsmooth_experiments.sampled_shapes import Sampling, Shape, ellipse, spheroid, torus

SHAPES = (ellipse(1.0, 1.0), ellipse(1.0, 0.6), spheroid(), spheroid(1.0, 0.7), torus(0.4))


def oblate_area(a: float, c: float) -> float:
    """Closed form of the area of a flattened ellipsoid of revolution."""
    e = np.sqrt(1 - (c / a) ** 2)
    return float(2 * np.pi * a**2 * (1 + (1 - e**2) / e * np.arctanh(e)))


@pytest.mark.parametrize(
    ("shape", "area"),
    [
        (SHAPES[0], 2 * np.pi),
        (SHAPES[1], 4 * ellipe(1 - 0.6**2)),
        (SHAPES[2], 4 * np.pi),
        (SHAPES[3], oblate_area(1.0, 0.7)),
        (SHAPES[4], 4 * np.pi**2 * 0.4),
    ],
)
def test_areas(shape: Shape, area: float) -> None:
    assert shape.area == pytest.approx(area, rel=1e-9)


@pytest.mark.parametrize("sampling", ["even", "random"])
@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.name)
def test_points_lie_on_the_shape_with_its_normals(shape: Shape, sampling: Sampling) -> None:
    sample = shape.sample(500, sampling)
    x, normals = sample.points, sample.normals
    if shape.name == "torus":
        assert abs(oracles.distance_to_torus(x, 0.4)).max() < 1e-12
        center = np.c_[x[:, :2] / np.hypot(x[:, 0], x[:, 1])[:, None], np.zeros(len(x))]
        expected = (x - center) / 0.4
    else:
        squares = {"ellipse": [1, 0.36], "ellipsoid": [1, 1, 0.49]}.get(
            shape.name, [1.0] * shape.dimension
        )
        assert abs((x**2 / squares).sum(axis=1) - 1).max() < 1e-12
        expected = x / squares
        expected = expected / np.linalg.norm(expected, axis=1, keepdims=True)
    assert abs(normals - expected).max() < 1e-9


@pytest.mark.parametrize("shape", SHAPES[2:], ids=lambda shape: shape.name)
def test_curvatures(shape: Shape) -> None:
    """Gauss-Bonnet, and the derivative of the area of parallel surfaces."""
    sample = shape.sample(20_000, "even")
    gaussian = sample.principal_curvatures.prod(axis=1)
    total = shape.area * gaussian.mean()
    assert total == pytest.approx(2 * np.pi * shape.euler_characteristic, abs=2e-3)
    if shape.name == "torus":
        assert shape.area * sample.mean_curvatures.mean() == pytest.approx(4 * np.pi**2, rel=1e-4)
    if shape.name == "ellipsoid":  # at the poles c / a^2, at the equator 1/a and a / c^2
        top = np.argmax(sample.points[:, 2])
        assert sample.principal_curvatures[top] == pytest.approx(0.7, rel=1e-3)
        side = np.argmin(abs(sample.points[:, 2]))
        assert sample.principal_curvatures[side] == pytest.approx([1 / 0.49, 1.0], rel=1e-3)


def test_curvature_of_an_ellipse() -> None:
    """Its integral along the curve is one turn; at the ends of the axes a / b^2 and b / a^2."""
    shape = ellipse(1.0, 0.6)
    sample = shape.sample(4000, "even")
    assert shape.area * sample.mean_curvatures.mean() == pytest.approx(2 * np.pi, rel=1e-5)
    assert sample.mean_curvatures.max() == pytest.approx(1 / 0.36, rel=1e-4)
    assert sample.mean_curvatures.min() == pytest.approx(0.6, rel=1e-4)
    assert shape.reach == pytest.approx(0.36)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.name)
def test_even_points_are_even(shape: Shape) -> None:
    n = 987
    points = shape.sample(n, "even").points
    spacing = (shape.area / n) ** (1 / (shape.dimension - 1))
    nearest = cKDTree(points).query(points, 2)[0][:, 1]
    assert nearest.min() > 0.7 * spacing
    assert shape.covering_radius(points) < 0.9 * spacing


def test_random_points_are_uniform_by_area() -> None:
    """Of a torus the inner half has less area than the outer one."""
    x = torus(0.4).sample(40_000, "random", seed=3).points
    outer = (np.hypot(x[:, 0], x[:, 1]) > 1).mean()
    assert outer == pytest.approx(0.5 + 0.4 / np.pi, abs=0.01)
    z = spheroid().sample(40_000, "random").points[:, 2]
    assert np.quantile(z, [0.1, 0.5, 0.9]) == pytest.approx([-0.8, 0.0, 0.8], abs=0.02)


@pytest.mark.parametrize("n", [10, 37, 200])
def test_covering_radius_of_even_points_of_a_circle(n: int) -> None:
    circle = ellipse(1.0, 1.0)
    covering = circle.covering_radius(circle.sample(n, "even").points)
    expected = 2 * np.sin(np.pi / (2 * n))
    assert 0.985 * expected < covering <= expected * (1 + 1e-9)


def test_tubes() -> None:
    r = 0.3
    assert spheroid().tube_volume(r) == pytest.approx(4 / 3 * np.pi * (1.3**3 - 0.7**3), rel=1e-9)
    assert ellipse(1.0, 1.0).tube_volume(r) == pytest.approx(np.pi * (1.3**2 - 0.7**2), rel=1e-9)
    assert torus(0.4).tube_volume(r) == pytest.approx(2 * np.pi**2 * (0.7**2 - 0.1**2), rel=1e-9)


def test_tube_of_an_ellipsoid() -> None:
    """Shells between parallel surfaces, by quadrature over the latitude."""
    a, c, r = 1.0, 0.7, 0.2

    def shell(t: float) -> float:
        speed = np.hypot(a * np.sin(t), c * np.cos(t))
        k1, k2 = a * c / speed**3, c / (a * speed)
        area = 2 * np.pi * a * np.cos(t) * speed
        return float(area * (2 * r + 2 / 3 * r**3 * k1 * k2))

    expected = quad(shell, -np.pi / 2, np.pi / 2)[0]
    assert spheroid(a, c).tube_volume(r) == pytest.approx(expected, rel=1e-8)
