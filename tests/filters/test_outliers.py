from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import oracles
from filters.whole import filter_whole, plan_of
from oracles import Array


def found(points: Array, noise: float | None = None) -> npt.NDArray[np.bool_]:
    plan = plan_of(points, noise)
    assert plan is not None
    assert plan.moves_points  # else none are looked for
    return filter_whole(points, plan).outliers


@pytest.mark.parametrize("clump", [1, 2, 4])
@pytest.mark.parametrize("noise", [0.1, 1.4])
def test_points_far_from_the_surface_are_found_and_no_others(noise: float, clump: int) -> None:
    surface = oracles.torus_surface(10_000)
    spacing = surface.spacing
    rng = np.random.default_rng(4)
    centers = rng.uniform([-1.4, -1.4, -0.4], [1.4, 1.4, 0.4], (100 // clump, 1, 3))
    scatter = spacing * (clump > 1) * rng.normal(size=(100 // clump, clump, 3))
    strays = (centers + scatter).reshape(-1, 3)
    marked = found(np.r_[surface.noisy(noise), strays])
    distances = np.abs(oracles.distance_to_torus(strays))
    assert not marked[:10_000].any()
    assert marked[10_000:][distances > max(6 * noise, 3.5) * spacing].mean() > 0.95
    assert marked[10_000:][distances > 8 * spacing].all()
    assert not marked[10_000:][distances < noise * spacing].any()


@pytest.mark.parametrize("dimension", [2, 3])
def test_borders_and_corners_are_no_outliers(dimension: int) -> None:
    n = 5000
    rng = np.random.default_rng(0)
    sheet = np.zeros((n, dimension))
    sheet[:, :-1] = rng.random((n, dimension - 1))
    spacing = n ** (-1 / (dimension - 1))
    sheet[:, -1] = 0.5 * spacing * rng.normal(size=n)
    assert not found(sheet).any()
    cube = np.ceil(3 * rng.random(n)).astype(int) - 1
    box = rng.random((n, 3))
    box[np.arange(n), cube] = np.round(box[np.arange(n), cube])
    box += 0.3 * np.sqrt(6 / n) * rng.normal(size=(n, 3))
    assert not found(box).any()


def strays_in(points: Array, share: float, rng: np.random.Generator) -> Array:
    """Random points in a box somewhat larger than that of others."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.2 * (high - low).max()
    return rng.uniform(low - margin, high + margin, (int(share * len(points)), points.shape[1]))


@pytest.mark.parametrize("share", [0.01, 0.03, 0.1, 0.3])
def test_crowds_of_outliers_are_found(share: float) -> None:
    """In space the others are so near the surface that they cannot be told from it."""
    rng = np.random.default_rng(8)
    surface = oracles.torus_surface(8000)
    strays = strays_in(surface.noisy(0.3), share, rng)
    marked = found(np.r_[surface.noisy(0.3), strays])
    is_far = np.abs(oracles.distance_to_torus(strays)) > 2.5 * surface.spacing
    assert not marked[:8000].any()
    assert marked[8000:][is_far].mean() > 0.9


@pytest.mark.parametrize("share", [0.01, 0.03, 0.1, 0.3])
def test_crowds_of_outliers_around_a_curve_are_found(share: float) -> None:
    rng = np.random.default_rng(9)
    circle = oracles.random_sphere(2000, dimension=2)
    spacing = 2 * np.pi / 2000
    noisy = circle * (1 + 0.3 * spacing * rng.normal(size=(2000, 1)))
    strays = strays_in(noisy, share, rng)
    marked = found(np.r_[noisy, strays])
    is_far = np.abs(np.linalg.norm(strays, axis=1) - 1) > 10 * spacing
    assert not marked[:2000].any()
    assert marked[2000:][is_far].mean() > 0.95


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("size", [5, 10, 20])
def test_clumps_are_found(size: int, dimension: int) -> None:
    rng = np.random.default_rng(10)
    n = 5000 if dimension == 3 else 1500
    sphere = oracles.random_sphere(n, dimension=dimension)
    spacing = (oracles.sphere_area(1, dimension) / n) ** (1 / (dimension - 1))
    sphere *= 1 + 0.3 * spacing * rng.normal(size=(n, 1))
    clump = spacing * rng.normal(size=(size, dimension))  # 14 spacings from all others, and more
    marked = found(np.r_[sphere, clump])
    assert not marked[:n].any()
    assert marked[n:].all()


def test_sparse_walls_and_cables_over_dense_ground_are_none() -> None:
    """A wall that is seen from above and a cable are ten times sparser: next to none is marked."""
    rng = np.random.default_rng(11)
    n = 8000
    ground = np.c_[rng.random((n, 2)) * np.sqrt(n), 0.1 * rng.normal(size=n)]
    wall = np.zeros((120, 3))
    wall[:, 1:] = rng.random((120, 2)) * [60, 20]
    cable = np.zeros((60, 3))
    cable[:, 0], cable[:, 1:] = np.linspace(0, 89, 60), [45, 15]
    cable += 0.05 * rng.normal(size=cable.shape)
    far = [[30.0, 60.0, 40.0]]
    marked = found(np.r_[ground, wall, cable, far])
    assert not marked[:n].any()
    assert marked[n:-1].mean() < 0.1
    assert marked[-1]


def test_a_single_far_point_is_found_wherever_it_is() -> None:
    sphere = oracles.sphere_surface(1000).noisy(0.3)
    for far in (3.0, 1e9, 1e100):
        marked = found(np.r_[sphere, [[far, 0.0, 0.0]]])
        np.testing.assert_array_equal(np.flatnonzero(marked), [1000])


def test_the_sparse_part_of_a_cloud_is_no_crowd_of_outliers() -> None:
    n = 10_000
    rng = np.random.default_rng(0)
    for share_of_area in (1e-2, 1e-4):
        square = rng.random((n, 2))
        square[n // 2 :] *= np.sqrt(share_of_area)
        assert found(np.c_[square, np.zeros(n)], noise=1e-5).mean() < 0.001
