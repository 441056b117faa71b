"""The Euclidean alpha-complex."""

from __future__ import annotations

from functools import cache
from itertools import combinations, pairwise

import numpy as np
import numpy.typing as npt
import pytest

import oracles
import polyhedron_oracles as expect
from pcsmooth.energies.polyhedra.alpha_complex import find_simplices


def on_cylinder(around: int, rings: int) -> oracles.Array:
    circle = oracles.even_circle(around)
    return np.concatenate([np.c_[circle, np.full(around, z)] for z in 0.25 * np.arange(rings)])


def on_torus(around: int, across: int) -> oracles.Array:
    """Rows and columns on the torus R = 1, tube 0.4: cocircular and coplanar up to rounding."""
    tube = 0.4 * oracles.even_circle(across)
    circle = oracles.even_circle(around)
    rings = [np.c_[(1 + a) * circle, np.full(around, z)] for a, z in tube]
    return np.concatenate(rings)


#: Points, a radius, and the Euler characteristic of the union of balls (of disks in 2D), which the
#: complex has whatever diagonals it takes: pieces minus tunnels plus cavities.
DEGENERATE = {
    "square, apart": (oracles.lattice(2, 2), 0.49, 4),
    "square, ring": (oracles.lattice(2, 2), 0.6, 0),
    "square": (oracles.lattice(2, 2), 0.75, 1),
    "squares, rings": (oracles.lattice(5, 4), 0.6, 1 - 12),
    "squares": (oracles.lattice(5, 4), 0.75, 1),
    "squares, large radius": (oracles.lattice(5, 4), 10.0, 1),
    "triangles": (oracles.lattice(6, 6) @ np.array([[1, 0], [0.5, np.sqrt(0.75)]]), 0.6, 1),
    "circle, ring": (oracles.even_circle(16), 0.9, 0),
    "circle": (oracles.even_circle(16), 1.1, 1),
    "row": (np.c_[np.arange(9.0), np.zeros(9)], 0.6, 1),
    "cube, frame": (oracles.lattice(2, 2, 2), 0.6, 8 - 12),
    "cube, cavity": (oracles.lattice(2, 2, 2), 0.8, 2),
    "cube": (oracles.lattice(2, 2, 2), 0.9, 1),
    "grid, frame": (oracles.lattice(4, 4, 4), 0.6, 64 - 144),
    "grid, cavities": (oracles.lattice(4, 4, 4), 0.8, 1 + 27),
    "grid": (oracles.lattice(4, 4, 4), 0.9, 1),
    "grid, large radius": (oracles.lattice(4, 4, 4), 20.0, 1),
    "plane in space, rings": (oracles.lattice(5, 1, 4), 0.6, 1 - 12),
    "plane in space": (oracles.lattice(5, 1, 4), 0.75, 1),
    "slanted plane": (oracles.lattice(5, 4) @ np.array([[1, 0, 1], [0, 1, 2]]), 3.0, 1),
    "row in space": (np.outer(np.arange(7), [1.0, 2.0, 2.0]), 1.6, 1),
    "circle in space, ring": (np.c_[oracles.even_circle(12), np.ones(12)], 0.9, 0),
    "circle in space": (np.c_[oracles.even_circle(12), np.ones(12)], 1.1, 1),
    "octahedron, cavity": (np.r_[np.eye(3), -np.eye(3)], 0.9, 2),
    "octahedron": (np.r_[np.eye(3), -np.eye(3)], 1.1, 1),
    "sphere, cavity": (oracles.even_sphere(60), 0.9, 2),
    "sphere": (oracles.even_sphere(60), 1.1, 1),
    "dodecahedron, cavity": (expect.solid("icosahedron").normals, 0.9, 2),
    "dodecahedron": (expect.solid("icosahedron").normals, 1.1, 1),
    "cylinder, tube": (on_cylinder(24, 8), 0.3, 0),
    "cylinder": (on_cylinder(24, 8), 1.1, 1),
    "torus, tube": (on_torus(24, 12), 0.3, 0),
    "torus, full": (on_torus(24, 12), 0.45, 0),
    "torus": (on_torus(24, 12), 1.0, 1),
    "prism": (oracles.lattice(3, 3, 2), 0.9, 1),
}


def simplices_of(points: oracles.Array, radius: float) -> set[expect.Simplex]:
    """Read the complex as gudhi has it, vertices included, and check its form on the way."""
    found: set[expect.Simplex] = {(i,) for i in range(len(points))}
    for size, rows in enumerate(find_simplices(points, radius), start=2):
        assert rows.shape == (len(rows), size)
        assert np.issubdtype(rows.dtype, np.integer)
        assert (np.diff(rows, axis=1) > 0).all()
        simplices = [tuple(row) for row in rows.tolist()]
        assert simplices == sorted(set(simplices))
        found |= set(simplices)
    return found


@cache
def simplices_of_set(name: str) -> set[expect.Simplex]:
    return simplices_of(*DEGENERATE[name][:2])


def euler_characteristic(simplices: set[expect.Simplex]) -> int:
    return sum((-1) ** (len(simplex) - 1) for simplex in simplices)


def assert_closed(simplices: set[expect.Simplex]) -> None:
    """Every face of a simplex of a complex is in it."""
    for simplex in simplices:
        for face in combinations(simplex, len(simplex) - 1):
            assert not face or face in simplices


def renumbered(simplices: set[expect.Simplex], order: npt.NDArray[np.int64]) -> set[expect.Simplex]:
    return {tuple(sorted(order[list(simplex)].tolist())) for simplex in simplices}


# --- general position


