"""`pcsmooth denoise` of a cloud that is cut into tiles: read, moved and written piece by piece."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pcsmooth.cli.estimates import EstimatesOutput, provenance_of
from pcsmooth.cli.flow_options import method_provenance
from pcsmooth.cli.messages import Say, computing, say_warnings
from pcsmooth.cli.options import STANDARD_STREAM, Reading, Writing
from pcsmooth.cli.shapes import union_of
from pcsmooth.errors import CloudFileError
from pcsmooth.printable import printable

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from pcsmooth.attributes import EstimatedCloud
    from pcsmooth.cli.tile_options import Tiling
    from pcsmooth.cloud import PointCloud
    from pcsmooth.denoise_result import DenoiseResult
    from pcsmooth.formats import CloudChunks
    from pcsmooth.methods.estimate import Estimate
    from pcsmooth.methods.method import Method
    from pcsmooth.methods.motion import Motion
    from pcsmooth.progress import Progress
    from pcsmooth.tiling.cutting import Piece, Source

#: Rows that are read and written at a time.
_ROWS = 1 << 20

#: Least bytes that a point takes in a file: no smaller file can hold a cloud that is too large.
_LEAST_BYTES = 4


def points_of_tile(
    input_path: str,
    output_path: str,
    tiling: Tiling,
    method: Method,
    motion: Motion,
    writing: Writing,
    reading: Reading,
    *,
    has_report: bool,
) -> int | None:
    """Points of a tile, or None if the cloud is to be denoised as a whole.

    Raises
    ------
    CloudFileError
        If tiles are asked for and cannot be.
    """
    from pcsmooth.cli.files import display_name
    from pcsmooth.formats import open_chunks

    if tiling.size == "off":
        return None
    obstacle = _obstacle(input_path, output_path, method, motion, writing, reading, has_report)
    if obstacle is not None:
        if not tiling.is_asked_for:
            return None
        cause, remedy = obstacle
        raise CloudFileError(display_name(input_path), cause, remedy)
    if not tiling.is_asked_for:
        most = os.path.getsize(input_path) // _LEAST_BYTES if os.path.isfile(input_path) else 0
        if tiling.points_of_tile(most) is None:
            return None
    try:
        with open_chunks(input_path, reading.dim) as chunks:
            return tiling.points_of_tile(chunks.count)
    except CloudFileError:
        if tiling.is_asked_for:
            raise
        return None  # whatever is wrong with it, the reader of whole clouds says


def _obstacle(
    input_path: str,
    output_path: str,
    method: Method,
    motion: Motion,
    writing: Writing,
    reading: Reading,
    has_report: bool,
) -> tuple[str, str] | None:
    """Say what stands against tiles, and what helps."""
    from pcsmooth.formats import output_format
    from pcsmooth.formats.chunks import CHUNKED_FORMATS

    if STANDARD_STREAM in (input_path, output_path):
        return "a stream cannot be cut into tiles", "name files"
    if reading.columns is not None:
        return "--columns is for text files, which cannot be cut into tiles", "leave it out"
    if output_format(output_path) not in CHUNKED_FORMATS:
        return (
            f"tiles cannot be put together to {output_format(output_path)}",
            f"write {' or '.join(CHUNKED_FORMATS)}",
        )
    whole = method.whole_cloud_for
    if whole:
        return f"{whole} needs the whole cloud", "leave it out, or pass --tile off"
    if writing.colormap is not None:
        return "--colormap needs the whole cloud", "color the result, or pass --tile off"
    if has_report:
        return "--report needs the whole cloud", "leave it out, or pass --tile off"
    return None


def denoise_tiled(
    input_path: str,
    output_path: str,
    tiling: Tiling,
    tile_points: int,
    *,
    say: Say,
    shows_bar: bool,
    verbose: bool,
    method: Method,
    motion: Motion,
    estimate: Estimate,
    reading: Reading,
    fixed_column: str | None,
    keeps_noise: bool,
    writing: Writing,
    shape: dict[str, str],
    check: Callable[[int], None],
    overwrite: bool,
    threads: int | None,
) -> tuple[DenoiseResult, dict[str, Any], dict[str, Any]]:
    """Denoise a cloud tile by tile and write it.

    Returns
    -------
    overall : DenoiseResult
        Without any points.
    counted : dict
        What the summary says of all points.
    estimated : dict
        What it says of the estimates.
    """
    from pcsmooth.cli.files import (
        attribute_teller,
        check_active,
        count_noise,
        without_marks,
    )
    from pcsmooth.formats import (
        coordinate_columns,
        open_chunks,
        write_chunks,
        write_template,
    )
    from pcsmooth.formats.unchanged import Unchanged
    from pcsmooth.tiling.denoising import denoise_in_tiles

    with ExitStack() as opened:
        chunks = opened.enter_context(open_chunks(input_path, reading.dim))
        unchanged = Unchanged(input_path)
        if chunks.count == 0:
            raise CloudFileError(input_path, "it holds no points", "give a file with points")
        say_warnings(chunks.template, input_path, say)

        def read(columns: bool = True) -> Iterator[PointCloud]:
            clouds = chunks.read(_ROWS, columns)
            return map(without_marks, clouds) if keeps_noise else clouds

        check_active(read(False), input_path)
        source = _source(chunks, read, fixed_column, estimate.orient)
        check(chunks.dimension)
        folder = opened.enter_context(tiling.work_folder(output_path, say))
        runner = opened.enter_context(tiling.runner(folder, tile_points, threads, say))
        bar = opened.enter_context(_Bar(printable(Path(input_path).name), shows_bar))

        def tell(progress: Progress) -> None:
            if progress.record is None:
                bar.tell(progress.stage, progress.done, progress.total)
            elif verbose:
                with bar.paused():
                    say(progress.record.in_words())

        opened.enter_context(computing(input_path, say, union_of(method.shapes)))
        result = denoise_in_tiles(
            source, folder, tile_points, runner, method, motion=motion, estimate=estimate,
            threads=threads, callback=tell,
        )  # fmt: skip
        facts, overall = result.denoised.facts(), result.overall
        estimated = {
            "normal_support": overall.curvature.normal_support,
            "curvature_support": overall.curvature.curvature_support,
            "orientation": dict(overall.curvature.orientation),
            "without_normal": facts.without_normal,
            "mean_convention": writing.convention if chunks.dimension == 3 else None,
            "median_abs_mean_curvature": facts.median_abs_mean_curvature
            * (2.0 if chunks.dimension == 3 and writing.convention == "sum" else 1.0),
        }
        output = EstimatesOutput(
            chunks.template, output_path, writing,
            denoise_provenance(overall, shape, provenance_of(estimated, estimate.orient)),
        )  # fmt: skip

        def part(cloud: PointCloud, result: DenoiseResult) -> EstimatedCloud:
            return output.part(
                cloud, result.points, result.curvature, result.displacement, result.outliers
            )

        template = part(chunks.template, overall)
        ends = (replace(piece, points=moved.points) for piece, moved in result.parts(read()))
        cloud = write_template(output_path, template.cloud, ends)
        if cloud is not template.cloud:
            output.layout = cloud.layout
        n_noise = 0

        def parts() -> Iterator[PointCloud]:
            nonlocal n_noise
            for piece, moved in result.parts(read()):
                n_noise += count_noise(piece)
                yield part(piece, moved).cloud
            unchanged.check()  # an older file than the one of this name is not written either

        pieces = bar.counted(parts(), "writing", -(-chunks.count // _ROWS))
        write_chunks(
            output_path, cloud, chunks.count, pieces, overwrite=overwrite,
            tell=attribute_teller(output_path, say),
        )  # fmt: skip
        output.say_rounding(overall.spacing, facts.mean_displacement, say)
        output.say_losses(chunks.template, template, say)
        counted = {
            "points": chunks.count,
            "dimension": chunks.dimension,
            "coordinates": coordinate_columns(chunks.template),
            "not_finite": chunks.count - result.store.count - n_noise,
            "noise_class": n_noise,
            "fixed": facts.fixed,
            "mean_displacement": facts.mean_displacement,
            "max_displacement": facts.max_displacement,
            "outliers": facts.outliers,
            "tiles": result.store.partition.n_tiles,
        }
    return overall, counted, estimated


def denoise_provenance(result: DenoiseResult, shape: dict[str, str], estimates: str) -> str:
    """Write what was done for a comment, in which values have no spaces."""
    words = "".join(f"{key}={printable('-'.join(value.split()))} " for key, value in shape.items())
    return (
        f"denoise {method_provenance(result)}{words}radius={result.radius:.9g} "
        f"spacing={result.spacing:.9g} {estimates}"
    )


def _source(
    chunks: CloudChunks,
    read: Callable[[bool], Iterator[PointCloud]],
    fixed_column: str | None,
    orient: str,
) -> Source:
    """Give positions, fixed points and normals of a file, piece by piece."""
    from pcsmooth.cli.estimates import input_normals
    from pcsmooth.cli.fixed_points import fixed_points
    from pcsmooth.curvature.orientation import parse_orientation
    from pcsmooth.estimating import given_normals
    from pcsmooth.tiling.cutting import Piece, Source

    orientation = parse_orientation(orient)
    fixed_points(chunks.template, fixed_column, chunks.name)
    has_normals = input_normals(chunks.template, orient, chunks.name) is not None
    has_normals &= orientation.rule in ("input", "auto")

    def positions() -> Iterator[npt.NDArray[np.float64]]:
        return (cloud.active_points for cloud in read(False))

    def pieces() -> Iterator[Piece]:
        for cloud in read(has_normals or fixed_column is not None):
            normals = None
            if has_normals:
                normals = given_normals(
                    input_normals(cloud, orient, chunks.name), cloud.points.shape, orientation
                )
            yield Piece(
                cloud.active_points, fixed_points(cloud, fixed_column, chunks.name)
                if fixed_column is not None else cloud.fixed_marks, normals,
            )  # fmt: skip

    return Source(chunks.count, chunks.dimension, has_normals, positions, pieces)


class _Bar:
    """A progress bar for each stage of the work, one after the other."""

    def __init__(self, name: str, shows_bar: bool) -> None:
        from tqdm import tqdm

        self._name = name
        self._bar = tqdm(
            desc=name, unit="tile", delay=1.0, leave=False, file=sys.stderr,
            disable=None if shows_bar else True,
        )  # fmt: skip

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *_error: object) -> None:
        self._bar.close()

    def tell(self, stage: str, done: int, total: int) -> None:
        """Say how far a stage is."""
        if done == 0:
            self._bar.reset(total)
            self._bar.set_description(f"{self._name}: {stage}")
        else:
            self._bar.update(done - self._bar.n)

    def paused(self) -> Any:
        """Leave the line to something else."""
        return self._bar.external_write_mode(file=sys.stderr)

    def counted(self, parts: Iterator[PointCloud], stage: str, total: int) -> Iterator[PointCloud]:
        """Count parts as they are taken."""
        self.tell(stage, 0, total)
        for done, part in enumerate(parts, 1):
            yield part
            self.tell(stage, done, total)
