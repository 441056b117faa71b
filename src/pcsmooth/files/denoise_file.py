"""Denoise a cloud from file to file."""

from __future__ import annotations

import os
import time
from dataclasses import astuple, dataclass, replace
from functools import partial
from typing import Literal, Unpack

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.denoised_rows import DenoisedRows
from pcsmooth.denoising import Denoised, denoise_parts
from pcsmooth.files.cloud_input import CloudInput, InputPiece, parts_selected
from pcsmooth.files.estimates_output import (
    check_color_by,
    check_displacement,
    marks_outliers,
)
from pcsmooth.files.notes import WARNING, Say
from pcsmooth.files.opening import InputFile, open_input
from pcsmooth.files.outlier_classes import check_classes, classes_of_outliers, with_classes
from pcsmooth.files.outlier_rows import check_outliers, kept_rows, rows_written
from pcsmooth.files.report import DenoiseReport, PointFacts, ShapeFacts
from pcsmooth.files.result_file import EstimatedPiece, Target, write_result
from pcsmooth.files.selection import Selection
from pcsmooth.files.taking_part import TakingPart
from pcsmooth.files.targets import check_target
from pcsmooth.files.tiling import Tiling
from pcsmooth.files.writing import Writing
from pcsmooth.formats import check_cloud, output_format
from pcsmooth.formats.some_rows import grid_of_rows
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.methods.estimate import Estimate
from pcsmooth.methods.keywords import Keywords, resolve_keywords
from pcsmooth.methods.method import Method
from pcsmooth.methods.motion import Direction, Motion
from pcsmooth.methods.shapes import Polyhedra
from pcsmooth.progress import Callback, ignore
from pcsmooth.tiling.runner import Runner

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
            result = _result(self.denoised, piece)
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


def denoise_file(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    method: Method | None = None,
    *,
    motion: Motion | Direction = "free",
    estimate: Estimate | None = None,
    writing: Writing | None = None,
    fixed: str | None = None,
    selection: Selection | None = None,
    dim: Literal["auto", 2, 3] = "auto",
    columns: tuple[str, ...] | None = None,
    keep_noise_class: bool = False,
    tile: int | Literal["auto", "off"] = "auto",
    tile_folder: str | os.PathLike[str] | None = None,
    runner: Runner | None = None,
    threads: int | None = None,
    overwrite: bool = True,
    say: Say = lambda _message: None,
    callback: Callback = ignore,
    **keywords: Unpack[Keywords],
) -> DenoiseReport:
    """Denoise a file of points into another, in tiles if it does not fit into memory.

    Parameters
    ----------
    source, target : path
        The files, of any format that is read and written. The target may be the source, and is
        replaced as a whole or, after any error, not at all.
    method, motion, estimate, threads, **keywords
        As `denoise` takes them.
    writing : Writing, optional
        How estimates are written.
    fixed : str, optional
        Column that marks points which stay (see `fixed_points`).
    selection : Selection, optional
        Which points may move; the others stay, and act on these or are ignored.
    dim : {"auto", 2, 3}
        Number of coordinates.
    columns : tuple of str, optional
        Columns of the coordinates in a text file, by names or numbers.
    keep_noise_class : bool
        Whether points that the file calls noise take part, too.
    tile : int, "auto" or "off"
        Points of a tile; auto cuts only what does not fit into memory.
    tile_folder : path, optional
        Where tiles lie meanwhile, up to 400 bytes a point; by default a folder beside the target.
    runner : Runner, optional
        Works on the tiles, such as `ProcessRunner` or `DaskRunner`; by default this process.
    overwrite : bool
        Whether a file that is there is replaced.
    say : callable
        Gets what a person should know: warnings, and what is lost, rounded, replaced or left out.
    callback : callable
        Called with a `Progress` as stages go on, and with its `record` set when a state is known.

    Returns
    -------
    DenoiseReport
        What was done. The result is in the file: every row, column and comment of the source in
        its order, with new positions, normals, curvatures, confidence and displacement.

    Raises
    ------
    CloudFileError
        A file cannot be read or written, or tiles are wanted and cannot be.
    InvalidInputError
        As `denoise`.
    """
    started = time.perf_counter()
    method, motion, estimate = resolve_keywords(method, motion, estimate, keywords)
    writing = writing or Writing()
    to = Target(os.fspath(target), overwrite=overwrite)
    check_target(to.path, overwrite)
    tiling = Tiling(tile, None if tile_folder is None else os.fspath(tile_folder))
    with open_input(
        InputFile(os.fspath(source), None, dim, columns, keep_noise_class), to, tiling=tiling,
        whole_cloud_for=method.whole_cloud_for or writing.whole_cloud_for, runner=runner,
        threads=threads, say=say,
    ) as cloud:  # fmt: skip
        check_cloud(cloud.template, output_format(to.path, cloud.template), to.path)
        return denoise_input(
            cloud, to, method, motion=motion, estimate=estimate, writing=writing,
            fixed_column=fixed,
            selection=selection, shape=_shape_of(method),
            threads=threads, started=started, say=say,
            callback=callback,
        ).report  # fmt: skip


