"""Inclusion-exclusion over the Euclidean alpha-complex."""

from __future__ import annotations

import numpy as np
import pytest

import oracles
import polyhedron_oracles as expect
from energies.cases import measure_bodies
from oracles import assert_close
from pcsmooth import PolyhedronUnion
from pcsmooth.energies.polyhedra.alpha_complex import find_simplices
from polyhedron_oracles import Rule

#: Sets without a unique Delaunay triangulation, with distance 1 between neighbours.
DEGENERATE = {
    "square": oracles.lattice(2, 2),
    "squares": oracles.lattice(5, 4),
    "triangles": oracles.lattice(5, 5) @ np.array([[1, 0], [0.5, np.sqrt(0.75)]]),
    "circle": oracles.even_circle(12) / (2 * np.sin(np.pi / 12)),
    "cube": oracles.lattice(2, 2, 2),
    "cubes": oracles.lattice(4, 3, 3),
    "squares in space": oracles.lattice(4, 1, 4),
    "centred cubes": np.r_[oracles.lattice(3, 3, 3), oracles.lattice(2, 2, 2) + 0.5],
}


def measure(
    points: oracles.Array,
    radius: float,
    body: expect.Body,
    rule: Rule = "inclusion-exclusion",
) -> PolyhedronUnion:
    return measure_bodies(points, radius, body, rule)


def bodies_for(points: oracles.Array) -> tuple[str, ...]:
    return ("square", "lopsided polygon") if points.shape[1] == 2 else ("cube", "icosahedron")


@pytest.mark.parametrize("kind", ["cloud", "cap"])
@pytest.mark.parametrize("shape", [*expect.SHAPES[2], *expect.SHAPES[3]])
def test_sum_agrees_with_brute_force(shape: str, kind: str) -> None:
    scene = expect.scene(shape, kind, 10, seed=1)
    union = measure(scene.points, scene.radius, scene.body)
    simplices = expect.alpha_complex(scene.points, scene.radius)
    expected = expect.sum_over_simplices(scene.points, scene.radius, scene.body, simplices)
    # Qhull's vertices are good to some 1e-14, and some 50 terms cancel
    expect.assert_union(union, expected, 1e-11)
    volumes, _ = expect.naive_cells_of_scene(shape, kind, 10, seed=1)
    assert_close(union.cell_volumes, volumes, 1e-11)


@pytest.mark.parametrize("shape", ["square", "cube"])
def test_sum_agrees_with_the_complex_of_gudhi(shape: str) -> None:
    scene = expect.scene(shape, "cloud", 60, seed=2)
    union = measure(scene.points, scene.radius, scene.body)
    simplices = expect.gudhi_alpha_complex(scene.points, scene.radius)
    totals = np.zeros(2)
    for simplex in simplices:
        overlap = expect.overlap_of_cubes(scene.points[list(simplex)], scene.radius)
        totals += (-1) ** (len(simplex) - 1) * np.array(overlap)
    assert union.volume == pytest.approx(totals[0], rel=1e-12)
    assert union.area == pytest.approx(totals[1], rel=1e-12)


# --- closed forms, and where the sum is not the union


@pytest.mark.parametrize("shape", ["square", "cube"])
@pytest.mark.parametrize("distance", [0.5, 1.9, 1.99999, 2.00001, 2.5])
def test_two_cubes_meet_up_to_two_radii(shape: str, distance: float) -> None:
    """Cubes along a diagonal overlap beyond that, but are no longer an edge of the complex."""
    body = expect.solid(shape)
    dimension = body.normals.shape[1]
    points = np.array([np.zeros(dimension), np.full(dimension, distance / np.sqrt(dimension))])
    union = measure(points, 1.0, body)
    volume, area = expect.overlap_of_cubes(points, 1.0)
    assert volume > 0
    edges = distance < 2
    assert union.volume == pytest.approx(2 * 2**dimension - edges * volume, rel=1e-13)
    whole = 2 * dimension * 2 ** (dimension - 1)
    assert union.area == pytest.approx(2 * whole - edges * area, rel=1e-13)
    exact = measure(points, 1.0, body, "exact")
    assert union.volume - exact.volume == pytest.approx((not edges) * volume, abs=1e-12)


