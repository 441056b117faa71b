from __future__ import annotations

from functools import cache
from typing import get_args

import numpy as np
import numpy.typing as npt
import pytest

import oracles
from oracles import (
    assert_close,
    assert_identities,
    assert_positive_tensors,
    assert_same_measures,
    scale_of,
)
from pcsmooth.energies.balls import BallEnergy, BallUnion, measure_balls
from pcsmooth.energies.protocol import Quantity, Weight
from pcsmooth.errors import InvalidInputError

#: (what, dimension, radius in spacings) of the random clouds.
CLOUDS = [
    (kind, dimension, spacings)
    for kind in ("cube", "surface")
    for dimension in (2, 3)
    for spacings in (1.5, 2.5, 4.0)
]

TRIANGLES = {
    "equilateral": np.array([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(0.75), 0]]),
    "acute": np.array([[0, 0, 0], [1.1, 0, 0.2], [0.4, 0.8, -0.1]]),
    "obtuse": np.array([[0, 0, 0], [1.5, 0, 0], [0.7, 0.3, 0.2]]),
}


@cache
def cloud(kind: str, dimension: int, spacings: float, n: int = 200) -> tuple[oracles.Array, float]:
    """Random points and a radius that is a multiple of their spacing."""
    if kind == "cube":
        return oracles.uniform_cloud(n, dimension), spacings * n ** (-1 / dimension)
    size = oracles.sphere_area(1.0, dimension)
    spacing = size / n if dimension == 2 else np.sqrt(size / n)
    noise = 1 + 0.3 * spacing * np.random.default_rng(1).normal(size=(n, 1))
    return noise * oracles.random_sphere(n, dimension=dimension), spacings * spacing


@cache
def union_of(kind: str, dimension: int, spacings: float) -> BallUnion:
    return measure_balls(*cloud(kind, dimension, spacings))


# --- closed forms


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("radius", [1e-3, 1.0, 7.5])
def test_one_ball(dimension: int, radius: float) -> None:
    union = measure_balls(np.full((1, dimension), 3.0), radius)
    area = oracles.sphere_area(radius, dimension)
    assert union.volume == pytest.approx(oracles.ball_volume(radius, dimension), rel=1e-15, abs=0)
    assert union.area == pytest.approx(area, rel=1e-15, abs=0)
    assert not union.volume_gradient.any()
    assert not union.area_gradient.any()
    assert_close(union.normal_tensors[0], area / dimension * np.eye(dimension), 1e-15)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("distance", [1e-3, 0.3, 1.0, 1.7, 1.999])
def test_two_balls(dimension: int, distance: float) -> None:
    points = np.zeros((2, dimension))
    points[1, :2] = distance * np.array([0.6, 0.8])
    union, expected = measure_balls(points, 1.0), oracles.two_balls(points, 1.0)
    for name in oracles.MEASURES:
        assert_close(getattr(union, name), getattr(expected, name), 1e-12)


@pytest.mark.parametrize("distance", [0.3, 1.0, 1.7])
def test_volume_and_area_of_two_balls(distance: float) -> None:
    union = measure_balls(np.array([[0, 0, 0], [0, 0, distance]]), 1.0)
    lens = np.pi * (4 + distance) * (2 - distance) ** 2 / 12
    assert union.volume == pytest.approx(8 * np.pi / 3 - lens, rel=1e-14)
    assert union.area == pytest.approx(4 * np.pi + 2 * np.pi * distance, rel=1e-14)


@pytest.mark.parametrize("distance", [0.3, 1.0, 1.7])
def test_normal_tensor_of_two_balls(distance: float) -> None:
    union = measure_balls(np.array([[0, 0, 0], [distance, 0, 0]]), 1.0)
    for tensor in union.normal_tensors:
        assert_close(tensor, oracles.lens_tensor(1.0, distance), 1e-12)


@pytest.mark.parametrize("triangle", TRIANGLES)
def test_three_balls(triangle: str) -> None:
    points = TRIANGLES[triangle]
    union, expected = measure_balls(points, 1.0), oracles.three_balls(points, 1.0)
    for name in oracles.MEASURES:
        assert_close(getattr(union, name), getattr(expected, name), 1e-12)
    volume, area = oracles.three_ball_totals(points, 1.0)
    assert union.volume == pytest.approx(volume, rel=1e-12)
    assert union.area == pytest.approx(area, rel=1e-12)