def denoise_input(
    source: CloudInput,
    target: Target,
    method: Method,
    *,
    motion: Motion,
    estimate: Estimate,
    writing: Writing,
    fixed_column: str | None,
    selection: Selection | None,
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
    selection : Selection or None
        Which points may move.
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
    writing.check_moved_by(method.name)
    is_stream = target.stream is not None
    to = output_format(None if is_stream else target.path, source.template)
    name = "<stdout>" if is_stream else target.path
    check_displacement(writing, source.template, to, name)
    check_outliers(source.template, to, name, writing.outliers)
    if writing.outliers == "class":
        check_classes(to, name)
    marks = writing.outliers == "mark" and marks_outliers(writing, source.template, to)
    if writing.outliers == "mark" and method.name == "filter" and not marks:
        say(f"{name}: this file gets no column for outliers; .ply, .csv, .las and .pcd have one")
    with thread_limit(threads):
        roles = TakingPart(source.name, fixed_column, selection)
        parts = parts_selected(source, estimate, roles, callback)
        denoised = denoise_parts(parts, method, motion, estimate, callback)
        facts = denoised.facts()
        if selection is not None and facts.fixed == parts.count:
            missed = (
                "all points that are selected are fixed"
                if source.counts.selected
                else selection.missed_in_words(source.counts.box, source.counts.noise)
            )
            say(f"{WARNING} {source.name}: {missed}")
        columns = denoised.columns
        classes = None
        if writing.outliers == "class":
            columns["class"], classes = classes_of_outliers(denoised)
        elif writing.outliers != "mark":
            columns["fixed"] = parts.fixed
        count = rows_written(source, columns, writing.outliers)
        if count < source.count and (grid := grid_of_rows(source.template, to)):
            say(f"{WARNING} {name}: {grid} in rows and columns become one row of {count}")
        points = PointFacts.of(source.template, source.count, parts.count, source.counts, selection)
        report = DenoiseReport.of(
            denoised, facts, writing.convention, outliers_as=writing.outliers,
            outliers_marked=marks, outlier_classes=classes,
            removed=source.count - count, input=source.name, output=target.path,
            points=points,
            tiles=None if source.is_whole else parts.n_parts, shape=shape, seconds=0.0,
        )  # fmt: skip
        rounding = write_result(
            source, target, writing, columns, partial(_estimated, denoised, writing, source.name),
            estimates=denoised.estimated.all,
            provenance=report.provenance(estimate.orient)
            + roles.provenance
            + ("" if writing.outliers == "mark" else f" outliers={writing.outliers}"),
            count=count, spacing=report.spacing, mean_displacement=facts.mean_displacement, say=say,
            callback=callback,
        )  # fmt: skip
    seconds = round(time.perf_counter() - started, 3)
    return DenoisedFile(replace(report, rounding=rounding, seconds=seconds), denoised, source)


def _shape_of(method: Method) -> ShapeFacts | None:
    """Say that a body without a name is used, if there is one."""
    shapes = method.shapes
    return ShapeFacts("polyhedron", shapes.union) if isinstance(shapes, Polyhedra) else None


def _estimated(
    denoised: Denoised, writing: Writing, name: str, piece: InputPiece
) -> EstimatedPiece:
    """Make the result of a piece of the input, as it is written."""
    made = denoised_piece(_result(denoised, piece), piece.cloud, writing)
    if writing.outliers == "mark":
        return made
    if writing.outliers == "class":
        cloud = with_classes(made.cloud, name, piece.places, piece.rows["class"])
        return replace(made, outliers=None, cloud=cloud)
    return replace(made, outliers=None, kept=kept_rows(piece, writing.outliers))


def denoised_piece(rows: DenoisedRows, cloud: PointCloud, writing: Writing) -> EstimatedPiece:
    """Take of some rows of a result, and of the cloud that they come from, what is written."""
    return EstimatedPiece(
        cloud, rows.points, rows.curvature, rows.displacement, rows.outliers,
        sigma=rows.sigma if "sigma" in writing.extra_columns else None,
        sigma_after=rows.sigma_after if "sigma_after" in writing.extra_columns else None,
    )  # fmt: skip


def _result(denoised: Denoised, piece: InputPiece) -> DenoisedRows:
    """Make the result of a piece of the input."""
    return denoised.result(piece.cloud.points, piece.finite, piece.places, piece.rows)