def test_missing_triangle() -> None:
    """Figure 33 of the thesis: squares of three points share what their disks do not.

    The circumscribed circle has radius 1.06 > r = 1, the edges are shorter than 2 and the triangle
    is acute: the complex is the three edges. The squares share [0.8, 1] x [0.6, 1], which the sum
    subtracts three times and never adds again.
    """
    points = np.array([[0, 0], [1.8, 0], [0.9, 1.6]])
    edges, *larger = find_simplices(points, 1.0)
    assert edges.tolist() == [[0, 1], [0, 2], [1, 2]]
    assert not any(len(simplices) for simplices in larger)
    body = expect.solid("square")
    union, exact = measure(points, 1.0, body), measure(points, 1.0, body, "exact")
    # overlaps: 0.2 x 2 and twice 1.1 x 0.4
    assert union.volume == pytest.approx(12 - 0.4 - 2 * 0.44, rel=1e-14)
    assert exact.volume == pytest.approx(12 - 0.4 - 2 * 0.44 + 0.08, rel=1e-14)
    assert exact.volume - union.volume == pytest.approx(0.2 * 0.4, rel=1e-12)
    assert exact.area - union.area == pytest.approx(2 * (0.2 + 0.4), rel=1e-12)


def test_missing_edge() -> None:
    """The error has the other sign where two squares meet outside of the one between them.

    0 and 2 are hidden from each other by 1 (the triangle's circle has radius 1.85 > 1), so what
    squares 0 and 2 share counts twice where 1 does not hold it: [0.2, 1] x [-1, -0.9].
    """
    points = np.array([[0, 0], [0.6, 0.1], [1.2, 0]])
    edges, *larger = find_simplices(points, 1.0)
    assert edges.tolist() == [[0, 1], [1, 2]]
    assert not any(len(simplices) for simplices in larger)
    body = expect.solid("square")
    union, exact = measure(points, 1.0, body), measure(points, 1.0, body, "exact")
    assert union.volume == pytest.approx(12 - 2 * 1.4 * 1.9, rel=1e-14)
    assert union.volume - exact.volume == pytest.approx(0.8 * 0.1, rel=1e-12)


def test_missing_tetrahedron_of_cubes() -> None:
    """Four cubes share what the complex, the surface of a tetrahedron, leaves out.

    The corners of the regular tetrahedron are (±s, ±s, ±s): edges 2 sqrt(2) s, triangles' circles
    sqrt(8/3) s < 1, tetrahedron's sphere sqrt(3) s > 1; the cubes share one of side 2 - 2 s.
    """
    s = 0.6
    points = s * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    edges, triangles, tetrahedra = find_simplices(points, 1.0)
    assert (len(edges), len(triangles), len(tetrahedra)) == (6, 4, 0)
    union = measure(points, 1.0, expect.solid("cube"))
    shared = 2 - 2 * s
    # pairs share 2 x shared², triples and all four shared³ (both signs of every coordinate occur)
    assert union.volume == pytest.approx(32 - 6 * 2 * shared**2 + 4 * shared**3, rel=1e-13)
    exact = measure(points, 1.0, expect.solid("cube"), "exact")
    assert union.volume - exact.volume == pytest.approx(shared**3, rel=1e-12)
    assert union.area - exact.area == pytest.approx(6 * shared**2, rel=1e-12)


