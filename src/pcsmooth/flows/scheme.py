"""What every time-stepping scheme offers to a flow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from pcsmooth.flows.state import State

#: Makes numbers (n,) of the points of a state; NaN for points that do not count.
Values = Callable[[State], npt.NDArray[np.float64]]


@dataclass(frozen=True)
class Displacement:
    """Where one step takes the points.

    Attributes
    ----------
    vectors : ndarray, shape (n, d)
        From old to new positions, L; of coincident points only those of the carrier count.
    iterations : int
        Iterations of a solver of linear equations; 0 if there is none.
    error : float
        Bound of the error that the solver has left, as a share of the displacement, both RMS over
        the points weighted by their masses.
    """

    vectors: npt.NDArray[np.float64]
    iterations: int = 0
    error: float = 0.0


class Scheme(Protocol):
    """A way to go from one state of a gradient flow to the next.

    What depends on all points of a cloud, of which a step sees a part, are two medians.
    """

    @property
    def time_scale(self) -> Values | None:
        """Numbers whose median over the first state the time step is made of, if there are any."""

    @property
    def balance(self) -> Values | None:
        """Numbers whose median over its state each step has to know, if there are any."""

    def time_step(self, median: float | None) -> float:
        """Choose the time step of the whole flow.

        Parameters
        ----------
        median : float or None
            Of the time scale; None if there is none, or no point counts.
        """

    def reach(self, step: float) -> float:
        """How far a step of this length looks beyond the energy, along an axis, L."""

    def displacement(self, state: State, held: npt.NDArray[np.bool_]) -> Displacement:
        """Find where a step of length state.step goes; the points that are held do not move.

        Parameters
        ----------
        state : State
            Where the points are.
        held : ndarray of bool, shape (n,)
            Points whose position does not change; they are to get displacement 0.
        """
