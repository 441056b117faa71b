"""Corners by cutting, against Qhull and by counting."""

from __future__ import annotations

import numpy as np
import pytest

import oracles
import polyhedron_oracles as expect
from pcsmooth.autodiff.polytopes import Polytope, intersect_half_spaces
from pcsmooth.errors import InvalidInputError


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("seed", range(5))
def test_corners_are_those_of_qhull(dimension: int, seed: int) -> None:
    normals = oracles.random_sphere(15, dimension=dimension, seed=seed)
    normals = np.r_[normals, np.eye(dimension), -np.eye(dimension)]
    offsets = np.random.default_rng(seed).uniform(0.5, 1.5, len(normals))
    found = intersect_half_spaces(normals, offsets)
    expected = expect.intersect_half_spaces(normals, offsets)
    assert found is not None
    assert expected is not None
    assert len(found.corners) == len(expected.vertices)
    for corner in found.corners:
        assert np.linalg.norm(expected.vertices - corner, axis=1).min() < 1e-12
    for planes, corner in zip(found.planes, found.corners, strict=True):
        np.testing.assert_allclose(normals[list(planes)] @ corner, offsets[list(planes)])


@pytest.mark.parametrize(("shape", "corners"), [("cube", 8), ("icosahedron", 36), ("square", 4)])
def test_corners_where_many_planes_meet_are_several(shape: str, corners: int) -> None:
    """A corner of an icosahedron has 5 planes: as if moved a little, 3 corners and 2 edges."""
    body = expect.solid(shape)
    found = intersect_half_spaces(body.normals, body.offsets)
    assert found is not None
    assert len(found.corners) == corners
    dimension = body.normals.shape[1]
    assert len(found.edges) == dimension * corners // 2  # Euler: of simple polytopes


def test_half_spaces_without_a_common_inside() -> None:
    normals = np.array([[1, 0], [0, 1], [-1, 0], [0, -1.0]])
    assert intersect_half_spaces(normals, np.array([1, 1, -2, 1.0])) is None
    assert intersect_half_spaces(normals, np.array([-2, 1, 1, 1.0])) is None


def test_planes_that_touch_cut_nothing() -> None:
    body = expect.solid("cube")
    cube = intersect_half_spaces(body.normals, body.offsets)
    assert cube is not None
    diagonal = np.array([1, 1, 0]) / np.sqrt(2)
    assert cube.cut(6, diagonal, np.sqrt(2)) is cube


def test_a_spoiled_polytope_is_refused() -> None:
    spoiled = Polytope(((0, 1), (1, 2)), np.zeros((2, 2)))
    with pytest.raises(InvalidInputError, match="too degenerate for automatic differentiation"):
        _ = spoiled.edges
