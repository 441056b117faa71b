from __future__ import annotations

from itertools import pairwise
from typing import get_args

import numpy as np
import numpy.typing as npt
import pytest

import oracles
from flows.dense import dense_laplacian, rough_sphere
from oracles import Array
from pcsmooth.bodies.presets import load_presets
from pcsmooth.energies.balls import BallEnergy, measure_balls
from pcsmooth.energies.facet_laplacian import facet_laplacian
from pcsmooth.energies.polyhedra.union import PolyhedronEnergy
from pcsmooth.energies.protocol import Energy, Quantity, UnionName, Weight
from pcsmooth.errors import InvalidInputError
from pcsmooth.flows import implicit
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import FlowState, run_flow
from pcsmooth.flows.implicit import AUTOMATIC_STEP, STEP_OF_NOISE, Implicit, Order
from pcsmooth.methods.flows import ImplicitFlow
from pcsmooth.methods.shapes import Balls, Polyhedra
from pcsmooth.neighbors.local_radii import LocalRadii
from pcsmooth.neighbors.spacing import mean_spacing

Mask = npt.NDArray[np.bool_]

every_quantity = pytest.mark.parametrize("quantity", get_args(Quantity))
every_weight = pytest.mark.parametrize("weight", get_args(Weight))
every_order = pytest.mark.parametrize("order", get_args(Order))
every_dimension = pytest.mark.parametrize("dimension", [2, 3])


def one_step(
    energy: Energy, points: Array, scheme: Implicit, fixed: Mask | None = None
) -> FlowState:
    _, state = run_flow(energy, points, scheme, 1, fixed=fixed)
    return state


def masses_by_hand(energy: BallEnergy, points: Array) -> Array:
    union = energy.evaluate(points).union
    unit = energy.radius if energy.quantity == "area" else 1.0
    cells = union.cell_volumes / unit
    return {
        "none": np.ones(len(points)),
        "cell": cells,
        "boundary": np.maximum(energy.radius * union.visible_areas / unit, 0.1 * cells),
    }[energy.weight]


def largest_mass(energy: BallEnergy, dimension: int = 3) -> float | None:
    """What an implicit flow tells its scheme of an energy that is not weighted."""
    if energy.weight != "none":
        return None
    return Balls(quantity=energy.quantity).largest_mass(energy.radius, dimension)


@every_quantity
@every_dimension
def test_steps_without_a_weight_reach_as_far_as_those_in_cells(
    dimension: int, quantity: Quantity
) -> None:
    """Whatever the cells: a step of the automatic length is as long in the median cell."""
    weighted, plain = (BallEnergy(0.12, quantity, weight) for weight in ("cell", "none"))
    points = oracles.uniform_cloud(300, dimension)
    masses = weighted.evaluate(points).masses
    scheme = Implicit(0.1, 1, largest_mass=largest_mass(plain, dimension))
    (state,) = run_flow(plain, points, scheme, 0)
    step = AUTOMATIC_STEP[1] * 0.01
    assert state.step == pytest.approx(step / np.median(masses))
    farthest = Implicit(0.1, 1).reach(step * masses.max() / float(np.median(masses)))
    assert scheme.reach(state.step) >= farthest > 0.0


@pytest.mark.slow
@every_quantity
@every_weight
@every_dimension
@every_order
@pytest.mark.parametrize("is_fixed", [False, True])
def test_dense_solution(
    dimension: int, quantity: Quantity, weight: Weight, order: Order, is_fixed: bool
) -> None:
    """Order 2 in its real form: the complex one is another way to the same positions."""
    n = 300
    points = oracles.uniform_cloud(n, dimension)
    energy = BallEnergy(0.12, quantity, weight)
    union = measure_balls(points, energy.radius)
    masses = masses_by_hand(energy, points)
    step = 0.01 / np.median(union.cell_volumes) if weight == "none" else 0.01
    fixed = np.arange(n) % 9 == 0 if is_fixed else np.zeros(n, bool)
    state = one_step(energy, points, Implicit(0.1, order, step, 1e-12), fixed)
    assert state.step == step
    laplacian = dense_laplacian(facet_laplacian(union, quantity), union.numbers)
    gradient = laplacian @ points
    inside = np.ix_(~fixed, ~fixed)
    matrix, right_side = np.diag(masses) + step * laplacian, -step * gradient
    if order == 2:  # the curvature, gradient over mass, of the fixed points is taken for 0
        squared = laplacian[:, ~fixed] / masses[~fixed] @ laplacian[~fixed]
        matrix = np.diag(masses) + step**2 * squared
        right_side = -(step**2) * laplacian[:, ~fixed] / masses[~fixed] @ gradient[~fixed]
    moved = np.linalg.solve(matrix[inside], right_side[~fixed])
    expected = points.copy()
    expected[~fixed] += moved
    size = np.abs(expected - points).max()
    np.testing.assert_allclose(state.points, expected, rtol=0, atol=1e-8 * size)
    assert state.points[fixed].tobytes() == points[fixed].tobytes()
    assert state.solver_iterations > 0
    assert state.solver_error < 1e-12


