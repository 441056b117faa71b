"""Gradient flows, as they are asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

from pcsmooth.energies.weighting import power_of_step
from pcsmooth.errors import InvalidInputError
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.filters.planning import plan_filter
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import take_step, time_step
from pcsmooth.flows.implicit import Implicit, Order
from pcsmooth.flows.scheme import Scheme
from pcsmooth.lengths import check_length, local_multiple, step_in_unit
from pcsmooth.measured import Measured
from pcsmooth.methods.checks import check_count, check_positive
from pcsmooth.methods.method import MethodName, Moved
from pcsmooth.methods.motion import Motion
from pcsmooth.methods.shapes import Balls, Polyhedra
from pcsmooth.parts.cloud_state import CloudState
from pcsmooth.parts.part import Parts
from pcsmooth.record import Record


@dataclass(frozen=True, kw_only=True)
class _Flow:
    """What all flows have."""

    shapes: Balls = field(default_factory=Balls)
    iterations: int
    step: float | Literal["auto"] = "auto"
    stop: float | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        check_count("iterations", self.iterations)
        object.__setattr__(self, "iterations", int(self.iterations))
        if self.step != "auto":
            check_positive("step", self.step, "auto")
        if self.stop is not None:
            check_positive("stop", self.stop, "None")

    def stages(self, motion: Motion) -> int:
        """How many stages a run has at most: each step, and what goes before and comes after."""
        of_step = 1 + motion.keep_volume + isinstance(self.shapes, Polyhedra)
        return of_step * self.iterations + 10

    @property
    def whole_cloud_for(self) -> str:
        """What of the shapes needs it."""
        return self.shapes.whole_cloud_for

    def unit_of_step(self, cloud: Measured) -> float:
        """Give what time steps on a cloud are multiples of."""
        shapes = self.shapes
        power = power_of_step(shapes.quantity, shapes.weight, cloud.dimension)
        return float(cloud.unit**power)

    def move(
        self,
        parts: Parts,
        measured: Measured,
        motion: Motion,
        note: Callable[[Record], None],
    ) -> Moved:
        """Take steps until all are taken or points rest: see `take_step`."""
        local = measured.local_radii(self.shapes.radius, parts, may_choose=False)
        radius = measured.radius(self.shapes.radius) if local is None else local.median
        parts.check_width(parts.box, 2.0 * radius, "the diameter of the balls")
        plan, scheme = self._planned(parts, measured, radius)
        restraint = motion.restraint(measured, moves_along_normals=False)
        energy = self.shapes.energy(radius, local)
        state = CloudState.at_start(parts)
        step = time_step(parts, state, energy, scheme)
        solved, error = [], 0.0
        while state.iteration < self.iterations and not state.converged:
            record, state = take_step(
                parts, state, energy, scheme, step, restraint=restraint,
                least_move=0.0 if self.stop is None else self.stop * measured.spacing,
                stage=f"step {state.iteration + 1} of {self.iterations}",
            )  # fmt: skip
            note(record)
            if state.solver_iterations:
                solved.append(state.solver_iterations)
            error = max(error, state.solver_error)
        return Moved(state, radius, local, plan, step, None, tuple(solved), error)

    def _planned(
        self, parts: Parts, measured: Measured, radius: float
    ) -> tuple[FilterPlan | None, Scheme]:
        """Make what takes the steps, and find out about the noise if it has to know."""
        raise NotImplementedError

    def given_step(self, cloud: Measured) -> float | None:
        """Time step in the cloud's unit, if it is not to be chosen."""
        return step_in_unit(self.step, self.unit_of_step(cloud))


@dataclass(frozen=True, kw_only=True)
class EulerFlow(_Flow):
    """Explicit steps down the gradient of an energy, as in the thesis (see `Euler`).

    Attributes
    ----------
    shapes : Balls or Polyhedra
        Whose union is measured.
    iterations : int
        Number of steps, >= 0.
    step : float or "auto"
        Time step; in units of L^2 under a weight. ``"auto"`` is stable.
    stop : float, optional
        End after the step in which the points that are not fixed move less than this on average,
        in units of the spacing.

    Raises
    ------
    InvalidInputError
        A value is none of these.

    Notes
    -----
    Of steps of the automatic length 6 remove most noise before shrinkage is felt: the error on a
    torus and a sphere of 20,000 points with noise of 0.36 spacings is least after 6 to 8.
    """

    iterations: int = 6

    order: ClassVar[None] = None
    name: ClassVar[MethodName] = "euler"

    def _planned(self, _parts: Parts, measured: Measured, _radius: float) -> tuple[None, Scheme]:
        return None, Euler(self.given_step(measured))


@dataclass(frozen=True, kw_only=True)
class ImplicitFlow(_Flow):
    """Semi-implicit steps, which are stable whatever their length (see `Implicit`).

    Attributes
    ----------
    shapes, iterations, step, stop
        As those of `EulerFlow`. An automatic step is made of the noise.
    order : {1, 2}
        Mean curvature flow, or surface diffusion, which shrinks far less. By default 2, with
        polyhedra 1.
    noise : float or str, optional
        Standard deviation of the noise, as `Filter` has it.

    Raises
    ------
    InvalidInputError
        A value is none of these, order 2 is wanted of polyhedra, gradients are to be found by
        automatic differentiation, or the area is of shapes of local radius.
    """

    iterations: int = 2
    order: Order | None = None
    noise: float | str | None = None

    name: ClassVar[MethodName] = "implicit"

    def __post_init__(self) -> None:
        """Check the values."""
        super().__post_init__()
        if self.order not in (None, 1, 2):
            raise InvalidInputError(f"order is {self.order!r}; it must be 1 or 2")
        if self.noise is not None:
            check_length(self.noise, "noise")
        is_polyhedral = isinstance(self.shapes, Polyhedra)
        if self.order == 2 and is_polyhedral:
            raise InvalidInputError(
                "the order is 2, which is for balls, not polyhedra; use order 1 or scheme euler"
            )
        if self.shapes.gradient == "autodiff":
            raise InvalidInputError(
                "gradient is 'autodiff' and the scheme is implicit, which needs more than "
                "gradients; choose the scheme euler"
            )
        if self.shapes.is_local and self.shapes.quantity == "area":
            raise InvalidInputError(
                "the energy is area and the scheme is implicit, for which shapes need one radius; "
                f"the radius is {self.shapes.radius!r}: choose the energy volume or the scheme "
                "euler"
            )
        chosen: Any = self.order or (1 if is_polyhedral else 2)
        object.__setattr__(self, "order", chosen)

    @property
    def whole_cloud_for(self) -> str:
        """What needs it of the shapes, or of equations that reach as far as the largest balls."""
        if self.shapes.is_local:
            return "an implicit step with a local radius"
        return super().whole_cloud_for

    def _planned(
        self, parts: Parts, measured: Measured, radius: float
    ) -> tuple[FilterPlan | None, Scheme]:
        assert self.order is not None  # filled in
        noise = None if self.noise is None else measured.noise(self.noise)
        plan = plan_filter(parts, measured.distinct, noise)
        dimension = parts.dimension
        multiple = local_multiple(self.shapes.radius)
        return plan, Implicit(
            measured.spacing if multiple is None else radius / multiple,
            self.order, self.given_step(measured),
            noise=None if plan is None else plan.noise.deviation,
            largest_mass=self.shapes.largest_mass(radius, dimension)
            if self.shapes.weight == "none" else None,
            is_of_balls=not isinstance(self.shapes, Polyhedra),
        )  # fmt: skip
