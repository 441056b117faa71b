"""The local spacing of a cloud in parts, the same as that of the whole to the last bit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.surface.covering_neighborhoods import (
    LARGEST,
    SEEN_FIRST,
)
from pcsmooth.neighbors.coincident import Distinct
from pcsmooth.neighbors.k_nearest import k_nearest
from pcsmooth.neighbors.local_spacing import (
    SLOPE,
    SMOOTHINGS,
    BoxedPoints,
    positive,
    smoothed,
    spacings_in_order,
)
from pcsmooth.neighbors.surroundings import nearest_of
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts, Reach
from pcsmooth.point_order import scattered_ranks

#: Least length that a part looks, L: what it sees within is all at one place.
_LEAST_REACH = float(np.finfo(np.float64).tiny)

#: Lengths are taken to be longer by this share, lest rounding leaves out a point.
_MARGIN = 1e-9

#: Own points of a part at which it is seen how far the nearest points may be that theirs depends
#: on, the share of them for which a part looks far enough, and how much farther it looks: points
#: apart from all others are looked after one by one.
_SAMPLES = 400
_SERVED = 0.95
_FARTHER = 1.5

#: Nearest points of a single point that are looked for, beyond those it may need so that it is no
#: matter of chance which of equally far ones are among them, and how many points at a time.
_SEARCHED = LARGEST + 32
_AT_ONCE = 4096


def local_spacings_of(parts: Parts, distinct: Distinct) -> Column:
    """Find the local spacing of all points of a cloud at its start: see `local_spacings`.

    Parameters
    ----------
    parts : Parts
        The cloud.
    distinct : Distinct
        Its points that are the first at their position.

    Returns
    -------
    Column
        L; 0 if there are fewer than two distinct points.

    Notes
    -----
    A part looks as far around as most of its own points need; those that need more, as they are
    far from others, get the points nearest to them from all parts.
    """
    spacings = parts.create("local spacings", np.float64)
    if parts.n_parts == 1:
        spacings.write(0, spacings_in_order(parts.start.read(0, parts.count)))
        return spacings
    if distinct.count < 2:
        return spacings
    marks, stage, start = distinct.marks, "local spacing", parts.start
    seen = min(SEEN_FIRST, distinct.count - 1)
    raw = parts.create("raw spacings", np.float64)
    neighbors = parts.create("spacing neighbors", (np.int64, (seen,)))
    reaches = _Reaches(*zip(*parts.map(stage, _LookAtSamples(marks), start), strict=True))
    measure = _Measure(marks, distinct.count, reaches, raw, neighbors)
    left = np.concatenate(list(parts.map(stage, measure, start)))
    alone = _measure_alone(parts, distinct, stage, left, seen)
    even = parts.create("even spacings", np.float64)
    found = list(parts.map(stage, _Smooth(marks, raw, neighbors, alone, even), start))
    least = min(smallest for *_, smallest in found)
    reaches = _Reaches(*zip(*(first_and_reach for *first_and_reach, _ in found), strict=True))
    lowered = parts.create("lowered spacings", np.float64)
    lower = _Lower(marks, even, reaches, least, lowered)
    rows, values = (
        np.concatenate(each) for each in zip(*parts.map(stage, lower, start), strict=True)
    )
    if len(rows):
        more = _LowerAlone(marks, even, start.take(rows), values)
        values = np.min(list(parts.map(stage, more, start)), axis=0)
    _finish(marks, lowered, rows, values, spacings)
    parts.drop("raw spacings", "spacing neighbors", "even spacings", "lowered spacings")
    return spacings


@dataclass(frozen=True, eq=False)
class _Reaches:
    """How far each part looks (see `Reach`): first rows of the parts, and lengths, L."""

    firsts: tuple[int, ...]
    lengths: tuple[float, ...]

    def of_parts(self, drift: float) -> npt.NDArray[np.float64]:
        return np.array(self.lengths) + 2.0 * drift

    def of(self, part: Part) -> float:
        """Tell it of one part."""
        return self.lengths[self.firsts.index(part.first)]


@dataclass(frozen=True, eq=False)
class _Alone:
    """Rows (u,) of single points, increasing, spacings (u,), L, and neighbours' rows (u, m)."""

    rows: npt.NDArray[np.int64]
    spacings: npt.NDArray[np.float64]
    neighbors: npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class _LookAtSamples:
    """Find how far a part should look for the points nearest to its own; its first row, the length.

    As far as the nearest own points of most of its own are.
    """

    marks: Column

    reach = 0.0

    def __call__(self, part: Part) -> tuple[int, float]:
        points = part.points[part.read(self.marks)]
        samples = points[scattered_ranks(len(points), _SAMPLES)]
        count = min(LARGEST + 1, len(points))
        distances = k_nearest(points, samples, max(count, 2))[0][:, count - 1]
        return part.first, max(_FARTHER * float(np.quantile(distances, _SERVED)), _LEAST_REACH)


