"""Gradient flows: a cloud moved step by step so that an energy decreases."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.protocol import Energy
from pcsmooth.flows.restraint import FREE, Restraint
from pcsmooth.flows.scheme import Displacement, Scheme
from pcsmooth.flows.state import State


def run_flow(
    energy: Energy,
    points: npt.NDArray[np.float64],
    scheme: Scheme,
    iterations: int,
    *,
    fixed: npt.NDArray[np.bool_] | None = None,
    restraint: Restraint = FREE,
    stop: float = 0.0,
) -> Iterator[State]:
    """Take steps of a scheme.

    Parameters
    ----------
    energy : Energy
        What to decrease.
    points : ndarray, shape (n, d)
        Finite positions, n >= 1.
    scheme : Scheme
        How to step, such as `Euler`, `Implicit` and `Filtering`.
    iterations : int
        Number of steps, >= 0.
    fixed : ndarray of bool, shape (n,), optional
        Points that act on the others and do not move.
    restraint : Restraint
        How the points may move.
    stop : float
        End after the step in which the points that are not fixed move less than this on
        average, L.

    Yields
    ------
    State
        The states 0 (the input) to `iterations`, or to that at which the flow stops.

    Notes
    -----
    Coincident points move together; if one of them is fixed they all are.
    """
    evaluation = energy.evaluate(points)
    state = State(0, points, evaluation, np.zeros(len(points)), scheme.time_step(evaluation))
    yield state
    while state.iteration < iterations:
        displacement, held = next_displacement(state, scheme, points, fixed, restraint)
        moved = state.points + displacement.vectors
        state = State(
            state.iteration + 1,
            moved,
            energy.evaluate(moved),
            np.linalg.norm(displacement.vectors, axis=1),
            state.step,
            displacement.iterations,
            displacement.error,
            displacement.outliers,
        )
        yield state
        if state.moves[~held].sum() < stop * np.count_nonzero(~held):
            break


def next_displacement(
    state: State,
    scheme: Scheme,
    start: npt.NDArray[np.float64],
    fixed: npt.NDArray[np.bool_] | None,
    restraint: Restraint,
) -> tuple[Displacement, npt.NDArray[np.bool_]]:
    """Find where the next step takes every point.

    Parameters
    ----------
    state : State
        Where the points are.
    scheme : Scheme
        How to step.
    start : ndarray, shape (n, d)
        Where they were at first, L.
    fixed : ndarray of bool, shape (n,), optional
        Points that do not move.
    restraint : Restraint
        How the points may move.

    Returns
    -------
    displacement : Displacement
        What the scheme wants, as far as the motion allows it, of all points.
    held : ndarray of bool, shape (n,)
        Those that are fixed or coincide with one that is.
    """
    carriers = state.evaluation.union.carriers
    held = np.zeros(len(start), dtype=bool)
    if fixed is not None:
        held[carriers[fixed]] = True
    wanted = scheme.displacement(state, held)
    held = held[carriers]
    outliers = None if wanted.outliers is None else wanted.outliers[carriers]
    rests = held if outliers is None else held | outliers
    vectors = restraint.restrain(state, wanted.vectors[carriers], rests, start)
    return replace(wanted, vectors=vectors, outliers=outliers), held
