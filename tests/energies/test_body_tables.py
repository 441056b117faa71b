from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

import oracles
from oracles import assert_close
from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.bodies.generators import box, platonic, polygon, prism, sphere
from pcsmooth.energies.polyhedra.body_tables import BodyTables, body_tables
from polyhedron_structure import assert_consistent, assert_placed, facet_sums


def pyramid(sides: int) -> ConvexBody:
    base = np.c_[oracles.even_circle(sides), np.full(sides, -0.5)]
    return ConvexBody.from_vertices([*base, [0.1, 0.05, 1.2]])


def bipyramid(sides: int) -> ConvexBody:
    return ConvexBody.from_vertices(
        [*np.c_[oracles.even_circle(sides), np.zeros(sides)], [0, 0, 0.8], [0, 0, -0.6]]
    )


SOLIDS = {
    "tetrahedron": platonic(4),
    "cube": platonic(6),
    "octahedron": platonic(8),
    "dodecahedron": platonic(12),
    "icosahedron": platonic(20),
    "box": box([1, 2, 5]),
    "turned octahedron": platonic(8).rotated(oracles.random_rotation(3, np.random.default_rng(0))),
    "cuboctahedron": ConvexBody.from_vertices(
        [[a, b, 0] for a in (-1, 1) for b in (-1, 1)]
        + [[a, 0, b] for a in (-1, 1) for b in (-1, 1)]
        + [[0, a, b] for a in (-1, 1) for b in (-1, 1)]
    ),
    "pyramid of 12 sides": pyramid(12),
    "pyramid of 40 sides": pyramid(40),
    "bipyramid of 7 sides": bipyramid(7),
    "prism of 100 sides": prism(100, height=0.5),
    "sphere": sphere(75),
}

POLYGONS = {
    "triangle": polygon(3),
    "square": box([1, 1]),
    "hexagon": polygon(6),
    "lopsided": ConvexBody.from_vertices([[2, 0.1], [0.3, 1], [-1, 0.2], [-0.2, -1], [1, -0.5]]),
    "circle": polygon(64),
}

every_solid = pytest.mark.parametrize("name", SOLIDS)
every_polygon = pytest.mark.parametrize("name", POLYGONS)
every_radius = pytest.mark.parametrize("radius", [1.0, 0.3, 40.0])


def assert_right(tables: BodyTables) -> None:
    """The structure of the polyhedron, its place, and that of the facets' corners."""
    vertices, planes, across = tables.polyhedron
    size = float(np.abs(vertices).max())
    assert_consistent(planes, across)
    assert planes.max() + 1 == len(tables.offsets) == tables.normals.shape[1]
    assert_placed(vertices / size, planes, tables.normals, tables.offsets / size, 1e-12)
    assert {tuple(v) for v in vertices.T} == {tuple(v) for v in tables.corners}
    for number, facet in enumerate(tables.facets):
        corners = tables.corners[list(facet)]
        normal = tables.normals[:, number]
        assert_close(corners @ normal, tables.offsets[number], 1e-12, size)
        arms = np.roll(corners, -1, axis=0) - corners
        turns = np.cross(arms, np.roll(arms, -1, axis=0)) @ normal
        assert (turns > 0).all()  # counter-clockwise, and convex


@every_radius
@every_solid
def test_polyhedron_of_a_solid(name: str, radius: float) -> None:
    body = SOLIDS[name]
    tables = body_tables(body, radius)
    assert_right(tables)
    assert (tables.n_counted, tables.thickness) == (len(body.offsets), 1.0)
    volume, areas = facet_sums(*tables.polyhedron, tables.normals, tables.offsets)
    assert volume == pytest.approx(body.volume * radius**3, rel=1e-12)
    assert_close(areas, body.facet_areas * radius**2, 1e-12)
    distances = np.linalg.norm(tables.corners, axis=1)
    assert tables.reach == pytest.approx(distances.max(), rel=1e-15)


@pytest.mark.parametrize(
    ("name", "most"),
    [
        ("cube", 1),
        ("octahedron", 2),
        ("icosahedron", 3),
        ("pyramid of 12 sides", 10),
        ("bipyramid of 7 sides", 5),
    ],
)
def test_corner_of_m_facets_is_m_minus_two_vertices(name: str, most: int) -> None:
    tables = body_tables(SOLIDS[name], 1.0)
    vertices, planes, _ = tables.polyhedron
    places, counts = np.unique(vertices, axis=1, return_counts=True)
    assert counts.max() == most
    for place, count in zip(places.T, counts, strict=True):
        here = planes[:, (vertices == place[:, np.newaxis]).all(axis=0)]
        meeting = np.isclose(place @ tables.normals, tables.offsets, rtol=1e-9)
        assert count == meeting.sum() - 2
        assert set(here.ravel()) == set(np.flatnonzero(meeting))


@every_radius
@every_polygon
def test_polygon_is_a_prism_whose_ends_do_not_count(name: str, radius: float) -> None:
    body = POLYGONS[name]
    tables = body_tables(body, radius)
    assert_right(tables)
    n = len(body.offsets)
    assert (tables.n_counted, tables.thickness) == (n, 2 * radius)
    np.testing.assert_array_equal(tables.normals[:2, :n].T, body.normals)
    np.testing.assert_array_equal(tables.normals[:, n:].T, [[0, 0, 1], [0, 0, -1]])
    volume, areas = facet_sums(*tables.polyhedron, tables.normals, tables.offsets)
    assert volume == pytest.approx(body.volume * radius**2 * tables.thickness, rel=1e-12)
    assert_close(areas[:n], body.facet_areas * radius * tables.thickness, 1e-12)
    assert_close(areas[n:], body.volume * radius**2, 1e-12)
    # That of the polygon: the prism's corners are farther.
    assert tables.reach == pytest.approx(body.circumradius * radius, rel=1e-15)


@pytest.mark.parametrize("body", [*SOLIDS.values(), *POLYGONS.values()], ids=[*SOLIDS, *POLYGONS])
def test_tangents_are_of_half_the_angles(body: ConvexBody) -> None:
    tables = body_tables(body, 0.7)
    n = tables.n_counted
    sines = np.linalg.norm(body.normals[:, np.newaxis] - body.normals, axis=2) / 2
    cosines = np.linalg.norm(body.normals[:, np.newaxis] + body.normals, axis=2) / 2
    expected = np.tan(np.arctan2(sines, cosines))
    expected[cosines < 1e-12] = 0.0
    np.testing.assert_allclose(tables.tangents[:n, :n], expected, rtol=1e-12)
    assert (tables.tangents[n:] == 0).all()
    assert (tables.tangents[:, n:] == 0).all()
    np.testing.assert_array_equal(tables.tangents, tables.tangents.T)
    assert (np.diag(tables.tangents) == 0).all()


@pytest.mark.parametrize(
    ("body", "tangents"),
    [
        (platonic(6), [0, 1]),
        (platonic(8), [0, sqrt(0.5), sqrt(2)]),
        (polygon(6), [0, 1 / sqrt(3), sqrt(3)]),
        (polygon(3), [0, sqrt(3)]),
    ],
    ids=repr,
)
def test_tangents_in_closed_form(body: ConvexBody, tangents: list[float]) -> None:
    """Those of opposite facets, which have no edge, are 0."""
    assert_close(np.unique(body_tables(body, 1.0).tangents.round(12)), tangents, 1e-12)
