from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

import oracles
from oracles import Array
from pcsmooth.orientation import orient_normals

TORUS, TORUS_NORMALS = oracles.random_torus(3000)
SPHERE = oracles.random_sphere(1500)
CIRCLE = oracles.random_sphere(300, dimension=2)

CLOSED = {
    "sphere": (SPHERE, SPHERE),
    "torus": (TORUS, TORUS_NORMALS),
    "two spheres": (
        np.r_[SPHERE + 5, 0.5 * SPHERE - 5],
        np.r_[SPHERE, SPHERE],
    ),
    "circle": (3 * CIRCLE + 7, CIRCLE),
}


def with_random_signs(normals: Array, seed: int) -> Array:
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], len(normals))
    return signs[:, np.newaxis] * normals


def oriented_normals(points: Array, normals: Array, areas: Array) -> Array:
    neighbors = cKDTree(points).query(points, 9)[1].astype(np.int32)
    oriented = normals.copy()
    orient_normals(points, oriented, areas, neighbors)
    return oriented


def random_areas(n: int) -> Array:
    return np.random.default_rng(9).uniform(0.5, 1.5, n)


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("shape", CLOSED)
def test_closed_shapes_look_outward_everywhere(shape: str, seed: int) -> None:
    points, outward = CLOSED[shape]
    oriented = oriented_normals(points, with_random_signs(outward, seed), random_areas(len(points)))
    np.testing.assert_array_equal(oriented, outward)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("relief", [0.02, 0.1, -0.1])
def test_open_sheets_look_along_the_positive_axis(axis: int, seed: int, relief: float) -> None:
    x, y = oracles.uniform_cloud(2000, 2).T
    slope_x, slope_y = 6 * relief * np.cos(6 * x), -6 * relief * np.sin(6 * y)
    points = np.c_[relief * (np.sin(6 * x) + np.cos(6 * y)), x, y]
    normals = np.c_[np.ones(2000), -slope_x, -slope_y]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points, normals = np.roll(points, axis, axis=1), np.roll(normals, axis, axis=1)
    oriented = oriented_normals(points, with_random_signs(normals, seed), np.ones(2000))
    np.testing.assert_array_equal(oriented, normals)


def test_missing_normals_stay_missing() -> None:
    normals = with_random_signs(SPHERE, 2)
    normals[::50] = 0
    oriented = oriented_normals(SPHERE, normals, np.ones(len(SPHERE)))
    known = normals.any(axis=1)
    np.testing.assert_array_equal(oriented[known], SPHERE[known])
    assert not oriented[~known].any()


def test_one_point_looks_along_the_positive_axis() -> None:
    oriented = oriented_normals(np.ones((1, 3)), np.array([[0.6, -0.8, 0.0]]), np.ones(1))
    np.testing.assert_array_equal(oriented, [[-0.6, 0.8, 0.0]])
