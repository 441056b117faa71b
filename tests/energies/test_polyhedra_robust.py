"""Input that is wrong, and clouds in ties or all at one place."""

from __future__ import annotations

from itertools import permutations
from math import sqrt
from typing import Any

import numpy as np
import pytest

import oracles
import polyhedron_oracles as expect
from oracles import Array
from pcsmooth import ConvexBody, measure_polyhedra
from pcsmooth.bodies.generators import platonic, polygon, sphere
from pcsmooth.energies.polyhedra import alpha_complex
from pcsmooth.energies.polyhedra.alpha_complex import find_simplices
from pcsmooth.errors import InvalidInputError, PcsmoothError
from pcsmooth.kernels.polyhedra import polyhedron_intersections
from polyhedron_oracles import RULES, Rule

SQUARE = ConvexBody([[1, 0], [0, 1], [-1, 0], [0, -1]])
CUBE = platonic(6)

every_rule = pytest.mark.parametrize("rule", RULES)


# --- wrong input


@every_rule
def test_points_of_another_dimension_than_the_body(rule: Rule) -> None:
    with pytest.raises(InvalidInputError, match="the points have 3 coordinates and the body 2"):
        measure_polyhedra([[0, 0, 0]], 1.0, SQUARE, union=rule)
    with pytest.raises(InvalidInputError, match="the points have 2 coordinates and the body 3"):
        measure_polyhedra([[0, 0], [1, 1]], 1.0, CUBE, union=rule)


@pytest.mark.parametrize("union", ["Exact", "", "balls", None])
def test_wrong_union(union: Any) -> None:
    with pytest.raises(InvalidInputError, match="it must be naive, inclusion-exclusion or exact"):
        measure_polyhedra([[0, 0, 0]], 1.0, CUBE, union=union)


def test_torn_stars_are_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    list_simplices = polyhedron_intersections.list_simplices

    def list_torn(*arguments: Any) -> tuple[Array, int]:
        return list_simplices(*arguments)[0], 2

    monkeypatch.setattr(alpha_complex, "list_simplices", list_torn)
    with pytest.raises(PcsmoothError, match="triangulation is not clear at 2 points"):
        measure_polyhedra(oracles.lattice(2, 2, 2), 1.0, CUBE, union="inclusion-exclusion")


# --- ties


@pytest.mark.parametrize("order", list(permutations(range(3))))
@pytest.mark.parametrize("dimension", [2, 3])
def test_right_triangle_whose_circle_is_as_large_as_the_radius(
    order: tuple[int, ...], dimension: int
) -> None:
    """Its longest edge is 2 r long: whichever point comes first, all of it is in."""
    points = np.zeros((3, dimension))
    points[:, :2] = [[0, 0], [2, 0], [1, 1]]
    edges, triangles, _ = find_simplices(points[list(order)], 1.0)
    assert (len(edges), len(triangles)) == (3, 1)


def test_edge_as_long_as_two_radii() -> None:
    assert len(find_simplices([[0, 0], [2, 0]], 1.0)[0]) == 1


@pytest.mark.parametrize("radius", [sqrt(0.5), sqrt(0.75), 1.0])
@pytest.mark.parametrize("counts", [(2, 2, 2), (4, 4, 4), (5, 5)])
def test_order_of_a_grid_does_not_matter(counts: tuple[int, ...], radius: float) -> None:
    points = oracles.lattice(*counts)
    body = platonic(8) if len(counts) == 3 else polygon(6)
    expected = measure_polyhedra(points, radius, body, union="inclusion-exclusion")
    for seed in range(3):
        order = np.random.default_rng(seed).permutation(len(points))
        union = measure_polyhedra(points[order], radius, body, union="inclusion-exclusion")
        assert union.volume == pytest.approx(expected.volume, rel=1e-12)
        assert union.area == pytest.approx(expected.area, rel=1e-12)


def test_order_of_points_with_edges_of_two_radii_does_not_matter() -> None:
    points = np.array([[0, 1, 1], [2, 0, 0], [2, 2, 2], [1, 2, 2], [0, 2, 1]], float)
    volumes = [
        measure_polyhedra(points[list(order)], 1.5, CUBE, union="inclusion-exclusion").volume
        for order in permutations(range(5))
    ]
    np.testing.assert_allclose(volumes, volumes[0], rtol=1e-13)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("radius", [0.3, 0.5, sqrt(0.5), 0.75, sqrt(0.75), 1.0, 1.5])
@pytest.mark.parametrize("counts", [(7, 7), (4, 4, 4), (3, 1, 5)])
def test_turned_grid_has_the_exact_measures(
    counts: tuple[int, ...], radius: float, seed: int
) -> None:
    points = oracles.lattice(*counts)
    turn = oracles.random_rotation(len(counts), np.random.default_rng(seed))
    body = SQUARE if len(counts) == 2 else CUBE
    union = measure_polyhedra(points @ turn.T, radius, body.rotated(turn))
    expected = expect.box_union(points, radius)
    assert union.volume == pytest.approx(expected.volume, rel=1e-10)
    assert union.area == pytest.approx(expected.area, rel=1e-10)


# --- clusters


@every_rule
@pytest.mark.parametrize(
    ("size", "origin"), [(1e-3, 0.37), (1e-6, 0.0), (1e-9, 0.37), (1e-12, 0.37), (1e-12, 0.0)]
)
@pytest.mark.parametrize("body", [SQUARE, polygon(6), CUBE, sphere(50)], ids=repr)
def test_cluster_of_a_size_is_one_body_up_to_that_size(
    body: ConvexBody, origin: float, size: float, rule: Rule
) -> None:
    points = origin + size * np.random.default_rng(0).random((50, body.dimension))
    union = measure_polyhedra(points, 1.0, body, union=rule)
    assert np.isfinite(union.rows).all()
    assert union.volume == pytest.approx(body.volume, rel=3 * size + 1e-11)
    assert union.area == pytest.approx(body.facet_areas.sum(), rel=3 * size + 1e-11)


@pytest.mark.parametrize("gap", [1e-6, 1e-8, 1e-10, 1e-12])
@pytest.mark.parametrize("counts", [(6, 1), (4, 4), (6, 1, 1), (3, 3, 3)])
def test_complex_of_a_cluster_has_no_holes(counts: tuple[int, ...], gap: float) -> None:
    points = gap * oracles.lattice(*counts)
    edges, triangles, tetrahedra = find_simplices(points, 1.0)
    vertices = np.unique(edges)  # points that ties leave without a cell are in no simplex
    assert len(vertices) - len(edges) + len(triangles) - len(tetrahedra) == 1


@pytest.mark.parametrize("factor", [1e-65, 1e65])
def test_complex_of_a_grid_of_any_size(factor: float) -> None:
    grid = oracles.lattice(4, 4, 4)
    found = find_simplices(factor * grid, 0.9 * factor)
    assert len(grid) - len(found[0]) + len(found[1]) - len(found[2]) == 1
