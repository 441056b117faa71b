"""What every method offers to those who carry it out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

from pcsmooth.filters.plan import FilterPlan
from pcsmooth.flows.implicit import Order
from pcsmooth.measured import Measured
from pcsmooth.methods.motion import Motion
from pcsmooth.methods.shapes import Balls
from pcsmooth.neighbors.local_radii import LocalRadii
from pcsmooth.parts.cloud_state import CloudState
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Parts
from pcsmooth.record import Record

MethodName = Literal["filter", "euler", "implicit"]


@dataclass(frozen=True, eq=False)
class Moved:
    """Where a method has taken a cloud.

    Attributes
    ----------
    state : CloudState
        The cloud.
    radius : float
        Of the shapes, L; the median of local radii.
    local : LocalRadii or None
        Radii of the balls, if each has its own.
    plan : FilterPlan or None
        What was found of its noise, if that was to be known and there was enough to tell.
    step : float
        Time step; 0 for a filter.
    outliers : Column or None
        Marks of points taken for outliers, if it looks for any.
    solver_iterations : tuple of int
        Iterations of the solver of linear equations in each step, if there is one.
    solver_error : float
        Bound of the error that it has left, in the worst step.
    noise : Column or None
        Noise of each point, L, if it is a filter's and differs from place to place.
    left : Column or None
        Standard deviation of the error that is left of it, L, if a filter has moved points.
    """

    state: CloudState
    radius: float
    local: LocalRadii | None = None
    plan: FilterPlan | None = None
    step: float = 0.0
    outliers: Column | None = None
    solver_iterations: tuple[int, ...] = ()
    solver_error: float = 0.0
    noise: Column | None = None
    left: Column | None = None


class Method(Protocol):
    """A way to denoise a cloud."""

    @property
    def name(self) -> MethodName:
        """What it is called."""

    @property
    def shapes(self) -> Balls:
        """Shapes whose union is measured."""

    @property
    def iterations(self) -> int:
        """Number of steps, >= 0."""

    @property
    def order(self) -> Order | None:
        """Order of implicit steps."""

    def stages(self, motion: Motion) -> int:
        """How many stages a run of a cloud in one part has at most, estimates included."""

    @property
    def whole_cloud_for(self) -> str:
        """Name what of it needs the whole cloud; nothing if it can be done in parts."""

    def unit_of_step(self, cloud: Measured) -> float:
        """Give what time steps on a cloud are multiples of, in the unit of the input."""

    def move(
        self,
        parts: Parts,
        measured: Measured,
        motion: Motion,
        note: Callable[[Record], None],
    ) -> Moved:
        """Move the points of a cloud.

        Parameters
        ----------
        parts : Parts
            The cloud.
        measured : Measured
            Its size and spacing.
        motion : Motion
            How points may move.
        note : callable
            Gets the record of each state but the last.
        """
