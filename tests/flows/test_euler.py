from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import get_args

import numpy as np
import numpy.typing as npt
import pytest

import oracles
from oracles import Array
from pcsmooth.energies.balls import BallEnergy, measure_balls
from pcsmooth.energies.protocol import Energy, Quantity, Weight
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import FlowState, run_flow

every_quantity = pytest.mark.parametrize("quantity", get_args(Quantity))
every_weight = pytest.mark.parametrize("weight", get_args(Weight))
every_dimension = pytest.mark.parametrize("dimension", [2, 3])


def euler_flow(
    energy: Energy,
    points: Array,
    iterations: int,
    step: float | None = None,
    fixed: npt.NDArray[np.bool_] | None = None,
) -> Iterator[FlowState]:
    return run_flow(energy, points, Euler(step), iterations, fixed=fixed)


def masses_by_hand(points: Array, radius: float, quantity: str, weight: str) -> Array:
    union = measure_balls(points, radius)
    masses = {
        "none": np.ones(len(points)),
        "cell": union.cell_volumes,
        "boundary": radius * union.visible_areas,
    }[weight]
    return np.asarray(masses / radius if quantity == "area" and weight != "none" else masses)


def rough_sphere(dimension: int, n: int) -> Array:
    noise = 0.03 * np.random.default_rng(1).normal(size=(n, 1))
    return (1 + noise) * oracles.random_sphere(n, dimension=dimension)


def last(states: list[FlowState]) -> FlowState:
    return states[-1]


@every_quantity
@every_weight
@every_dimension
def test_constant_step_is_gradient_over_mass(
    dimension: int, quantity: Quantity, weight: Weight
) -> None:
    points, radius, step = oracles.uniform_cloud(60, dimension), 0.2, 1e-4
    states = list(euler_flow(BallEnergy(radius, quantity, weight), points, 3, step))
    assert [state.iteration for state in states] == [0, 1, 2, 3]
    np.testing.assert_array_equal(states[0].points, points)
    assert not states[0].moves.any()
    for before, after in pairwise(states):
        gradient = getattr(measure_balls(before.points, radius), f"{quantity}_gradient")
        masses = masses_by_hand(before.points, radius, quantity, weight)
        visible = masses > 1e-9 * masses.max()
        displacement = np.zeros_like(points)
        displacement[visible] = -step * gradient[visible] / masses[visible, np.newaxis]
        np.testing.assert_allclose(after.points, before.points + displacement, atol=1e-15)
        moves = np.linalg.norm(displacement, axis=1)
        np.testing.assert_allclose(after.moves, moves, rtol=1e-12, atol=1e-15)
        assert after.step == step


@every_quantity
@every_weight
@every_dimension
def test_automatic_step_takes_the_median_point_to_the_mean_of_its_neighbors(
    dimension: int, quantity: Quantity, weight: Weight
) -> None:
    points, radius = rough_sphere(dimension, 100), 0.3
    before, after = euler_flow(BallEnergy(radius, quantity, weight), points, 1)
    union = measure_balls(points, radius)
    diagonal = getattr(union, f"{quantity}_diagonal")
    masses = masses_by_hand(points, radius, quantity, weight)
    moving = (diagonal > 0) & (masses > 0)
    step = 1 / np.median(diagonal[moving] / masses[moving])
    assert before.step == after.step == pytest.approx(step, rel=1e-12)
    rate = np.zeros(len(points))
    rate[moving] = np.minimum(step / masses[moving], 0.9 / diagonal[moving])
    expected = points - rate[:, np.newaxis] * getattr(union, f"{quantity}_gradient")
    np.testing.assert_allclose(after.points, expected, atol=1e-14)


SHAPES = {
    "curve": (rough_sphere(2, 200), 0.06),
    "sphere": (rough_sphere(3, 800), 0.25),
    "torus": (
        oracles.random_torus(800)[0] + 0.03 * np.random.default_rng(2).normal(size=(800, 3)),
        0.28,
    ),
}


@every_quantity
@pytest.mark.parametrize("shape", SHAPES)
def test_automatic_steps_decrease_the_energy(shape: str, quantity: Quantity) -> None:
    points, radius = SHAPES[shape]
    energy = BallEnergy(radius, quantity, "cell")
    values = [state.evaluation.value for state in euler_flow(energy, points, 15)]
    assert all(after < before for before, after in pairwise(values))


@every_weight
@every_dimension
def test_automatic_steps_stay_in_the_hull(dimension: int, weight: Weight) -> None:
    """A step is a mean of a point and its neighbours: no coordinate passes the extremes."""
    points = oracles.uniform_cloud(100, dimension)
    for before, after in pairwise(euler_flow(BallEnergy(0.3, "area", weight), points, 10)):
        assert (after.points.min(axis=0) >= before.points.min(axis=0)).all()
        assert (after.points.max(axis=0) <= before.points.max(axis=0)).all()


