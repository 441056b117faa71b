"""Unions of bodies whose sizes differ: all three of them, and the complex of balls as unequal."""

from __future__ import annotations

from functools import cache
from itertools import combinations, product
from typing import Any

import numpy as np
import pytest

import oracles
import polyhedron_oracles as expect
from energies.cases import convex_body
from oracles import MEASURES, Array, assert_close
from pcsmooth import InvalidInputError, PolyhedronUnion, measure_balls, measure_polyhedra
from pcsmooth.energies.polyhedra.alpha_complex import find_simplices
from pcsmooth.kernels.threads import thread_limit
from polyhedron_oracles import RULES, Rule

every_rule = pytest.mark.parametrize("rule", RULES)
every_dimension = pytest.mark.parametrize("dimension", [2, 3])
every_shape = pytest.mark.parametrize("shape", [*expect.SHAPES[2], *expect.SHAPES[3]])

BOXES = {2: "square", 3: "cube"}

TOTALS = ("volume", "area")


def measure(points: Array, radii: Any, shape: str, rule: Rule = "exact") -> PolyhedronUnion:
    return measure_polyhedra(points, radii, convex_body(expect.solid(shape)), union=rule)


@cache
def scene(shape: str, n: int = 9, change: float = 0.6) -> tuple[Array, Array]:
    """Points of a `polyhedron_oracles.scene`, and radii of which the largest is the scene's."""
    made = expect.scene(shape, "cloud", n, seed=1)
    shares = 1 - change * np.random.default_rng(3).random(n)
    return made.points, made.radius * shares / shares.max()


# --- closed forms


@every_dimension
@pytest.mark.parametrize("arm", [(0.3, 0.5, -0.45), (1.1, -0.25, 0.7), (0.9, 1.4, 1.2)])
@pytest.mark.parametrize("sizes", [(1.0, 0.6), (0.7, 0.9), (1.0, 0.999)])
def test_two_boxes(sizes: tuple[float, float], arm: tuple[float, ...], dimension: int) -> None:
    """One is cut off at one side of each axis where its side sticks out, or spans the other."""
    points = np.array([np.zeros(dimension), arm[:dimension]]) + 0.1
    halves = np.array(sizes)[:, np.newaxis]
    union = measure(points, sizes, BOXES[dimension])
    faces = points[:, np.newaxis] + halves[:, np.newaxis] * np.array([[-1], [1]])
    low, high = faces[:, 0], faces[:, 1]
    sides = np.minimum(*high) - np.maximum(*low)
    whole = [(2 * s) ** dimension for s in sizes]
    rims = [2 * dimension * (2 * s) ** (dimension - 1) for s in sizes]
    shared = sides.prod() if (sides > 0).all() else 0.0
    ends = np.array([np.delete(sides, k).prod() for k in range(dimension)]) * (shared > 0)
    assert union.volume == pytest.approx(sum(whole) - shared, rel=1e-12)
    assert union.area == pytest.approx(sum(rims) - 2 * ends.sum(), rel=1e-12)
    # A facet of the one in the other takes part in the overlap, which grows and shrinks with it.
    inner = np.stack([low == np.maximum(*low), high == np.minimum(*high)])  # (side, body, axis)
    assert_close(union.visible_areas, rims - (inner.sum(axis=0) * ends).sum(axis=1), 1e-12)
    slopes = (inner[0].astype(float) - inner[1]) * ends
    assert_close(union.volume_gradient, slopes, 1e-12, max(rims))
    across = np.ones(dimension) * (shared > 0)
    if dimension == 3:
        across = (sides.sum() - sides) * (shared > 0)
    slopes = 2 * (inner[0].astype(float) - inner[1]) * across
    assert_close(union.area_gradient, slopes, 1e-12, 1.0)


@pytest.mark.parametrize("n", [2, 3, 8])
@pytest.mark.parametrize("shape", ["triangle", "tetrahedron"])
def test_simplices(shape: str, n: int) -> None:
    """Homothetic simplices meet in a smaller one: all is known, gradients too."""
    points, radii = scene(shape)
    union = measure(points[:n], radii[:n], shape)
    expected, area_gradient = expect.simplex_union(points[:n], radii[:n], expect.solid(shape))
    expect.assert_union(union, expected, 1e-12)
    assert_close(union.area_gradient, area_gradient, 1e-12, radii.max())


