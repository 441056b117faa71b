"""The naive union: Voronoi cells cut out of each body."""

from __future__ import annotations

import numpy as np
import pytest

import oracles
import polyhedron_oracles as expect
from energies.cases import measure_bodies
from oracles import assert_close
from pcsmooth import PolyhedronUnion

#: Generic vectors from one cube to the other, in radii.
ARMS = [(0.3, 0.5, -0.4), (1.1, -0.2, 0.7), (1.5, 1.4, 1.3), (0.01, 0.02, 0.9), (2.1, 0.4, 0.6)]


def measure(points: oracles.Array, radius: float, body: expect.Body) -> PolyhedronUnion:
    return measure_bodies(points, radius, body, "naive")


@pytest.mark.parametrize("kind", ["cloud", "cap"])
@pytest.mark.parametrize("shape", [*expect.SHAPES[2], *expect.SHAPES[3]])
def test_cells_agree_with_brute_force(shape: str, kind: str) -> None:
    scene = expect.scene(shape, kind, 10, seed=1)
    union = measure(scene.points, scene.radius, scene.body)
    volumes, areas = expect.naive_cells_of_scene(shape, kind, 10, seed=1)
    # Qhull's vertices are good to some 1e-14 of the cell's size
    assert_close(union.cell_volumes, volumes, 1e-11)
    assert_close(union.visible_areas, areas, 1e-11)
    assert union.volume == pytest.approx(volumes.sum(), rel=1e-11)
    assert union.area == pytest.approx(areas.sum(), rel=1e-11)


@pytest.mark.parametrize("shape", ["square", "cube"])
@pytest.mark.parametrize("arm", ARMS)
def test_two_cubes(shape: str, arm: tuple[float, ...]) -> None:
    body = expect.solid(shape)
    vector = np.array(arm)[: body.normals.shape[1]]
    union = measure(
        0.7 * np.array([np.ones_like(vector), np.ones_like(vector) + vector]), 0.7, body
    )
    volume, area = expect.naive_pair_of_cubes(0.7 * vector, 0.7)
    # the closed form divides by the components of the arm: 1e-15 / 1e-4
    assert_close(union.cell_volumes, volume, 1e-11)
    assert_close(union.visible_areas, area, 1e-11)


@pytest.mark.parametrize("t", [0.2, 1.0, 1.7])
def test_two_squares_along_the_diagonal(t: float) -> None:
    """Each loses the corner beyond x + y = t, a triangle with legs 2 - t."""
    union = measure(np.array([[0, 0], [t, t]]), 1.0, expect.solid("square"))
    assert union.volume == pytest.approx(8 - (2 - t) ** 2, rel=1e-14)
    assert union.area == pytest.approx(16 - 4 * (2 - t), rel=1e-14)
    # of the whole overlap (2 - t)² the pair loses each half once: volumes' slope is 2 (2 - t)
    assert_close(union.volume_gradient, (2 - t) * np.array([[-1, -1], [1, 1]]), 1e-13)
    assert_close(union.area_gradient, 2 * np.array([[-1, -1], [1, 1]]), 1e-13)


def test_naive_is_not_exact() -> None:
    """Figure 32 of the thesis: parts of one body in the cell of the other are lost."""
    points = np.array([[0.0, 0.0], [1.0, 0.5]])
    volume = measure(points, 1.0, expect.solid("square")).volume
    # the bisector x + y/2 = 0.625 cuts off a corner, from (0.125, 1) to (1, -0.75)
    lost = 0.875 * 1.75 / 2
    assert volume == pytest.approx(8 - 2 * lost, rel=1e-14)
    assert volume != pytest.approx(8 - 1.0 * 1.5, rel=1e-3)


def test_hidden_cell() -> None:
    """A point in the middle of near ones: its cell has no part of its body's boundary."""
    around = np.r_[np.eye(3), -np.eye(3)]
    union = measure(np.r_[np.zeros((1, 3)), around], 1.0, expect.solid("cube"))
    assert union.cell_volumes[0] == pytest.approx(1.0, rel=1e-14)
    assert union.visible_areas[0] == 0
    assert_close(union.volume_gradient[0], 0, 1e-14, 1.0)


@pytest.mark.parametrize("spacing", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("shape", ["square", "cube"])
def test_grid(shape: str, spacing: float) -> None:
    """On a grid the cells are boxes and the naive union is the exact one."""
    body = expect.solid(shape)
    dimension = body.normals.shape[1]
    points = spacing * oracles.lattice(*[4] * dimension)
    union = measure(points, 0.5, body)
    expected = expect.box_union(points, 0.5)
    assert union.volume == pytest.approx(expected.volume, rel=1e-13)
    if spacing < 1:  # at 1 facets of the bodies lie in the bisectors
        assert union.area == pytest.approx(expected.area, rel=1e-13)
    sides = np.where((points == 0) | (points == 3 * spacing), 0.5 + spacing / 2, spacing)
    assert_close(union.cell_volumes, sides.prod(axis=1), 1e-13)
