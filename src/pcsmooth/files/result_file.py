"""The result of a run written into a file, whole or piece by piece."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.curvature.estimate import CurvatureEstimate
from pcsmooth.files.cloud_input import ROWS, CloudInput, InputPiece, no_rows
from pcsmooth.files.estimates_output import Colors, EstimatesOutput, check_color_by
from pcsmooth.files.notes import WARNING, Say
from pcsmooth.files.output_columns import EstimatedCloud
from pcsmooth.files.writing import Writing
from pcsmooth.formats import write_chunks, write_cloud, write_template
from pcsmooth.formats.some_rows import some_rows
from pcsmooth.neighbors.local_spacing import local_spacings
from pcsmooth.parts.column import Column
from pcsmooth.progress import Callback, Progress


@dataclass(frozen=True, eq=False)
class EstimatedPiece:
    """Consecutive rows of a result.

    Attributes
    ----------
    cloud : PointCloud
        As they came.
    points : ndarray, shape (n, d)
        Positions, L.
    estimate : CurvatureEstimate
        Normals and curvatures there.
    displacement : ndarray, shape (n,), optional
        How far they moved, L.
    outliers : ndarray of bool, shape (n,), optional
        Points taken for outliers.
    spacings : ndarray, shape (n,), optional
        Local spacing, L.
    sigma : ndarray, shape (n,), optional
        Standard deviation of the noise of the input, L.
    sigma_after : ndarray, shape (n,), optional
        Standard deviation of the error that is left, L.
    kept : ndarray of bool, shape (n,), optional
        Which rows are written; by default all.
    """

    cloud: PointCloud
    points: npt.NDArray[np.float64]
    estimate: CurvatureEstimate
    displacement: npt.NDArray[np.float64] | None = None
    outliers: npt.NDArray[np.bool_] | None = None
    spacings: npt.NDArray[np.float64] | None = None
    sigma: npt.NDArray[np.float64] | None = None
    sigma_after: npt.NDArray[np.float64] | None = None
    kept: npt.NDArray[np.bool_] | None = None

    def kept_rows(self) -> EstimatedPiece:
        """Give what is written."""
        if self.kept is None:
            return self
        kept = self.kept
        arrays = {
            field.name: getattr(self, field.name)[kept]
            for field in fields(self)
            if isinstance(getattr(self, field.name), np.ndarray)
        }
        return EstimatedPiece(
            **{
                **arrays,
                "cloud": some_rows(self.cloud, kept),
                "estimate": self.estimate.some_rows(kept),
                "kept": None,
            }
        )


@dataclass(frozen=True)
class Target:
    """Where a result goes.

    Attributes
    ----------
    path : str
        The file; its name in messages if there is a stream.
    stream : binary file, optional
        Where to write in its place.
    overwrite : bool
        Whether a file that is there is replaced.
    """

    path: str
    stream: BinaryIO | None = None
    overwrite: bool = True


def write_result(
    source: CloudInput,
    target: Target,
    writing: Writing,
    columns: Mapping[str, Column],
    make: Callable[[InputPiece], EstimatedPiece],
    *,
    estimates: Callable[[], Iterable[CurvatureEstimate]],
    provenance: str,
    count: int,
    spacing: float,
    mean_displacement: float | None,
    say: Say,
    callback: Callback,
) -> float:
    """Write the result of a run, and say what is lost, rounded, replaced or left out.

    Parameters
    ----------
    source : CloudInput
        What was read.
    target : Target
        Where to write.
    writing : Writing
        How estimates are written.
    columns : mapping of str to Column
        What there is of each point.
    make : callable
        Makes the result of a piece of the input, with what the columns hold.
    estimates : callable
        Gives the estimates of all points, in parts, in any order.
    provenance : str
        Command and values, for a comment.
    count : int
        How many rows are written.
    spacing : float
        Mean spacing, L.
    mean_displacement : float or None
        How far points moved on average, L.
    say : callable
        Takes each message.
    callback : callable
        Told how many pieces have been written.

    Returns
    -------
    float
        Most that the format rounded a coordinate, L.
    """
    colors = Colors.for_all(writing, estimates)

    def new_output() -> EstimatesOutput:
        return EstimatesOutput(source.template, target.path, writing, provenance, colors)

    output = new_output()

    def part(piece: EstimatedPiece, output: EstimatesOutput = output) -> EstimatedCloud:
        return _part(piece, output)

    def tell(phrase: str) -> None:
        say(f"{WARNING} {target.path}: {phrase}")

    if source.is_whole:
        (whole,) = source.pieces(columns)
        estimated = part(_with_spacings(make(whole), whole.finite, writing))
        output.say_rounding(spacing, mean_displacement, say)
        output.say_losses(source.template, estimated, say)
        if target.stream is None:
            write_cloud(estimated.cloud, target.path, overwrite=target.overwrite, tell=tell)
        else:
            write_cloud(estimated.cloud, target.stream)
            target.stream.flush()
        return output.rounding

    def pieces() -> Iterator[EstimatedPiece]:
        return map(make, source.pieces(columns))

    estimated = part(make(no_rows(source.template, columns)))
    before = new_output()  # what it notes of rounding is not that of the steps to be settled
    clouds = (part(piece, before).cloud for piece in pieces())
    cloud = write_template(target.path, estimated.cloud, clouds)
    if cloud is not estimated.cloud:
        output.layout = cloud.layout
    total = -(-source.count // ROWS)

    def parts() -> Iterator[PointCloud]:
        callback(Progress("writing", 0, total))
        for done, piece in enumerate(pieces(), 1):
            yield part(piece).cloud
            callback(Progress("writing", done, total))
        source.check()  # an older file than the one of this name is not written either

    write_chunks(target.path, cloud, count, parts(), overwrite=target.overwrite, tell=tell)
    output.say_rounding(spacing, mean_displacement, say)
    output.say_losses(source.template, estimated, say)
    return output.rounding


def result_cloud(
    piece: EstimatedPiece,
    finite: npt.NDArray[np.bool_],
    path: str,
    writing: Writing,
    provenance: str,
) -> PointCloud:
    """Make the cloud that is written of a result in memory.

    Parameters
    ----------
    piece : EstimatedPiece
        All its rows.
    finite : ndarray of bool, shape (n,)
        Which of them took part.
    path : str
        Where it will be written; the names of columns go by its format.
    writing : Writing
        How estimates are written.
    provenance : str
        Command and values, for a comment.

    Raises
    ------
    CloudFileError
        The format cannot hold the positions, or colors are to show what a curve has not.
    """
    check_color_by(writing, piece.points.shape[1], path)
    colors = Colors.for_all(writing, lambda: [piece.estimate])
    output = EstimatesOutput(piece.cloud, path, writing, provenance, colors)
    return _part(_with_spacings(piece, finite, writing), output).cloud


def _part(piece: EstimatedPiece, output: EstimatesOutput) -> EstimatedCloud:
    piece = piece.kept_rows()
    return output.part(
        piece.cloud, piece.points, piece.estimate, piece.displacement, piece.outliers,
        piece.spacings, piece.sigma, piece.sigma_after,
    )  # fmt: skip


def _with_spacings(
    piece: EstimatedPiece, finite: npt.NDArray[np.bool_], writing: Writing
) -> EstimatedPiece:
    """Measure the local spacing of a whole cloud, if it is wanted."""
    if "spacing" not in writing.extra_columns:
        return piece
    spacings = np.zeros(len(piece.points))
    spacings[finite] = local_spacings(piece.points[finite])
    return replace(piece, spacings=spacings)