@every_dimension
def test_body_inside_another_is_no_part_of_the_exact_union(dimension: int) -> None:
    points = np.zeros((2, dimension))
    for place in (np.zeros(dimension), np.full(dimension, 0.3), np.full(dimension, 0.5)):
        points[0] = place  # at 0.5 they share corners and parts of facets
        union = measure(points, [0.5, 1.0], BOXES[dimension])
        alone = measure(points[1:], 1.0, BOXES[dimension])
        assert not union.rows[0].any()
        for name in ("volume_shares", "visible_areas", "volume_gradient", "area_gradient"):
            assert_close(getattr(union, name)[1], getattr(alone, name)[0], 1e-14, 1.0)


@every_rule
@every_dimension
@pytest.mark.parametrize("distance", [0.0, 0.01, 0.2])
def test_body_in_the_middle_of_another_is_no_part_of_any_union(
    dimension: int, rule: Rule, distance: float
) -> None:
    """Of the power cell of its ball nothing is left."""
    points = np.zeros((2, dimension))
    points[0, 0] = distance
    union = measure(points, [0.25, 1.0], BOXES[dimension], rule)
    assert not union.rows[0].any()
    assert union.cell_volumes[0] == 0
    assert union.volume == pytest.approx(2.0**dimension, rel=1e-14)
    assert union.area == pytest.approx(2 * dimension * 2.0 ** (dimension - 1), rel=1e-14)


@every_rule
@every_dimension
def test_body_hidden_by_several(dimension: int, rule: Rule) -> None:
    around = np.r_[np.eye(dimension), -np.eye(dimension)]
    points = np.r_[np.full((1, dimension), 0.02), around]
    union = measure(points, np.r_[0.3, np.full(2 * dimension, 1.4)], BOXES[dimension], rule)
    assert not union.rows[0].any()
    assert_close(union.volume_gradient.sum(axis=0), 0, 1e-13, union.area)


# --- other computations


@every_dimension
@pytest.mark.parametrize("n", [5, 20, 60])
def test_random_boxes(n: int, dimension: int) -> None:
    for seed, change in product(range(3), (0.1, 0.9)):
        points = oracles.uniform_cloud(n, dimension, seed)
        radii = 0.7 * n ** (-1 / dimension) * (1 - change * np.random.default_rng(seed).random(n))
        union = measure(points, radii, BOXES[dimension])
        expect.assert_union(union, expect.box_union(points, radii), 1e-12)


@every_dimension
def test_sizes_may_differ_a_hundredfold(dimension: int) -> None:
    rng = np.random.default_rng(5)
    radii = 10 ** (2 * rng.random(150) - 2.5)
    points = 2 * rng.random((150, dimension))
    union = measure(points, radii, BOXES[dimension])
    expect.assert_union(union, expect.box_union(points, radii), 1e-12)


@pytest.mark.parametrize("seed", range(8))
@every_dimension
def test_boxes_in_all_ties(dimension: int, seed: int) -> None:
    """Facets of several bodies in one plane, from the same side and from both."""
    rng = np.random.default_rng(seed)
    points = rng.integers(0, 7, (30, dimension)) / 4
    radii = rng.choice([0.25, 0.5, 0.75], 30)
    union = measure(points, radii, BOXES[dimension])
    expected = expect.box_union(points, radii)
    expect.assert_totals(union, expected, 1e-13)
    assert_close(union.volume_gradient.sum(axis=0), 0, 1e-13, union.area)
    turn = oracles.random_rotation(dimension, rng)
    body = convex_body(expect.rotated(expect.solid(BOXES[dimension]), turn))
    turned = measure_polyhedra(points @ turn.T, radii, body)
    assert turned.volume == pytest.approx(expected.volume, rel=1e-12)


@pytest.mark.parametrize("n", [8, 20])
@pytest.mark.parametrize("shape", expect.SHAPES[2])
def test_polygons(shape: str, n: int) -> None:
    points, radii = scene(shape, n)
    expected = expect.polygon_union(points, radii, expect.solid(shape))
    expect.assert_union(measure(points, radii, shape), expected, 1e-12)