@pytest.mark.parametrize("step", [None, 1e-3])
def test_fixed_points_stay_and_act(step: float | None) -> None:
    points = rough_sphere(3, 200)
    fixed = np.zeros(200, dtype=bool)
    fixed[::7] = True
    energy = BallEnergy(0.4)
    free, held, absent = (
        list(euler_flow(energy, *arguments))
        for arguments in (
            (points, 5, step, None),
            (points, 5, step, fixed),
            (points[~fixed], 5, step, None),
        )
    )
    assert last(held).points[fixed].tobytes() == points[fixed].tobytes()
    assert not last(held).moves[fixed].any()
    np.testing.assert_array_equal(held[1].points[~fixed], free[1].points[~fixed])
    assert (held[2].points[~fixed] != free[2].points[~fixed]).any()
    assert (held[1].points[~fixed] != absent[1].points).any()


@every_quantity
@every_dimension
def test_coincident_points_move_as_one(dimension: int, quantity: Quantity) -> None:
    points = oracles.uniform_cloud(80, dimension)
    twice = np.r_[points, points[:30]]
    energy = BallEnergy(0.25, quantity)
    alone = last(list(euler_flow(energy, points, 3, 1e-4)))
    together = last(list(euler_flow(energy, twice, 3, 1e-4)))
    np.testing.assert_array_equal(together.points[80:], together.points[:30])
    np.testing.assert_allclose(together.points[:80], alone.points, rtol=0, atol=1e-13)
    np.testing.assert_array_equal(together.moves[80:], together.moves[:30])
    assert together.moves[:30].any()


@pytest.mark.parametrize("twin", [0, 1])
def test_coincident_points_stay_if_one_is_fixed(twin: int) -> None:
    points = np.array([[0.0, 0.0], [0.0, 0.0], [0.7, 0.0], [0.2, 0.5]])
    fixed = np.arange(4) == twin
    end = last(list(euler_flow(BallEnergy(0.5), points, 3, fixed=fixed)))
    np.testing.assert_array_equal(end.points[:2], points[:2])
    assert (end.points[2:] != points[2:]).any(axis=1).all()


@every_quantity
@every_weight
@every_dimension
def test_isolated_points_stay(dimension: int, quantity: Quantity, weight: Weight) -> None:
    points = np.r_[np.eye(dimension), 10 + 0.5 * np.eye(dimension)]
    end = last(list(euler_flow(BallEnergy(0.5, quantity, weight), points, 3)))
    np.testing.assert_array_equal(end.points[:dimension], points[:dimension])
    assert end.moves[dimension:].all()
    alone = last(list(euler_flow(BallEnergy(0.5, quantity, weight), points[:dimension], 3)))
    np.testing.assert_array_equal(alone.points, points[:dimension])
    assert alone.step == 0


@pytest.mark.parametrize("step", [None, 0.1])
def test_no_iterations_yield_the_input(step: float | None) -> None:
    points = rough_sphere(2, 50)
    (state,) = euler_flow(BallEnergy(0.3), points, 0, step)
    np.testing.assert_array_equal(state.points, points)
    assert state.iteration == 0
    assert not state.moves.any()


@every_quantity
@every_dimension
@pytest.mark.parametrize("step", [None, 1e-3])
def test_covered_points_rest_under_the_boundary_weight(
    dimension: int, quantity: Quantity, step: float | None
) -> None:
    shift = 0.1 * np.eye(1, dimension)
    points = np.r_[shift, 1.05 * np.eye(dimension), -np.eye(dimension)]
    energy = BallEnergy(1.0, quantity, "boundary")
    states = list(euler_flow(energy, points, 1, step))
    assert states[0].evaluation.masses[0] == 0
    np.testing.assert_array_equal(states[1].points[0], points[0])
    assert (states[1].moves[1:] > 0).all()


@every_quantity
@every_weight
@every_dimension
def test_two_points_meet(dimension: int, quantity: Quantity, weight: Weight) -> None:
    """Each goes nine tenths of the way to the other, so that a step leaves -0.8 of their arm."""
    points = np.array([[1.0, 2.0, 3.0], [1.0, 2.5, 3.0]])[:, :dimension]
    states = list(euler_flow(BallEnergy(1.0, quantity, weight), points, 20))
    for k, state in enumerate(states):
        np.testing.assert_allclose(state.points.mean(axis=0), [1, 2.25, 3][:dimension], rtol=1e-14)
        arm = state.points[1] - state.points[0]
        np.testing.assert_allclose(arm, (-0.8) ** k * (points[1] - points[0]), atol=1e-13)
