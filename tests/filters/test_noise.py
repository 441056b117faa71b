from __future__ import annotations

import numpy as np
import pytest

import oracles
from filters.whole import surroundings_of
from oracles import Array
from pcsmooth.filters.design import DESIGN
from pcsmooth.filters.noise import measure_noise
from pcsmooth.neighbors.surroundings import Surroundings


def measured(points: Array) -> tuple[float, int]:
    found = measure_noise(surroundings_of(points), DESIGN)
    return found.deviation, found.support


def line(n: int) -> Array:
    return np.asarray(np.c_[np.random.default_rng(0).random(n), np.zeros(n)])


def plane(n: int) -> Array:
    return np.asarray(np.c_[np.random.default_rng(0).random((n, 2)), np.zeros(n)])


@pytest.mark.parametrize("noise", [0.1, 0.7, 2.0])
@pytest.mark.parametrize("name", ["line", "plane", "sphere", "torus"])
def test_noise_of_known_surfaces(name: str, noise: float) -> None:
    """Within 8 %, three times what 800 overlapping samples leave; 4 % more for a torus' detail."""
    n = 10_000
    if name in ("line", "plane"):
        clean = line(n) if name == "line" else plane(n)
        deviation = noise / n if name == "line" else noise / np.sqrt(n)
        points = clean.copy()
        points[:, -1] += deviation * np.random.default_rng(1).normal(size=n)
    else:
        surface = oracles.sphere_surface(n) if name == "sphere" else oracles.torus_surface(n)
        deviation = noise * surface.spacing
        points = surface.noisy(noise)
    found, _ = measured(points)
    assert found == pytest.approx(deviation, rel=0.12 if name == "torus" else 0.08)


@pytest.mark.parametrize("noise", [0.1, 0.7])
def test_outliers_hardly_count(noise: float) -> None:
    surface = oracles.torus_surface(10_000)
    strays = np.random.default_rng(2).uniform([-1.4, -1.4, -0.4], [1.4, 1.4, 0.4], (200, 3))
    found, _ = measured(np.r_[surface.noisy(noise), strays])
    assert found == pytest.approx(noise * surface.spacing, rel=0.1)


def around_first(points: Array) -> Surroundings:
    """All points as if in the order of their distance from the first."""
    return Surroundings(len(points), np.ones((1, len(points))), points[np.newaxis])


def test_a_quadric_over_a_plane_has_no_noise() -> None:
    """Where its principal plane is the tangent plane; up to the root of the rounding error."""
    x = np.linspace(-1, 1, 16)
    parabola = np.c_[x, 0.1 * x**2]
    found = measure_noise(around_first(parabola[np.argsort(x**2)]), DESIGN)
    assert found.deviation < 1e-9
    u, v = (grid.ravel() for grid in np.meshgrid(x[::3], x[::3]))
    saddle = np.c_[u, v, 0.1 * (u**2 - v**2)]
    nearest = np.argsort(np.round(u**2 + v**2, 9), kind="stable")
    found = measure_noise(around_first(saddle[nearest]), DESIGN)
    assert found.deviation < 1e-9


@pytest.mark.parametrize("dimension", [2, 3])
def test_neighborhoods_grow_with_the_noise(dimension: int) -> None:
    rng = np.random.default_rng(3)
    clean = line(4000) * 4000 if dimension == 2 else plane(4000) * np.sqrt(4000)
    supports = []
    for noise in (0.3, 1.0, 2.0, 4.0):
        points = clean.copy()
        points[:, -1] += noise * rng.normal(size=len(points))
        supports.append(measured(points)[1])
    assert supports == sorted(supports)
    assert supports[-1] > 2 * supports[0]


@pytest.mark.parametrize(("dimension", "too_few"), [(2, 5), (3, 15)])
def test_too_few_points_have_no_noise(dimension: int, too_few: int) -> None:
    points = np.random.default_rng(0).normal(size=(too_few, dimension))
    assert measured(points) == (0.0, 0)


def test_collinear_points_in_space_have_no_noise() -> None:
    points = np.random.default_rng(0).random((100, 1)) * [1.0, 2.0, 3.0]
    assert measured(points)[0] < 1e-15
