"""The filter, as it is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from pcsmooth.filters.plan import FilterPlan
from pcsmooth.flows.filtering import Filtering
from pcsmooth.lengths import check_length, check_radius
from pcsmooth.methods.measured import Measured
from pcsmooth.methods.method import MethodName
from pcsmooth.methods.motion import Motion
from pcsmooth.methods.shapes import Balls


@dataclass(frozen=True, kw_only=True)
class Filter:
    """A filter that measures what it needs (see `filter_points`).

    Attributes
    ----------
    noise : float or str, optional
        Standard deviation of the noise: a length, ``"0.5x"`` the spacing or ``"0.1%"`` of the
        bounding box's diagonal. By default it is measured (see `measure_noise`). More smooths
        more.
    radius : float or str
        Of the balls on whose union volume, area and normals are measured (see `Balls`).

    Raises
    ------
    InvalidInputError
        A value is none of these.
    """

    noise: float | str | None = None
    radius: float | str = "auto"

    name: ClassVar[MethodName] = "filter"
    iterations: ClassVar[int] = 1
    order: ClassVar[None] = None
    stop: ClassVar[None] = None
    needs_plan: ClassVar[bool] = True
    moves_along_normals: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the values."""
        check_radius(self.radius)
        if self.noise is not None:
            check_length(self.noise, "noise")

    @property
    def shapes(self) -> Balls:
        """Balls whose union is measured."""
        return Balls(radius=self.radius)

    def told_noise(self, cloud: Measured) -> float | None:
        """Give the noise's standard deviation in the cloud's unit, unless it is to be measured."""
        return None if self.noise is None else cloud.length(self.noise, "noise")

    def unit_of_step(self, _cloud: Measured) -> float:
        """Return 1: a filter takes no time."""
        return 1.0

    def scheme(self, _cloud: Measured, plan: FilterPlan | None, motion: Motion) -> Filtering:
        """Make what takes the step."""
        return Filtering(plan, motion.direction == "free")