@pytest.mark.parametrize("shape", expect.SHAPES[3])
def test_whole_nerve(shape: str) -> None:
    points, radii = (values[:7] for values in scene(shape))
    expected = expect.sum_over_simplices(points, radii, expect.solid(shape))
    expect.assert_union(measure(points, radii, shape), expected, 1e-10)


@every_shape
def test_naive_union_is_the_sum_of_cells(shape: str) -> None:
    points, radii = scene(shape)
    volumes, areas = expect.naive_cells(points, radii, expect.solid(shape))
    union = measure(points, radii, shape, "naive")
    assert_close(union.volume_shares, volumes, 1e-11)
    assert_close(union.visible_areas, areas, 1e-11)
    for rule in RULES:
        assert_close(measure(points, radii, shape, rule).cell_volumes, volumes, 1e-11)


@every_dimension
def test_naive_union_of_bodies_that_lie_outside_their_cells(dimension: int) -> None:
    points = oracles.uniform_cloud(60, dimension)
    radii = 0.3 * (1 - 0.6 * np.random.default_rng(2).random(60))
    powers = ((points[:, np.newaxis] - points) ** 2).sum(axis=2) - radii**2
    assert np.count_nonzero(powers.argmin(axis=1) != np.arange(60)) > 10
    union = measure(points, radii, BOXES[dimension], "naive")
    volumes, areas = expect.naive_cells(points, radii, expect.solid(BOXES[dimension]))
    assert_close(union.volume_shares, volumes, 1e-11)
    assert_close(union.visible_areas, areas, 1e-11)


def test_visible_body_without_a_cell_rests() -> None:
    """Its stiffness is infinite; that of the others is not."""
    points = oracles.uniform_cloud(60, 3, seed=5)
    radii = 0.3 * (1 - 0.7 * np.random.default_rng(5).random(60))
    union = measure(points, radii, "cube")
    alone = (union.cell_volumes == 0) & (union.visible_areas > 0)
    assert np.count_nonzero(alone) == 1
    assert union.volume_gradient[alone].any()
    for stiffness in (union.volume_diagonal, union.area_diagonal):
        np.testing.assert_array_equal(np.isinf(stiffness), alone)
        assert not np.isnan(stiffness).any()


@pytest.mark.parametrize("shape", ["hexagon", "lopsided polygon", "cube", "lopsided polyhedron"])
def test_naive_union_lies_between_that_of_the_balls_inside_and_the_exact_one(shape: str) -> None:
    points, radii = scene(shape, 20)
    inside = measure_balls(points, radii * expect.solid(shape).offsets.min())
    union, exact = (measure(points, radii, shape, rule) for rule in ("naive", "exact"))
    assert inside.volume < union.volume < exact.volume


@every_shape
def test_inclusion_exclusion_over_the_complex(shape: str) -> None:
    points, radii = scene(shape)
    simplices = expect.alpha_complex(points, radii)
    expected = expect.sum_over_simplices(points, radii, expect.solid(shape), simplices)
    expect.assert_union(measure(points, radii, shape, "inclusion-exclusion"), expected, 1e-11)


# --- the complex


def simplices_of(points: Array, radii: Array) -> set[expect.Simplex]:
    """Edges, triangles and tetrahedra; of which points are vertices nothing is said."""
    return {tuple(row) for rows in find_simplices(points, radii) for row in rows.tolist()}


def without_vertices(simplices: set[expect.Simplex]) -> set[expect.Simplex]:
    return {simplex for simplex in simplices if len(simplex) > 1}


@pytest.mark.parametrize("largest", [0.8, 1.5, 3.0])
@pytest.mark.parametrize("change", [0.1, 0.7, 0.95])
@every_dimension
def test_complex_is_that_of_gudhi(dimension: int, change: float, largest: float) -> None:
    n = 150
    points = oracles.uniform_cloud(n, dimension, seed=4)
    radii = largest * n ** (-1 / dimension)
    radii = radii * (1 - change * np.random.default_rng(5).random(n))
    expected = expect.gudhi_alpha_complex(points, radii)
    assert simplices_of(points, radii) == without_vertices(expected)


