from __future__ import annotations

import numpy as np
import pytest

import oracles
import polyhedron_oracles as expect
from kernels.alone import all_alone
from oracles import Array
from pcsmooth import measure_polyhedra
from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.bodies.generators import platonic, polygon, prism, sphere
from pcsmooth.kernels.polyhedra import visible_facets

kernel = all_alone(visible_facets)

SQUARE = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)
OCTAGON = oracles.even_circle(8)


def as_piece(corners: Array) -> Array:
    """Rows of a piece; the edge from corner v on is part of facet 100 + v."""
    return np.vstack([corners.T, 100.0 + np.arange(len(corners))])


def area_of(piece: Array) -> float:
    x, y = piece[:2]
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def edges_of(piece: Array) -> list[tuple[float, tuple[float, float], tuple[float, float]]]:
    """What each edge is part of, and its ends; those without length do not count."""
    ends = [(float(x), float(y)) for x, y in piece[:2].T]
    following = ends[1:] + ends[:1]
    return [
        (float(code), a, b)
        for code, a, b in zip(piece[2], ends, following, strict=True)
        if np.hypot(a[0] - b[0], a[1] - b[1]) > 1e-13
    ]


def assert_convex(piece: Array) -> None:
    arms = np.roll(piece[:2], -1, axis=1) - piece[:2]
    following = np.roll(arms, -1, axis=1)
    assert (arms[0] * following[1] - arms[1] * following[0]).min() > -1e-14


# --- pieces with many vertices


