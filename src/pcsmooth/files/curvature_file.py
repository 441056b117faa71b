"""Estimate normals and curvatures of a cloud from file to file."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import partial

from pcsmooth.curvature.single_gradient import Estimator
from pcsmooth.energies.protocol import Quantity
from pcsmooth.estimating import EstimatedParts, estimate_parts
from pcsmooth.files.cloud_input import CloudInput, InputPiece, parts_selected
from pcsmooth.files.estimates_output import check_color_by
from pcsmooth.files.notes import WARNING, Say
from pcsmooth.files.report import CurvatureReport, PointFacts
from pcsmooth.files.result_file import EstimatedPiece, Target, write_result
from pcsmooth.files.selection import Selection
from pcsmooth.files.taking_part import TakingPart
from pcsmooth.files.writing import Writing
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.methods.estimate import Estimate
from pcsmooth.progress import Callback


@dataclass(frozen=True, eq=False)
class EstimatedFile:
    """What came of estimating a file.

    Attributes
    ----------
    report : CurvatureReport
        What was done.
    estimated : EstimatedParts
        The cloud in parts.
    """

    report: CurvatureReport
    estimated: EstimatedParts


def estimate_input(
    source: CloudInput,
    target: Target,
    estimate: Estimate,
    *,
    radius: float | str,
    estimator: Estimator,
    quantity: Quantity,
    writing: Writing,
    selection: Selection | None,
    threads: int | None,
    started: float,
    say: Say,
    callback: Callback,
) -> EstimatedFile:
    """Estimate normals and curvatures of a cloud that has been opened, and write it with them.

    Parameters
    ----------
    source : CloudInput
        The cloud.
    target : Target
        Where the result goes.
    estimate : Estimate
        How.
    radius, estimator, quantity
        See `estimate_curvature`.
    writing : Writing
        How estimates are written.
    selection : Selection or None
        Which points get estimates; the others take part in these, or do not.
    threads : int or None
        Threads to use.
    started : float
        When the run began, by `time.perf_counter`.
    say : callable
        Takes each message.
    callback : callable
        Told how far it is.
    """
    check_color_by(writing, source.dimension, source.name)
    writing.check_moved_by("")
    with thread_limit(threads):
        roles = TakingPart(source.name, None, selection, moves=False)
        parts = parts_selected(source, estimate, roles, callback)
        estimated = estimate_parts(
            parts, radius=radius, support=estimate.support, estimator=estimator,
            quantity=quantity, orientation=estimate.orientation,
        )  # fmt: skip
        if selection is not None:
            estimated.fitted.clear_marked(parts.fixed)
            if not source.counts.selected:
                missed = selection.missed_in_words(source.counts.box, source.counts.noise)
                say(f"{WARNING} {source.name}: {missed}")
        points = PointFacts.of(source.template, source.count, parts.count, source.counts, selection)
        report = CurvatureReport.of(
            estimated, writing.convention, estimator, quantity, input=source.name,
            output=target.path, points=points,
            tiles=None if source.is_whole else parts.n_parts, seconds=0.0,
        )  # fmt: skip
        rounding = write_result(
            source, target, writing, {"estimate": estimated.fitted.estimates},
            partial(_estimated, estimated), estimates=estimated.all,
            provenance=report.provenance(estimate.orient) + roles.provenance,
            count=source.count, spacing=report.spacing,
            mean_displacement=None, say=say, callback=callback,
        )  # fmt: skip
    seconds = round(time.perf_counter() - started, 3)
    return EstimatedFile(replace(report, rounding=rounding, seconds=seconds), estimated)


def _estimated(estimated: EstimatedParts, piece: InputPiece) -> EstimatedPiece:
    """Make the result of a piece of the input."""
    found = estimated.of_rows(piece.rows["estimate"], piece.places, piece.finite)
    return EstimatedPiece(piece.cloud, piece.cloud.points, found)
