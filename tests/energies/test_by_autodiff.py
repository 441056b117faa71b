"""Gradients of every energy: analytic = dual numbers = finite differences."""

from __future__ import annotations

from collections.abc import Callable
from typing import get_args

import numpy as np
import pytest
from pcsmooth.energies.choice import choose_energy

import oracles
import polyhedron_oracles as expect
from oracles import assert_close
from pcsmooth import BallEnergy, ConvexBody, InvalidInputError, PolyhedronEnergy, load_presets
from pcsmooth.autodiff.cell_edges import restricted_cell_edges
from pcsmooth.autodiff.edge_sums import parts_of, whole_ball
from pcsmooth.autodiff.shape import ball_shape
from pcsmooth.energies.by_autodiff import LARGEST_CLOUD, AutodiffEnergy
from pcsmooth.energies.protocol import Quantity, Weight
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import run_flow
from polyhedron_oracles import RULES, Rule

Evaluated = BallEnergy | PolyhedronEnergy

SHAPES = ["ball", *expect.SHAPES[2], *expect.SHAPES[3]]
QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)
WEIGHTS: tuple[Weight, ...] = get_args(Weight)

#: Every union: ball in both dimensions, then each body in its own, by each rule.
UNIONS = [("ball", "naive", 2), ("ball", "naive", 3)] + [
    (shape, rule, dimension)
    for dimension, shapes in expect.SHAPES.items()
    for shape in shapes
    for rule in RULES
]


def scene(shape: str, dimension: int, kind: str, n: int) -> tuple[oracles.Array, float]:
    body = {2: "hexagon", 3: "icosahedron"}[dimension] if shape == "ball" else shape
    made = expect.scene(body, kind, n)
    return made.points, made.radius


def energy_of(shape: str, rule: Rule, radius: float) -> Evaluated:
    if shape == "ball":
        return BallEnergy(radius, weight="none")
    solid = expect.solid(shape)
    body = ConvexBody(solid.normals, solid.offsets)
    return PolyhedronEnergy(radius, body, rule, weight="none")


@pytest.mark.parametrize(("shape", "rule", "dimension"), UNIONS)
@pytest.mark.parametrize("kind", ["cloud", "cap"])
def test_analytic_dual_and_differences(shape: str, rule: Rule, dimension: int, kind: str) -> None:
    points, radius = scene(shape, dimension, kind, 8 if shape == "sphere" else 14)
    energy = energy_of(shape, rule, radius)
    analytic, dual = energy.evaluate(points).union, AutodiffEnergy(energy).evaluate(points).union
    direction = np.random.default_rng(5).normal(size=points.shape)
    step = 1e-6 * radius
    ahead, behind = (
        AutodiffEnergy(energy).evaluate(points + sign * step * direction).union for sign in (1, -1)
    )
    for name in ("volume", "area"):
        gradient = getattr(dual, f"{name}_gradient")
        assert getattr(dual, name) == pytest.approx(getattr(analytic, name), rel=1e-12)
        assert_close(gradient, getattr(analytic, f"{name}_gradient"), 1e-9)
        assert abs(gradient).max() > 0.1 * radius ** (points.shape[1] - 1 - (name == "area"))
        slope = (getattr(ahead, name) - getattr(behind, name)) / (2 * step)
        assert slope == pytest.approx((gradient * direction).sum(), rel=2e-6)


@pytest.mark.parametrize(("shape", "rule", "dimension"), UNIONS)
def test_measures_of_each_point(shape: str, rule: Rule, dimension: int) -> None:
    points, radius = scene(shape, dimension, "cloud", 9)
    energy = energy_of(shape, rule, radius)
    analytic, dual = energy.evaluate(points).union, AutodiffEnergy(energy).evaluate(points).union
    for name in ("volume", "area", "cell_volumes", "visible_areas"):
        assert_close(getattr(dual, name), getattr(analytic, name), 1e-12)
    for name in ("radius", "carriers", "volume_diagonal", "area_diagonal"):
        np.testing.assert_array_equal(getattr(dual, name), getattr(analytic, name))


# --- the reference itself, against what owes nothing to the kernels


@pytest.mark.parametrize("shape", [*expect.SHAPES[2], *expect.SHAPES[3]])
def test_reference_cells_are_those_of_qhull(shape: str) -> None:
    points, radius = scene(shape, 0, "cloud", 12)
    body = expect.solid(shape)
    union = AutodiffEnergy(energy_of(shape, "naive", radius)).evaluate(points).union
    volumes, areas = expect.naive_cells(points, radius, body)
    assert_close(union.cell_volumes, volumes, 1e-9)
    assert_close(union.visible_areas, areas, 1e-9)


@pytest.mark.parametrize("shape", ["square", "triangle", "cube", "tetrahedron"])
def test_reference_exact_union_is_inclusion_exclusion_over_the_nerve(shape: str) -> None:
    points, radius = scene(shape, 0, "cloud", 7)
    energy = energy_of(shape, "exact", radius)
    union = AutodiffEnergy(energy).evaluate(points).union
    expected = expect.sum_over_simplices(points, radius, expect.solid(shape))
    assert union.volume == pytest.approx(expected.volume, rel=1e-9)
    assert union.area == pytest.approx(expected.area, rel=1e-9)
    assert_close(union.visible_areas, expected.visible_areas, 1e-9)
    assert_close(union.volume_gradient, expected.volume_gradient, 1e-9)