@pytest.mark.parametrize(("spacings", "seed"), [(0.3, 0), (0.6, 1), (1.0, 2), (2.0, 3), (20.0, 4)])
@pytest.mark.parametrize("kind", ["cloud", "surface"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_complex_is_that_of_gudhi(dimension: int, kind: str, spacings: float, seed: int) -> None:
    n = 100
    points = (
        oracles.uniform_cloud(n, dimension, seed)
        if kind == "cloud"
        else oracles.random_sphere(n, seed=seed, dimension=dimension)
        * np.random.default_rng(seed).normal(1, 0.02, (n, 1))
    )
    size = 1.0 if kind == "cloud" else oracles.sphere_area(1.0, dimension)
    spacing = (size / n) ** (1 / (dimension if kind == "cloud" else dimension - 1))
    simplices = simplices_of(points, spacings * spacing)
    assert simplices == expect.gudhi_alpha_complex(points, spacings * spacing)


@pytest.mark.parametrize("radius", [0.1, 0.2, 0.3, 0.5, 3.0])
@pytest.mark.parametrize("dimension", [2, 3])
def test_complex_is_that_of_empty_spheres(dimension: int, radius: float) -> None:
    for seed in range(4):
        points = oracles.uniform_cloud(12, dimension, seed)
        assert simplices_of(points, radius) == expect.alpha_complex(points, radius)


@pytest.mark.parametrize("spacings", [0.6, 1.0, 2.0])
def test_flat_cloud_in_space_has_the_complex_of_the_plane(spacings: float) -> None:
    points = oracles.uniform_cloud(100, 2)
    flat = simplices_of(points, spacings / 10)
    assert flat == expect.gudhi_alpha_complex(points, spacings / 10)
    for axis in range(3):
        assert simplices_of(np.insert(points, axis, 0.25, axis=1), spacings / 10) == flat


@pytest.mark.parametrize("dimension", [2, 3])
def test_larger_radius_keeps_all_simplices(dimension: int) -> None:
    points = oracles.uniform_cloud(100, dimension, seed=5)
    sets = [simplices_of(points, radius) for radius in (0.03, 0.05, 0.1, 0.2, 0.5, 5.0)]
    for smaller, larger in pairwise(sets):
        assert smaller <= larger
    for simplices in sets:
        assert_closed(simplices)
    assert euler_characteristic(sets[-1]) == 1


@pytest.mark.parametrize("dimension", [2, 3])
def test_order_of_points_does_not_matter(dimension: int) -> None:
    points = oracles.uniform_cloud(200, dimension, seed=6)
    order = np.random.default_rng(0).permutation(len(points))
    shuffled = simplices_of(points[order], 0.15)
    assert renumbered(shuffled, order) == simplices_of(points, 0.15)


@pytest.mark.parametrize("points", [[[1.0, 2.0]], [[0, 0, 0]], [[0, 0, 0], [0, 0, 2.001]]])
def test_few_points_have_no_simplices(points: npt.ArrayLike) -> None:
    assert all(len(rows) == 0 for rows in find_simplices(np.asarray(points, float), 1.0))


@pytest.mark.parametrize("dimension", [2, 3])
def test_triangle_is_in_from_its_circle_on(dimension: int) -> None:
    """Acute: from the circumscribed radius on. Obtuse: so is the long edge."""
    acute, obtuse = np.zeros((3, dimension)), np.zeros((3, dimension))
    acute[:, :2] = np.array([[0, 0], [1, 0], [0.5, 1]])  # radius 0.625
    obtuse[:, :2] = np.array([[-2, 0], [0, 1], [2, 0]])  # radius 2.5
    edges, triangles = find_simplices(acute, 0.624)[:2]
    assert (len(edges), len(triangles)) == (3, 0)
    edges, triangles = find_simplices(acute, 0.626)[:2]
    assert (len(edges), len(triangles)) == (3, 1)
    edges, triangles = find_simplices(obtuse, 2.499)[:2]
    assert (edges.tolist(), len(triangles)) == ([[0, 1], [1, 2]], 0)
    edges, triangles = find_simplices(obtuse, 2.501)[:2]
    assert (len(edges), len(triangles)) == (3, 1)


# --- degenerate positions


@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_sets_have_the_shape_of_the_union_of_balls(name: str) -> None:
    simplices = simplices_of_set(name)
    assert_closed(simplices)
    assert euler_characteristic(simplices) == DEGENERATE[name][2]


@pytest.mark.parametrize("name", DEGENERATE)
def test_order_of_degenerate_sets_does_not_matter(name: str) -> None:
    points, radius, _ = DEGENERATE[name]
    for seed in range(2):
        order = np.random.default_rng(seed).permutation(len(points))
        assert renumbered(simplices_of(points[order], radius), order) == simplices_of_set(name)


@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_sets_keep_their_shape_when_moved(name: str) -> None:
    """Rounding of a moved grid decides between diagonals, one by one: they must agree."""
    points, radius, characteristic = DEGENERATE[name]
    for seed in range(2):
        rotation = oracles.random_rotation(points.shape[1], np.random.default_rng(seed))
        simplices = simplices_of(points @ rotation.T + 0.1 * seed, radius)
        assert_closed(simplices)
        assert euler_characteristic(simplices) == characteristic


def test_coincident_points_are_one_vertex() -> None:
    """The first of them; the others are in no simplex."""
    distinct = oracles.uniform_cloud(40, 3, seed=7)
    of = np.r_[np.random.default_rng(8).integers(0, 40, 40), np.arange(40)]
    first = np.array([list(of).index(i) for i in range(40)])
    expected = renumbered(simplices_of(distinct, 0.3), first)
    found = simplices_of(distinct[of], 0.3)
    assert {s for s in found if len(s) > 1} == {s for s in expected if len(s) > 1}
