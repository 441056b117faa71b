"""What every method offers to those who carry it out."""

from __future__ import annotations

from typing import Literal, Protocol

from pcsmooth.filters.plan import FilterPlan
from pcsmooth.flows.implicit import Order
from pcsmooth.flows.scheme import Scheme
from pcsmooth.methods.measured import Measured
from pcsmooth.methods.motion import Motion
from pcsmooth.methods.shapes import Balls

MethodName = Literal["filter", "euler", "implicit"]


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

    @property
    def stop(self) -> float | None:
        """Mean move of the free points that ends it, in spacings."""

    @property
    def needs_plan(self) -> bool:
        """Whether it has to know the noise."""

    @property
    def moves_along_normals(self) -> bool:
        """Whether it moves points along their normals by itself where it is to."""

    def told_noise(self, cloud: Measured) -> float | None:
        """Give the noise's standard deviation in the cloud's unit, unless it is to be measured."""

    def unit_of_step(self, cloud: Measured) -> float:
        """Give what time steps on a cloud are multiples of, in the unit of the input."""

    def scheme(self, cloud: Measured, plan: FilterPlan | None, motion: Motion) -> Scheme:
        """Make what takes the steps.

        Parameters
        ----------
        cloud : Measured
            Size and spacing of the cloud.
        plan : FilterPlan or None
            What was found of its noise, if there was enough to tell.
        motion : Motion
            How points may move.
        """