@every_quantity
@every_dimension
def test_short_steps_are_those_of_euler(dimension: int, quantity: Quantity) -> None:
    points, step = rough_sphere(300, dimension), 1e-9
    energy = BallEnergy(0.3, quantity)
    state = one_step(energy, points, Implicit(0.1, 1, step, 1e-9))
    *_, expected = run_flow(energy, points, Euler(step), 1)
    np.testing.assert_allclose(
        state.points - points, expected.points - points, rtol=0, atol=1e-3 * expected.moves.max()
    )


@every_order
@every_dimension
def test_sphere_shrinks_as_its_closed_form(dimension: int, order: Order) -> None:
    """Coordinates on a sphere are eigenfunctions: L p = m p (d - 1) / R^2, all points alike.

    So a step of order 1 takes R to R / (1 + (d - 1) tau / R^2), and one of order 2 to
    R / (1 + ((d - 1) tau / R^2)^2).
    """
    radius, step = 2.0, 0.2
    points = oracles.even_circle(400, radius) if dimension == 2 else oracles.even_sphere(4000, 2.0)
    energy = BallEnergy(2.5 * mean_spacing(points))
    state = one_step(energy, points, Implicit(0.1, order, step, 1e-9))
    ratio = np.linalg.norm(state.points, axis=1).mean() / radius
    rate = (dimension - 1) * step / radius**2
    expected = 1 / (1 + rate**order)
    assert 1 - ratio == pytest.approx(1 - expected, rel=0.05)


@pytest.mark.slow
def test_second_order_takes_noise_and_leaves_the_shape() -> None:
    surface = oracles.torus_surface(20_000)
    points = surface.noisy(0.5)
    spacing = mean_spacing(points)
    deviation = 0.5 * surface.spacing
    energy = BallEnergy(2 * spacing)
    errors = {
        scheme: [
            oracles.distance_to_torus(state.points)
            for state in run_flow(energy, points, scheme, iterations)
        ]
        for scheme, iterations in (
            (Euler(), 6),
            (Implicit(spacing, 1, noise=deviation), 2),
            (Implicit(spacing, 2, noise=deviation), 2),
        )
    }
    noise = np.sqrt(np.mean(errors[Euler()][0] ** 2))
    euler, first, second = (np.sqrt(np.mean(found[-1] ** 2)) for found in errors.values())
    assert second < 0.24 * noise
    assert 1.4 * second < min(euler, first)
    shrinkage = [-found[-1].mean() for found in errors.values()]
    assert 2 * abs(shrinkage[2]) < min(shrinkage[:2])


@every_order
@every_weight
@every_quantity
@pytest.mark.parametrize("noise", [None, 0.02, 0.3])
def test_automatic_step(
    order: Order, weight: Weight, quantity: Quantity, noise: float | None
) -> None:
    points = rough_sphere(500)
    energy = BallEnergy(0.3, quantity, weight)
    scheme = Implicit(0.1, order, noise=noise, largest_mass=largest_mass(energy))
    (state,) = run_flow(energy, points, scheme, 0)
    expected = AUTOMATIC_STEP[order] * 0.01
    if noise is not None:
        expected = STEP_OF_NOISE[order] * 0.1 * noise
    if weight == "none":
        cells = energy.evaluate(points).union.cell_volumes
        expected /= np.median(cells / 0.3 if quantity == "area" else cells)
    assert state.step == pytest.approx(expected, rel=1e-12)
    assert state.solver_iterations == 0