@pytest.mark.parametrize("room", [1, 3, 64])
@pytest.mark.parametrize("n", [3, 31, 32, 33, 34, 62, 63, 64, 100, 257])
def test_many_corners_are_pushed_as_several_pieces(n: int, room: int) -> None:
    most = kernel._MOST_VERTICES
    polygon = as_piece(oracles.even_circle(n))
    pieces, counts = np.full((room, 3, most), np.nan), np.zeros(room, np.int64)
    pieces[0, :, :3] = polygon[:, :3]
    counts[0] = 3
    n_pieces = kernel._push(polygon, n, pieces, counts, 1)
    n_parts = -(-(n - 2) // (most - 2))
    if 1 + n_parts > room:
        assert n_pieces == kernel._FULL
        return
    np.testing.assert_array_equal(pieces[0, :, :3], polygon[:, :3])  # what was there stays
    parts = [pieces[p, :, : counts[p]] for p in range(1, n_pieces)]
    assert all(3 <= part.shape[1] <= most for part in parts)
    assert len(parts) == n_parts
    assert sum(map(area_of, parts)) == pytest.approx(area_of(polygon), rel=1e-14)
    for part in parts:
        assert_convex(part)
    edges = [edge for part in parts for edge in edges_of(part)]
    own = sorted(edge for edge in edges if edge[0] >= 0)
    assert own == sorted(edges_of(polygon))
    inner = [edge for edge in edges if edge[0] < 0]
    assert {code for code, _, _ in inner} <= {kernel._INSIDE}
    assert len(inner) == 2 * (len(parts) - 1)  # each from both sides
    assert {(a, b) for _, a, b in inner} == {(b, a) for _, a, b in inner}


# --- a line through a piece


def split(corners: Array, normal: tuple[float, float], end: float) -> tuple[Array, Array]:
    n = len(corners)
    inside, spare, outside = (np.full((3, n + 4), np.nan) for _ in range(3))
    inside[:, :n] = as_piece(corners)
    length = np.hypot(*normal)
    n_inside, n_outside = kernel._split(
        inside, n, normal[0] / length, normal[1] / length, end / length, 1e-14, 7.0, spare, outside
    )
    if n_inside == 0:
        np.testing.assert_array_equal(inside[:, :n], as_piece(corners))
        return inside[:, :0], inside[:, :n]
    return inside[:, :n_inside], outside[:, :n_outside]


@pytest.mark.parametrize(
    ("normal", "end", "area"),
    [
        ((1, 0), 0.5, 3.0),
        ((1, 0), -0.75, 0.5),
        ((0, -1), 0.0, 2.0),
        ((1, 1), 0.0, 2.0),  # through two vertices
        ((-1, 1), 0.0, 2.0),
        ((2, 1), 1.0, 3.0),  # through one
        ((1, 2), -3 + 1e-9, 2.5e-19),  # next to one
        ((1, 1), 2.0, 4.0),  # through one, and all is inside
        ((1, 1), -2.0, 0.0),  # and all is beyond
        ((1, 0), 1.0, 4.0),  # along an edge
        ((0, 1), -1.0, 0.0),
        ((1, 0), 1.0 - 5e-15, 4.0),  # as good as along it
        ((0, 1), -1.0 + 5e-15, 0.0),
        ((1, 0), 1.5, 4.0),  # not at all
        ((-1, -1), -2.5, 0.0),
    ],
)
def test_line_splits_a_square(normal: tuple[float, float], end: float, area: float) -> None:
    inside, outside = split(SQUARE, normal, end)
    assert area_of(inside) == pytest.approx(area, rel=1e-6)
    assert area_of(inside) + area_of(outside) == pytest.approx(4.0, rel=1e-14)
    assert (inside.shape[1] == 0) == (area == 0)
    assert (outside.shape[1] == 0) == (area == 4)


@pytest.mark.parametrize("seed", range(30))
def test_parts_of_a_polygon(seed: int) -> None:
    """They have the polygon's edges, in two where the line crosses them, and one more each."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, 2 * np.pi)
    normal, end = (np.cos(angle), np.sin(angle)), rng.uniform(-0.9, 0.9)
    through_corners = seed % 3
    if through_corners:
        a, b = OCTAGON[rng.permutation(8)[:2]]
        normal = (b[1] - a[1], a[0] - b[0])
        end = float(np.dot(normal, a if through_corners == 1 else (a + OCTAGON[0]) / 2))
    inside, outside = split(OCTAGON, normal, end)
    parts = [part for part in (inside, outside) if part.shape[1]]
    assert sum(map(area_of, parts)) == pytest.approx(area_of(as_piece(OCTAGON)), rel=1e-14)
    levels = np.dot(normal, inside[:2]), np.dot(normal, outside[:2])
    assert levels[0].max(initial=-np.inf) < end + 1e-14
    assert len(parts) == 1 or levels[1].min() > end - 1e-14
    lengths = np.zeros(8)
    for part in parts:
        assert_convex(part)
        for code, a, b in edges_of(part):
            if code >= 100:
                lengths[int(code) - 100] += np.hypot(a[0] - b[0], a[1] - b[1])
    np.testing.assert_allclose(lengths, 2 * np.sin(np.pi / 8), rtol=1e-13)
    if len(parts) == 2:
        new = [edge for edge in edges_of(outside) if edge[0] == 7.0]
        back = [edge for edge in edges_of(inside) if edge[0] == kernel._INSIDE]
        assert len(new) == len(back) == 1
        assert new[0][1:] == back[0][:0:-1]


# --- bodies with many facets, or with large ones


def union_of_two(points: Array, body: ConvexBody) -> tuple[float, float]:
    """Volume and area by Qhull, of two bodies without facets in one plane."""
    heights = (points @ body.normals.T).min(axis=0)
    common = expect.intersect_half_spaces(body.normals, body.offsets + heights)
    assert common is not None
    area = 2 * body.facet_areas.sum() - common.facet_areas.sum()
    return 2 * body.volume - common.volume, float(area)


LARGE = [sphere(200), prism(100), prism(64, height=0.3), polygon(64), polygon(400), sphere(9)]
every_large_body = pytest.mark.parametrize("body", LARGE, ids=repr)


@every_large_body
def test_one_large_body(body: ConvexBody) -> None:
    union = measure_polyhedra(np.full((1, body.dimension), 0.3), 2.0, body)
    size = 2.0**body.dimension
    assert union.volume == pytest.approx(size * body.volume, rel=1e-13)
    assert union.area == pytest.approx(size / 2 * body.facet_areas.sum(), rel=1e-13)
    oracles.assert_close(union.volume_gradient, 0, 1e-13, union.area)
    oracles.assert_close(union.area_gradient, 0, 1e-12, union.area)


@every_large_body
@pytest.mark.parametrize("arm", [(0.013, 0.008, 0.011), (0.7, 0.2, 0.1), (-0.3, 0.41, -0.13)])
def test_two_large_bodies(body: ConvexBody, arm: tuple[float, ...]) -> None:
    points = np.array([np.zeros(body.dimension), arm[: body.dimension]])
    union = measure_polyhedra(points, 1.0, body)
    volume, area = union_of_two(points, body)
    assert union.volume == pytest.approx(volume, rel=1e-12)
    assert union.area == pytest.approx(area, rel=1e-11)
    oracles.assert_close(union.volume_gradient.sum(axis=0), 0, 1e-11, union.area)


@pytest.mark.parametrize("sides", [3, 5, 33, 100])
def test_prisms_side_by_side_are_a_union_of_polygons_extruded(sides: int) -> None:
    """Their ends, of so many corners, are in common planes, and parts of them coincide."""
    points = np.array([[0, 0], [0.9, 0.2], [0.4, 0.83], [-0.35, 0.1], [0.2, -2.3], [2.7, 2.1]])
    flat = expect.polygon_union(points, 1.0, polygon(sides))
    union = measure_polyhedra(np.c_[points, np.full(6, 0.4)], 1.0, prism(sides, height=1.5))
    assert union.volume == pytest.approx(1.5 * flat.volume, rel=1e-12)
    assert union.area == pytest.approx(1.5 * flat.area + 2 * flat.volume, rel=1e-12)
    oracles.assert_close(union.volume_gradient[:, :2], 1.5 * flat.volume_gradient, 1e-11)
    oracles.assert_close(union.volume_gradient[:, 2], 0, 1e-11, union.area)


@pytest.mark.parametrize("height", [0.25, 1.0, 1.75])
def test_prisms_one_above_the_other(height: float) -> None:
    body = prism(100)
    union = measure_polyhedra(np.array([[0, 0, 0], [0, 0, height]]), 1.0, body)
    end = float(body.facet_areas[-1])
    assert union.volume == pytest.approx(end * (2 + height), rel=1e-13)
    sides = float(body.facet_areas[:-2].sum())
    assert union.area == pytest.approx(2 * end + sides * (2 + height) / 2, rel=1e-13)
    oracles.assert_close(union.volume_gradient, [[0, 0, -end], [0, 0, end]], 1e-12)


@pytest.mark.parametrize("depth", [0.01, 0.5, 1.1])
@pytest.mark.parametrize("sides", [4, 100])
def test_hole_in_a_facet(sides: int, depth: float) -> None:
    """A pyramid lower down pierces the base; what both share is a smaller pyramid."""
    base = np.c_[oracles.even_circle(sides), np.full(sides, -0.4)]
    body = ConvexBody.from_vertices([*base, [0, 0, 0.8]])
    points = np.array([[0, 0, 0], [0.1 * depth, -0.05 * depth, -depth]])
    union = measure_polyhedra(points, 1.0, body)
    share = 1 - depth / 1.2
    assert union.volume == pytest.approx(body.volume * (2 - share**3), rel=1e-13)
    bottom = int(np.argmin(body.normals[:, 2]))
    parts = body.facet_areas * np.where(np.arange(sides + 1) == bottom, 1 - share**2, 1.0)
    lower = body.facet_areas.sum() - share**2 * np.delete(body.facet_areas, bottom).sum()
    oracles.assert_close(union.visible_areas, [parts.sum(), lower], 1e-13)
    oracles.assert_close(union.volume_gradient[0], parts @ body.normals, 1e-12)


def test_many_large_bodies_at_one_place() -> None:
    """All pieces of most facets are covered, some of them by many bodies."""
    body = platonic(20)
    points = 0.2 * oracles.random_sphere(7, seed=2)
    union = measure_polyhedra(points, 1.0, body)
    expect.assert_union(union, expect.sum_over_simplices(points, 1.0, body), 1e-10)