@dataclass(frozen=True, eq=False)
class _Measure:
    """Measure the spacing at a part's own points; gives the rows for which it saw too little."""

    marks: Column
    count: int
    reaches: _Reaches
    raw: Column
    neighbors: Column

    @property
    def reach(self) -> Reach:
        return self.reaches

    def __call__(self, part: Part) -> npt.NDArray[np.int64]:
        distinct = part.read(self.marks)
        is_own = np.zeros(len(distinct), np.bool_)
        is_own[part.own] = True
        own_rows = part.rows[distinct & is_own]
        n = int(np.count_nonzero(distinct))
        (seen,) = self.neighbors.dtype.shape
        if n - 1 < min(LARGEST, self.count - 1):
            return own_rows
        numbers = np.flatnonzero(is_own[distinct])
        found = BoxedPoints.of(part.points[distinct]).spacings_at(numbers, seen)
        raw, neighbors = np.zeros(len(distinct)), np.zeros((len(distinct), seen), np.int64)
        raw[distinct & is_own] = found.spacings
        neighbors[distinct & is_own] = part.rows[distinct][found.neighbors]
        part.write(self.raw, raw)
        part.write(self.neighbors, neighbors)
        return own_rows[found.reaches > self.reaches.of(part) * (1.0 - _MARGIN)]


@dataclass(frozen=True, eq=False)
class _Smooth:
    """Smooth the spacings of a part's own points over neighbours that may be anywhere.

    Gives the first row, how far it should look to lower them, and the least.
    """

    marks: Column
    raw: Column
    neighbors: Column
    alone: _Alone
    even: Column

    reach = 0.0

    def __call__(self, part: Part) -> tuple[int, float, float]:
        own = part.rows[part.read(self.marks)]
        rows = own
        for _ in range(SMOOTHINGS):  # each looks at neighbours once more
            known, rows = rows, np.unique(np.concatenate([rows, self._neighbors(rows).ravel()]))
        # Those of the outermost points do not matter.
        places = np.zeros((len(rows), *self.neighbors.dtype.shape), np.int32)
        places[np.searchsorted(rows, known)] = np.searchsorted(rows, self._neighbors(known))
        raw = self.raw.take(rows)
        inside, at = self._alone(rows)
        raw[inside] = self.alone.spacings[at]
        values = smoothed(positive(raw), places)[np.searchsorted(rows, own)]
        even = np.zeros(part.stop - part.first)
        even[own - part.first] = values
        part.write(self.even, even)
        reach = float(np.quantile(values, _SERVED)) / SLOPE
        return part.first, max(reach, _LEAST_REACH), float(values.min())

    def _neighbors(self, rows: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
        """Rows of the neighbours of points, (k, m)."""
        found = self.neighbors.take(rows)
        inside, at = self._alone(rows)
        found[inside] = self.alone.neighbors[at]
        return found

    def _alone(
        self, rows: npt.NDArray[np.int64]
    ) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.int64]]:
        """Which of some rows, (k,), were measured alone, and their places among these."""
        places = np.searchsorted(self.alone.rows, rows)
        inside = np.append(self.alone.rows, -1)[places] == rows
        return inside, places[inside]