@pytest.mark.parametrize("shape", ["hexagon", "tetrahedron"])
def test_reference_inclusion_exclusion_over_the_alpha_complex(shape: str) -> None:
    points, radius = scene(shape, 0, "cloud", 8)
    energy = energy_of(shape, "inclusion-exclusion", radius)
    union = AutodiffEnergy(energy).evaluate(points).union
    simplices = expect.alpha_complex(points, radius)
    assert max(map(len, simplices)) == points.shape[1] + 1
    expected = expect.sum_over_simplices(points, radius, expect.solid(shape), simplices)
    assert union.volume == pytest.approx(expected.volume, rel=1e-9)
    assert_close(union.visible_areas, expected.visible_areas, 1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_reference_of_two_balls(dimension: int) -> None:
    """|C_i| and S_i of two balls at the distance d: the ball less a cap."""
    r, d = 0.7, 0.9
    points = np.zeros((2, dimension))
    points[1, 0] = d
    union = AutodiffEnergy(BallEnergy(r, weight="none")).evaluate(points).union
    h = r - d / 2
    if dimension == 3:
        cap, rim, lens = np.pi * h * h * (3 * r - h) / 3, 2 * np.pi * r * h, r * r - d * d / 4
        facet, slope = np.pi * lens, 2 * np.pi * r
    else:
        angle = 2 * np.arccos(d / 2 / r)
        cap, rim = r * r * (angle - np.sin(angle)) / 2, r * angle
        facet = 2 * np.sqrt(r * r - d * d / 4)
        slope = 4 * r / facet
    assert_close(union.cell_volumes, oracles.ball_volume(r, dimension) - cap, 1e-14)
    assert_close(union.visible_areas, oracles.sphere_area(r, dimension) - rim, 1e-14)
    assert_close(union.volume_gradient[:, 0], [-facet, facet], 1e-13)
    assert_close(union.area_gradient[:, 0], [-slope, slope], 1e-13)
    assert_close(union.volume_gradient[:, 1:], 0, 1e-13, facet)


def test_reference_of_three_balls() -> None:
    points = np.array([[0, 0, 0], [1, 0.1, 0], [0.3, 0.8, 0.2]])
    union = AutodiffEnergy(BallEnergy(0.8, weight="none")).evaluate(points).union
    expected = oracles.three_balls(points, 0.8)
    for name in oracles.MEASURES:
        assert_close(getattr(union, name), getattr(expected, name), 1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_reference_takes_any_type_of_number(dimension: int) -> None:
    """In long doubles the volumes agree with those in doubles, and are not the same numbers."""
    points = oracles.uniform_cloud(20, dimension, seed=3)
    shape = ball_shape(0.2, dimension)
    edges = restricted_cell_edges(points, shape)
    positions = points[edges.slots]
    long = parts_of(edges, positions.astype(np.longdouble), shape).volumes
    assert long.dtype == np.longdouble
    short = parts_of(edges, positions, shape).volumes
    assert_close(long.astype(float), short, 1e-14, 0.2**dimension)
    total = float(long.sum()) + 20 * whole_ball(0.2, dimension)[0]
    assert total == pytest.approx(BallEnergy(0.2).evaluate(points).value, rel=1e-13)


# --- as an energy of a flow


@pytest.mark.parametrize("weight", WEIGHTS)
@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize(("shape", "rule"), [("ball", "naive"), ("hexagon", "exact")])
def test_flows_are_the_same(shape: str, rule: Rule, quantity: Quantity, weight: Weight) -> None:
    rng = np.random.default_rng(0)
    points = oracles.even_circle(40) * (1 + 0.02 * rng.normal(size=(40, 1)))
    body = None if shape == "ball" else load_presets()["hexagon"]
    ends = []
    for gradient in ("analytic", "autodiff"):
        energy = choose_energy(0.31, quantity, weight, body, rule, gradient)
        *_, last = run_flow(energy, points, Euler(), 4)
        ends.append(last.points)
    assert np.linalg.norm(ends[0] - points, axis=1).mean() > 0.003
    assert_close(ends[1], ends[0], 1e-11)


@pytest.mark.parametrize("shape", ["ball", "cube", "icosahedron"])
@pytest.mark.parametrize("rule", RULES)
def test_grids_have_the_same_gradients(shape: str, rule: Rule) -> None:
    """Where many cells and bodies meet, and the volume is smooth all the same."""
    points = oracles.lattice(3, 3, 3).astype(float)
    energy = energy_of(shape, rule, 1.3)
    analytic, dual = energy.evaluate(points), AutodiffEnergy(energy).evaluate(points)
    assert dual.value == pytest.approx(analytic.value, rel=1e-13)
    assert_close(dual.gradient, analytic.gradient, 1e-11)


@pytest.mark.parametrize(("shape", "rule"), [("ball", "naive"), ("cube", "exact")])
def test_coincident_points_count_once(shape: str, rule: Rule) -> None:
    points, radius = scene(shape, 3, "cloud", 10)
    energy = AutodiffEnergy(energy_of(shape, rule, radius))
    once, twice = energy.evaluate(points), energy.evaluate(np.r_[points, points[:4]])
    assert twice.value == once.value
    np.testing.assert_array_equal(twice.gradient[:10], once.gradient)
    assert not twice.gradient[10:].any()
    assert not twice.union.cell_volumes[10:].any()


@pytest.mark.parametrize("make", [oracles.random_sphere, oracles.even_sphere])
def test_large_clouds_are_refused(make: Callable[[int], oracles.Array]) -> None:
    points = make(LARGEST_CLOUD + 1)
    with pytest.raises(InvalidInputError, match=r"1001 distinct points.* 1000 at most; take"):
        AutodiffEnergy(BallEnergy(0.01)).evaluate(points)
    evaluation = AutodiffEnergy(BallEnergy(0.01)).evaluate(np.r_[points[1:], points[1:]])
    assert evaluation.value > 0
