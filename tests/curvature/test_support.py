from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt
import pytest

import oracles
from curvature.found import facing, find
from oracles import Array, Surface
from pcsmooth.curvature import support
from pcsmooth.curvature.cell_normals import CELLS
from pcsmooth.curvature.support import (
    choose_supports,
    fit_supports,
    ratios_of_supports,
    sample_ranks,
)
from pcsmooth.kernels.surface.nested_supports import fit_nested_supports
from pcsmooth.neighbors.grid import build_grid
from pcsmooth.python.estimating import estimate_curvature

SUPPORTS = [30, 60, 120, 240, 480, 960, 1920]


@cache
def surface_named(name: str) -> Surface:
    if name == "torus":
        return oracles.torus_surface(10_000)
    return oracles.ellipsoid_surface(10_000, (1.0, 0.7, 0.5))


@pytest.mark.parametrize("name", ["torus", "ellipsoid"])
def test_supports_grow_with_the_noise(name: str) -> None:
    surface = surface_named(name)
    estimates = [estimate_curvature(surface.noisy(noise)) for noise in (0.0, 0.1, 0.3, 0.7)]
    normal = [estimate.normal_support for estimate in estimates]
    curvature = [estimate.curvature_support for estimate in estimates]
    assert (np.diff(normal) > 0).all()
    assert (np.diff(curvature) > 0).all()
    assert curvature[-1] > 2 * curvature[0]
    assert all(small <= large for small, large in zip(normal, curvature, strict=True))


@pytest.mark.parametrize("noise", [0.1, 0.7])
def test_supports_are_large_where_the_fit_is_exact(noise: float) -> None:
    """On a sphere there is no bias to weigh against the noise."""
    estimate = estimate_curvature(oracles.sphere_surface(20_000).noisy(noise))
    assert estimate.normal_support > 300
    assert estimate.curvature_support > 600


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.1, 0.3, 0.7])
@pytest.mark.parametrize("name", ["torus", "ellipsoid"])
def test_chosen_supports_are_nearly_the_best(name: str, noise: float) -> None:
    surface = surface_named(name)
    points = surface.noisy(noise)

    def error(choice: int | str) -> float:
        estimate = estimate_curvature(points, support=choice)  # type: ignore[arg-type]
        return float(np.median(abs(estimate.mean_curvature - surface.mean)))

    assert error("auto") < 1.2 * min(map(error, SUPPORTS))


def nested_fits(points: Array, outward: Array, radius: float) -> tuple[Array, Array, Array]:
    """Ratios of radii, and fitted normals and shape operators of 2,000 points less the truth.

    For points near a unit sphere, where the shape operator is the identity.
    """
    dimension = points.shape[1]
    found = facing(find(points, radius), outward)
    ratios = 2.0 ** (np.arange(7) / 2)
    extent = found.cells.extent
    grid = build_grid(found.cells.anchors[:dimension].T, float(extent * ratios[-1]))
    samples = np.argsort(grid.order)[:: -(-len(points) // 2000)]
    normals, shapes = fit_nested_supports(
        grid.coordinates,
        grid.order,
        grid.cells,
        found.points,
        found.cells.normals,
        found.cells.weights,
        dimension,
        samples,
        np.full(len(samples), extent),
        ratios,
    )
    truth = np.zeros((len(samples), 3))
    truth[:, :dimension] = outward[found.order[grid.order[samples]]]
    operator = [1.0, 1.0, 0.0] if dimension == 3 else [1.0, 0.0, 0.0]
    shapes = shapes - operator
    if dimension == 2:
        shapes[:, :, 1:] = 0
    return ratios, normals - truth[:, np.newaxis], shapes * np.sqrt([1.0, 1.0, 2.0])


def variances(deviations: Array) -> Array:
    """Median squares, relative to the first."""
    squares = np.median((deviations**2).sum(axis=2), axis=0)
    return np.asarray(squares / squares[0])


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.1, 0.3, 0.7])
@pytest.mark.parametrize("dimension", [2, 3])
def test_noise_falls_as_the_laws_say(dimension: int, noise: float) -> None:
    n = 20_000
    outward = oracles.even_circle(n) if dimension == 2 else oracles.random_sphere(n)
    spacing = 2 * np.pi / n if dimension == 2 else np.sqrt(4 * np.pi / n)
    moves = np.random.default_rng(1).normal(size=(n, 1))
    points = outward * (1 + noise * spacing * moves)
    ratios, normals, shapes = nested_fits(points, outward, 2 * spacing)
    laws = support._NORMAL_NOISE[dimension], support._SHAPE_NOISE[dimension]
    for law, measured in zip(laws, (variances(normals), variances(shapes)), strict=True):
        quotients = (measured / support._variance(ratios, law))[:6]  # 8 is a tenth of the sphere
        assert (quotients > 1 / 2).all()
        assert (quotients < 2).all()


def chosen(points: Array, radius: float) -> tuple[float, float, float]:
    found = find(points, radius)
    dimension = points.shape[1]
    n, extent = len(points), found.cells.extent
    ratios = ratios_of_supports(n, dimension, CELLS[dimension][0])
    samples = sample_ranks(n)
    fits = fit_supports(found.cells, found.points, dimension, samples, extent, ratios)
    supports = choose_supports(fits, extent, dimension)
    return supports.normal_radius, supports.curvature_radius, found.cells.extent


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("n", [1, 2, 3, 5, 20, 100])
def test_tiny_clouds_have_a_support(dimension: int, n: int) -> None:
    normal, curvature, extent = chosen(oracles.uniform_cloud(n, dimension), 0.5)
    assert np.isfinite([normal, curvature, extent]).all()
    assert 0 < extent <= normal <= curvature


@pytest.mark.parametrize("points", [oracles.lattice(40, 40), oracles.uniform_cloud(1500, 2)])
def test_planes_have_a_support(points: npt.NDArray[np.float64]) -> None:
    flat = np.c_[points, np.zeros(len(points))]
    estimate = estimate_curvature(flat)
    assert 3 <= estimate.normal_support <= estimate.curvature_support
    np.testing.assert_allclose(estimate.mean_curvature, 0, atol=1e-12)


def test_a_support_is_at_most_a_quarter_of_the_points() -> None:
    for n in (200, 1000, 5000):
        estimate = estimate_curvature(oracles.sphere_surface(n).noisy(0.7))
        assert estimate.curvature_support <= max(61, n / 4 + 1)


def test_the_supports_in_points_are_those_of_an_even_cloud() -> None:
    """The number of points within the radius, which is reported relative to the cells' own."""
    for count in (60, 200):
        surface = oracles.torus_surface(5000)
        estimate = estimate_curvature(surface.points, support=count)
        assert estimate.normal_support == pytest.approx(count)
        assert estimate.curvature_support == pytest.approx(count)
