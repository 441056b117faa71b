from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import oracles
from flows.dense import rough_sphere
from oracles import Array
from pcsmooth.bodies.presets import load_presets
from pcsmooth.energies.balls import BallEnergy, measure_balls
from pcsmooth.energies.polyhedra.union import PolyhedronEnergy
from pcsmooth.energies.protocol import Energy
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import run_flow
from pcsmooth.flows.implicit import Implicit
from pcsmooth.flows.restraint import Restraint
from pcsmooth.flows.scheme import Scheme
from pcsmooth.flows.state import State
from pcsmooth.parts.part import Part
from pcsmooth.parts.whole_cloud import WholeCloud

SCHEMES = {"euler": Euler(), "first order": Implicit(0.1, 1), "second order": Implicit(0.1, 2)}
every_scheme = pytest.mark.parametrize("scheme", SCHEMES.values(), ids=SCHEMES)
RESTRAINTS = {
    "free": Restraint(),
    "normal": Restraint(along_normals=True),
    "volume": Restraint(keeps_volume=True),
    "all": Restraint(along_normals=True, keeps_volume=True, longest=0.01),
}
every_restraint = pytest.mark.parametrize("restraint", RESTRAINTS.values(), ids=RESTRAINTS)


@every_scheme
@every_restraint
def test_fixed_points_and_their_twins_stay_and_act(scheme: Scheme, restraint: Restraint) -> None:
    points = rough_sphere(300)
    points[1::14] = points[::14][: len(points[1::14])]
    fixed = np.zeros(300, dtype=bool)
    fixed[::7] = True
    held = fixed.copy()
    held[1::14] = True
    energy = BallEnergy(0.4)
    *_, free = run_flow(energy, points, scheme, 3, restraint=restraint)
    *_, state = run_flow(energy, points, scheme, 3, restraint=restraint, fixed=fixed)
    assert state.points[held].tobytes() == points[held].tobytes()
    assert not state.moves[held].any()
    assert (state.moves[~held] > 0).all()
    assert (state.points[~held] != free.points[~held]).any()


@every_scheme
def test_flow_stops_when_steps_are_short(scheme: Scheme) -> None:
    points = rough_sphere(300)
    energy = BallEnergy(0.4)
    moves = [state.moves.mean() for state in run_flow(energy, points, scheme, 6)][1:]
    limit = 1.01 * min(moves)
    expected = next(k for k, move in enumerate(moves, 1) if move < limit)
    states = list(run_flow(energy, points, scheme, 6, least_move=limit))
    assert [state.iteration for state in states] == list(range(expected + 1))


def test_fixed_points_do_not_stop_a_flow() -> None:
    points = rough_sphere(300)
    fixed = np.arange(300) > 10
    *_, free = run_flow(BallEnergy(0.4), points, Euler(), 1)
    limit = 0.3 * free.moves[~fixed].mean()
    assert free.moves[~fixed].sum() / 300 < limit
    states = list(run_flow(BallEnergy(0.4), points, Euler(), 2, fixed=fixed, least_move=limit))
    assert len(states) == 3
    everything = np.ones(300, bool)
    assert (
        len(list(run_flow(BallEnergy(0.4), points, Euler(), 2, fixed=everything, least_move=1.0)))
        == 3
    )


def test_points_at_rest_stop_a_flow() -> None:
    states = list(run_flow(BallEnergy(0.4), np.eye(3), Euler(), 5, least_move=1e-9))
    assert [state.iteration for state in states] == [0, 1]


@dataclass(frozen=True)
class Look:
    """A step that gives the state of a part."""

    energy: Energy
    box: Array

    reach = 0.0

    def __call__(self, part: Part) -> State:
        return State(part, self.energy.evaluate(part.points, self.box), self.box)


def state_of(energy: Energy, points: Array) -> State:
    cloud = WholeCloud.as_it_is(points)
    (state,) = cloud.map("look", Look(energy, cloud.box), cloud.start)
    return state


def test_balls_of_a_state() -> None:
    points = oracles.uniform_cloud(50, 3)
    state = state_of(BallEnergy(0.3), points)
    assert state.balls is state.evaluation.union
    state = state_of(PolyhedronEnergy(0.3, load_presets()["cube"]), points)
    oracles.assert_same_measures(state.balls, measure_balls(points, 0.3), 1e-15)
    assert state.balls is state.balls
