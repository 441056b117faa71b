"""The reference by automatic differentiation, against what owes nothing to the kernels."""

from __future__ import annotations

from itertools import product
from typing import Any, get_args

import numpy as np
import pytest

import oracles
import polyhedron_oracles as expect
from energies.cases import convex_body
from oracles import assert_close
from pcsmooth import (
    BallEnergy,
    Balls,
    InvalidInputError,
    Polyhedra,
    PolyhedronEnergy,
    load_presets,
)
from pcsmooth.autodiff.cell_edges import restricted_cell_edges
from pcsmooth.autodiff.edge_sums import parts_of, whole_ball
from pcsmooth.autodiff.shape import ball_shape
from pcsmooth.energies.by_autodiff import LARGEST_CLOUD, AutodiffEnergy
from pcsmooth.energies.protocol import GradientName, Quantity, UnionMeasures, Weight
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import run_flow
from polyhedron_oracles import RULES, Rule


def energy_of(shape: str, rule: Rule, radius: float) -> BallEnergy | PolyhedronEnergy:
    if shape == "ball":
        return BallEnergy(radius, weight="none")
    return PolyhedronEnergy(radius, convex_body(expect.solid(shape)), rule, weight="none")


def reference(shape: str, rule: Rule, n: int) -> tuple[expect.Scene, UnionMeasures]:
    """A cloud, and its measures by the reference."""
    made = expect.scene(shape, "cloud", n)
    return made, AutodiffEnergy(energy_of(shape, rule, made.radius)).evaluate(made.points).union


@pytest.mark.parametrize("shape", [*expect.SHAPES[2], *expect.SHAPES[3]])
def test_reference_cells_are_those_of_qhull(shape: str) -> None:
    _, union = reference(shape, "naive", 12)
    volumes, areas = expect.naive_cells_of_scene(shape, "cloud", 12)
    assert_close(union.cell_volumes, volumes, 1e-9)
    assert_close(union.visible_areas, areas, 1e-9)


@pytest.mark.parametrize("shape", ["square", "triangle", "cube", "tetrahedron"])
def test_reference_exact_union_is_inclusion_exclusion_over_the_nerve(shape: str) -> None:
    made, union = reference(shape, "exact", 7)
    expected = expect.sum_over_simplices(made.points, made.radius, made.body)
    assert union.volume == pytest.approx(expected.volume, rel=1e-9)
    assert union.area == pytest.approx(expected.area, rel=1e-9)
    assert_close(union.visible_areas, expected.visible_areas, 1e-9)
    assert_close(union.volume_gradient, expected.volume_gradient, 1e-9)


@pytest.mark.parametrize("shape", ["hexagon", "tetrahedron"])
def test_reference_inclusion_exclusion_over_the_alpha_complex(shape: str) -> None:
    made, union = reference(shape, "inclusion-exclusion", 8)
    simplices = expect.alpha_complex(made.points, made.radius)
    assert max(map(len, simplices)) == made.points.shape[1] + 1
    expected = expect.sum_over_simplices(made.points, made.radius, made.body, simplices)
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


@pytest.mark.parametrize(
    ("shape", "quantity", "weight"),
    [
        ("ball", "volume", "none"),
        ("ball", "area", "cell"),
        ("ball", "volume", "boundary"),
        ("hexagon", "area", "none"),
        ("hexagon", "volume", "cell"),
        ("hexagon", "area", "boundary"),
    ],
)
def test_flows_are_the_same(shape: str, quantity: Quantity, weight: Weight) -> None:
    rng = np.random.default_rng(0)
    points = oracles.even_circle(20) * (1 + 0.02 * rng.normal(size=(20, 1)))
    ends = []
    for gradient in get_args(GradientName):
        options: Any = {"quantity": quantity, "weight": weight, "gradient": gradient}
        hexagon = load_presets()["hexagon"]
        shapes = Balls(**options) if shape == "ball" else Polyhedra(body=hexagon, **options)
        *_, last = run_flow(shapes.energy(0.61), points, Euler(), 3)
        ends.append(last.points)
    assert np.linalg.norm(ends[0] - points, axis=1).mean() > 0.003
    assert_close(ends[1], ends[0], 1e-11)


@pytest.mark.parametrize(
    ("shape", "rule"), [("ball", "naive"), *product(("cube", "icosahedron"), RULES)]
)
def test_grids_have_the_same_gradients(shape: str, rule: Rule) -> None:
    """Where many cells and bodies meet, and the volume is smooth all the same."""
    points = oracles.lattice(3 if shape == "cube" else 2, 2, 2)
    energy = energy_of(shape, rule, 1.3)
    analytic, dual = energy.evaluate(points), AutodiffEnergy(energy).evaluate(points)
    assert dual.value == pytest.approx(analytic.value, rel=1e-13)
    assert_close(dual.gradient, analytic.gradient, 1e-11)


def test_large_clouds_are_refused() -> None:
    points, energy = oracles.uniform_cloud(LARGEST_CLOUD + 1, 3), BallEnergy(0.01)
    with pytest.raises(InvalidInputError, match=r"1001 distinct points.* 1000 at most; take"):
        AutodiffEnergy(energy).evaluate(points)
    twice = np.r_[points[1:], points[1:]]
    value = AutodiffEnergy(energy).evaluate(twice).value
    assert value == pytest.approx(energy.evaluate(twice).value, rel=1e-12)