@every_dimension
def test_complex_is_that_of_orthogonal_spheres(dimension: int) -> None:
    for seed, largest in product(range(3), (0.2, 0.4, 0.8)):
        points = oracles.uniform_cloud(12, dimension, seed)
        radii = largest * (1 - 0.6 * np.random.default_rng(seed).random(12))
        expected = expect.alpha_complex(points, radii)
        assert simplices_of(points, radii) == without_vertices(expected)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("counts", [(6, 5), (4, 3, 3), (4, 1, 5)])
def test_complex_of_a_grid_in_ties(counts: tuple[int, ...], seed: int) -> None:
    """It has every face of what it has, and is the same in every order."""
    rng = np.random.default_rng(seed)
    points = oracles.lattice(*counts)
    radii = np.sqrt(rng.choice([0.5, 1.0, 1.5, 2.0], len(points)))
    simplices = simplices_of(points, radii)
    for simplex in simplices:
        faces = set(combinations(simplex, len(simplex) - 1))
        assert len(simplex) == 2 or faces <= simplices
    order = rng.permutation(len(points))
    found = simplices_of(points[order], radii[order])
    assert {tuple(sorted(order[list(simplex)].tolist())) for simplex in found} == simplices


# --- gradients and identities


@every_rule
@every_shape
def test_gradients_are_derivatives_at_fixed_radii(shape: str, rule: Rule) -> None:
    points, radii = scene(shape, 15)
    union = measure(points, radii, shape, rule)
    for direction in expect.probes(points, 2):
        slopes = expect.slopes(
            lambda moved: [getattr(measure(moved, radii, shape, rule), q) for q in TOTALS],
            points, direction, 1e-5 * radii.min(),
        )  # fmt: skip
        gradients = union.volume_gradient, union.area_gradient
        for slope, gradient in zip(slopes, gradients, strict=True):
            derivative = float((gradient * direction).sum())
            assert slope == pytest.approx(derivative, rel=0, abs=3e-7 * abs(gradient).max())


@every_rule
@every_shape
def test_sizes_and_places_make_up_the_whole(shape: str, rule: Rule) -> None:
    """Euler: p . gradient + r . dV/dr = d V, and with d - 1 for the area; no motion does work."""
    points, radii = scene(shape, 15)
    union = measure(points, radii, shape, rule)
    growth = expect.slopes(
        lambda factor: [
            getattr(measure(points, radii * factor[0, 0], shape, rule), q) for q in TOTALS
        ],
        np.ones((1, 1)), np.ones((1, 1)), 1e-5,
    )  # fmt: skip
    d = points.shape[1]
    for q, name in enumerate(TOTALS):
        gradient, total = getattr(union, f"{name}_gradient"), getattr(union, name)
        virial = float((points * gradient).sum())
        assert virial + growth[q] == pytest.approx((d - q) * total, rel=1e-8)
        assert_close(gradient.sum(axis=0), 0, 1e-12, abs(gradient).max())
    offsets = expect.solid(shape).offsets
    if rule == "exact" and np.ptp(offsets) == 0:  # the boundary moves outwards as the radii do
        virial = float((points * union.volume_gradient).sum())
        grown = offsets[0] * float(radii @ union.visible_areas)
        assert virial + grown == pytest.approx(d * union.volume, rel=1e-12)


@pytest.mark.parametrize("shape", ["square", "hexagon", "cube", "icosahedron", "sphere"])
def test_volume_grows_with_a_size_by_what_is_visible(shape: str) -> None:
    points, radii = scene(shape, 15)
    union, step = measure(points, radii, shape), 1e-5 * radii.min()
    for i in range(0, 15, 3):
        less, more = radii.copy(), radii.copy()
        less[i] -= step
        more[i] += step
        growth = measure(points, more, shape).volume - measure(points, less, shape).volume
        assert_close(growth / (2 * step), union.visible_areas[i], 1e-8, union.visible_areas.max())


# --- what is given, and how


@every_rule
@every_dimension
def test_equal_radii_are_a_radius(dimension: int, rule: Rule) -> None:
    points = oracles.uniform_cloud(80, dimension)
    union = measure(points, np.full(80, 0.2), BOXES[dimension], rule)
    assert union.radii is None
    alone = measure(points, 0.2, BOXES[dimension], rule)
    for name in (*MEASURES, "volume_diagonal", "area_diagonal"):
        assert getattr(union, name).tobytes() == getattr(alone, name).tobytes()


