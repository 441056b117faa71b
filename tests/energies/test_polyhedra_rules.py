"""What ties the three unions to each other and to what is known of rows and flat clouds."""

from __future__ import annotations

import numpy as np
import pytest

import oracles
import polyhedron_oracles as expect
from energies.cases import POLYHEDRA, Case, measure_bodies
from oracles import assert_close
from polyhedron_oracles import RULES, Rule

every_rule = pytest.mark.parametrize("rule", RULES)


def cases(*shapes: str) -> list[Case]:
    return [case for case in POLYHEDRA if case.shape in shapes]


@pytest.mark.parametrize("case", POLYHEDRA, ids=str)
def test_cell_volumes_are_those_of_the_naive_union(case: Case) -> None:
    naive = measure_bodies(case.points, case.radius, expect.solid(case.shape), "naive")
    assert_close(case.measure().cell_volumes, naive.cell_volumes, 1e-12)


@pytest.mark.parametrize("case", cases("hexagon", "icosahedron"), ids=str)
def test_size_of_the_body_is_that_of_the_radius_but_for_the_complex(case: Case) -> None:
    points, radius, body = case.points, case.radius, expect.solid(case.shape)
    larger = expect.Solid(body.normals, 2 * body.offsets)
    union = measure_bodies(points, radius / 2, larger, case.rule)
    if case.rule == "inclusion-exclusion":
        simplices = expect.alpha_complex(points, radius / 2)
        expected = expect.sum_over_simplices(points, radius, body, simplices)
        expect.assert_union(union, expected, 1e-11)
    else:
        assert union.volume == pytest.approx(case.measure().volume, rel=1e-12)
        assert union.area == pytest.approx(case.measure().area, rel=1e-12)
        for name in oracles.MEASURES:
            assert_close(getattr(union, name), getattr(case.measure(), name), 1e-12)


@pytest.mark.parametrize("case", cases("lopsided polygon", "lopsided polyhedron"), ids=str)
def test_order_of_facets_does_not_matter(case: Case) -> None:
    body = expect.solid(case.shape)
    order = np.random.default_rng(5).permutation(len(body.offsets))
    shuffled = expect.Solid(body.normals[order], body.offsets[order])
    union = measure_bodies(case.points, case.radius, shuffled, case.rule)
    oracles.assert_same_measures(union, case.measure(), 1e-12)


# --- flat clouds


@every_rule
@pytest.mark.parametrize("seed", range(3))
def test_cubes_in_a_plane_are_prisms_over_squares(seed: int, rule: Rule) -> None:
    """Heights, sides and the two ends: each body's measures follow from those in the plane."""
    scene = expect.scene("square", "cloud", 20, seed)
    flat = measure_bodies(scene.points, scene.radius, scene.body, rule)
    for axis in range(3):
        points = np.insert(scene.points, axis, 0.3, axis=1)
        union = measure_bodies(points, scene.radius, expect.solid("cube"), rule)
        assert_close(union.cell_volumes, 2 * scene.radius * flat.cell_volumes, 1e-12)
        assert union.volume == pytest.approx(2 * scene.radius * flat.volume, rel=1e-12)
        area = 2 * flat.volume + 2 * scene.radius * flat.area
        assert union.area == pytest.approx(area, rel=1e-12)
        assert union.visible_areas.sum() == pytest.approx(area, rel=1e-12)
        along = np.delete(union.volume_gradient, axis, axis=1)
        assert_close(along, 2 * scene.radius * flat.volume_gradient, 1e-12)
        across = union.volume_gradient[:, axis]
        assert_close(across.sum(), 0, 1e-12, scene.radius**2)
        # the ends belong to one body each: not more than its own end, 4 r², on either side
        assert abs(across).max() <= 4 * scene.radius**2 * (1 + 1e-12)


@every_rule
@pytest.mark.parametrize("shape", ["square", "cube"])
def test_row_of_cubes(shape: str, rule: Rule) -> None:
    body, dimension = expect.solid(shape), {"square": 2, "cube": 3}[shape]
    places = np.array([0.0, 0.3, 0.9, 1.3, 3.6, 4.5, 7.0])  # gaps of 2.3 and 2.5
    points = np.zeros((len(places), dimension))
    points[:, -1] = places
    union = measure_bodies(points, 1.0, body, rule)
    length = (1.3 + 2) + (0.9 + 2) + 2
    face = 2.0 ** (dimension - 1)
    rim = {2: 2.0, 3: 8.0}[dimension]
    assert union.volume == pytest.approx(face * length, rel=1e-13)
    assert union.area == pytest.approx(rim * length + 3 * 2 * face, rel=1e-13)
    lengths = [1.15, 0.45, 0.5, 1.2, 1.45, 1.45, 2]
    assert_close(union.cell_volumes, face * np.array(lengths), 1e-13)
    ends = face * np.array([-1, 0, 0, 1, -1, 1, 0])
    assert_close(union.volume_gradient[:, -1], ends, 1e-12)


@every_rule
@pytest.mark.parametrize(("shape", "face", "rim"), [("square", 2.0, 2.0), ("cube", 4.0, 8.0)])
def test_stiffness_of_two_near_cubes(shape: str, face: float, rim: float, rule: Rule) -> None:
    """Facet and rim between their cells, over the distance; K is square to the facet."""
    body = expect.solid(shape)
    points = np.zeros((2, body.normals.shape[1]))
    points[1, -1] = 0.1
    union = measure_bodies(points, 1.0, body, rule)
    assert_close(union.volume_diagonal, np.full(2, face / 0.1), 1e-13)
    assert_close(union.area_diagonal, np.full(2, rim / 0.1), 1e-13)


@every_rule
@pytest.mark.parametrize("shape", ["hexagon", "lopsided polygon", "icosahedron", "sphere"])
def test_row_of_bodies(shape: str, rule: Rule) -> None:
    """On a line the unions differ, but for inclusion-exclusion of neighbours alone."""
    body = expect.solid(shape)
    direction = np.array([0.31, 0.83, -0.47])[: body.normals.shape[1]]
    direction /= np.linalg.norm(direction)
    points = np.outer([0.0, 0.35, 0.8, 1.2, 1.9], direction)
    union = measure_bodies(points, 1.0, body, rule)
    if rule == "naive":
        volumes, areas = expect.naive_cells(points, 1.0, body)
        assert_close(union.cell_volumes, volumes, 1e-11)
        assert_close(union.visible_areas, areas, 1e-11)
        return
    pairs = [(i, i + 1) for i in range(4)]
    simplices = None if rule == "exact" else [*((i,) for i in range(5)), *pairs]
    expected = expect.sum_over_simplices(points, 1.0, body, simplices)
    expect.assert_union(union, expected, 1e-11)
