"""Gradient flows: a cloud moved step by step so that an energy decreases."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.protocol import Energy, Evaluation

#: Share of the way to the weighted mean of its neighbours that a point may go in one automatic
#: step; below 1 so that two points alone do not change places for ever.
_LONGEST_MOVE = 0.9


@dataclass(frozen=True)
class State:
    """A cloud on its way.

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
        The time step of the flow (the gradient over the masses times this is the displacement).
    """

    iteration: int
    points: npt.NDArray[np.float64]
    evaluation: Evaluation
    moves: npt.NDArray[np.float64]
    step: float


def euler_flow(
    energy: Energy,
    points: npt.NDArray[np.float64],
    iterations: int,
    step: float | None = None,
    fixed: npt.NDArray[np.bool_] | None = None,
) -> Iterator[State]:
    """Explicit Euler steps p <- p - step * gradient / mass (report, Eq. 2.4).

    Parameters
    ----------
    energy : Energy
        What to decrease.
    points : ndarray, shape (n, d)
        Finite positions, n >= 1.
    iterations : int
        Number of steps, >= 0.
    step : float, optional
        Constant time step, applied as it is. By default the inverse of the median of
        diagonal / mass over the points: the gradient being a weighted graph Laplacian, that
        takes the median point to the weighted mean of its neighbours. Points that are stiffer
        than that are slowed down to nine tenths of the way to their own mean; with this no
        step of a union of balls leaves the convex hull of a point and its neighbours, and the
        flow is stable.
    fixed : ndarray of bool, shape (n,), optional
        Points that act on the others and do not move.

    Yields
    ------
    State
        The states 0 (the input) to `iterations`.

    Notes
    -----
    Coincident points move together; if one of them is fixed they all are. Points of mass 0
    (no visible boundary, under the boundary weight) rest.
    """
    evaluation = energy.evaluate(points)
    limited = step is None
    if step is None:
        step = _automatic_step(evaluation)
    moves = np.zeros(len(points))
    for iteration in range(iterations + 1):
        if iteration > 0:
            displacement = _displacement(evaluation, step, limited, fixed)
            points = points + displacement
            moves = np.linalg.norm(displacement, axis=1)
            evaluation = energy.evaluate(points)
        yield State(iteration, points, evaluation, moves, step)


def _automatic_step(evaluation: Evaluation) -> float:
    """Time in which the median point reaches the weighted mean of its neighbours."""
    moving = (evaluation.diagonal > 0.0) & (evaluation.masses > 0.0)
    if not moving.any():
        return 0.0  # isolated points: nothing will move
    return float(1.0 / np.median(evaluation.diagonal[moving] / evaluation.masses[moving]))


def _displacement(
    evaluation: Evaluation,
    step: float,
    limited: bool,
    fixed: npt.NDArray[np.bool_] | None,
) -> npt.NDArray[np.float64]:
    """One step's displacement, (n, d)."""
    masses = evaluation.masses
    rate = np.divide(step, masses, out=np.zeros_like(masses), where=masses > 0.0)
    if limited:
        with np.errstate(divide="ignore"):
            rate = np.minimum(rate, _LONGEST_MOVE / evaluation.diagonal)
    displacement = -rate[:, np.newaxis] * evaluation.gradient
    carriers = evaluation.union.carriers
    if fixed is not None:
        held = np.zeros(len(fixed), dtype=bool)
        held[carriers[fixed]] = True
        displacement[held] = 0.0
    return displacement[carriers]