@pytest.mark.parametrize("triangle", ["equilateral", "acute"])
def test_three_disks(triangle: str) -> None:
    points = TRIANGLES[triangle][:, :2]
    union, expected = measure_balls(points, 1.0), oracles.three_disks(points, 1.0)
    for name in oracles.MEASURES:
        assert_close(getattr(union, name), getattr(expected, name), 1e-12)


# --- gradients and measures of random clouds


@pytest.mark.parametrize("quantity", ["volume", "area"])
@pytest.mark.parametrize(("kind", "dimension", "spacings"), CLOUDS)
def test_gradient_is_the_derivative(
    kind: str, dimension: int, spacings: float, quantity: str
) -> None:
    points, radius = cloud(kind, dimension, spacings)
    gradient = getattr(union_of(kind, dimension, spacings), f"{quantity}_gradient")
    rng = np.random.default_rng(2)
    directions = [rng.normal(size=points.shape)]
    for i in rng.permutation(len(points))[:10]:
        directions.append(np.zeros_like(points))
        directions[-1][i] = rng.normal(size=dimension)
    for direction in directions:
        direction /= np.linalg.norm(direction)
        slope = oracles.directional_difference(
            lambda moved: float(getattr(measure_balls(moved, radius), quantity)),
            points,
            direction,
            1e-5 * radius,
        )
        assert slope == pytest.approx((gradient * direction).sum(), abs=3e-8 * abs(gradient).max())


