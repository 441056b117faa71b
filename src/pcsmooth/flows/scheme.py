"""What every time-stepping scheme offers to a flow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.protocol import Evaluation
from pcsmooth.flows.state import State


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
    outliers : ndarray of bool, shape (n,), optional
        Points that the scheme took for outliers, of coincident ones the carrier.
    """

    vectors: npt.NDArray[np.float64]
    iterations: int = 0
    error: float = 0.0
    outliers: npt.NDArray[np.bool_] | None = None


class Scheme(Protocol):
    """A way to go from one state of a gradient flow to the next."""

    def time_step(self, evaluation: Evaluation) -> float:
        """Choose the time step of the whole flow from its first state."""

    def displacement(self, state: State, held: npt.NDArray[np.bool_]) -> Displacement:
        """Find where a step of length state.step goes; the points that are held do not move.

        Parameters
        ----------
        state : State
            Where the points are.
        held : ndarray of bool, shape (n,)
            Points whose position does not change; they are to get displacement 0.
        """
