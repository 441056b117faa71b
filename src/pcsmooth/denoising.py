"""Denoise a cloud: from positions as they come to smoothed positions with estimates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.fitted_cloud import fit_cloud
from pcsmooth.denoise_result import DenoiseResult
from pcsmooth.errors import InvalidInputError
from pcsmooth.estimating import EstimatedParts, given_normals
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.flows.flow import record_of
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.measured import Measured, measure_cloud
from pcsmooth.methods.estimate import Estimate
from pcsmooth.methods.keywords import Keywords, resolve_keywords
from pcsmooth.methods.method import Method, Moved
from pcsmooth.methods.motion import Direction, Motion
from pcsmooth.neighbors.marked import count_marked
from pcsmooth.parts.column import Column
from pcsmooth.parts.exact_sums import exact_sum, total_of
from pcsmooth.parts.part import Parts
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.positions import as_positions, usable_rows
from pcsmooth.progress import Callback, Progress, ignore
from pcsmooth.real_numbers import real_array
from pcsmooth.record import Record


def denoise(
    points: npt.ArrayLike,
    method: Method | None = None,
    *,
    motion: Motion | Direction = "free",
    estimate: Estimate | None = None,
    fixed: npt.ArrayLike | None = None,
    normals: npt.ArrayLike | None = None,
    threads: int | None = None,
    callback: Callback = ignore,
    **keywords: Unpack[Keywords],
) -> DenoiseResult:
    """Denoise a point cloud: by default filtered with parameters measured from the cloud.

    Flows are the other way: gradient descent on an energy of the union of balls around the
    points. With a convex polyhedron in place of the ball a flow is anisotropic: it turns the
    surface towards the polyhedron's facets.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3)
        Positions, L. Rows with a NaN, an infinity or a masked coordinate take no part and come
        back as they are, what is masked as NaN.
    method : Filter, EulerFlow or ImplicitFlow, optional
        How; by default the filter.
    motion : Motion, "free" or "normal"
        How points may move.
    estimate : Estimate, optional
        How normals and curvatures are estimated at the new positions.
    fixed : array_like of bool, shape (n,), optional
        Points that stay, and act on the others; masked ones do not stay.
    normals : array_like, shape (n, d), optional
        Normals of the input, which those at the new positions may follow: see
        `estimate_curvature`.
    threads : int, optional
        Threads to use, all by default. The result does not depend on it.
    callback : callable, optional
        Called with a `Progress` when a stage begins and ends, and with its `record` set when a
        state is known.
    **keywords
        In place of objects, the words that they are made of, all optional, such as ``scheme``,
        ``noise`` and ``iterations`` of the method, ``keep_volume`` of the motion, ``orient`` of
        the estimate: see `Keywords` and `MethodKeywords`.

    Returns
    -------
    DenoiseResult
        points, history, normals, curvatures, displacement and what was chosen.

    Raises
    ------
    InvalidInputError
        Wrong shapes or option values, no finite point, a radius that cannot be derived, or an
        implicit step that cannot be solved.

    Notes
    -----
    Points are taken in the order of their positions (see `order_by_position`): permuted rows give
    the permuted result, to the last bit.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    >>> circle = np.c_[np.cos(angle), np.sin(angle)] * (1 + 0.01 * rng.normal(size=(200, 1)))
    >>> result = denoise(circle)
    >>> bool(np.linalg.norm(result.points, axis=1).std() < 0.005)
    True
    >>> flow = EulerFlow(shapes=Balls(radius="3x", quantity="area"), iterations=10)
    >>> denoise(circle, flow).history[-1].iteration
    10
    """
    method, motion, estimate = resolve_keywords(method, motion, estimate, keywords)
    positions = as_positions(points)
    given = given_normals(normals, positions.shape, estimate.orientation)
    finite = usable_rows(positions)
    marks = None if fixed is None else _as_marks(fixed, len(positions))
    with thread_limit(threads):
        cloud = WholeCloud.of(positions, finite, fixed=marks, given=given, callback=callback)
        denoised = denoise_parts(cloud, method, motion, estimate, callback)
    return denoised.result(positions, finite, cloud.input_rows, denoised.read(0, cloud.count))


@dataclass(frozen=True)
class Facts:
    """What a summary says of all finite points.

    Attributes
    ----------
    mean_displacement, max_displacement : float
        Distance from start to end, L.
    outliers : int or None
        Points taken for outliers, if that was looked for.
    at_limit : int or None
        Points that the filter has moved as far as it moves any.
    fixed : int
        Points that are fixed.
    """

    mean_displacement: float
    max_displacement: float
    outliers: int | None
    at_limit: int | None
    fixed: int


@dataclass(frozen=True, eq=False)
class Denoised:
    """A denoised cloud in parts.

    Attributes
    ----------
    method, motion : Method, Motion
        How it was denoised; lengths of the motion in the unit of the input.
    measured : Measured
        Its size and spacing at the start.
    moved : Moved
        Where it is now.
    estimated : EstimatedParts
        The cloud there, with normals and curvatures.
    history : tuple of Record
        Its states, in the unit of the input.
    """

    method: Method
    motion: Motion
    measured: Measured
    moved: Moved
    estimated: EstimatedParts
    history: tuple[Record, ...]

    @property
    def parts(self) -> Parts:
        """The cloud."""
        return self.estimated.parts

    @property
    def step(self) -> float:
        """Time step, in the unit of the input."""
        return self.moved.step * self.method.unit_of_step(self.measured)

    @property
    def plan(self) -> FilterPlan | None:
        """What was found of the noise, in the unit of the input."""
        plan = self.moved.plan
        return None if plan is None else plan.scaled(self.parts.unit)

    @property
    def stopped_early(self) -> bool:
        """Whether the steps had become shorter than the tolerance before the last one."""
        return self.moved.state.iteration < self.method.iterations

    @property
    def columns(self) -> dict[str, Column]:
        """What there is of each point: "start", "end", "estimate", and "outlier" of the filter.

        If radii are local, "spacing", that they are a multiple of; "noise", if the filter's is;
        "left", the error that is left of it.
        """
        columns = {
            "start": self.parts.start,
            "end": self.moved.state.points,
            "estimate": self.estimated.fitted.estimates,
        }
        if self.moved.outliers is not None:
            columns["outlier"] = self.moved.outliers
        if self.moved.local is not None:
            columns["spacing"] = self.moved.local.spacings
        if self.moved.noise is not None:
            columns["noise"] = self.moved.noise
        if self.moved.left is not None:
            columns["left"] = self.moved.left
        return columns

    def facts(self) -> Facts:
        """Find what a summary says of all points."""
        unit = self.parts.unit
        totals: list[tuple[float, ...]] = []
        largest = 0.0
        at_limit = None if self.moved.outliers is None else 0
        plan, noise, first = self.moved.plan, self.moved.noise, 0
        ends = self.moved.state.points.chunks()
        for start, end in zip(self.parts.start.chunks(), ends, strict=True):
            lengths = np.linalg.norm(end - start, axis=1)
            stop = first + len(start)
            if at_limit is not None and plan is not None:
                known = plan.noise.deviation if noise is None else noise.read(first, stop)
                at_limit += plan.count_at_limit(known, lengths)
            first = stop
            lengths *= unit
            totals.append(exact_sum(lengths))
            largest = max(largest, float(lengths.max()))
        return Facts(
            total_of(totals) / self.parts.count,
            largest,
            None if self.moved.outliers is None else count_marked(self.moved.outliers),
            at_limit,
            count_marked(self.parts.fixed),
        )

    def read(self, start: int, stop: int) -> dict[str, npt.NDArray[Any]]:
        """Read some rows of all columns."""
        return {name: column.read(start, stop) for name, column in self.columns.items()}

    def result(
        self,
        positions: npt.NDArray[np.float64],
        finite: npt.NDArray[np.bool_],
        places: npt.NDArray[np.int64],
        rows: Mapping[str, npt.NDArray[Any]] | npt.NDArray[np.void],
    ) -> DenoiseResult:
        """Give the result of some rows of the input.

        Parameters
        ----------
        positions : ndarray, shape (n, d)
            Where they were, L; what is not finite as it came.
        finite : ndarray of bool, shape (n,)
            Which of them took part.
        places : ndarray of int, shape (m,)
            These, in some order.
        rows : mapping of str to ndarray, or structured ndarray, shape (m,)
            What there is of each, by the names of `columns`, in the same order.
        """
        measured, moved, unit = self.measured, self.moved, self.parts.unit
        displacement = np.zeros_like(positions)
        displacement[places] = (rows["end"] - rows["start"]) * unit
        outliers = None
        if moved.outliers is not None:
            outliers = np.zeros(len(positions), np.bool_)
            outliers[places] = rows["outlier"]
        sigma = sigma_after = None
        if moved.outliers is not None and moved.plan is not None:
            sigma = np.zeros(len(positions))
            noise = moved.plan.noise.deviation if moved.noise is None else rows["noise"]
            sigma[places] = noise * unit
            sigma_after = sigma
            if moved.left is not None:
                sigma_after = np.zeros(len(positions))
                sigma_after[places] = rows["left"] * unit
        radii = None
        if moved.local is not None:
            radii = np.zeros(len(positions))
            radii[places] = moved.local.multiple * rows["spacing"] * unit
        return DenoiseResult(
            points=np.where(displacement == 0.0, positions, positions + displacement),  # keeps -0.0
            history=self.history,
            curvature=self.estimated.of_rows(rows["estimate"], places, finite),
            displacement=np.linalg.norm(displacement, axis=1),
            outliers=outliers,
            sigma=sigma,
            sigma_after=sigma_after,
            method=self.method,
            motion=self.motion,
            spacing=measured.spacing * unit,
            radius=moved.radius * unit,
            radii=radii,
            step=self.step,
            plan=self.plan,
            stopped_early=self.stopped_early,
            solver_iterations=moved.solver_iterations,
            solver_error=moved.solver_error,
            finite=finite,
        )


def denoise_parts(
    parts: Parts, method: Method, motion: Motion, estimate: Estimate, callback: Callback = ignore
) -> Denoised:
    """Denoise a cloud in parts: see `denoise`.

    Parameters
    ----------
    parts : Parts
        The cloud.
    method, motion, estimate : Method, Motion, Estimate
        How.
    callback : callable
        Gets a `Progress` with the record of each state.
    """
    unit, steps = parts.unit, method.iterations
    history: list[Record] = []

    def note(record: Record) -> None:
        history.append(record.scaled(unit, parts.dimension))
        callback(Progress("steps", record.iteration, steps, history[-1]))

    measured = measure_cloud(parts)
    moved = method.move(parts, measured, motion, note)
    # Normals and curvatures are those of the surface, whatever the shapes that moved it.
    fitted = fit_cloud(
        parts, moved.state, method.shapes.energy(moved.radius, moved.local),
        support=estimate.support,
        orientation=estimate.orientation.seen_from(parts.origin, unit),
    )  # fmt: skip
    note(record_of(moved.state, fitted.totals))
    estimated = EstimatedParts(parts, fitted, moved.radius, measured.spacing, moved.local)
    return Denoised(method, motion.on(measured), measured, moved, estimated, tuple(history))


def _as_marks(fixed: npt.ArrayLike, count: int) -> npt.NDArray[np.bool_]:
    """Take the marks of fixed points; masked ones are not set."""
    marks = np.nan_to_num(real_array(fixed, "fixed marks", may_be_bool=True)) != 0.0
    if marks.shape != (count,):
        raise InvalidInputError(
            f"fixed has shape {marks.shape}; it must have one value per point, ({count},)"
        )
    return np.asarray(marks)
