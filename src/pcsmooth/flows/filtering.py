"""A filter as a scheme: one step, which takes the noise out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.protocol import Evaluation
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.filters.surface_filter import filter_points
from pcsmooth.flows.scheme import Displacement
from pcsmooth.flows.state import State


@dataclass(frozen=True)
class Filtering:
    """The filter of `filter_points` in place of a step down an energy's gradient.

    Attributes
    ----------
    plan : FilterPlan or None
        What `plan_filter` chose for the cloud.
    evens : bool
        Whether points also move along the surface, to be spread more evenly.
    on_pass : callable, optional
        Called after each pass.
    """

    plan: FilterPlan | None
    evens: bool = True
    on_pass: Callable[[], None] | None = None

    def time_step(self, _evaluation: Evaluation) -> float:
        """Return 0: a filter takes no time."""
        return 0.0

    def displacement(self, state: State, held: npt.NDArray[np.bool_]) -> Displacement:
        """Filter the distinct positions."""
        numbers = state.balls.numbers
        filtered = filter_points(
            state.points[numbers], self.plan, held[numbers], evens=self.evens,
            on_pass=self.on_pass,
        )  # fmt: skip
        vectors = np.zeros_like(state.points)
        vectors[numbers] = filtered.points - state.points[numbers]
        outliers = np.zeros(len(held), np.bool_)
        outliers[numbers] = filtered.outliers
        return Displacement(vectors, outliers=outliers)
