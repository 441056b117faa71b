"""Denoise a cloud of any size: cut into tiles on disk, moved step by step, put in order again."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.cloud import PointCloud
from pcsmooth.curvature.estimate import (
    CurvatureEstimate,
    Support,
    check_support,
    given_normals,
    spread_over,
)
from pcsmooth.curvature.orientation import parse_orientation
from pcsmooth.denoise_options import MotionName, resolve_options
from pcsmooth.denoise_result import DenoiseResult, Record
from pcsmooth.energies.choice import choose_energy
from pcsmooth.energies.polyhedra.union import Union
from pcsmooth.energies.protocol import Quantity, Weight
from pcsmooth.energies.weighting import power_of_step
from pcsmooth.errors import InvalidInputError
from pcsmooth.flows.choice import SchemeName
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.implicit import Implicit, Order
from pcsmooth.flows.motion import Motion
from pcsmooth.flows.scheme import Scheme
from pcsmooth.kernels.surface import shape_operators as columns
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.lengths import resolve_length, resolve_radius, step_in_unit
from pcsmooth.positions import usable_rows
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

#: Takes the name of what is being done, how many pieces of it are done, and how many there are.
Progress = Callable[[str, int, int], None]

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
    *,
    energy: Quantity | None = None,
    weight: Weight | None = None,
    radius: float | str = "auto",
    iterations: int | Literal["auto"] = "auto",
    step: float | Literal["auto"] = "auto",
    scheme: SchemeName = "auto",
    order: Order | None = None,
    noise: float | str | None = None,
    motion: MotionName = "free",
    max_move: float | str | None = None,
    stop: float | None = None,
    polyhedron: ConvexBody | None = None,
    union: Union = "exact",
    support: Support = "auto",
    orient: str = "auto",
    threads: int | None = None,
    on_state: Callable[[Record], None] = lambda _record: None,
    progress: Progress = lambda _stage, _done, _total: None,
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
    energy, weight, radius, iterations, step, scheme, order, noise, motion, max_move, stop
        As `denoise` takes them. Implicit steps need a weight.
    polyhedron, union
        As `denoise` takes them, but not with implicit steps.
    support, orient, threads
        As `denoise` takes them.
    on_state : callable
        Called with the record of each state.
    progress : callable
        Told what is being done, and how far it is.

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
    options = resolve_options(
        energy=energy, weight=weight, radius=radius, iterations=iterations, step=step,
        scheme=scheme, order=order, motion=motion, max_move=max_move, stop=stop, noise=noise,
        gradient=None, is_polyhedral=polyhedron is not None,
    )  # fmt: skip
    if options.scheme == "implicit":
        _check_implicit(options.weight, polyhedron)
    check_support(support)
    orientation = parse_orientation(orient)
    if not source.has_normals:
        given_normals(None, (source.count, source.dimension), orientation)
    steps = options.steps
    with thread_limit(threads):
        cloud = cut_cloud(source, folder, tile_points, _counter(progress, "cutting into tiles", 3))
        unit = cloud.unit
        unit_of_step = unit ** power_of_step(options.energy, options.weight, cloud.dimension)
        given_step = step_in_unit(step, unit_of_step)
        n_tiles = cloud.partition.n_tiles
        spacing = measure_spacing(cloud, runner, _counter(progress, "spacing", 2 * n_tiles))
        ends = cloud.box[: cloud.count]  # of one point, one: messages tell the difference
        length = resolve_radius(radius, ends, spacing, unit)
        plan = None
        if options.scheme != "euler":
            told = None if noise is None else resolve_length(noise, ends, spacing, "noise", unit)
            plan = plan_in_tiles(cloud, told, runner, _counter(progress, "noise", 2 * n_tiles))
        longest = math.inf
        if max_move is not None:
            longest = resolve_length(max_move, ends, spacing, "max_move", unit)
        check_width(cloud.box, 2.0 * length, cloud.box[0])
        shapes = choose_energy(length, options.energy, options.weight, polyhedron, union)
        state = TiledState(0, cloud.start, cloud.box, 0.0)
        history = []
        outliers, time, solved, error = None, 0.0, [], 0.0
        way: Scheme = Euler(given_step, is_limited=given_step is None)
        if options.scheme == "filter":
            totals = measure_in_tiles(
                cloud, state, shapes, runner, _counter(progress, "energy", n_tiles)
            )
            history.append(record_in_tiles(state, totals).scaled(unit, cloud.dimension))
            on_state(history[-1])
            state, outliers = filter_in_tiles(
                cloud, plan, length, Motion(longest=longest), motion == "free", runner,
                lambda stage: _counter(progress, stage, n_tiles),
            )  # fmt: skip
        elif options.order is not None:
            noise_found = None if plan is None else plan.noise.deviation
            way = Implicit(spacing, options.order, given_step, noise=noise_found)
            time = way.weighted_step(is_of_balls=True)
        elif given_step is None:
            time = automatic_step(cloud, shapes, runner, _counter(progress, "step", n_tiles))
            way = Euler(time, is_limited=True)
        else:
            time = given_step
        while state.iteration < steps and not state.rests:  # the filter has taken its only one
            record, state = take_step(
                cloud, state, shapes, way, time,
                Motion(motion == "normal", longest=longest),
                0.0 if stop is None else stop * spacing,
                runner, _counter(progress, f"step {state.iteration + 1} of {steps}", n_tiles),
            )  # fmt: skip
            history.append(record.scaled(unit, cloud.dimension))
            on_state(history[-1])
            if state.solver_iterations:
                solved.append(state.solver_iterations)
            error = max(error, state.solver_error)
        curvature = estimate_in_tiles(
            cloud, state, shapes, support=support,
            orientation=orientation.seen_from(cloud.origin, unit),
            given=cloud.given if source.has_normals else None,
            runner=runner, on_tile=_counter(progress, "normals and curvature", 2 * n_tiles),
        )  # fmt: skip
        history.append(record_in_tiles(state, curvature.totals).scaled(unit, cloud.dimension))
        on_state(history[-1])
        ordered = _put_in_order(cloud, state, curvature, outliers, progress)
    return TiledResult(
        cloud,
        DenoiseResult(
            points=np.empty((0, cloud.dimension)),
            history=tuple(history),
            curvature=_no_estimates(cloud.dimension, length * unit, spacing * unit, curvature),
            displacement=np.empty(0),
            outliers=None if outliers is None else np.empty(0, np.bool_),
            scheme=options.scheme,
            energy=options.energy,
            weight=options.weight,
            spacing=spacing * unit,
            radius=length * unit,
            step=time * unit_of_step,
            plan=None if plan is None else plan.scaled(unit),
            order=options.order,
            max_move=None if max_move is None else longest * unit,
            stopped_early=state.iteration < steps,
            solver_iterations=tuple(solved),
            solver_error=error,
            finite=np.empty(0, np.bool_),
        ),
        ordered,
    )


def _check_implicit(weight: Weight, polyhedron: ConvexBody | None) -> None:
    """Raise `InvalidInputError` if implicit steps need what only the whole cloud tells."""
    if weight == "none":
        raise InvalidInputError(
            "implicit steps in tiles need a weight; choose cell or boundary, or pass tile off"
        )
    if polyhedron is not None:
        raise InvalidInputError(
            "implicit steps in tiles are for balls; leave the polyhedron out, or pass tile off"
        )


def _counter(progress: Progress, stage: str, total: int) -> Callable[[], None]:
    """Make a function that counts up and tells."""
    done = 0
    progress(stage, done, total)

    def count() -> None:
        nonlocal done
        done += 1
        progress(stage, done, total)

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
    progress: Progress,
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
    count = _counter(progress, "putting in order", 2 * (len(starts) - 1))

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