@pytest.mark.parametrize("shape", ["triangle", "tetrahedron"])
def test_simplices_with_the_whole_complex(shape: str) -> None:
    """With as many points as vertices and a large radius the sum is the union."""
    body = expect.solid(shape)
    points = oracles.uniform_cloud(len(body.normals), body.normals.shape[1], seed=8)
    radius = 1.5
    assert len(expect.alpha_complex(points, radius)) == 2 ** len(points) - 1
    union = measure(points, radius, body)
    expected, area_gradient = expect.simplex_union(points, radius, body)
    expect.assert_union(union, expected, 1e-13)
    assert_close(union.area_gradient, area_gradient, 1e-12)


# --- degenerate positions


@pytest.mark.parametrize("radius", [0.45, 0.6, 0.8, 1.3])
@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_sets_do_not_depend_on_the_order(name: str, radius: float) -> None:
    points = DEGENERATE[name]
    rng = np.random.default_rng(0)
    for shape in bodies_for(points):
        body = expect.solid(shape)
        union = measure(points, radius, body)
        assert np.isfinite(union.volume)
        for _ in range(2):
            order = rng.permutation(len(points))
            other = measure(points[order], radius, body)
            assert other.volume == pytest.approx(union.volume, rel=1e-12)
            assert other.area == pytest.approx(union.area, rel=1e-12)
            assert_close(other.cell_volumes, union.cell_volumes[order], 1e-12)


@pytest.mark.parametrize("radius", [0.45, 0.8, 1.3])
@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_sets_are_measured_by_their_complex(name: str, radius: float) -> None:
    points = DEGENERATE[name]
    simplices = [(i,) for i in range(len(points))]
    for rows in find_simplices(points, radius):
        simplices += [tuple(row) for row in rows.tolist()]
    shape = bodies_for(points)[0]
    union = measure(points, radius, expect.solid(shape))
    totals = np.zeros(2)
    if shape in ("square", "cube"):
        for simplex in simplices:
            overlap = expect.overlap_of_cubes(points[list(simplex)], radius)
            totals += (-1) ** (len(simplex) - 1) * np.array(overlap)
    # where cubes just touch their overlap is flat: it has no volume, and an area by convention
    assert union.volume == pytest.approx(totals[0], rel=1e-12)
    assert union.area == pytest.approx(totals[1], rel=1e-12)


@pytest.mark.parametrize("radius", [0.45, 0.6, 0.8, 1.3])
@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_sets_after_a_motion(name: str, radius: float) -> None:
    """Rounding decides between diagonals; it must leave a complex all the same."""
    points = DEGENERATE[name]
    dimension = points.shape[1]
    for shape in bodies_for(points):
        still = measure(points, radius, expect.solid(shape))
        for seed in range(2):
            rotation = oracles.random_rotation(dimension, np.random.default_rng(seed))
            body = expect.rotated(expect.solid(shape), rotation)
            union = measure(points @ rotation.T + 0.1, radius, body)
            for measure_name in oracles.MEASURES:
                assert np.isfinite(getattr(union, measure_name)).all()
            assert_close(union.cell_volumes, still.cell_volumes, 1e-11)
            # diagonals move the sum by less than one body for each point
            whole = expect.measure_body(body).volume * radius**dimension
            assert 0 < union.volume < len(points) * whole * (1 + 1e-12)


@pytest.mark.parametrize("radius", [0.45, 0.7])
@pytest.mark.parametrize("dimension", [2, 3])
def test_grid_of_cubes_that_only_neighbours_share(dimension: int, radius: float) -> None:
    """Below half the diagonal the complex of a grid is its edges alone."""
    points = oracles.lattice(*[4] * dimension)
    shape = {2: "square", 3: "cube"}[dimension]
    union = measure(points, radius, expect.solid(shape))
    side, edges = 2 * radius, dimension * 3 * 4 ** (dimension - 1)
    shared = max(0.0, side - 1) * side ** (dimension - 1) * (radius > 0.5)
    expected = 4**dimension * side**dimension - edges * shared
    assert union.volume == pytest.approx(expected, rel=1e-12)