@every_order
def test_step_of_unknown_noise(order: Order) -> None:
    """It is about that of a noise of 0.4 spacings."""
    assert AUTOMATIC_STEP[order] == pytest.approx(0.4 * STEP_OF_NOISE[order], rel=0.05)


@every_order
def test_what_has_no_noise_rests(order: Order) -> None:
    points = rough_sphere(300)
    state = one_step(BallEnergy(0.4), points, Implicit(0.1, order, noise=0.0))
    np.testing.assert_array_equal(state.points, points)
    assert state.step == 0


@every_order
def test_given_step_goes_before_that_of_the_noise(order: Order) -> None:
    scheme = Implicit(0.1, order, 0.25, noise=0.1)
    (state,) = run_flow(BallEnergy(0.4), rough_sphere(300), scheme, 0)
    assert state.step == 0.25


@pytest.mark.parametrize("step", [1e-3, 1.0, 1e3, 1e9])
@every_order
def test_no_step_is_too_long(step: float, order: Order) -> None:
    points = rough_sphere(300)
    state = one_step(BallEnergy(0.4), points, Implicit(0.1, order, step))
    assert np.isfinite(state.points).all()
    assert np.abs(state.points).max() < 1.1 * np.abs(points).max()
    assert state.evaluation.value < BallEnergy(0.4).evaluate(points).value
    np.testing.assert_allclose(masses_mean(state.points, points), 0, atol=2e-3)


def clump_on_torus() -> Array:
    """Cells whose volumes lie fifteen decades apart."""
    rng = np.random.default_rng(2)
    surface = oracles.torus_surface(1200).noisy(0.3)
    clumps = [surface[k] + size * rng.normal(size=(60, 3)) for k, size in ((3, 1e-5), (700, 1e-3))]
    return np.concatenate([surface, *clumps])


CLOUDS = {
    "clumps": clump_on_torus(),
    "two far apart": np.concatenate([rough_sphere(400), 1e4 + rough_sphere(300)]),
    "open curve": np.c_[np.sort(np.random.default_rng(0).uniform(0, 4, 200)), np.zeros(200)],
    "curve in pieces": oracles.uniform_cloud(150, 2),
}


@pytest.mark.slow
@pytest.mark.parametrize("step", [1e-3, 0.03, 1.0, 1e3, 1e6, 1e9, 1e12, 1e20])
@pytest.mark.parametrize("is_fixed", [False, True])
@pytest.mark.parametrize("points", CLOUDS.values(), ids=CLOUDS)
def test_steps_of_first_order_stay_within_the_hull(
    points: Array, is_fixed: bool, step: float
) -> None:
    """Each new position is a mean of all old ones, so no direction knows a farther point."""
    fixed = np.arange(len(points)) % 97 == 0 if is_fixed else None
    energy = BallEnergy(2.5 * mean_spacing(points))
    state = one_step(energy, points, Implicit(0.1, 1, step), fixed)
    directions = oracles.random_sphere(500, dimension=points.shape[1])
    beyond = (state.points @ directions.T).max(axis=0) - (points @ directions.T).max(axis=0)
    assert beyond.max() < 1e-12 * np.abs(points).max()
    assert state.moves.max() > 0


def test_longest_steps_take_every_component_to_its_mean() -> None:
    """Of order 1 and 2, and whatever the other components do."""
    parts = [rough_sphere(300), 5 + rough_sphere(200), 1e3 + rough_sphere(250)]
    points = np.concatenate(parts)
    fixed = np.arange(750) == 720  # in the third
    energy = BallEnergy(0.45)
    masses = energy.evaluate(points).masses
    for order in get_args(Order):
        state = one_step(energy, points, Implicit(0.1, order, 1e15), fixed)
        for rows in (slice(0, 300), slice(300, 500)):
            mean = masses[rows] @ points[rows] / masses[rows].sum()
            np.testing.assert_allclose(
                state.points[rows], np.broadcast_to(mean, points[rows].shape), atol=1e-6
            )
        third = np.broadcast_to(points[720], (250, 3))
        np.testing.assert_allclose(state.points[500:], third, atol=5e-3)


