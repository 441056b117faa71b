"""Convex bodies against closed forms, Qhull and what must hold for all of them."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from dataclasses import FrozenInstanceError
from itertools import product

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial import ConvexHull, HalfspaceIntersection
from scipy.spatial.transform import Rotation

from pcsmooth import ConvexBody, InvalidInputError

Array = npt.NDArray[np.float64]

GOLDEN = 0.5 * (1 + math.sqrt(5))
CUBE = np.array(list(product((-1.0, 1.0), repeat=3)))
SQUARE = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
AXES = np.vstack([np.eye(3), -np.eye(3)])


def cyclic(*points: tuple[float, float, float]) -> Array:
    return np.array([np.roll(point, shift) for point in points for shift in range(3)])


def signed(x: float, y: float, z: float) -> list[tuple[float, float, float]]:
    return [(x, a * y, b * z) for a, b in product((-1, 1), repeat=2)]


#: Corners, volume, edge count of a facet; with edges 2, 2, 2 sqrt 2, 2 / golden, 2.
PLATONIC = {
    "tetrahedron": (CUBE[CUBE.prod(axis=1) > 0], (2 * math.sqrt(2)) ** 3 / (6 * math.sqrt(2)), 3),
    "cube": (CUBE, 8.0, 4),
    "octahedron": (AXES, math.sqrt(2) ** 4 / 3, 3),
    "dodecahedron": (
        np.vstack([CUBE, cyclic(*signed(0, 1 / GOLDEN, GOLDEN))]),
        (15 + 7 * math.sqrt(5)) / 4 * (2 / GOLDEN) ** 3,
        5,
    ),
    "icosahedron": (cyclic(*signed(0, 1, GOLDEN)), 5 * (3 + math.sqrt(5)) / 12 * 8, 3),
}
CUBOCTAHEDRON = cyclic(*signed(0, 1, 1))


def turn(seed: int) -> Array:
    return np.asarray(Rotation.random(random_state=seed).as_matrix())


def random_half_spaces(dimension: int, seed: int) -> tuple[Array, Array]:
    random = np.random.default_rng(seed)
    normals = random.normal(size=(30, dimension))
    return normals / np.linalg.norm(normals, axis=1)[:, None], random.uniform(1.0, 1.02, 30)


def random_body(dimension: int, seed: int = 0) -> ConvexBody:
    """A body without symmetry; the hull of points, so that every facet counts."""
    random = np.random.default_rng(seed)
    return ConvexBody.from_vertices(random.normal(size=(40, dimension)) * [1, 2, 0.5][:dimension])


def near_pairs(found: Array, expected: Array) -> bool:
    """Whether two sets of points are the same."""
    if found.shape != expected.shape:
        return False
    apart = np.linalg.norm(found[:, None] - expected, axis=2)
    return bool(apart.min(axis=0).max() < 1e-12 and apart.min(axis=1).max() < 1e-12)


def check_consistency(body: ConvexBody) -> None:
    """Check what must hold for every body."""
    size = body.circumradius
    np.testing.assert_allclose(np.linalg.norm(body.normals, axis=1), 1.0, atol=1e-15)
    heights = body.vertices @ body.normals.T - body.offsets
    assert heights.max() < 1e-13 * size
    for facet, numbers in enumerate(body.facets):
        on_facet = np.flatnonzero(np.abs(heights[:, facet]) < 1e-11 * size)
        assert sorted(numbers) == on_facet.tolist()
    assert {number for facet in body.facets for number in facet} == set(range(len(body.vertices)))
    if body.dimension == 3:
        edges = [pair for f in body.facets for pair in zip(f, (*f[1:], f[0]), strict=True)]
        assert len(set(edges)) == len(edges)
        assert {(end, start) for start, end in edges} == set(edges)
        assert len(body.vertices) - len(edges) // 2 + len(body.facets) == 2
    else:
        assert sorted(start for start, _ in body.facets) == list(range(len(body.vertices)))
        assert sorted(end for _, end in body.facets) == list(range(len(body.vertices)))
    # Counter-clockwise: every simplex sees the origin from its inner side.
    assert np.linalg.det(body.vertices[body.simplices]).min() > 0.0
    hull = ConvexHull(body.vertices)
    assert body.volume == pytest.approx(hull.volume, rel=1e-12)
    assert body.facet_areas.sum() == pytest.approx(hull.area, rel=1e-12)
    # A closed surface has no mean normal.
    np.testing.assert_allclose(body.facet_areas @ body.normals, 0.0, atol=1e-12 * hull.area)


@pytest.mark.parametrize(("corners", "volume", "n_edges"), PLATONIC.values(), ids=PLATONIC)
@pytest.mark.parametrize("seed", [None, 0, 1])
def test_regular_solids(corners: Array, volume: float, n_edges: int, seed: int | None) -> None:
    turned = corners if seed is None else corners @ turn(seed).T
    body = ConvexBody.from_vertices(turned)
    check_consistency(body)
    assert near_pairs(body.vertices, turned)
    assert {len(facet) for facet in body.facets} == {n_edges}
    assert body.volume == pytest.approx(volume, rel=1e-14)
    assert np.ptp(body.facet_areas) < 1e-13
    assert body.is_symmetric == (len(corners) != 4)
    again = ConvexBody(body.normals, body.offsets)
    assert near_pairs(again.vertices, turned)


def test_a_cube_is_exact() -> None:
    body = ConvexBody.from_vertices(CUBE)
    assert sorted(body.normals.tolist()) == sorted(AXES.tolist())
    assert body.offsets.tolist() == [1.0] * 6
    assert sorted(body.vertices.tolist()) == CUBE.tolist()
    assert not np.signbit(body.normals[body.normals == 0.0]).any()
    assert (body.inradius, body.circumradius) == (1.0, math.sqrt(3))
    assert body.dimension == 3
    assert repr(body) == "<ConvexBody in 3D: 6 facets, 8 vertices>"


def test_a_square_is_exact() -> None:
    body = ConvexBody(SQUARE)
    assert body.normals.tolist() == SQUARE.tolist()
    assert sorted(body.vertices.tolist()) == [[-1, -1], [-1, 1], [1, -1], [1, 1]]
    assert [body.vertices[list(facet)].tolist() for facet in body.facets] == [
        [[1, -1], [1, 1]], [[1, 1], [-1, 1]], [[-1, 1], [-1, -1]], [[-1, -1], [1, -1]],
    ]  # fmt: skip
    assert (body.volume, body.dimension, body.is_symmetric) == (4.0, 2, True)
    assert body.facet_areas.tolist() == [2.0] * 4


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_half_spaces_against_qhull(dimension: int, seed: int) -> None:
    normals, offsets = random_half_spaces(dimension, seed)
    expected = HalfspaceIntersection(np.c_[normals, -offsets], np.zeros(dimension))
    used = sorted({number for facet in expected.dual_facets for number in facet})
    lengths = np.random.default_rng(seed).uniform(0.1, 10, len(used))
    body = ConvexBody(normals[used] * lengths[:, None], offsets[used] * lengths)
    check_consistency(body)
    np.testing.assert_allclose(body.normals, normals[used], rtol=0, atol=1e-15)
    np.testing.assert_allclose(body.offsets, offsets[used], rtol=1e-15)
    assert near_pairs(body.vertices, expected.intersections)
    assert not body.is_symmetric


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_vertices_against_qhull(dimension: int, seed: int) -> None:
    points = np.random.default_rng(seed).normal(size=(60, dimension))
    body = ConvexBody.from_vertices(points)
    check_consistency(body)
    assert near_pairs(body.vertices, points[ConvexHull(points).vertices])


@pytest.mark.parametrize("seed", range(3))
def test_points_on_facets_edges_and_inside_change_nothing(seed: int) -> None:
    lattice = np.array(list(product((-1.0, -0.3, 0.0, 1.0), repeat=3))) @ turn(seed).T
    body = ConvexBody.from_vertices(lattice)
    check_consistency(body)
    assert near_pairs(body.vertices, CUBE @ turn(seed).T)
    assert len(body.facets) == 6
    assert body.is_symmetric


@pytest.mark.parametrize("corners", [CUBOCTAHEDRON, PLATONIC["dodecahedron"][0]])
@pytest.mark.parametrize("seed", range(3))
def test_single_precision_needs_more_tolerance(corners: Array, seed: int) -> None:
    exact = ConvexBody.from_vertices(corners @ turn(seed).T)
    rounded = (corners @ turn(seed).T).astype(np.float32)
    assert len(ConvexBody.from_vertices(rounded).facets) > len(exact.facets)
    body = ConvexBody.from_vertices(rounded, tolerance=1e-6)
    assert len(body.facets) == len(exact.facets)
    assert len(body.vertices) == len(exact.vertices)
    assert body.is_symmetric
    assert body.volume == pytest.approx(exact.volume, rel=1e-6)


@pytest.mark.parametrize("dimension", [2, 3])
def test_norm_and_support_are_dual(dimension: int) -> None:
    body = random_body(dimension)
    random = np.random.default_rng(1)
    points, directions = random.normal(size=(2, 500, dimension))
    polar = ConvexBody(body.vertices)  # {u : v . u <= 1}, whose norm is the support of the body
    np.testing.assert_allclose(body.support(directions), polar.norm(directions), rtol=1e-13)
    np.testing.assert_allclose(body.norm(points), polar.support(points), rtol=1e-13)
    products = (points * directions).sum(axis=1)
    assert (products <= body.norm(points) * body.support(directions) * (1 + 1e-13)).all()
    np.testing.assert_allclose(body.support(body.normals), body.offsets, rtol=1e-13)
    np.testing.assert_allclose(body.norm(body.vertices), 1.0, rtol=1e-13)


@pytest.mark.parametrize("dimension", [2, 3])
def test_norm_is_a_gauge(dimension: int) -> None:
    body = random_body(dimension)
    random = np.random.default_rng(2)
    first, second = random.normal(size=(2, 500, dimension))
    np.testing.assert_allclose(body.norm(2.5 * first), 2.5 * body.norm(first), rtol=1e-13)
    assert (body.norm(first + second) <= body.norm(first) + body.norm(second) + 1e-12).all()
    on_boundary = body.radial(first)[:, None] * first
    heights = on_boundary @ body.normals.T - body.offsets
    np.testing.assert_allclose(heights.max(axis=1), 0.0, atol=1e-12)


def test_single_vectors_give_numbers() -> None:
    body = ConvexBody(SQUARE)
    for value, expected in [
        (body.norm([3, -4]), 4.0), (body.support([3, -4]), 7.0), (body.radial([3, -4]), 0.25),
        (body.norm([0, 0]), 0.0), (body.radial([0, 0]), math.inf),
    ]:  # fmt: skip
        assert isinstance(value, float)
        assert value == expected
    assert body.norm(np.empty((0, 2))).shape == (0,)
    assert body.radial([[0, 0], [2, 0]]).tolist() == [math.inf, 0.5]


@pytest.mark.parametrize("dimension", [2, 3])
def test_centroid(dimension: int) -> None:
    body = random_body(dimension)
    random = np.random.default_rng(3)
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    points = random.uniform(low, high, (200_000, dimension))
    expected = points[body.norm(points) <= 1].mean(axis=0)
    np.testing.assert_allclose(body.centroid, expected, atol=0.02)
    centered = ConvexBody.from_vertices(body.vertices + 100.0, center=True)
    np.testing.assert_allclose(centered.centroid, 0.0, atol=1e-12)
    assert centered.volume == pytest.approx(body.volume, rel=1e-11)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("factor", [2.0, 0.3, [1.0, 3.0, 0.25]])
def test_scaled(dimension: int, factor: float | list[float]) -> None:
    body = random_body(dimension)
    factors = np.broadcast_to(factor, 3)[:dimension]
    scaled = body.scaled(factor if isinstance(factor, float) else factors)
    check_consistency(scaled)
    assert near_pairs(scaled.vertices, body.vertices * factors)
    if isinstance(factor, float):
        assert np.array_equal(scaled.normals, body.normals)
        assert np.array_equal(scaled.offsets, body.offsets * factor)


@pytest.mark.parametrize("seed", range(3))
def test_rotated(seed: int) -> None:
    body = random_body(3)
    rotated = body.rotated(turn(seed))
    check_consistency(rotated)
    assert near_pairs(rotated.vertices, body.vertices @ turn(seed).T)
    assert np.array_equal(rotated.offsets, body.offsets)
    mirrored = body.rotated(np.diag([1, 1, -1]))
    check_consistency(mirrored)
    assert near_pairs(mirrored.vertices, body.vertices * [1, 1, -1])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("factors", [[1, 1, 1], [1, 1, 1e-4], [1, 1e-3, 30]])
@pytest.mark.parametrize("corners", [CUBOCTAHEDRON, PLATONIC["icosahedron"][0]])
def test_thin_bodies_keep_their_vertices(corners: Array, factors: list[float], seed: int) -> None:
    body = ConvexBody.from_vertices(corners)
    thin = body.scaled(factors).rotated(turn(seed))
    assert [len(facet) for facet in thin.facets] == [len(facet) for facet in body.facets]
    assert len(thin.vertices) == len(body.vertices)
    assert thin.is_symmetric
    assert thin.volume == pytest.approx(body.volume * np.prod(factors), rel=1e-8)


def test_opposite_normals_are_exact() -> None:
    for seed in range(20):
        body = ConvexBody.from_vertices(CUBOCTAHEDRON @ turn(seed).T)
        for normal, offset in zip(body.normals, body.offsets, strict=True):
            (opposite,) = np.flatnonzero((body.normals == -normal).all(axis=1))
            assert body.offsets[opposite] == offset


def test_symmetry_needs_equal_offsets() -> None:
    body = ConvexBody(AXES, [1, 1, 1, 1, 1, 1.001])
    assert not body.is_symmetric
    assert np.array_equal(body.normals[3:], np.where(AXES[:3] == 0, 0, -AXES[:3]))
    assert ConvexBody(AXES, [1, 1, 1, 1, 1, 1 + 1e-13]).is_symmetric


def test_bodies_cannot_be_changed() -> None:
    body = ConvexBody(SQUARE)
    with pytest.raises(FrozenInstanceError):
        body.offsets = np.ones(4)  # type: ignore[misc]
    for array in (body.normals, body.offsets, body.vertices, body.facet_areas, body.simplices):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    given = SQUARE.copy()
    held = ConvexBody(given)
    given[:] = 7.0
    assert held.normals.tolist() == SQUARE.tolist()


def test_bodies_can_be_pickled() -> None:
    body = random_body(3)
    again = pickle.loads(pickle.dumps(body))
    assert np.array_equal(again.normals, body.normals)
    assert again.facets == body.facets


DIAGONAL = np.vstack([AXES, [[1.0, 1.0, 0.0]]])

#: What is done, what the message must say.
FAULTS: dict[str, tuple[Callable[[], object], str]] = {
    "words": (lambda: ConvexBody([["a", "b"]] * 3), "normals are not an array of real numbers"),
    "ragged": (lambda: ConvexBody([[1, 2], [3]]), "normals are not an array of real numbers"),
    "flat": (lambda: ConvexBody([1, 2, 3]), r"normals have shape \(3,\)"),
    "4D": (lambda: ConvexBody(np.eye(4)), r"normals have shape \(4, 4\)"),
    "word offsets": (lambda: ConvexBody(SQUARE, ["a"] * 4), "offsets are not an array of real"),
    "offsets": (lambda: ConvexBody(SQUARE, [1, 1]), r"offsets have shape \(2,\); 4 normals need"),
    "NaN": (lambda: ConvexBody(SQUARE * [1, np.nan]), "normals: row 0 is not finite"),
    "infinity": (lambda: ConvexBody(SQUARE, [1, 1, np.inf, 1]), "offset 2 is not finite"),
    "zero": (lambda: ConvexBody(np.vstack([SQUARE, [0, 0]])), "normal 4 is zero"),
    "origin outside": (lambda: ConvexBody(AXES, [1, 1, 1, 1, -0.5, 1]), "offset 4 is -0.5.*origin"),
    "origin on facet": (lambda: ConvexBody(AXES, [1, 1, 0, 1, 1, 1]), "offset 2 is 0.*origin"),
    "duplicate": (
        lambda: ConvexBody(np.vstack([AXES, [0, 2, 0]])),
        "half-spaces 1 and 6 have the same normal; remove one",
    ),
    "parallel": (
        lambda: ConvexBody(np.vstack([AXES, [0, 1, 1e-10]]), [1] * 6 + [2]),
        "half-spaces 1 and 6 have the same normal",
    ),
    "far": (lambda: ConvexBody(DIAGONAL, [1] * 6 + [5]), "half-space 6 bounds no part"),
    "touches an edge": (lambda: ConvexBody(DIAGONAL, [1] * 6 + [2]), "half-space 6 bounds no par"),
    "few": (lambda: ConvexBody(AXES[:3]), "there are 3 normals; a body in 3D needs at least 4"),
    "few in 2D": (lambda: ConvexBody(SQUARE[:2]), "there are 2 normals; .* at least 3"),
    "open": (lambda: ConvexBody(SQUARE[:3]), "the body is unbounded; add"),
    "open column": (
        lambda: ConvexBody([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]),
        "the body is unbounded; add",
    ),
    "open half": (lambda: ConvexBody(AXES[[0, 1, 2, 3]]), "the body is unbounded; add"),
    "point": (lambda: ConvexBody.from_vertices([1, 2, 3]), r"vertices have shape \(3,\)"),
    "word vertices": (lambda: ConvexBody.from_vertices([["a"]]), "vertices are not an array"),
    "infinite vertex": (
        lambda: ConvexBody.from_vertices(np.vstack([SQUARE, [0, np.inf]])),
        "vertices: row 4 is not finite",
    ),
    "triangle": (lambda: ConvexBody.from_vertices(AXES[:3]), "there are 3 vertices"),
    "plane": (
        lambda: ConvexBody.from_vertices([[1, 0, 0], [-1, 1, 0], [-1, -1, 0], [0, 0, 0]]),
        "the vertices lie in a plane",
    ),
    "nearly a plane": (
        lambda: ConvexBody.from_vertices(CUBE * [1, 1, 1e-10]),
        "the vertices lie in a plane",
    ),
    "line": (lambda: ConvexBody.from_vertices([[1, 1], [0, 0], [-1, -1]]), "lie on a line"),
    "origin beside": (lambda: ConvexBody.from_vertices(CUBE + 3), "offset . is -2.*center it"),
    "origin a corner": (lambda: ConvexBody.from_vertices(CUBE + 1), "offset . is .*origin must"),
    "scale": (lambda: ConvexBody(SQUARE).scaled([1, 2, 3]), "scale is .*a number or 2 of them"),
    "scale words": (lambda: ConvexBody(SQUARE).scaled("big"), "scale is 'big'"),
    "scale zero": (lambda: ConvexBody(SQUARE).scaled(0), "scale is 0; it must be finite and pos"),
    "scale NaN": (lambda: ConvexBody(SQUARE).scaled([1, np.nan]), "must be finite and positive"),
    "rotation": (lambda: ConvexBody(SQUARE).rotated(np.eye(3)), r"shape \(3, 3\); .* \(2, 2\)"),
    "shear": (lambda: ConvexBody(SQUARE).rotated([[1, 1], [0, 1]]), "rotation is not orthogonal"),
    "vectors": (lambda: ConvexBody(SQUARE).norm([1, 2, 3]), r"vectors have shape \(3,\)"),
    "tables": (lambda: ConvexBody(SQUARE).support(np.ones((2, 2, 2))), "vectors have shape"),
}  # fmt: skip


@pytest.mark.parametrize(("act", "message"), FAULTS.values(), ids=FAULTS)
def test_faults(act: Callable[[], object], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        act()