@dataclass(frozen=True, eq=False)
class _Lower:
    """Lower the spacings of a part's own points to what those around allow.

    Gives rows of own points that may have to be lower still, for points beyond, and their values.
    """

    marks: Column
    even: Column
    reaches: _Reaches
    least: float
    lowered: Column

    @property
    def reach(self) -> Reach:
        return self.reaches

    def __call__(self, part: Part) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
        distinct = part.read(self.marks)
        lowered = np.zeros(len(distinct))
        lowered[distinct] = BoxedPoints.of(part.points[distinct]).lowered(
            part.read(self.even)[distinct]
        )
        part.write(self.lowered, lowered)
        far = self.least + SLOPE * self.reaches.of(part) * (1.0 - _MARGIN)
        left = np.flatnonzero(lowered[part.own] > far)
        return part.first + left, lowered[part.own][left]


@dataclass(frozen=True, eq=False)
class _LowerAlone:
    """Lower the spacings (u,) of single points (u, d) to what a part's own points allow."""

    marks: Column
    even: Column
    queries: npt.NDArray[np.float64]
    values: npt.NDArray[np.float64]

    reach = 0.0

    def __call__(self, part: Part) -> npt.NDArray[np.float64]:
        distinct = part.read(self.marks)
        points, even = part.points[distinct], part.read(self.even)[distinct]
        gaps = self.queries - np.clip(self.queries, points.min(axis=0), points.max(axis=0))
        least = even.min() + SLOPE * np.linalg.norm(gaps, axis=1) * (1.0 - _MARGIN)
        near = np.flatnonzero(least < self.values)
        values = self.values.copy()
        if len(near):
            both = np.concatenate([points, self.queries[near]])
            lowered = BoxedPoints.of(both).lowered(np.concatenate([even, self.values[near]]))
            values[near] = lowered[len(points) :]
        return values


def _measure_alone(
    parts: Parts, distinct: Distinct, stage: str, rows: npt.NDArray[np.int64], seen: int
) -> _Alone:
    """Measure the spacings at single points, from the points nearest to each."""
    spacings, neighbors = np.empty(len(rows)), np.empty((len(rows), seen), np.int64)
    for start in range(0, len(rows), _AT_ONCE):
        some = rows[start : start + _AT_ONCE]
        _, nearest, positions = nearest_of(parts, distinct, stage, some, _SEARCHED)
        order = np.argsort(nearest, axis=1)  # of equal distances the lower row counts as nearer
        nearest = np.take_along_axis(nearest, order, axis=1)
        for k, row in enumerate(some.tolist()):
            place = np.searchsorted(nearest[k], [row])
            found = BoxedPoints.of(positions[k, order[k]]).spacings_at(place, seen)
            spacings[start + k] = found.spacings[0]
            neighbors[start + k] = nearest[k, found.neighbors[0]]
    return _Alone(rows, spacings, neighbors)


def _finish(
    marks: Column,
    lowered: Column,
    rows: npt.NDArray[np.int64],
    values: npt.NDArray[np.float64],
    spacings: Column,
) -> None:
    """Write the spacings (u,) of some rows and those that were lowered before into a column.

    Coincident points, which follow the first of them, get that one's.
    """
    before = np.zeros(1)
    begin = 0
    for chunk, distinct in zip(lowered.chunks(), marks.chunks(), strict=True):
        some = slice(*np.searchsorted(rows, (begin, begin + len(chunk))))
        found = np.concatenate([before, chunk])
        found[1 + rows[some] - begin] = values[some]
        last = np.maximum.accumulate(np.where(distinct, np.arange(1, len(found)), 0))
        before = found[last[-1:]]
        spacings.write(begin, found[last])
        begin += len(chunk)