def masses_mean(moved: Array, points: Array) -> Array:
    """Displacement of the centre of mass, which flows keep."""
    masses = BallEnergy(0.4).evaluate(points).masses
    return np.asarray(masses @ (moved - points) / masses.sum())


@every_order
@every_dimension
def test_coincident_points_move_as_one(dimension: int, order: Order) -> None:
    points = oracles.uniform_cloud(80, dimension)
    twice = np.r_[points, points[:30]]
    scheme = Implicit(0.1, order, 0.01, 1e-10)
    energy = BallEnergy(0.25)
    alone, together = one_step(energy, points, scheme), one_step(energy, twice, scheme)
    np.testing.assert_array_equal(together.points[80:], together.points[:30])
    np.testing.assert_allclose(together.points[:80], alone.points, rtol=0, atol=1e-12)
    fixed = np.arange(110) >= 100
    held = one_step(energy, twice, scheme, fixed)
    assert held.points[20:30].tobytes() == points[20:30].tobytes()
    assert (held.moves[:20] > 0).all()


DEGENERATE = {
    "one point": np.ones((1, 3)),
    "two points": np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]),
    "far apart": np.eye(3),
    "some far apart": np.r_[5 + np.eye(3), oracles.uniform_cloud(30, 3)],
    "on a line": np.linspace(0, 1, 40)[:, np.newaxis] * [1.0, 2.0, -1.0],
    "in a plane": np.c_[oracles.uniform_cloud(200, 2), np.zeros(200)],
    "a grid": 0.1 * oracles.lattice(6, 6, 6),
    "a plane grid": 0.1 * oracles.lattice(9, 9),
    "nearly one": 1.0 + 1e-12 * oracles.uniform_cloud(20, 3),
}


@every_order
@every_weight
@pytest.mark.parametrize("points", DEGENERATE.values(), ids=DEGENERATE)
def test_degenerate_clouds(points: Array, weight: Weight, order: Order) -> None:
    energy = BallEnergy(0.2, "volume", weight)
    *_, state = run_flow(energy, points, Implicit(0.1, order, largest_mass=largest_mass(energy)), 2)
    assert np.isfinite(state.points).all()
    rests = energy.evaluate(points).diagonal == 0
    np.testing.assert_array_equal(state.points[rests], points[rests])
    low, high = points.min(axis=0), points.max(axis=0)
    reach = 0.05 * (high - low).max() + 1e-12
    assert (state.points > low - reach).all()
    assert (state.points < high + reach).all()


def test_covered_points_follow_their_neighbors_under_the_boundary_weight() -> None:
    """A point without visible boundary has no mass of its own; Euler lets it rest."""
    points = np.r_[np.array([[0.1, 0.0, 0.0]]), 1.05 * np.eye(3), -np.eye(3)]
    energy = BallEnergy(1.0, "volume", "boundary")
    assert energy.evaluate(points).masses[0] == 0
    state = one_step(energy, points, Implicit(1.0, 1, 0.1))
    assert np.isfinite(state.points).all()
    assert 0 < state.moves[0] < 0.2


def energies_fall(states: list[FlowState]) -> bool:
    return all(b.evaluation.value < a.evaluation.value for a, b in pairwise(states))


@pytest.mark.parametrize("union", get_args(UnionName))
def test_first_order_with_polyhedra(union: UnionName) -> None:
    """The energy falls in steps that are long for Euler, the sphere turns into a cube."""
    cube = load_presets()["cube"]
    points = oracles.random_sphere(500)
    spacing = mean_spacing(points)
    energy = PolyhedronEnergy(2.5 * spacing, cube, union)
    scheme = Implicit(spacing, 1, 1.5 * spacing**2, is_of_balls=False)
    states = list(run_flow(energy, points, scheme, 4))
    assert energies_fall(states)
    *_, euler = run_flow(energy, points, Euler(0.02 * spacing**2), 1)
    first = states[1].points - points
    second = euler.points - points
    assert (first * second).sum() > 0.5 * np.linalg.norm(first) * np.linalg.norm(second)
    norms = [np.abs(state.points).max(axis=1) for state in states]
    spreads = [norm.std() / norm.mean() for norm in norms]
    assert spreads[-1] < 0.7 * spreads[0]


