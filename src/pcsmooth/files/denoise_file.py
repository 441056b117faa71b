"""Denoise a cloud from file to file."""

from __future__ import annotations

import time
from dataclasses import astuple, dataclass, replace
from itertools import repeat

import numpy as np
import numpy.typing as npt

from pcsmooth.denoise_result import DenoiseResult
from pcsmooth.denoising import Denoised, denoise_parts
from pcsmooth.files.cloud_input import CloudInput, InputPiece, Wanted, no_rows
from pcsmooth.files.estimates_output import Colors, EstimatesOutput, check_color_by
from pcsmooth.files.notes import Say
from pcsmooth.files.report import DenoiseReport, PointFacts, ShapeFacts
from pcsmooth.files.result_file import EstimatedPiece, Target, write_result
from pcsmooth.files.writing import Writing
from pcsmooth.formats import coordinate_columns
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.methods.estimate import Estimate
from pcsmooth.methods.method import Method
from pcsmooth.methods.motion import Motion
from pcsmooth.progress import Callback

#: Most points whose results are taken for pictures.
_MOST_SHOWN = 1_000_000


@dataclass(frozen=True, eq=False)
class Sample:
    """Some points of a denoised cloud, in the order of the input.

    Attributes
    ----------
    before, after : ndarray, shape (n, d)
        Positions, L.
    normals : ndarray, shape (n, d)
        Unit normals after; zero where unknown.
    mean_curvature : ndarray, shape (n,)
        (k1 + k2) / 2, in 2D k, after, 1/L.
    """

    before: npt.NDArray[np.float64]
    after: npt.NDArray[np.float64]
    normals: npt.NDArray[np.float64]
    mean_curvature: npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DenoisedFile:
    """What came of denoising a file.

    Attributes
    ----------
    report : DenoiseReport
        What was done.
    denoised : Denoised
        What it was done to, in parts.
    source : CloudInput
        The input.
    """

    report: DenoiseReport
    denoised: Denoised
    source: CloudInput

    def sample(self) -> Sample:
        """Take the result of so many points that pictures show no difference."""
        every = -(-self.source.count // _MOST_SHOWN)
        found, start = [], 0
        for piece in self.source.pieces(self.denoised.columns):
            rows = slice(-start % every, None, every)
            result = _result(piece, self.denoised)
            found.append(
                Sample(
                    piece.cloud.points[rows], result.points[rows], result.normals[rows],
                    result.mean_curvature[rows],
                )
            )  # fmt: skip
            start += len(piece.cloud)
        if len(found) == 1:
            return found[0]
        columns = zip(*(astuple(part) for part in found), strict=True)
        return Sample(*(np.concatenate(column) for column in columns))


def denoise_input(
    source: CloudInput,
    target: Target,
    method: Method,
    *,
    motion: Motion,
    estimate: Estimate,
    writing: Writing,
    fixed_column: str | None,
    shape: ShapeFacts | None,
    threads: int | None,
    started: float,
    say: Say,
    callback: Callback,
) -> DenoisedFile:
    """Denoise a cloud that has been opened, and write it.

    Parameters
    ----------
    source : CloudInput
        The cloud.
    target : Target
        Where the result goes.
    method, motion, estimate : Method, Motion, Estimate
        How.
    writing : Writing
        How estimates are written.
    fixed_column : str or None
        Column of the fixed points (see `fixed_points`).
    shape : ShapeFacts or None
        How the user calls the body in place of the ball.
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
    with thread_limit(threads):
        parts = source.parts(Wanted(fixed_column, estimate.orient), callback)
        denoised = denoise_parts(parts, method, motion, estimate, callback)
        facts = denoised.facts()
        counted = PointFacts(
            source.count,
            source.dimension,
            coordinate_columns(source.template),
            source.count - parts.count - source.noise_count,
            source.noise_count,
        )
        report = DenoiseReport.of(
            denoised, facts, writing.convention, input=source.name, output=target.path,
            points=counted, tiles=None if source.is_whole else parts.n_parts, shape=shape,
            seconds=0.0,
        )  # fmt: skip
        colors = Colors.for_all(writing, denoised.estimates)
        output = EstimatesOutput(
            source.template, target.path, writing, report.provenance(estimate.orient), colors
        )
        write_result(
            source, target, output,
            lambda: map(_estimated, source.pieces(denoised.columns), repeat(denoised)),
            lambda: _estimated(no_rows(source.template, denoised.columns), denoised),
            spacing=report.spacing, mean_displacement=facts.mean_displacement, say=say,
            callback=callback,
        )  # fmt: skip
    seconds = round(time.perf_counter() - started, 3)
    return DenoisedFile(replace(report, seconds=seconds), denoised, source)


def _estimated(piece: InputPiece, denoised: Denoised) -> EstimatedPiece:
    """Make the result of a piece of the input, as it is written."""
    result = _result(piece, denoised)
    return EstimatedPiece(
        piece.cloud, result.points, result.curvature, result.displacement, result.outliers
    )


def _result(piece: InputPiece, denoised: Denoised) -> DenoiseResult:
    """Make the result of a piece of the input."""
    return denoised.result(piece.cloud.points, piece.finite, piece.places, piece.rows)
