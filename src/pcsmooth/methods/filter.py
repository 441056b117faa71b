"""The filter, as it is asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from pcsmooth.energies.on_parts import Measure
from pcsmooth.filters.design import DESIGN, FilterDesign
from pcsmooth.filters.planning import plan_filter
from pcsmooth.filters.surface_filter import filter_points
from pcsmooth.flows.flow import record_of
from pcsmooth.lengths import check_length, check_radius
from pcsmooth.measured import Measured
from pcsmooth.methods.method import MethodName, Moved
from pcsmooth.methods.motion import Motion
from pcsmooth.methods.shapes import Balls
from pcsmooth.parts.cloud_state import CloudState
from pcsmooth.parts.part import Parts
from pcsmooth.record import Record


@dataclass(frozen=True, kw_only=True)
class Filter:
    """A filter that measures what it needs (see `filter_points`).

    Attributes
    ----------
    noise : float or str, optional
        Standard deviation of the noise: a length, ``"0.5x"`` the spacing or ``"0.1%"`` of the
        bounding box's diagonal. By default it is measured (see `measure_noise`). More smooths
        more.
    closed : bool
        Whether points are told to lie on closed surfaces. Both sides of parts that are no thicker
        than a few times the noise are then told apart (see `find_winding_field`).
    radius : float or str
        Of the balls on whose union volume, area and normals are measured (see `Balls`). If it is
        local, a volume that is kept is that of balls of the median radius.
    design : FilterDesign
        Numbers of the filter, so that others can be tried.

    Raises
    ------
    InvalidInputError
        A value is none of these.
    """

    noise: float | str | None = None
    closed: bool = False
    radius: float | str = "auto"
    design: FilterDesign = DESIGN

    name: ClassVar[MethodName] = "filter"
    iterations: ClassVar[int] = 1
    order: ClassVar[None] = None

    def __post_init__(self) -> None:
        """Check the values."""
        check_radius(self.radius)
        if self.noise is not None:
            check_length(self.noise, "noise")

    @property
    def shapes(self) -> Balls:
        """Balls whose union is measured."""
        return Balls(radius=self.radius)

    @property
    def whole_cloud_for(self) -> str:
        """What of the shapes needs it."""
        return self.shapes.whole_cloud_for

    def stages(self, motion: Motion) -> int:
        """How many stages a run has at most."""
        return 20 + 2 * motion.keep_volume

    def unit_of_step(self, _measured: Measured) -> float:
        """Return 1: a filter takes no time."""
        return 1.0

    def move(
        self,
        parts: Parts,
        measured: Measured,
        motion: Motion,
        note: Callable[[Record], None],
    ) -> Moved:
        """Take the noise out of a cloud: see `filter_points`."""
        told = None if self.noise is None else measured.noise(self.noise)
        local = measured.local_radii(self.radius, parts, may_choose=True)
        radius = measured.radius(self.radius) if local is None else local.median
        parts.check_width(parts.box, 2.0 * radius, "the diameter of the balls")
        plan = plan_filter(parts, measured.distinct, told, self.design, closed=self.closed)
        restraint = motion.restraint(measured, moves_along_normals=True)
        start = CloudState.at_start(parts)
        step = Measure(self.shapes.energy(radius, local), start.box)
        note(record_of(start, list(parts.map("energy", step, start.points))))
        parts.forget()
        is_free = motion.direction == "free"
        filtered = filter_points(parts, plan, radius, restraint=restraint, redistribute=is_free)
        return Moved(
            filtered.state, radius, local, plan,
            outliers=filtered.outliers, noise=filtered.noise, left=filtered.left,
        )  # fmt: skip
