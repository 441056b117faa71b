"""What holds for all three unions: gradients, motions, order, scale, flat clouds."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

import oracles
import polyhedron_oracles as expect
from oracles import assert_close
from pcsmooth import ConvexBody, measure_polyhedra
from polyhedron_oracles import RULES, Rule

#: (shape, kind of cloud, number of points): general position.
SCENES = [
    ("square", "cloud", 25),
    ("hexagon", "cap", 18),
    ("lopsided polygon", "cloud", 20),
    ("cube", "cloud", 20),
    ("tetrahedron", "cap", 20),
    ("icosahedron", "cap", 16),
    ("sphere", "cloud", 12),
    ("lopsided polyhedron", "cloud", 16),
]


def body_of(shape: str) -> ConvexBody:
    solid = expect.solid(shape)
    return ConvexBody(solid.normals, solid.offsets)


@cache
def union_of(shape: str, kind: str, n: int, rule: Rule) -> expect.Measured:
    scene = expect.scene(shape, kind, n)
    return measure_polyhedra(scene.points, scene.radius, body_of(shape), union=rule)


def totals(radius: float, body: ConvexBody, rule: Rule) -> Callable[[oracles.Array], list[float]]:
    """Volume and area as a function of the points."""

    def measure(points: oracles.Array) -> list[float]:
        union = measure_polyhedra(points, radius, body, union=rule)
        return [union.volume, union.area]

    return measure


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(("shape", "kind", "n"), SCENES)
def test_gradients_are_derivatives(shape: str, kind: str, n: int, rule: Rule) -> None:
    scene, union = expect.scene(shape, kind, n), union_of(shape, kind, n, rule)
    # facets are more than 10 steps from passing each other; rounding leaves 1e-10
    for direction in expect.probes(scene.points, 6):
        slopes = expect.slopes(
            totals(scene.radius, body_of(shape), rule),
            scene.points,
            direction,
            1e-5 * scene.radius,
        )
        for slope, gradient in zip(
            slopes, (union.volume_gradient, union.area_gradient), strict=True
        ):
            derivative = float((gradient * direction).sum())
            assert slope == pytest.approx(derivative, rel=0, abs=1e-6 * abs(gradient).max())


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(("shape", "kind", "n"), SCENES)
def test_totals_are_sums_and_gradients_add_up_to_zero(
    shape: str, kind: str, n: int, rule: Rule
) -> None:
    union = union_of(shape, kind, n, rule)
    assert union.area == pytest.approx(union.visible_areas.sum(), rel=1e-13)
    for gradient in (union.volume_gradient, union.area_gradient):
        assert_close(gradient.sum(axis=0), 0, 1e-12, abs(gradient).max())
    if rule == "naive":
        assert union.volume == pytest.approx(union.cell_volumes.sum(), rel=1e-13)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(("shape", "kind", "n"), SCENES)
def test_cell_volumes_are_those_of_the_naive_union(
    shape: str, kind: str, n: int, rule: Rule
) -> None:
    actual, naive = union_of(shape, kind, n, rule), union_of(shape, kind, n, "naive")
    assert_close(actual.cell_volumes, naive.cell_volumes, 1e-12)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(
    ("shape", "kind", "n"), [s for s in SCENES if np.ptp(expect.solid(s[0]).offsets) == 0]
)
def test_volume_is_homogeneous(shape: str, kind: str, n: int, rule: Rule) -> None:
    """Where all facets are as far from the centre, dV/dr is the area times that distance."""
    scene, union = expect.scene(shape, kind, n), union_of(shape, kind, n, rule)
    virial = float((scene.points * union.volume_gradient).sum())
    growth = float(scene.radius * scene.body.offsets[0] * union.area)
    expected = scene.points.shape[1] * union.volume
    assert virial + growth == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("shape", ["lopsided polygon", "lopsided polyhedron"])
def test_measures_are_homogeneous(shape: str, rule: Rule) -> None:
    kind, n = next((s[1], s[2]) for s in SCENES if s[0] == shape)
    scene, union = expect.scene(shape, kind, n), union_of(shape, kind, n, rule)
    grown = expect.slopes(  # the radius as a cloud of one coordinate
        lambda radius: totals(float(radius[0, 0]), body_of(shape), rule)(scene.points),
        np.array([[scene.radius]]),
        np.ones((1, 1)),
        1e-5 * scene.radius,
    )
    dimension = scene.points.shape[1]
    for power, value, gradient, growth in (
        (dimension, union.volume, union.volume_gradient, grown[0]),
        (dimension - 1, union.area, union.area_gradient, grown[1]),
    ):
        virial = float((scene.points * gradient).sum())
        assert virial + scene.radius * growth == pytest.approx(power * value, rel=1e-8)


# --- motions, scale, order


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(("shape", "kind", "n"), SCENES)
def test_moving_points_and_body_changes_nothing(shape: str, kind: str, n: int, rule: Rule) -> None:
    scene = expect.scene(shape, kind, n)
    dimension = scene.points.shape[1]
    rotation = oracles.random_rotation(dimension, np.random.default_rng(3))
    moved = measure_polyhedra(
        scene.points @ rotation.T + np.arange(1, dimension + 1),
        scene.radius,
        ConvexBody(scene.body.normals @ rotation.T, scene.body.offsets),
        union=rule,
    )
    # moving rounds the coordinates to 1e-15 of lengths that are tenths of the radius
    expected = union_of(shape, kind, n, rule)
    expect.assert_same_measures(moved, expected, 1e-11, rotation=rotation)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("factor", [1e-4, 3.7, 2.0**40])
@pytest.mark.parametrize(("shape", "kind", "n"), SCENES[2:4] + SCENES[5:6])
def test_scale(shape: str, kind: str, n: int, factor: float, rule: Rule) -> None:
    scene = expect.scene(shape, kind, n)
    scaled = measure_polyhedra(
        factor * scene.points, factor * scene.radius, body_of(shape), union=rule
    )
    expect.assert_same_measures(scaled, union_of(shape, kind, n, rule), 1e-11, factor=factor)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("shape", ["hexagon", "icosahedron"])
def test_size_of_the_body_is_that_of_the_radius_but_for_the_complex(shape: str, rule: Rule) -> None:
    kind, n = next((s[1], s[2]) for s in SCENES if s[0] == shape)
    scene = expect.scene(shape, kind, n)
    body = ConvexBody(scene.body.normals, 2 * scene.body.offsets)
    union = measure_polyhedra(scene.points, scene.radius / 2, body, union=rule)
    if rule == "inclusion-exclusion":
        simplices = expect.alpha_complex(scene.points, scene.radius / 2)
        expected = expect.sum_over_simplices(scene.points, scene.radius, scene.body, simplices)
        expect.assert_union(union, expected, 1e-11)
    else:
        expect.assert_same_measures(union, union_of(shape, kind, n, rule), 1e-12)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(("shape", "kind", "n"), SCENES)
def test_order_of_points_does_not_matter(shape: str, kind: str, n: int, rule: Rule) -> None:
    scene = expect.scene(shape, kind, n)
    order = np.random.default_rng(4).permutation(n)
    shuffled = measure_polyhedra(scene.points[order], scene.radius, body_of(shape), union=rule)
    expect.assert_same_measures(shuffled, union_of(shape, kind, n, rule), 1e-12, order=order)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("shape", ["lopsided polygon", "lopsided polyhedron"])
def test_order_of_facets_does_not_matter(shape: str, rule: Rule) -> None:
    kind, n = next((s[1], s[2]) for s in SCENES if s[0] == shape)
    scene = expect.scene(shape, kind, n)
    order = np.random.default_rng(5).permutation(len(scene.body.offsets))
    body = ConvexBody(scene.body.normals[order], scene.body.offsets[order])
    union = measure_polyhedra(scene.points, scene.radius, body, union=rule)
    expect.assert_same_measures(union, union_of(shape, kind, n, rule), 1e-12)


# --- few points, far points, coincident points


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("radius", [1e-3, 1.0, 7.5])
@pytest.mark.parametrize("shape", [*expect.SHAPES[2], *expect.SHAPES[3]])
def test_one_body(shape: str, radius: float, rule: Rule) -> None:
    body = body_of(shape)
    union = measure_polyhedra(np.full((1, body.dimension), 3.0), radius, body, union=rule)
    # twelve digits of 3.0 are left to a body of size 1e-3
    whole = expect.measure_body(body)
    volume = whole.volume * radius**body.dimension
    area = whole.facet_areas.sum() * radius ** (body.dimension - 1)
    assert union.volume == pytest.approx(volume, rel=1e-12, abs=0)
    assert union.cell_volumes[0] == pytest.approx(volume, rel=1e-12, abs=0)
    assert union.area == pytest.approx(area, rel=1e-12, abs=0)
    assert union.visible_areas[0] == pytest.approx(area, rel=1e-12, abs=0)
    assert_close(union.volume_gradient, 0, 1e-12, area)
    assert_close(union.area_gradient, 0, 1e-12, area / radius)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(("shape", "kind", "n"), SCENES[2:4] + SCENES[4:5])
def test_far_parts_are_measured_as_if_alone(shape: str, kind: str, n: int, rule: Rule) -> None:
    scene, alone = expect.scene(shape, kind, n), union_of(shape, kind, n, rule)
    away = 100.0 * np.arange(1, scene.points.shape[1] + 1)
    both = measure_polyhedra(
        np.concatenate([scene.points, scene.points + away]),
        scene.radius,
        body_of(shape),
        union=rule,
    )
    for name in expect.UNITS:
        for part in (slice(0, n), slice(n, None)):
            assert_close(getattr(both, name)[part], getattr(alone, name), 1e-10)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(("shape", "kind", "n"), SCENES)
def test_first_of_coincident_points_carries_the_body(
    shape: str, kind: str, n: int, rule: Rule
) -> None:
    scene = expect.scene(shape, kind, n)
    of = np.r_[np.random.default_rng(5).integers(0, n, n), np.arange(n)]
    union = measure_polyhedra(scene.points[of], scene.radius, body_of(shape), union=rule)
    first = np.array([list(of).index(i) for i in range(n)])
    others = np.setdiff1d(np.arange(len(of)), first)
    distinct = union_of(shape, kind, n, rule)
    assert union.volume == pytest.approx(distinct.volume, rel=1e-12)
    assert union.area == pytest.approx(distinct.area, rel=1e-12)
    for name in expect.UNITS:
        assert not getattr(union, name)[others].any()
        assert_close(getattr(union, name)[first], getattr(distinct, name), 1e-12)


# --- flat clouds


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("seed", range(3))
def test_cubes_in_a_plane_are_prisms_over_squares(seed: int, rule: Rule) -> None:
    """Heights, sides and the two ends: each body's measures follow from those in the plane."""
    scene = expect.scene("square", "cloud", 20, seed)
    flat = measure_polyhedra(scene.points, scene.radius, body_of("square"), union=rule)
    for axis in range(3):
        union = measure_polyhedra(
            np.insert(scene.points, axis, 0.3, axis=1), scene.radius, body_of("cube"), union=rule
        )
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


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("shape", ["square", "cube"])
def test_row_of_cubes(shape: str, rule: Rule) -> None:
    body = body_of(shape)
    places = np.array([0.0, 0.3, 0.9, 1.3, 3.6, 4.5, 7.0])  # gaps of 2.3 and 2.5
    points = np.zeros((len(places), body.dimension))
    points[:, -1] = places
    union = measure_polyhedra(points, 1.0, body, union=rule)
    length = (1.3 + 2) + (0.9 + 2) + 2
    face = 2.0 ** (body.dimension - 1)
    rim = {2: 2.0, 3: 8.0}[body.dimension]
    assert union.volume == pytest.approx(face * length, rel=1e-13)
    assert union.area == pytest.approx(rim * length + 3 * 2 * face, rel=1e-13)
    lengths = [1.15, 0.45, 0.5, 1.2, 1.45, 1.45, 2]
    assert_close(union.cell_volumes, face * np.array(lengths), 1e-13)
    ends = face * np.array([-1, 0, 0, 1, -1, 1, 0])
    assert_close(union.volume_gradient[:, -1], ends, 1e-12)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("shape", ["hexagon", "lopsided polygon", "icosahedron", "sphere"])
