"""One state of a flow."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.balls import BallUnion, measure_balls
from pcsmooth.energies.protocol import Evaluation


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
        The time step of the flow (in an Euler step the gradient over the masses times this is the
        displacement).
    solver_iterations : int
        Iterations of the solver of linear equations in the last step; 0 if there is none.
    solver_error : float
        Bound of the last step's relative error: see `Displacement.error`.
    outliers : ndarray of bool, shape (n,), optional
        Points that the scheme of the last step took for outliers, if it looks for any.
    box : ndarray, shape (2, d), optional
        Bounding box of the whole cloud, L, if the points are a part of one.
    """

    iteration: int
    points: npt.NDArray[np.float64]
    evaluation: Evaluation
    moves: npt.NDArray[np.float64]
    step: float
    solver_iterations: int = 0
    solver_error: float = 0.0
    outliers: npt.NDArray[np.bool_] | None = None
    box: npt.NDArray[np.float64] | None = None

    @cached_property
    def balls(self) -> BallUnion:
        """The union of balls of the energy's radius, whatever the shapes of the energy."""
        union = self.evaluation.union
        return (
            union
            if isinstance(union, BallUnion)
            else measure_balls(self.points, union.radius, self.box)
        )
