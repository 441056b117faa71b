"""Gradient flows: a cloud moved step by step so that an energy decreases.

What a step does to a point depends on nothing but the points around it, in an order that is the
same in a part of the cloud as in the whole. The displacements are therefore the same to the last
bit, however the cloud is cut; but those of implicit steps, whose equations reach all over a
connected surface, and are solved for each part and what is noticeably near it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.on_parts import EVALUATION, EnergyStep, Totals, evaluate, sum_of
from pcsmooth.energies.protocol import Energy, Evaluation
from pcsmooth.flows.kept_volume import keep_volume
from pcsmooth.flows.restraint import FREE, Restraint
from pcsmooth.flows.scheme import Scheme, Values
from pcsmooth.flows.state import State
from pcsmooth.flows.wanted_step import WantedStep
from pcsmooth.parts.cloud_state import CloudState, Moves, next_state
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts, Reach
from pcsmooth.parts.streamed_median import streamed_median
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.record import Record


def time_step(parts: Parts, state: CloudState, energy: Energy, scheme: Scheme) -> float:
    """Choose the time step of a flow from its first state.

    Parameters
    ----------
    parts : Parts
        The cloud.
    state : CloudState
        Where it is.
    energy : Energy
        What is to decrease.
    scheme : Scheme
        How to step.
    """
    return scheme.time_step(_median(parts, state, energy, scheme.time_scale, "time step"))


def take_step(
    parts: Parts,
    state: CloudState,
    energy: Energy,
    scheme: Scheme,
    step: float,
    *,
    restraint: Restraint = FREE,
    least_move: float = 0.0,
    stage: str = "step",
) -> tuple[Record, CloudState]:
    """Take a step.

    Parameters
    ----------
    parts : Parts
        The cloud.
    state : CloudState
        Where it is.
    energy : Energy
        What is to decrease.
    scheme : Scheme
        How to step, such as `Euler` and `Implicit`.
    step : float
        Time step.
    restraint : Restraint
        How the points may move.
    least_move : float
        Mean move of the points that are not fixed, L, below which the cloud has converged.
    stage : str
        What the step is called.

    Returns
    -------
    record : Record
        Of the state before.
    state : CloudState
        The next one.

    Notes
    -----
    Coincident points move together; if one of them is fixed they all are.
    """
    balance = _median(parts, state, energy, scheme.balance, f"{stage}: stiffness")
    wanted = WantedStep(
        energy, scheme, step, 1.0 if balance is None else balance, parts.start, parts.fixed,
        state.box,
    )  # fmt: skip
    target = parts.create(f"points_{state.iteration + 1}", parts.start.dtype)
    if restraint.keeps_volume:
        found = keep_volume(parts, state, wanted, restraint, target, stage)
    else:
        taken = _Step(wanted, restraint, target)
        found = list(parts.map(stage, taken, state.points, state.drift))
    totals, moves = [total for total, _ in found], [move for _, move in found]
    parts.forget()
    parts.drop(f"points_{state.iteration}")
    return record_of(state, totals), next_state(parts, state, target, moves, least_move)


@dataclass(frozen=True, eq=False)
class FlowState:
    """One state of a flow of points in memory.

    Attributes
    ----------
    iteration : int
        Number of steps taken.
    points : ndarray, shape (n, d)
        The points now.
    evaluation : Evaluation
        The energy and all measures at these points.
    moves : ndarray, shape (n,)
        Length of each point's last step, L; zeros at the start.
    step : float
        The time step of the flow.
    solver_iterations, solver_error
        Of the last step: see `CloudState`.
    """

    iteration: int
    points: npt.NDArray[np.float64]
    evaluation: Evaluation
    moves: npt.NDArray[np.float64]
    step: float
    solver_iterations: int = 0
    solver_error: float = 0.0


def run_flow(
    energy: Energy,
    points: npt.NDArray[np.float64],
    scheme: Scheme,
    iterations: int,
    *,
    fixed: npt.NDArray[np.bool_] | None = None,
    restraint: Restraint = FREE,
    least_move: float = 0.0,
) -> Iterator[FlowState]:
    """Take steps with points in memory, in their order and unit.

    Parameters
    ----------
    energy : Energy
        What to decrease.
    points : ndarray, shape (n, d)
        Finite positions, L, n >= 1.
    scheme : Scheme
        How to step.
    iterations : int
        Number of steps, >= 0.
    fixed : ndarray of bool, shape (n,), optional
        Points that act on the others and do not move.
    restraint, least_move
        See `take_step`.

    Yields
    ------
    FlowState
        The states 0 (the input) to `iterations`, or to that at which the flow stops.
    """
    cloud = WholeCloud.as_it_is(points, fixed)
    state = CloudState.at_start(cloud)
    step = time_step(cloud, state, energy, scheme)
    moves = np.zeros(len(points))
    while True:
        now = state.points.read(0, cloud.count)
        evaluation = cloud.remembered(EVALUATION, partial(energy.evaluate, now))
        yield FlowState(
            state.iteration, now, evaluation, moves, step, state.solver_iterations,
            state.solver_error,
        )  # fmt: skip
        if state.iteration == iterations or state.converged:
            return
        _, state = take_step(
            cloud, state, energy, scheme, step, restraint=restraint, least_move=least_move
        )
        moves = np.linalg.norm(state.points.read(0, cloud.count) - now, axis=1)


def record_of(state: CloudState, totals: list[Totals]) -> Record:
    """Take down a state."""
    return Record(state.iteration, *sum_of(totals), state.mean_move, state.max_move)


@dataclass(frozen=True, eq=False)
class _Step:
    """Take the points of a part on; gives the energy, and what the step did.

    Attributes
    ----------
    wanted : WantedStep
        What the scheme wants.
    restraint : Restraint
        What of it is allowed.
    target : Column
        Gets the new positions, L.
    """

    wanted: WantedStep
    restraint: Restraint
    target: Column

    @property
    def reach(self) -> float | Reach:
        """As far as scheme and restraint look, one after the other."""
        return self.wanted.reach + self.restraint.reach(self.wanted.radius)

    def __call__(self, part: Part) -> tuple[Totals, Moves]:
        found = self.wanted.find(part)
        start = part.read(self.wanted.start)
        vectors = self.restraint.restrain(found.state, found.vectors, found.held, start)
        moved = part.points + vectors
        part.write(self.target, moved)
        moves = Moves.of(part, start, moved, vectors, found.held)
        return (
            Totals.of(part, found.state.evaluation),
            moves.solved(found.iterations, found.error),
        )


def _median(
    parts: Parts, state: CloudState, energy: Energy, values: Values | None, stage: str
) -> float | None:
    """Median over the points that count; None if nothing is asked for, or none counts."""
    if values is None:
        return None
    column = parts.create("values", np.float64)
    step = _WriteValues(energy, state.box, values, column)
    for _ in parts.map(stage, step, state.points, state.drift):
        pass

    def known() -> Iterator[npt.NDArray[np.float64]]:
        return (chunk[~np.isnan(chunk)] for chunk in column.chunks())

    median = streamed_median(known) if any(len(chunk) for chunk in known()) else None
    parts.drop("values")
    return median


@dataclass(frozen=True, eq=False)
class _WriteValues(EnergyStep):
    """Write numbers of the points of a part into a column."""

    values: Values
    column: Column

    def __call__(self, part: Part) -> None:
        state = State(part, evaluate(part, self.energy, self.box), self.box)
        part.write(self.column, self.values(state))