@every_rule
@every_dimension
def test_nearly_equal_radii_have_nearly_the_same_measures(dimension: int, rule: Rule) -> None:
    shape = {2: "lopsided polygon", 3: "lopsided polyhedron"}[dimension]
    points, radii = scene(shape, 15)
    largest = radii.max()
    nearly = largest * (1 - 1e-13 * np.random.default_rng(6).random(15))
    union, equal = measure(points, nearly, shape, rule), measure(points, largest, shape, rule)
    for name in MEASURES:
        size = largest ** (dimension + oracles.POWERS[name])
        assert_close(getattr(union, name), getattr(equal, name), 1e-11, size)


@pytest.mark.parametrize("rule", ["naive", "exact"])  # the third depends on the radii alone, too
@every_dimension
def test_size_of_the_body_is_that_of_the_radii(dimension: int, rule: Rule) -> None:
    shape = {2: "lopsided polygon", 3: "lopsided polyhedron"}[dimension]
    points, radii = scene(shape, 15)
    solid = expect.solid(shape)
    larger = convex_body(expect.Solid(solid.normals, 2 * solid.offsets))
    union = measure_polyhedra(points, radii / 2, larger, union=rule)
    for name in MEASURES:
        expected = measure(points, radii, shape, rule)
        assert_close(getattr(union, name), getattr(expected, name), 1e-12)


@every_rule
@every_dimension
def test_largest_of_coincident_bodies_counts(dimension: int, rule: Rule) -> None:
    points, radii = scene(BOXES[dimension], 20)
    rng = np.random.default_rng(6)
    of = rng.permutation(np.r_[np.arange(20), rng.integers(0, 20, 20)])
    scale = rng.choice([0.5, 0.9, 1.0], len(of))
    scale[[np.flatnonzero(of == i)[-1] for i in range(20)]] = 1.0
    union = measure(points[of], radii[of] * scale, BOXES[dimension], rule)
    carriers = [np.flatnonzero((of == i) & (scale == 1.0))[0] for i in range(20)]
    np.testing.assert_array_equal(union.carriers, np.array(carriers)[of])
    others = np.setdiff1d(np.arange(len(of)), carriers)
    for name in MEASURES:
        values, expected = getattr(union, name), measure(points, radii, BOXES[dimension], rule)
        assert_close(values[carriers], getattr(expected, name), 1e-12)
        assert not values[others].any()


@every_rule
@every_dimension
def test_threads_units_and_order_change_nothing(dimension: int, rule: Rule) -> None:
    points = 2 * oracles.uniform_cloud(500, dimension) * [200.0, *[1.0] * (dimension - 1)]
    radii = np.random.default_rng(7).uniform(0.3, 2.0, 500)
    found = []
    for threads in (1, 2):
        with thread_limit(threads):
            found.append(measure(points, radii, BOXES[dimension], rule))
    assert found[0].rows.tobytes() == found[1].rows.tobytes()
    scaled = measure(np.ldexp(points, 300), np.ldexp(radii, 300), BOXES[dimension], rule)
    areas = np.ldexp(scaled.visible_areas, -300 * (dimension - 1))
    np.testing.assert_array_equal(areas, found[0].visible_areas)
    order = np.random.default_rng(8).permutation(500)
    shuffled = measure(points[order], radii[order], BOXES[dimension], rule)
    for name in MEASURES:
        assert_close(getattr(shuffled, name), getattr(found[0], name)[order], 1e-12)


@every_rule
@pytest.mark.parametrize(
    ("radii", "message"),
    [
        ([1.0, 2.0], r"radii have shape \(2,\); there must be one for all points, or 3"),
        ([1.0, 0.0, 3.0], "the radius of point 1 is 0.0; it must be finite and positive"),
        ([1.0, np.inf, 1.0], "the radius of point 1 is inf"),
    ],
)
def test_radii_that_are_none_are_refused(radii: Any, message: str, rule: Rule) -> None:
    with pytest.raises(InvalidInputError, match=message):
        measure(np.eye(3), radii, "cube", rule)
    with pytest.raises(InvalidInputError, match=message):
        find_simplices(np.eye(3), radii)