@pytest.mark.parametrize(("kind", "dimension", "spacings"), CLOUDS)
def test_measures_agree_with_quadrature(kind: str, dimension: int, spacings: float) -> None:
    points, radius = cloud(kind, dimension, spacings, 100)
    union = measure_balls(points, radius)
    visible = np.flatnonzero(union.visible_areas > 0)
    for i in visible[:: -(-len(visible) // (2 if spacings < 4 else 1))]:
        arms = np.delete(points, i, axis=0) - points[i]
        distances = np.linalg.norm(arms, axis=1)
        arms, distances = arms[distances < 2 * radius], distances[distances < 2 * radius]
        area, flux, tensor = oracles.moments_on_sphere(arms, radius)
        facets, rims = oracles.facet_areas(arms, radius), oracles.rim_weights(arms, radius)
        expected = {
            "cell_volumes": (radius * area + facets @ distances / 2) / dimension,
            "visible_areas": area,
            "volume_gradient": flux,  # the integral of n over the visible boundary: Prop. 5
            "area_gradient": -(rims / distances) @ arms,
            "normal_tensors": tensor,
            "volume_diagonal": (facets / distances).sum(),
            "area_diagonal": (rims / distances).sum(),
        }
        for name, value in expected.items():
            assert_close(getattr(union, name)[i], value, 3e-10, scale_of(name, union))


@pytest.mark.parametrize(("kind", "dimension", "spacings"), CLOUDS)
def test_cells_grow_by_their_visible_boundary(kind: str, dimension: int, spacings: float) -> None:
    points, radius = cloud(kind, dimension, spacings)
    step = 1e-5 * radius
    larger, smaller = measure_balls(points, radius + step), measure_balls(points, radius - step)
    growth = (larger.cell_volumes - smaller.cell_volumes) / (2 * step)
    areas = union_of(kind, dimension, spacings).visible_areas
    # the step leaves 1e-10 of truncation, rounding over the step 1e-11
    assert_close(growth, areas, 1e-9, scale_of("visible_areas", larger))


@pytest.mark.parametrize(("kind", "dimension", "spacings"), CLOUDS)
def test_identities(kind: str, dimension: int, spacings: float) -> None:
    union = union_of(kind, dimension, spacings)
    assert_identities(cloud(kind, dimension, spacings)[0], union, 1e-13)
    assert_positive_tensors(union, 1e-13)


@pytest.mark.parametrize(("kind", "dimension", "spacings"), CLOUDS)
def test_area_is_homogeneous(kind: str, dimension: int, spacings: float) -> None:
    points, radius = cloud(kind, dimension, spacings)
    union = union_of(kind, dimension, spacings)
    step = 1e-5 * radius
    larger, smaller = measure_balls(points, radius + step), measure_balls(points, radius - step)
    growth = (larger.area - smaller.area) / (2 * step)
    virial = (points * union.area_gradient).sum()
    expected = (dimension - 1) * union.area
    assert virial + radius * growth == pytest.approx(expected, rel=1e-8)


# --- invariance


@pytest.mark.parametrize(("kind", "dimension", "spacings"), CLOUDS)
def test_motion_changes_nothing(kind: str, dimension: int, spacings: float) -> None:
    points, radius = cloud(kind, dimension, spacings)
    rotation = oracles.random_rotation(dimension, np.random.default_rng(3))
    moved = measure_balls(points @ rotation.T + np.arange(1, dimension + 1), radius)
    assert_same_measures(moved, union_of(kind, dimension, spacings), 1e-12, rotation)


@pytest.mark.parametrize("dimension", [2, 3])
def test_translation_to_map_coordinates(dimension: int) -> None:
    offset = np.array([5e5, 4.2e6, 1e6])[:dimension]
    points = oracles.uniform_cloud(200, dimension)
    moved = points + offset
    assert_same_measures(measure_balls(moved, 0.2), measure_balls(moved - offset, 0.2), 1e-11)


@pytest.mark.parametrize("exponent", [-60, 40])
@pytest.mark.parametrize(("kind", "dimension", "spacings"), CLOUDS)
def test_scaling_by_a_power_of_two_is_exact(
    kind: str, dimension: int, spacings: float, exponent: int
) -> None:
    points, radius = cloud(kind, dimension, spacings)
    scaled = measure_balls(np.ldexp(points, exponent), float(np.ldexp(radius, exponent)))
    for name, power in [("cell_volumes", 0), ("visible_areas", -1), ("area_gradient", -2)]:
        unscaled = np.ldexp(getattr(scaled, name), -exponent * (dimension + power))
        expected = getattr(union_of(kind, dimension, spacings), name)
        np.testing.assert_array_equal(unscaled, expected)


@pytest.mark.parametrize(("kind", "dimension", "spacings"), CLOUDS)
def test_order_of_points_does_not_matter(kind: str, dimension: int, spacings: float) -> None:
    points, radius = cloud(kind, dimension, spacings)
    shuffled = np.random.default_rng(4).permutation(len(points))
    union = measure_balls(points[shuffled], radius)
    for name in oracles.ALL_MEASURES:
        expected = getattr(union_of(kind, dimension, spacings), name)[shuffled]
        assert_close(getattr(union, name), expected, 1e-13, scale_of(name, union))


def test_far_parts_are_measured_as_if_alone() -> None:
    """Far copies have the same measures, also when the kernel's blocks of points part them."""
    part = oracles.uniform_cloud(900, 3)
    points = np.concatenate([part + np.array([4.0 * k, 0, 0]) for k in range(3)])
    whole, alone = measure_balls(points, 0.25), measure_balls(part, 0.25)
    for k in range(3):
        for name in oracles.ALL_MEASURES:
            actual = getattr(whole, name)[900 * k : 900 * (k + 1)]
            assert_close(actual, getattr(alone, name), 1e-11, scale_of(name, whole))


# --- coincident, far and covered points


@pytest.mark.parametrize("dimension", [2, 3])
def test_first_of_coincident_points_carries_the_cell(dimension: int) -> None:
    distinct = oracles.uniform_cloud(50, dimension)
    of = np.random.default_rng(5).integers(0, 50, 200)
    union, expected = (
        measure_balls(distinct[of], 0.2),
        measure_balls(np.unique(distinct[of], axis=0), 0.2),
    )
    first = np.array([list(of).index(place) for place in of])
    np.testing.assert_array_equal(union.carriers, first)
    assert union.volume == pytest.approx(expected.volume, rel=1e-13)
    assert union.area == pytest.approx(expected.area, rel=1e-13)
    others = first != np.arange(len(of))
    assert not union.measures[others].any()
    assert (union.cell_volumes[~others] > 0).all()


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("distance", [2.0, 2.1, 1e6, 1e150])
def test_far_points_do_not_matter(dimension: int, distance: float) -> None:
    pair = np.zeros((2, dimension))
    pair[1, 0] = 0.7
    far = np.zeros((1, dimension))
    far[0, 1] = distance
    far[0, 0] = 0.0 if distance == 2.0 else 0.1
    union = measure_balls(np.r_[pair, far], 1.0)
    if distance > 2.0:
        np.testing.assert_array_equal(union.measures[:2], measure_balls(pair, 1.0).measures)
    np.testing.assert_allclose(
        union.measures[2], measure_balls(far, 1.0).measures[0], rtol=1e-15, atol=0
    )


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(
    "distance",
    [1e-20, 1e-150, 1e-200],
)
def test_points_next_to_each_other_share_a_ball(dimension: int, distance: float) -> None:
    points = np.zeros((3, dimension))
    points[1, 0], points[2, 1] = distance, 1.0
    union, expected = measure_balls(points, 1.0), measure_balls(points[[0, 2]], 1.0)
    assert np.isfinite(union.measures).all()
    assert union.volume == pytest.approx(expected.volume, rel=1e-14)
    assert union.area == pytest.approx(expected.area, rel=1e-14)


@pytest.mark.parametrize("dimension", [2, 3])
def test_covered_ball(dimension: int) -> None:
    """A ball among near ones in every direction has no visible boundary and no gradient."""
    around = np.r_[np.eye(dimension), -np.eye(dimension)]
    union = measure_balls(np.r_[np.zeros((1, dimension)), around], 1.0)
    assert union.visible_areas[0] == 0
    assert not union.normal_tensors[0].any()
    assert not union.area_gradient[0].any()
    assert_close(union.volume_gradient[0], 0, 1e-15, 1.0)
    assert union.cell_volumes[0] == pytest.approx(1.0, rel=1e-15)


# --- the energies


@pytest.mark.parametrize("weight", get_args(Weight))
@pytest.mark.parametrize("quantity", get_args(Quantity))
@pytest.mark.parametrize("dimension", [2, 3])
def test_energy_hands_on_the_measures(dimension: int, quantity: Quantity, weight: Weight) -> None:
    points, radius = cloud("cube", dimension, 2.5)
    union = union_of("cube", dimension, 2.5)
    evaluation = BallEnergy(radius, quantity, weight).evaluate(points)
    assert evaluation.value == getattr(union, quantity)
    np.testing.assert_array_equal(evaluation.gradient, getattr(union, f"{quantity}_gradient"))
    np.testing.assert_array_equal(evaluation.diagonal, getattr(union, f"{quantity}_diagonal"))
    expected = {
        ("none", "volume"): np.ones(len(points)),
        ("none", "area"): np.ones(len(points)),
        ("cell", "volume"): union.cell_volumes,
        ("cell", "area"): union.cell_volumes / radius,
        ("boundary", "volume"): radius * union.visible_areas,
        ("boundary", "area"): union.visible_areas,
    }
    np.testing.assert_allclose(evaluation.masses, expected[weight, quantity], rtol=1e-15)


@pytest.mark.parametrize("quantity", get_args(Quantity))
def test_boundary_that_rounding_alone_shows_has_no_mass(quantity: Quantity) -> None:
    """At the circumradius of its triangles a hexagonal grid is covered, up to rounding."""
    grid = oracles.lattice(8, 8) @ np.array([[1, 0], [0.5, np.sqrt(0.75)]])
    evaluation = BallEnergy(1 / np.sqrt(3), quantity, "boundary").evaluate(grid)
    inside = ((oracles.lattice(8, 8) > 0) & (oracles.lattice(8, 8) < 7)).all(axis=1)
    assert not evaluation.masses[inside].any()
    assert evaluation.masses[~inside].all()


# --- refusals


@pytest.mark.parametrize(
    ("points", "radius", "message"),
    [
        ([1.0, 2.0], 1.0, r"shape \(2,\)"),
        (np.zeros((3, 4)), 1.0, r"shape \(3, 4\); they must be \(n, 2\) or \(n, 3\)"),
        (np.zeros((0, 3)), 1.0, "no points"),
        ([[0, 0], [0, np.nan]], 1.0, "point 1 is not finite"),
        ([[0, 0], [0, 1], [-np.inf, 0]], 1.0, "point 2 is not finite"),
        ([[0, 0]], 0.0, "radius is 0.0"),
        ([[0, 0]], -1.0, "radius is -1.0"),
        ([[0, 0]], np.nan, "radius is nan"),
        ([[0, 0]], np.inf, "radius is inf"),
    ],
)
def test_bad_input_is_refused(points: npt.ArrayLike, radius: float, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        measure_balls(points, radius)