def test_row_of_bodies(shape: str, rule: Rule) -> None:
    """On a line the unions differ, but for inclusion-exclusion of neighbours alone."""
    body = body_of(shape)
    direction = np.array([0.31, 0.83, -0.47])[: body.dimension]
    direction /= np.linalg.norm(direction)
    points = np.outer([0.0, 0.35, 0.8, 1.2, 1.9], direction)
    union = measure_polyhedra(points, 1.0, body, union=rule)
    if rule == "naive":
        volumes, areas = expect.naive_cells(points, 1.0, body)
        assert_close(union.cell_volumes, volumes, 1e-11)
        assert_close(union.visible_areas, areas, 1e-11)
        return
    pairs = [(i, i + 1) for i in range(4)]
    simplices = None if rule == "exact" else [*((i,) for i in range(5)), *pairs]
    expected = expect.sum_over_simplices(points, 1.0, body, simplices)
    expect.assert_union(union, expected, 1e-11)


@pytest.mark.parametrize("rule", RULES)
def test_bodies_far_from_the_origin(rule: Rule) -> None:
    """Map coordinates: what is measured depends on differences of coordinates alone."""
    scene = expect.scene("cube", "cloud", 20)
    moved = scene.points + np.array([5e5, 4.2e6, 1e6])
    back = moved - np.array([5e5, 4.2e6, 1e6])
    far = measure_polyhedra(moved, scene.radius, body_of("cube"), union=rule)
    near = measure_polyhedra(back, scene.radius, body_of("cube"), union=rule)
    expect.assert_same_measures(far, near, 1e-11)