@pytest.mark.parametrize("scale", [0.3, 3.0])
def test_size_of_the_polyhedron_does_not_matter(scale: float) -> None:
    points = rough_sphere(500)
    spacing = mean_spacing(points)
    cube = load_presets()["cube"]
    energy = PolyhedronEnergy(2.5 * spacing / scale, cube.scaled(scale))
    states = list(run_flow(energy, points, Implicit(spacing, 1, is_of_balls=False), 3))
    assert energies_fall(states)
    assert states[1].moves.mean() > 0.05 * spacing


def test_step_of_polyhedra_is_not_that_of_the_noise() -> None:
    """They turn a surface without noise too."""
    energy = PolyhedronEnergy(0.3, load_presets()["cube"])
    points = rough_sphere(300)
    (state,) = run_flow(energy, points, Implicit(0.1, 1, noise=0.0, is_of_balls=False), 0)
    (expected,) = run_flow(energy, points, Implicit(0.1, 1, is_of_balls=False), 0)
    assert state.step == expected.step == pytest.approx(AUTOMATIC_STEP[1] * 0.01)


@pytest.mark.slow
def test_steps_of_polyhedra_that_drown_in_rounding_are_an_error() -> None:
    energy = PolyhedronEnergy(0.3, load_presets()["cube"])
    with pytest.raises(InvalidInputError, match="implicit step has not been solved"):
        list(run_flow(energy, rough_sphere(200), Implicit(0.1, 1, 1e17, is_of_balls=False), 1))


def test_isolated_polyhedra_rest() -> None:
    energy = PolyhedronEnergy(0.3, load_presets()["cube"])
    *_, state = run_flow(energy, np.eye(3), Implicit(1.0, 1, is_of_balls=False), 1)
    np.testing.assert_array_equal(state.points, np.eye(3))


def test_second_order_is_not_for_polyhedra() -> None:
    shapes = Polyhedra(body=load_presets()["cube"])
    with pytest.raises(InvalidInputError, match="not polyhedra; use order 1 or scheme euler"):
        ImplicitFlow(shapes=shapes, order=2)
    assert ImplicitFlow(shapes=shapes).order == 1


# --- unequal shapes


@every_order
def test_ball_within_another_rests(order: Order) -> None:
    points = rough_sphere(300)
    radii = np.full(301, 2.0 * mean_spacing(points))
    radii[-1] = 0.1 * radii[0]
    inside = np.concatenate([points, points[:1] + 0.05 * radii[0]])
    local = LocalRadii.of(radii, 1.0)
    scheme = Implicit(mean_spacing(points), order)
    found = one_step(BallEnergy(local.median, local=local), inside, scheme)
    assert found.points[-1].tolist() == inside[-1].tolist()
    expected = one_step(BallEnergy(local.median), points, scheme)
    np.testing.assert_allclose(found.points[:-1], expected.points, rtol=0, atol=1e-8)


@pytest.mark.parametrize("union", get_args(UnionName))
def test_bodies_of_which_slivers_of_cells_are_left_do_not_fly(
    union: UnionName, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = rough_sphere(600)
    shares = np.random.default_rng(0).uniform(0.7, 1.3, 600)
    local = LocalRadii.of(2.0 * mean_spacing(points) * shares, 1.0)
    energy = PolyhedronEnergy(local.median, load_presets()["cube"], union, local=local)
    scheme = Implicit(mean_spacing(points), 1, is_of_balls=False)

    def moves() -> Array:
        state = one_step(energy, points, scheme)
        return np.asarray(np.linalg.norm(state.points - points, axis=1) / local.values)

    limited = moves()
    assert limited.max() < 1.5
    monkeypatch.setattr(implicit, "_limited", lambda right_side, _limits: right_side)
    free = moves()
    assert free.max() > 10
    # Few are held back.
    assert np.quantile(np.abs(limited - free), 0.9) < 0.02
    assert np.median(limited) > 0.03
