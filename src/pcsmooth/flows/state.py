"""Points in a flow, as a scheme sees them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.balls import BallUnion
from pcsmooth.energies.on_parts import balls_of
from pcsmooth.energies.protocol import Evaluation
from pcsmooth.parts.part import Part


@dataclass(frozen=True, eq=False)
class State:
    """The points of a part of a cloud, or all of it, where a flow has taken them.

    Attributes
    ----------
    part : Part
        The points.
    evaluation : Evaluation
        The energy and all measures there.
    box : ndarray, shape (2, d)
        Bounding box of the whole cloud, L.
    step : float
        The time step of the flow (in an Euler step the gradient over the masses times this is the
        displacement).
    balance : float
        Median over the whole cloud of what `Scheme.balance` tells.
    """

    part: Part
    evaluation: Evaluation
    box: npt.NDArray[np.float64]
    step: float = 0.0
    balance: float = 1.0

    @property
    def points(self) -> npt.NDArray[np.float64]:
        """Positions, (n, d), L."""
        return self.part.points

    @cached_property
    def balls(self) -> BallUnion:
        """The union of balls of the energy's radius, whatever the shapes of the energy."""
        return balls_of(self.part, self.evaluation, self.box)
