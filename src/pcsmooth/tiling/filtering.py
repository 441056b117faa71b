"""The filter of a cloud in tiles: stage by stage, the same to the last bit as of the whole.

Every stage takes all tiles from one column of positions to the next. It loads what is around a
tile as far as what it does to a point depends on other points, does the same as with the whole
cloud, and keeps the tile's own points. What depends on all points, how many stand alone, is
counted tile by tile.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.centers import place_centers
from pcsmooth.filters import outliers, surface_filter
from pcsmooth.filters.evening import even_out, evening_halo
from pcsmooth.filters.noise import LARGEST_SUPPORT
from pcsmooth.filters.plan import FilterPlan, can_be_planned, plan_from
from pcsmooth.flows.restraint import Restraint
from pcsmooth.tiling.column_store import Column
from pcsmooth.tiling.flow import Moves, TiledState, moves_of, next_state
from pcsmooth.tiling.runner import Runner, TileWork
from pcsmooth.tiling.spacing import DISTINCT
from pcsmooth.tiling.surroundings import look_around_in_tiles
from pcsmooth.tiling.tiled_cloud import Tile, TiledCloud

#: Column of the points that have been found to be outliers, as far as is known.
_OUTLIER = "outlier"

#: Columns of what the rounds find, and its bits: far from the surface around; on its own.
_SUSPECT = "suspect"
_OFF = 1
_ALONE = 2

#: Column of the numbers of points in the neighbourhoods of the last pass.
_SIZE = "size"

#: From the name of a stage, makes what is called after each of its tiles.
Stages = Callable[[str], Callable[[], None]]


def plan_in_tiles(
    cloud: TiledCloud, noise: float | None, runner: Runner, on_tile: Callable[[], None]
) -> FilterPlan | None:
    """Plan the filter of a cloud at its start: see `plan_filter`.

    Parameters
    ----------
    cloud : TiledCloud
        The cloud, with its column `DISTINCT`.
    noise : float or None
        Standard deviation of the noise, L; measured if there is none.
    runner : Runner
        Does the work.
    on_tile : callable
        Called after each piece of work; there are twice as many as tiles.

    Returns
    -------
    FilterPlan or None
        None if there are too few points to filter.
    """
    distinct = cloud.column(DISTINCT, np.bool_)
    count = sum(int(np.count_nonzero(chunk)) for chunk in distinct.chunks())
    if not can_be_planned(count, cloud.dimension):
        return None
    most = LARGEST_SUPPORT[cloud.dimension]
    return plan_from(look_around_in_tiles(cloud, count, most, runner, on_tile), noise)


@dataclass(frozen=True, eq=False)
class _Stage:
    """What a stage needs to know.

    Attributes
    ----------
    plan : FilterPlan
        Of the filter.
    radius : float
        Of the balls, L, whose cells give the order in which the filter takes the points.
    points, target : Column
        Positions before and after, L.
    drift : float
        Most that a point has moved from its start along an axis before, L.
    """

    plan: FilterPlan
    radius: float
    points: Column
    target: Column
    drift: float = 0.0


def filter_in_tiles(
    cloud: TiledCloud,
    plan: FilterPlan | None,
    radius: float,
    restraint: Restraint,
    evens: bool,
    runner: Runner,
    stages: Stages,
) -> tuple[TiledState, Column]:
    """Take the noise out of a cloud at its start: see `filter_points`.

    Parameters
    ----------
    cloud : TiledCloud
        The cloud.
    plan : FilterPlan or None
        What `plan_in_tiles` chose.
    radius : float
        Of the balls, L.
    restraint : Restraint
        Tells how far points may move in all.
    evens : bool
        Whether points also move along the surface.
    runner : Runner
        Does the work.
    stages : callable
        Called with the name of each stage.

    Returns
    -------
    state : TiledState
        The cloud after this one step.
    outliers : Column
        Which points were taken for outliers.
    """
    found = cloud.create(_OUTLIER, np.bool_)
    rests = TiledState(1, cloud.start, cloud.box, 0.0)
    if plan is None or not plan.moves_points:
        return rests, found

    def column(number: int) -> Column:
        # Names of their own: a worker that was given up may still write to an earlier one.
        return cloud.create(f"filtered_{number}", cloud.start.dtype)

    stage = _Stage(plan, radius, cloud.start, column(0))
    if not _find_outliers(cloud, stage, runner, stages):
        return rests, found
    cloud.create(_SIZE, np.float64)
    work: list[tuple[str, TileWork, tuple[Any, ...]]] = [
        (f"pass {number + 1} of {surface_filter.N_PASSES}", _pass_tile, (number,))
        for number in range(len(plan.passes))
    ]
    if evens:
        work.append(("evening out", _even_tile, ()))
    for number, (name, function, more) in enumerate(work, 1):
        drift = max(_map(cloud, function, (stage, *more), runner, stages(name)))
        cloud.drop(f"filtered_{number - 2}")
        stage = replace(stage, points=stage.target, target=column(number), drift=drift)
    name = f"pass {surface_filter.N_PASSES} of {surface_filter.N_PASSES}"
    moves: list[Moves] = list(_map(cloud, _last_tile, (stage, restraint), runner, stages(name)))
    cloud.drop(_SIZE, f"filtered_{len(work) - 1}")
    return next_state(cloud, rests.iteration, stage.target, moves, 0.0), found


def _map(
    cloud: TiledCloud,
    work: TileWork,
    more: tuple[Any, ...],
    runner: Runner,
    on_tile: Callable[[], None],
) -> Iterator[Any]:
    """Do the same work on all tiles."""
    for result in runner.map(
        work, ((cloud, tile, *more) for tile in range(cloud.partition.n_tiles))
    ):
        yield result
        on_tile()


def _find_outliers(cloud: TiledCloud, stage: _Stage, runner: Runner, stages: Stages) -> bool:
    """Mark the outliers round by round, as `find_outliers` does; tell if other points are left."""
    column = cloud.column(_OUTLIER, np.bool_)
    for number in range(outliers.ROUNDS):
        suspects = cloud.create(f"{_SUSPECT}_{number}", np.uint8)
        name = f"outliers {number + 1} of {outliers.ROUNDS}"
        # Of the tiles, how many points have none, one, the other, or both of the marks.
        counts = sum(_map(cloud, _suspect_tile, (stage, suspects), runner, stages(name)))
        count, alone = int(counts.sum()), int(counts[_ALONE] + counts[_ALONE | _OFF])
        wanted = _OFF | _ALONE if outliers.few_are_alone(alone, count) else _OFF
        start = 0
        for marks, known in zip(suspects.chunks(), column.chunks(), strict=True):
            column.write(start, known | (marks & wanted != 0))
            start += len(marks)
        found = sum(int(counts[marks]) for marks in range(len(counts)) if marks & wanted)
        cloud.drop(f"{_SUSPECT}_{number}")
        if found in (0, count):
            break
    return found < count


@dataclass(frozen=True, eq=False)
class _Part:
    """A tile and what is around it, as the filter takes it.

    Attributes
    ----------
    loaded : Tile
        All points.
    start : ndarray, shape (m, d)
        Where they were, L.
    carriers : ndarray of int, shape (m,)
        Which of them is the first at the position of each at the start.
    held : ndarray of bool, shape (m,)
        Whether each is fixed or coincides with one that is.
    outliers : ndarray of bool, shape (m,)
        Those that have been found to be outliers.
    chosen : ndarray of int, shape (k,)
        Which of them take part: the first at each position that are no outliers, in the order in
        which the filter of the whole takes them.
    """

    loaded: Tile
    start: npt.NDArray[np.float64]
    carriers: npt.NDArray[np.int64]
    held: npt.NDArray[np.bool_]
    outliers: npt.NDArray[np.bool_]
    chosen: npt.NDArray[np.int64]

    def write_points(self, target: Column, values: npt.NDArray[np.float64]) -> float:
        """Write positions (k, d) of the points that take part; return how far they have drifted."""
        moved = self.loaded.points.copy()
        moved[self.chosen] = values
        moved = moved[self.carriers]
        self.loaded.write(target, moved)
        own = self.loaded.own
        return float(np.abs(moved[own] - self.start[own]).max())


def _load(cloud: TiledCloud, tile: int, stage: _Stage, halo: float) -> _Part:
    """Load a tile and all that is within the halo, L."""
    loaded = cloud.tile(tile, stage.points, halo, stage.drift)
    start = loaded.read(cloud.start)
    centers = place_centers(start, stage.radius, reach=stage.radius, box=cloud.box)
    held = np.zeros(len(start), np.bool_)
    held[centers.carriers[loaded.read(cloud.fixed)]] = True
    found = loaded.read(cloud.column(_OUTLIER, np.bool_))
    numbers = centers.distinct[centers.grid.order]
    return _Part(
        loaded, start, centers.carriers, held[centers.carriers], found, numbers[~found[numbers]]
    )


def _suspect_tile(
    cloud: TiledCloud, tile: int, stage: _Stage, suspects: Column
) -> npt.NDArray[np.int64]:
    """Look for outliers once; count the tile's own distinct points by what was found."""
    width = stage.plan.passes[0]
    part = _load(cloud, tile, stage, outliers.REACHES * width.reach)
    marks = np.zeros(len(part.start), np.uint8)
    is_counted = np.zeros(len(part.start), np.bool_)
    if len(part.chosen):
        found = outliers.find_suspects(
            part.start[part.chosen], width, stage.plan.noise.deviation,
            surface_filter.OUTLIERS_EXPONENT,
        )  # fmt: skip
        marks[part.chosen] = found.off * _OFF + found.alone * _ALONE
        is_counted[part.chosen] = True
    part.loaded.write(suspects, marks[part.carriers])
    own = part.loaded.own
    return np.bincount(marks[own][is_counted[own]], minlength=(_OFF | _ALONE) + 1)


