"""The filter of a cloud: passes, tangential redistribution, and a last step.

Every stage takes all parts from one column of positions to the next. It looks around a part as far
as what it does to a point depends on other points, and keeps the part's own. What depends on all
points, how many are isolated, is counted part by part.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.balls import BallEnergy
from pcsmooth.energies.cell_reach import cell_reach
from pcsmooth.energies.centers import Centers, place_centers
from pcsmooth.energies.on_parts import evaluate
from pcsmooth.filters import errors_left, outliers, passes, redistribution
from pcsmooth.filters.neighborhoods import Neighborhoods, find_neighborhoods
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.filters.scales import Scales
from pcsmooth.flows.kept_volume import keep_volume
from pcsmooth.flows.restraint import FREE, Restraint
from pcsmooth.flows.state import State
from pcsmooth.flows.wanted_step import Wanted
from pcsmooth.parts.cloud_state import CloudState, Moves, next_state
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts, PartStep

#: Bits of what the rounds find: off the surface around; isolated.
_OFF = 1
_ISOLATED = 2

#: Name under which parts remember the order of their points.
_CENTERS = "centers"

#: Name under which they remember which points take part.
_POINTS = "points of the filter"

#: Name under which they remember noise and spacing.
_SCALES = "scales"

#: Name under which they remember the neighbourhoods in which outliers are looked for, which are
#: those of the first pass if none are found.
_NEIGHBORHOODS = "neighborhoods of the filter"


@dataclass(frozen=True, eq=False)
class Filtered:
    """A cloud whose noise was taken out.

    Attributes
    ----------
    state : CloudState
        The cloud after this one step.
    outliers : Column
        Which points were taken for outliers: too far from all others, or from the surface of
        those around. They stay where they are.
    noise : Column or None
        Standard deviation of the noise of each point, L, where it differs from place to place.
    left : Column or None
        Standard deviation of the error that is left of it, L (see `errors_left`), whether or not a
        volume was kept; None if no point was moved.
    """

    state: CloudState
    outliers: Column
    noise: Column | None = None
    left: Column | None = None


def filter_points(
    parts: Parts,
    plan: FilterPlan | None,
    radius: float,
    *,
    restraint: Restraint = FREE,
    redistribute: bool = True,
) -> Filtered:
    """Take the noise out of a cloud at its start.

    Parameters
    ----------
    parts : Parts
        The cloud.
    plan : FilterPlan or None
        What `plan_filter` chose for it.
    radius : float
        Of the balls, L, whose cells give the order in which the filter takes the points.
    restraint : Restraint
        Tells how far points may move in all.
    redistribute : bool
        Whether points also move along the surface, to be spread more evenly.

    Returns
    -------
    Filtered

    Notes
    -----
    A pass moves every point along its normal by z_i - mean_j(z_j), z_i the mean height of its
    neighbours over its tangent plane, and the mean of the z_j as lengths along their normals:
    Tukey's twicing, 2 W - W^2 for the averaging W. Plain averaging moves the points of a curved
    surface by r^2 H / 4; that is the same for all neighbours, and cancels. What is left is of
    fourth order in the radius, as in surface diffusion. Neighbours weigh |n_i . n_j|^e.

    Neighbourhoods are as wide as the noise needs (see `Width`): with a sheet thicker than the
    spacing, smaller ones are balls within it that know no surface. Between the passes and the
    last step the points are spread evenly over the surface (see `redistribution.redistribute`).

    The last step does the same with neighbourhoods of ten times as many points, but takes only a
    share of it. Its residual consists of the noise v that the passes have left, v = 1.2 sigma^2 /
    N, and of the surface's own detail. From their common energy r = mean(residual^2) around a
    point the share is min(1, v / r)^2 (Wiener's filter has v / r): all of it where the surface
    is smooth, next to nothing at edges and detail.

    In the first passes, too, a point takes only the share min(1, 2 v / h) of its move, h the
    variance of the heights around it and v what is left of the noise's: where the data cannot tell
    noise from shape, it moves less.

    No point ends up farther from its start than six times the noise, or 2.5 times its own where
    noise and spacing are known place by place (see `measure_scales`); all widths, shares and limits
    are then those of the place. Points that fill a volume, of which no surface shows, stay. These
    and all other numbers are the plan's design.
    """
    found = parts.create("outlier", np.bool_)
    start = CloudState.at_start(parts)
    rests = replace(start, iteration=1)
    if plan is None or not plan.moves_points:
        return Filtered(rests, found)
    cloud = _Cloud(plan, radius, parts.start, parts.fixed, parts.box, found)
    if not _find_outliers(parts, cloud):
        parts.forget(_CENTERS, _POINTS, _SCALES)
        return Filtered(rests, found)
    sizes = parts.create("size", np.float64)
    # Each pass reads one and writes the other.
    lefts = parts.create("left_0", np.float64), parts.create("left_1", np.float64)
    stages: list[tuple[str, Callable[[Column], PartStep[None]]]] = [
        (_name_of(number, plan), partial(_Pass, cloud, number, sizes, _turned(lefts, number)))
        for number in range(len(plan.passes))
    ]
    if redistribute:
        stages.append(("redistribution", partial(_Redistribution, cloud)))
    points = parts.start
    # None is farther from its start on the way.
    drift = (plan.max_move + plan.design.redistribution_max_move) * plan.largest_noise
    for number, (name, stage) in enumerate(stages):
        target = parts.create(f"filtered_{number}", parts.start.dtype)
        for _ in parts.map(name, stage(target), points, drift):
            pass
        parts.forget(_NEIGHBORHOODS)
        parts.drop(f"filtered_{number - 1}")
        points = target
    target = parts.create("filtered", parts.start.dtype)
    keeps_volume = restraint.keeps_volume
    noise = None if plan.scale_map is None else parts.create("noise", np.float64)
    before, left = _turned(lefts, len(plan.passes))
    last = _Last(cloud, sizes, before, FREE if keeps_volume else restraint, target, noise, left)
    name = _name_of(len(plan.passes), plan)
    moves = list(parts.map(name, last, points, drift))
    parts.drop("size", f"filtered_{len(stages) - 1}")
    parts.forget(_CENTERS, _POINTS, _SCALES)
    if keeps_volume:
        wanted, target = _Wanting(cloud, target), parts.create("kept", parts.start.dtype)
        moves = [move for _, move in keep_volume(parts, start, wanted, restraint, target, name)]
        parts.forget()
        parts.drop("filtered")
    return Filtered(next_state(parts, start, target, moves), found, noise, left)


def _turned(columns: tuple[Column, Column], number: int) -> tuple[Column, Column]:
    """Give two columns in turn: the one that is read in a pass, and the one that is written."""
    return columns if number % 2 == 0 else (columns[1], columns[0])


def _name_of(number: int, plan: FilterPlan) -> str:
    """Name a pass, of which the last step is one."""
    return f"pass {number + 1} of {plan.design.n_passes}"


def _find_outliers(parts: Parts, cloud: _Cloud) -> bool:
    """Mark the outliers round by round; tell if other points are left.

    Each round looks without the ones found before, which stand by each other.
    """
    design = cloud.plan.design
    for number in range(design.outlier_rounds):
        candidates = parts.create(f"candidates_{number}", np.uint8)
        name = f"outliers {number + 1} of {design.outlier_rounds}"
        # How many points have none, one, the other, or both of the marks.
        counts = np.sum(
            list(parts.map(name, _OutlierSearch(cloud, candidates), parts.start)), axis=0
        )
        count, isolated = int(counts.sum()), int(counts[_ISOLATED] + counts[_ISOLATED | _OFF])
        wanted = (
            _OFF | _ISOLATED if outliers.few_are_isolated(isolated, count, cloud.plan) else _OFF
        )
        start = 0
        for marks, known in zip(candidates.chunks(), cloud.outliers.chunks(), strict=True):
            cloud.outliers.write(start, known | (marks & wanted != 0))
            start += len(marks)
        found = sum(int(counts[marks]) for marks in range(len(counts)) if marks & wanted)
        parts.drop(f"candidates_{number}")
        if found == 0:
            break
        parts.forget(_POINTS, _NEIGHBORHOODS)
        if found == count:
            break
    return found < count


@dataclass(frozen=True, eq=False)
class _Cloud:
    """What all stages know of the cloud.

    Attributes
    ----------
    plan : FilterPlan
        Of the filter.
    radius : float
        Of the balls, L.
    start, fixed : Column
        Positions at the start, L, and marks of fixed points.
    box : ndarray, shape (2, d)
        Bounding box at the start, L.
    outliers : Column
        Those that have been found.
    """

    plan: FilterPlan
    radius: float
    start: Column
    fixed: Column
    box: npt.NDArray[np.float64]
    outliers: Column

    def look_at(self, part: Part) -> _Points:
        """Find out which points of a part take part, and in which order."""
        return part.remember(_POINTS, lambda: self._points(part))

    def look_around(self, part: Part, points: _Points) -> Neighborhoods:
        """Find the neighbourhoods of the first pass, at the start."""
        width = self.plan.passes[0]
        return part.remember(
            _NEIGHBORHOODS, lambda: find_neighborhoods(points.chosen_start, width, points.scales)
        )

    def _points(self, part: Part) -> _Points:
        start = part.read(self.start)
        centers = part.remember(_CENTERS, lambda: self._place(start))
        carriers = centers.carriers
        fixed = np.zeros(len(start), np.bool_)
        fixed[carriers[part.read(self.fixed)]] = True
        found = part.read(self.outliers)
        numbers = centers.distinct[centers.grid.order]
        chosen = numbers[~found[numbers]]
        fixed = fixed[carriers]
        scales = part.remember(_SCALES, lambda: self.plan.scales_at(start))
        return _Points(
            start, None if len(numbers) == len(start) else carriers, fixed, found, chosen,
            start[chosen], fixed[chosen],
            None if scales is None else scales.of(chosen),
            self.plan.noise_at(scales, len(start)),
        )  # fmt: skip

    def _place(self, start: npt.NDArray[np.float64]) -> Centers:
        return place_centers(start, self.radius, reach=self.radius, box=self.box)


@dataclass(frozen=True, eq=False)
class _Points:
    """The points of a part, as the filter takes them.

    Attributes
    ----------
    start : ndarray, shape (m, d)
        Where they were, L.
    carriers : ndarray of int, shape (m,), or None
        Which of them is the first at the position of each at the start; None if each is.
    fixed : ndarray of bool, shape (m,)
        Whether each is fixed or coincides with one that is.
    outliers : ndarray of bool, shape (m,)
        Those that have been found to be outliers.
    chosen : ndarray of int, shape (k,)
        Which of them take part: the first at each position that are no outliers, in the order in
        which the filter of the whole takes them.
    chosen_start, chosen_fixed : ndarray, shape (k, d) and (k,)
        The same of these.
    scales : Scales or None
        Noise and spacing at these at the start, if they differ.
    noise : ndarray, shape (m,)
        Noise of all of them, L.
    """

    start: npt.NDArray[np.float64]
    carriers: npt.NDArray[np.int64] | None
    fixed: npt.NDArray[np.bool_]
    outliers: npt.NDArray[np.bool_]
    chosen: npt.NDArray[np.int64]
    chosen_start: npt.NDArray[np.float64]
    chosen_fixed: npt.NDArray[np.bool_]
    scales: Scales | None
    noise: npt.NDArray[np.float64]

    def spread(
        self, values: npt.NDArray[np.float64], others: npt.NDArray[np.float64]
    ) -> npt.NDArray[np.float64]:
        """Put values (k, d) of the points that take part into those of all, (m, d)."""
        rows = np.empty_like(others) if len(self.chosen) == len(others) else others.copy()
        rows[self.chosen] = values
        return rows if self.carriers is None else rows[self.carriers]


@dataclass(frozen=True, eq=False)
class _OutlierSearch:
    """Look for outliers once; count the own distinct points by what was found."""

    cloud: _Cloud
    candidates: Column

    @property
    def reach(self) -> float:
        return outliers.search_reach(self.cloud.plan, self.cloud.box.shape[1])

    def __call__(self, part: Part) -> npt.NDArray[np.int64]:
        plan, points = self.cloud.plan, self.cloud.look_at(part)
        chosen, carriers = points.chosen, points.carriers
        marks = np.zeros(len(points.start), np.uint8)
        is_counted = np.zeros(len(marks), np.bool_)
        if len(chosen):
            neighborhoods = self.cloud.look_around(part, points)
            found = outliers.find_candidates(
                points.chosen_start, neighborhoods, plan, points.scales
            )
            marks[chosen] = found.off_surface * _OFF + found.isolated * _ISOLATED
            is_counted[chosen] = True
        own = part.own
        counts = np.bincount(marks[own][is_counted[own]], minlength=(_OFF | _ISOLATED) + 1)
        part.write(self.candidates, marks if carriers is None else marks[carriers])
        return counts


@dataclass(frozen=True, eq=False)
class _Pass:
    """One of the first passes."""

    cloud: _Cloud
    number: int
    sizes: Column
    lefts: tuple[Column, Column]
    target: Column

    @property
    def reach(self) -> float:
        plan = self.cloud.plan
        return passes.PASS_REACHES * plan.largest_radius(plan.passes[self.number])

    def __call__(self, part: Part) -> None:
        plan, points = self.cloud.plan, self.cloud.look_at(part)
        chosen, moved = points.chosen, points.chosen_start
        if len(chosen):
            before, after = self.lefts
            if self.number == 0:
                now, neighborhoods = moved, self.cloud.look_around(part, points)
                left = points.noise**2
            else:
                now, left = part.points[chosen], part.read(before)
                neighborhoods = find_neighborhoods(now, plan.passes[self.number], points.scales)
            moved, sizes, left_now = passes.take_pass(
                moved,
                now,
                neighborhoods,
                plan,
                self.number,
                points.chosen_fixed,
                points.scales,
                left[chosen],
            )
            rows = np.zeros(len(points.start))
            rows[chosen] = left_now
            part.write(after, rows)
            if self.number == len(plan.passes) - 1:
                rows = np.zeros(len(points.start))
                rows[chosen] = sizes
                part.write(self.sizes, rows)
        part.write(self.target, points.spread(moved, part.points))


@dataclass(frozen=True, eq=False)
class _Redistribution:
    """Spread points evenly over the surface."""

    cloud: _Cloud
    target: Column

    @property
    def reach(self) -> float:
        return redistribution.redistribution_reach(self.cloud.plan)

    def __call__(self, part: Part) -> None:
        plan, points = self.cloud.plan, self.cloud.look_at(part)
        moved = part.points[points.chosen]
        if len(moved):
            moved = redistribution.redistribute(moved, plan, points.chosen_fixed, points.scales)
        part.write(self.target, points.spread(moved, part.points))


@dataclass(frozen=True, eq=False)
class _Last:
    """Take the last step, and restrain the whole way."""

    cloud: _Cloud
    sizes: Column
    before: Column
    restraint: Restraint
    target: Column
    noise: Column | None
    left: Column

    @property
    def reach(self) -> float:
        return passes.LAST_REACHES * self.cloud.plan.largest_radius(self.cloud.plan.last)

    def __call__(self, part: Part) -> Moves:
        plan, points = self.cloud.plan, self.cloud.look_at(part)
        start, chosen, fixed = points.start, points.chosen, points.fixed
        vectors, left = np.zeros_like(start), points.noise
        if len(chosen):
            before, sizes = points.chosen_start, part.read(self.sizes)[chosen]
            moved, chosen_left = passes.take_last_step(
                before, part.points[chosen], plan, points.chosen_fixed, sizes, points.scales,
                part.read(self.before)[chosen],
            )  # fmt: skip
            vectors = points.spread(moved - before, vectors)
            left = points.spread(chosen_left, left)
        rests = fixed | points.outliers
        wanted = np.linalg.norm(vectors, axis=1)
        vectors = self.restraint.shorten(start, vectors, rests, start)
        went = np.linalg.norm(vectors, axis=1)
        shares = np.divide(went, wanted, out=np.zeros_like(went), where=wanted > 0.0)
        left = errors_left.where_held_back(left, points.noise, np.where(rests, 0.0, shares))
        part.write(self.left, left)
        moved = start + vectors
        part.write(self.target, moved)
        if self.noise is not None:
            part.write(self.noise, points.noise)
        return Moves.of(part, start, moved, vectors, fixed)


@dataclass(frozen=True, eq=False)
class _Wanting:
    """What the filter has done, as one step from the start (see `WantingStep`).

    Attributes
    ----------
    cloud : _Cloud
        What all stages know.
    target : Column
        Where the filter has taken the points, L.
    """

    cloud: _Cloud
    target: Column

    @property
    def radius(self) -> float:
        return self.cloud.radius

    @property
    def start(self) -> Column:
        return self.cloud.start

    @property
    def box(self) -> npt.NDArray[np.float64]:
        return self.cloud.box

    @property
    def reach(self) -> float:
        return cell_reach(self.radius, self.box.shape[1])

    def find(self, part: Part) -> Wanted:
        evaluation = evaluate(part, BallEnergy(self.radius), self.box)
        carriers = evaluation.union.carriers
        rests = np.zeros(len(carriers), np.bool_)
        rests[carriers[part.read(self.cloud.fixed)]] = True
        rests = rests[carriers] | part.read(self.cloud.outliers)
        vectors = part.read(self.target) - part.points
        return Wanted(State(part, evaluation, self.box), vectors, rests, 0, 0.0)
