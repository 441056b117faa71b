"""Denoise a cloud in parts: from its positions to smoothed ones with estimates."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.fitted_cloud import fit_cloud
from pcsmooth.denoised_rows import DenoisedRows
from pcsmooth.estimating import EstimatedParts
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.flows.flow import record_of
from pcsmooth.measured import Measured, measure_cloud
from pcsmooth.methods.beams import go_along_beams
from pcsmooth.methods.estimate import Estimate
from pcsmooth.methods.method import Method, Moved
from pcsmooth.methods.motion import Motion
from pcsmooth.methods.strength import go_a_share
from pcsmooth.neighbors.marked import count_marked
from pcsmooth.parts.column import Column
from pcsmooth.parts.exact_sums import exact_sum, total_of
from pcsmooth.parts.part import Parts
from pcsmooth.parts.streamed_median import streamed_median
from pcsmooth.progress import Callback, Progress, ignore
from pcsmooth.record import Record


@dataclass(frozen=True)
class Facts:
    """What a summary says of the finite points, and of their motion of those that may move.

    Attributes
    ----------
    mean_displacement, max_displacement : float
        Distance from start to end, L; 0 if all are fixed.
    outliers : int or None
        Points taken for outliers, if that was looked for.
    at_limit : int or None
        Points that the filter has moved as far as it moves any; None where it is not known.
    fixed : int
        Points that are fixed.
    rms_along_normal, rms_along_surface : float or None
        Root mean square of the displacements along the normals at the end, and across them, L, of
        the points that have one and are not fixed; None if no point is so.
    noise_after : float or None
        Median of the standard deviations of the errors that a filter leaves the points that are not
        fixed, L; None if all are.
    """

    mean_displacement: float
    max_displacement: float
    outliers: int | None
    at_limit: int | None
    fixed: int
    rms_along_normal: float | None
    rms_along_surface: float | None
    noise_after: float | None


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
        along: list[tuple[float, ...]] = []
        across: list[tuple[float, ...]] = []
        largest, with_normal = 0.0, 0
        # Along beams, points may go farther than the filter lets them along normals.
        is_limited = self.moved.outliers is not None and self.motion.direction != "ray"
        at_limit = 0 if is_limited else None
        plan, noise, first = self.moved.plan, self.moved.noise, 0
        ends = self.moved.state.points.chunks()
        marks = self.parts.fixed.chunks()
        for start, end, fixed in zip(self.parts.start.chunks(), ends, marks, strict=True):
            vectors, free = end - start, fixed == 0
            lengths = np.linalg.norm(vectors, axis=1)
            stop = first + len(start)
            if at_limit is not None and plan is not None:
                known = plan.noise.deviation if noise is None else noise.read(first, stop)
                whole = lengths / self.motion.strength if self.motion.strength else lengths
                at_limit += plan.count_at_limit(known, whole)
            normals = self.estimated.fitted.estimates.read(first, stop)[:, : start.shape[1]]
            has_normal = normals.any(axis=1) & free
            heights = np.sum(normals * vectors, axis=1)[has_normal]
            with_normal += len(heights)
            along.append(exact_sum(heights**2))
            across.append(exact_sum(np.maximum(lengths[has_normal] ** 2 - heights**2, 0.0)))
            first = stop
            lengths = unit * lengths[free]
            totals.append(exact_sum(lengths))
            largest = max(largest, float(lengths.max(initial=0.0)))
        rms_along, rms_across = (
            unit * math.sqrt(total_of(squares) / with_normal) if with_normal else None
            for squares in (along, across)
        )
        left, n_fixed = self.moved.left, count_marked(self.parts.fixed)
        n_free = self.parts.count - n_fixed
        return Facts(
            total_of(totals) / n_free if n_free else 0.0,
            largest,
            None if self.moved.outliers is None else count_marked(self.moved.outliers),
            at_limit,
            n_fixed,
            rms_along,
            rms_across,
            None
            if left is None or n_free == 0
            else streamed_median(partial(_where_free, left, self.parts.fixed)) * unit,
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
    ) -> DenoisedRows:
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
        return DenoisedRows(
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


def _where_free(column: Column, fixed: Column) -> Iterator[npt.NDArray[np.float64]]:
    """Read a column at the points that are not fixed."""
    for values, marks in zip(column.chunks(), fixed.chunks(), strict=True):
        yield values[marks == 0]


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

    beams_from = motion.origin_seen_from(parts.origin, unit)
    measured = measure_cloud(parts)
    moved = method.move(parts, measured, motion, note)
    if beams_from is not None:
        longest = motion.restraint(measured, moves_along_normals=True).longest
        moved = go_along_beams(parts, moved, beams_from, longest)
    moved = go_a_share(parts, moved, motion.strength)
    # Normals and curvatures are those of the surface, whatever the shapes that moved it.
    fitted = fit_cloud(
        parts, moved.state, method.shapes.energy(moved.radius, moved.local),
        support=estimate.support,
        orientation=estimate.orientation.seen_from(parts.origin, unit),
    )  # fmt: skip
    note(record_of(moved.state, fitted.totals))
    estimated = EstimatedParts(parts, fitted, moved.radius, measured.spacing, moved.local)
    return Denoised(method, motion.on(measured), measured, moved, estimated, tuple(history))