def _pass_tile(cloud: TiledCloud, tile: int, stage: _Stage, number: int) -> float:
    """Take a pass; return how far the tile's points have drifted."""
    halo = surface_filter.PASS_REACHES * stage.plan.passes[number].reach
    part = _load(cloud, tile, stage, halo)
    chosen = part.chosen
    moved = part.start[chosen]
    if len(chosen):
        moved, sizes = surface_filter.take_pass(
            moved, part.loaded.points[chosen], stage.plan, number, part.held[chosen]
        )
        if number == len(stage.plan.passes) - 1:
            rows = np.zeros(len(part.start))
            rows[chosen] = sizes
            part.loaded.write(cloud.column(_SIZE, np.float64), rows)
    return part.write_points(stage.target, moved)


def _even_tile(cloud: TiledCloud, tile: int, stage: _Stage) -> float:
    """Spread points evenly; return how far the tile's points have drifted."""
    width, noise = stage.plan.passes[-1], stage.plan.noise.deviation
    part = _load(cloud, tile, stage, evening_halo(width, noise))
    moved = part.loaded.points[part.chosen]
    if len(part.chosen):
        moved = even_out(moved, width, noise, part.held[part.chosen])
    return part.write_points(stage.target, moved)


def _last_tile(cloud: TiledCloud, tile: int, stage: _Stage, restraint: Restraint) -> Moves:
    """Take the last step, and restrain the way from start to end as `next_displacement` does."""
    part = _load(cloud, tile, stage, surface_filter.LAST_REACHES * stage.plan.last.reach)
    start, chosen = part.start, part.chosen
    vectors = np.zeros_like(start)
    if len(chosen):
        sizes = part.loaded.read(cloud.column(_SIZE, np.float64))
        moved = surface_filter.take_last_step(
            start[chosen], part.loaded.points[chosen], stage.plan, part.held[chosen], sizes[chosen]
        )
        vectors[chosen] = moved - start[chosen]
    vectors = restraint.shorten(start, vectors[part.carriers], part.held | part.outliers, start)
    moved = start + vectors
    part.loaded.write(stage.target, moved)
    return moves_of(part.loaded.own, start, moved, vectors, part.held)
