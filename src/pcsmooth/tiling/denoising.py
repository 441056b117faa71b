"""Denoise a cloud of any size: cut into tiles on disk, moved step by step, put in order again."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Unpack

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.curvature.estimate import CurvatureEstimate, given_normals, spread_over
from pcsmooth.denoise_result import DenoiseResult, Record
from pcsmooth.errors import InvalidInputError
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.filtering import Filtering
from pcsmooth.flows.implicit import Implicit
from pcsmooth.kernels.surface import shape_operators as columns
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.methods.estimate import Estimate
from pcsmooth.methods.keywords import Keywords, resolve_keywords
from pcsmooth.methods.measured import Measured
from pcsmooth.methods.method import Method
from pcsmooth.methods.motion import Direction, Motion
from pcsmooth.methods.shapes import Polyhedra
from pcsmooth.positions import usable_rows
from pcsmooth.progress import Callback, Progress
from pcsmooth.tiling.column_store import Column
from pcsmooth.tiling.curvature import TiledCurvature, estimate_in_tiles
from pcsmooth.tiling.cutting import Source, cut_cloud
from pcsmooth.tiling.disk_sort import sort_on_disk
from pcsmooth.tiling.filtering import filter_in_tiles, plan_in_tiles
from pcsmooth.tiling.flow import TiledState, automatic_step, record_in_tiles, take_step
from pcsmooth.tiling.measuring import measure_in_tiles
from pcsmooth.tiling.runner import Runner
from pcsmooth.tiling.spacing import measure_spacing
from pcsmooth.tiling.streamed_median import streamed_median
from pcsmooth.tiling.tiled_cloud import TiledCloud, check_width

#: Points that are put in order at a time.
_SEGMENT = 1 << 20

#: Field of the result that marks outliers.
_OUTLIER = "outlier"


@dataclass(frozen=True)
class Facts:
    """What a summary says of all finite points.

    Attributes
    ----------
    mean_displacement, max_displacement : float
        Distance from start to end, L.
    without_normal : int
        Points that have no normal.
    outliers : int
        Points taken for outliers.
    median_abs_mean_curvature : float
        Of those that have one, 1/L.
    """

    mean_displacement: float
    max_displacement: float
    without_normal: int
    outliers: int
    median_abs_mean_curvature: float


@dataclass(frozen=True, eq=False)
class TiledResult:
    """A denoised cloud on disk.

    Attributes
    ----------
    cloud : TiledCloud
        The tiles.
    overall : DenoiseResult
        What holds for the whole cloud, without any points.
    ordered : Column
        Start, end and estimates of the finite points in the order of the input, seen from the
        cloud's origin in its unit, and after the filter the marks of outliers.
    """

    cloud: TiledCloud
    overall: DenoiseResult
    ordered: Column

    @property
    def fixed(self) -> int:
        """Number of finite points that are marked as fixed."""
        return sum(int(np.count_nonzero(chunk)) for chunk in self.cloud.fixed.chunks())

    def parts(self, pieces: Iterable[PointCloud]) -> Iterator[tuple[PointCloud, DenoiseResult]]:
        """Give the result of the input piece by piece.

        Parameters
        ----------
        pieces : iterable of PointCloud
            All of the input, in its order; rows marked as noise are those that took no part.

        Yields
        ------
        piece : PointCloud
            As it came.
        result : DenoiseResult
            Of its rows.
        """
        start = 0
        for piece in pieces:
            finite = usable_rows(piece.active_points)
            stop = start + int(np.count_nonzero(finite))
            yield piece, self._part(piece.points, finite, self.ordered.read(start, stop))
            start = stop

    def facts(self) -> Facts:
        """Find what a summary says of all points."""
        total, largest, without_normal, outliers = [], 0.0, 0, 0
        for rows in self.ordered.chunks():
            lengths = np.linalg.norm(rows["end"] - rows["start"], axis=1)
            total.append(float(lengths.sum()))
            largest = max(largest, float(lengths.max()))
            without_normal += int(np.count_nonzero(~self._has_normal(rows)))
            if _OUTLIER in (rows.dtype.names or ()):
                outliers += int(np.count_nonzero(rows[_OUTLIER]))

        def sizes() -> Iterator[npt.NDArray[np.float64]]:
            for rows in self.ordered.chunks():
                yield np.abs(rows["estimate"][self._has_normal(rows), columns.MEAN])

        n = self.ordered.rows
        return Facts(
            math.fsum(total) / n * self.cloud.unit,
            largest * self.cloud.unit,
            without_normal,
            outliers,
            streamed_median(sizes) / self.cloud.unit if without_normal < n else 0.0,
        )

    def _has_normal(self, rows: npt.NDArray[np.void]) -> npt.NDArray[np.bool_]:
        return np.asarray(rows["estimate"][:, : self.cloud.dimension].any(axis=1))

    def _part(
        self,
        positions: npt.NDArray[np.float64],
        finite: npt.NDArray[np.bool_],
        rows: npt.NDArray[np.void],
    ) -> DenoiseResult:
        unit = self.cloud.unit
        displacement = np.zeros_like(positions)
        displacement[finite] = (rows["end"] - rows["start"]) * unit
        dimension = self.cloud.dimension
        estimates = rows["estimate"]
        estimate = replace(
            self.overall.curvature,
            normals=estimates[:, :dimension],
            mean_curvature=estimates[:, columns.MEAN] / unit,
            gaussian_curvature=estimates[:, columns.GAUSSIAN] / unit ** (dimension - 1),
            principal_curvatures=estimates[:, columns.PRINCIPAL : columns.PRINCIPAL + dimension - 1]
            / unit,
            confidence=estimates[:, columns.CONFIDENCE],
            finite=np.ones(len(rows), np.bool_),
        )
        outliers = None
        if _OUTLIER in (rows.dtype.names or ()):
            outliers = np.zeros(len(positions), np.bool_)
            outliers[finite] = rows[_OUTLIER]
        return replace(
            self.overall,
            points=np.where(displacement == 0.0, positions, positions + displacement),
            curvature=spread_over(np.flatnonzero(finite), finite, estimate),
            displacement=np.linalg.norm(displacement, axis=1),
            outliers=outliers,
            finite=finite,
        )


def denoise_in_tiles(
    source: Source,
    folder: Path,
    tile_points: int,
    runner: Runner,
    method: Method | None = None,
    *,
    motion: Motion | Direction = "free",
    estimate: Estimate | None = None,
    threads: int | None = None,
    callback: Callback = lambda _progress: None,
    **keywords: Unpack[Keywords],
) -> TiledResult:
    """Denoise a cloud that need not fit into memory.

    Parameters
    ----------
    source : Source
        The cloud.
    folder : Path
        An empty folder on a disk that all workers see. It takes up to 400 bytes a point, and
        holds the result.
    tile_points : int
        Most points of a tile; memory goes with it, not with the cloud.
    runner : Runner
        Does the work on the tiles.
    method, motion, estimate, threads, **keywords
        As `denoise` takes them; what needs the whole cloud, `needs_whole_cloud` tells.
    callback : callable
        Told how far each stage is, and the record of each state.

    Returns
    -------
    TiledResult
        The same as that of `denoise`, to the last bit, but for the sums of the history, which
        agree up to rounding. Implicit steps solve one system of equations for each tile and what
        is around it, to the same tolerance: both are within that, 1e-3 of the displacement (root
        of the mean square, weighted by the masses), of the exact solution; what is left out of
        the systems is less than 1e-6 of it.

    Raises
    ------
    InvalidInputError
        Option values, no finite point, no normals where they are to be followed, a radius that
        cannot be derived, an implicit step that cannot be solved, or a cloud wider than some
        hundred thousand radii.
    CloudFileError
        The folder is full.
    """
    method, motion, estimate = resolve_keywords(method, motion, estimate, keywords)
    obstacle = needs_whole_cloud(method, motion)
    if obstacle:
        raise InvalidInputError(f"{obstacle} cannot be done in tiles; pass tile off")
    orientation = estimate.orientation
    if not source.has_normals:
        given_normals(None, (source.count, source.dimension), orientation)
    steps = method.iterations

    def counter(stage: str, total: int) -> Callable[[], None]:
        return _counter(callback, stage, total)

    with thread_limit(threads):
        cloud = cut_cloud(source, folder, tile_points, counter("cutting into tiles", 3))
        unit = cloud.unit
        n_tiles = cloud.partition.n_tiles
        spacing = measure_spacing(cloud, runner, counter("spacing", 2 * n_tiles))
        # Of one point, one: messages tell the difference.
        measured = Measured(cloud.box[: cloud.count], spacing, unit)
        radius = measured.radius(method.shapes.radius)
        plan = None
        if method.needs_plan:
            told = method.told_noise(measured)
            plan = plan_in_tiles(cloud, told, runner, counter("noise", 2 * n_tiles))
        restraint = motion.restraint(measured, moves_along_normals=method.moves_along_normals)
        check_width(cloud.box, 2.0 * radius, cloud.box[0])
        shapes = method.shapes.energy(radius)
        scheme = method.scheme(measured, plan, motion)
        state = TiledState(0, cloud.start, cloud.box, 0.0)
        history: list[Record] = []

        def note(record: Record) -> None:
            history.append(record.scaled(unit, cloud.dimension))
            callback(Progress("steps", record.iteration, steps, history[-1]))

        outliers, time, solved, error = None, 0.0, [], 0.0
        if isinstance(scheme, Filtering):
            totals = measure_in_tiles(cloud, state, shapes, runner, counter("energy", n_tiles))
            note(record_in_tiles(state, totals))
            state, outliers = filter_in_tiles(
                cloud, scheme.plan, radius, restraint, scheme.evens, runner,
                lambda stage: counter(stage, n_tiles),
            )  # fmt: skip
        elif isinstance(scheme, Implicit):
            time = scheme.weighted_step(is_of_balls=True)
        elif isinstance(scheme, Euler) and scheme.step is None:
            time = automatic_step(cloud, shapes, runner, counter("step", n_tiles))
            scheme = Euler(time, is_limited=True)
        elif isinstance(scheme, Euler) and scheme.step is not None:
            time = scheme.step
        while state.iteration < steps and not state.rests:  # the filter has taken its only one
            record, state = take_step(
                cloud, state, shapes, scheme, time, restraint,
                0.0 if method.stop is None else method.stop * spacing,
                runner, counter(f"step {state.iteration + 1} of {steps}", n_tiles),
            )  # fmt: skip
            note(record)
            if state.solver_iterations:
                solved.append(state.solver_iterations)
            error = max(error, state.solver_error)
        curvature = estimate_in_tiles(
            cloud, state, shapes, support=estimate.support,
            orientation=orientation.seen_from(cloud.origin, unit),
            given=cloud.given if source.has_normals else None,
            runner=runner, on_tile=counter("normals and curvature", 2 * n_tiles),
        )  # fmt: skip
        note(record_in_tiles(state, curvature.totals))
        ordered = _put_in_order(cloud, state, curvature, outliers, counter)
    return TiledResult(
        cloud,
        DenoiseResult(
            points=np.empty((0, cloud.dimension)),
            history=tuple(history),
            curvature=_no_estimates(cloud.dimension, radius * unit, spacing * unit, curvature),
            displacement=np.empty(0),
            outliers=None if outliers is None else np.empty(0, np.bool_),
            method=method,
            motion=motion,
            spacing=spacing * unit,
            radius=radius * unit,
            step=time * method.unit_of_step(measured),
            plan=None if plan is None else plan.scaled(unit),
            max_move=None if motion.max_move is None else restraint.longest * unit,
            stopped_early=state.iteration < steps,
            solver_iterations=tuple(solved),
            solver_error=error,
            finite=np.empty(0, np.bool_),
        ),
        ordered,
    )


def needs_whole_cloud(method: Method, motion: Motion) -> str:
    """Name what of a method or motion needs the whole cloud; nothing if tiles will do."""
    if motion.keep_volume:
        return "keeping the volume"
    if method.shapes.gradient == "autodiff":
        return "automatic differentiation"
    if method.name == "implicit":
        if method.shapes.weight == "none":
            return "an implicit step without a weight"
        if isinstance(method.shapes, Polyhedra):
            return "an implicit step of polyhedra"
    return ""


def _counter(callback: Callback, stage: str, total: int) -> Callable[[], None]:
    """Make a function that counts up and tells."""
    done = 0
    callback(Progress(stage, done, total))

    def count() -> None:
        nonlocal done
        done += 1
        callback(Progress(stage, done, total))

    return count


def _no_estimates(
    dimension: int, radius: float, spacing: float, curvature: TiledCurvature
) -> CurvatureEstimate:
    return CurvatureEstimate(
        normals=np.empty((0, dimension)),
        mean_curvature=np.empty(0),
        gaussian_curvature=np.empty(0),
        principal_curvatures=np.empty((0, dimension - 1)),
        confidence=np.empty(0),
        radius=radius,
        spacing=spacing,
        normal_support=curvature.normal_support,
        curvature_support=curvature.curvature_support,
        orientation=curvature.orientation,
        finite=np.empty(0, np.bool_),
    )


def _put_in_order(
    cloud: TiledCloud,
    state: TiledState,
    curvature: TiledCurvature,
    outliers: Column | None,
    counter: Callable[[str, int], Callable[[], None]],
) -> Column:
    """Sort starts, ends, estimates and marks of outliers by the points' numbers."""
    fields = {
        "number": cloud.numbers,
        "start": cloud.start,
        "end": state.points,
        "estimate": curvature.estimates,
    }
    if outliers is not None:
        fields[_OUTLIER] = outliers
    row_type = np.dtype(
        [(name, column.dtype.base, column.dtype.shape) for name, column in fields.items()]
    )
    starts = np.append(np.arange(0, cloud.count, _SEGMENT), cloud.count)
    count = counter("putting in order", 2 * (len(starts) - 1))

    def chunks() -> Iterator[tuple[npt.NDArray[np.int64], npt.NDArray[np.void]]]:
        read = (column.chunks(_SEGMENT) for column in fields.values())
        for chunks_of_fields in zip(*read, strict=True):
            rows = np.empty(len(chunks_of_fields[0]), row_type)
            for name, values in zip(fields, chunks_of_fields, strict=True):
                rows[name] = values
            yield rows["number"] // _SEGMENT, rows
            count()

    ordered = cloud.create("ordered", row_type)
    sort_on_disk(chunks, np.arange(len(starts) - 1), starts, ordered)
    for start, stop in zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True):
        rows = ordered.read(start, stop)
        in_order = np.empty_like(rows)
        in_order[rows["number"] - start] = rows
        ordered.write(start, in_order)
        count()
    return ordered
