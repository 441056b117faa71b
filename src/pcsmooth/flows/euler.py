"""Explicit Euler steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.flows.scheme import Displacement, Values
from pcsmooth.flows.state import State

#: Share of the way to the weighted mean of its neighbours that a point may go in one automatic
#: step; below 1 so that two points alone do not change places for ever.
_LONGEST_MOVE = 0.9


@dataclass(frozen=True)
class Euler:
    """Explicit Euler steps p <- p - step * gradient / mass (report, Eq. 2.4).

    Attributes
    ----------
    step : float, optional
        Constant time step, applied as it is. By default the inverse of the median of
        diagonal / mass over the points: the gradient being a weighted graph Laplacian, that
        takes the median point to the weighted mean of its neighbours. Points that are stiffer
        than that are slowed down to nine tenths of the way to their own mean; with this no
        step of a union of balls leaves the convex hull of a point and its neighbours, and the
        flow is stable.

    Notes
    -----
    Points of mass 0 (no visible boundary, under the boundary weight) rest.
    """

    step: float | None = None

    @property
    def time_scale(self) -> Values | None:
        """The stiffness of the points, if the step is to be chosen."""
        return stiffness if self.step is None else None

    @property
    def balance(self) -> None:
        """Nothing: steps look at their own points."""

    def time_step(self, median: float | None) -> float:
        """Time in which the median point reaches the weighted mean of its neighbours."""
        if self.step is not None:
            return self.step
        return 0.0 if median is None else 1.0 / median  # isolated points rest

    def reach(self, _step: float) -> float:
        """No farther than the energy."""
        return 0.0

    def displacement(self, state: State, held: npt.NDArray[np.bool_]) -> Displacement:
        """Go down the gradient, automatic steps no farther than is stable."""
        masses = state.evaluation.masses
        rate = np.divide(state.step, masses, out=np.zeros_like(masses), where=masses > 0.0)
        if self.step is None:
            with np.errstate(divide="ignore"):
                rate = np.minimum(rate, _LONGEST_MOVE / state.evaluation.diagonal)
        vectors = -rate[:, np.newaxis] * state.evaluation.gradient
        vectors[held] = 0.0
        return Displacement(vectors)


def stiffness(state: State) -> npt.NDArray[np.float64]:
    """Inverse of the time in which each point reaches the mean of its neighbours, (n,).

    NaN for points that do not move.
    """
    evaluation = state.evaluation
    moving = (evaluation.diagonal > 0.0) & (evaluation.masses > 0.0)
    rates = np.full(len(moving), np.nan)
    np.divide(evaluation.diagonal, evaluation.masses, out=rates, where=moving)
    return rates
