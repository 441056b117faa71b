"""What is around some points of a cloud in parts: their nearest points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.neighbors.coincident import Distinct
from pcsmooth.neighbors.k_nearest import in_order_of_distance, k_nearest
from pcsmooth.neighbors.marked import marked_rows
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts
from pcsmooth.point_order import scattered_ranks

#: Distances are taken to be larger by this share where parts are left out.
_MARGIN = 1e-9

#: Distances, rows and coordinates of the points nearest to some others, (m, k) each, increasing;
#: distances are infinite where there are no more.
_Nearest = tuple[npt.NDArray[Any], ...]


@dataclass(frozen=True)
class Surroundings:
    """The points around some points of a cloud.

    Attributes
    ----------
    count : int
        Points of the cloud.
    distances : ndarray, shape (m, k)
        From some of them to their nearest points, themselves included, L, increasing.
    positions : ndarray, shape (m, l, d)
        Where the first l <= k of these are, L.
    """

    count: int
    distances: npt.NDArray[np.float64]
    positions: npt.NDArray[np.float64]


def look_around(
    parts: Parts, distinct: Distinct, stage: str, samples: int, most: int, located: int
) -> Surroundings:
    """Find the nearest points of some points of a cloud, at the start.

    Parameters
    ----------
    parts : Parts
        The cloud.
    distinct : Distinct
        Its points that are the first at their position, >= 2 of them, which count.
    stage : str
        Name of what it is done for (see `Parts.map`).
    samples, most, located : int
        How many points are looked at, how far how many of the nearest of each are, and where how
        many of these are, at most.

    Returns
    -------
    Surroundings
        Points at equal distances are in the order of their rows. Which of them are among the
        positions is undefined only where all the nearest points beyond the last position are
        exactly as far away as that.

    Notes
    -----
    The points of a sample's own part tell how far away the others can be. After that only those
    parts are looked through that come as near.
    """
    rows = marked_rows(distinct.marks, scattered_ranks(distinct.count, samples))
    distances, _, positions = nearest_of(parts, distinct, stage, rows, most)
    return Surroundings(distinct.count, distances, np.ascontiguousarray(positions[:, :located]))


def nearest_of(
    parts: Parts, distinct: Distinct, stage: str, rows: npt.NDArray[np.int64], most: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Find the points nearest to some distinct points of a cloud, at the start.

    Parameters
    ----------
    parts, distinct, stage
        As in `look_around`.
    rows : ndarray of int, shape (m,)
        Rows of the points, increasing.
    most : int
        How many of the nearest of each are looked for.

    Returns
    -------
    distances : ndarray, shape (m, k)
        To these, the points themselves included, L, increasing; k = `most`, or all there are.
    found : ndarray of int, shape (m, k)
        Their rows.
    positions : ndarray, shape (m, k, d)
        Where they are, L.
    """
    queries = parts.start.take(rows)
    nearest = _nothing(len(rows), most, parts.dimension)
    home = _SearchHome(most, distinct.marks, queries, rows)
    for places, found in parts.map(stage, home, parts.start):
        for known, values in zip(nearest, found, strict=True):
            known[places, : values.shape[1]] = values
    n_known = min(distinct.count, most)
    if parts.n_parts > 1:
        limits = nearest[0][:, n_known - 1] * (1.0 + _MARGIN)
        around = _SearchAround(most, distinct.marks, queries, rows, limits)
        for places, found in parts.map(stage, around, parts.start):
            _merge(nearest, places, found)
    distances, numbers, *coordinates = (values[:, :n_known] for values in nearest)
    return distances, numbers, np.stack(coordinates, axis=2)


@dataclass(frozen=True, eq=False)
class _SearchHome:
    """Find which of a part's own points are nearest to those samples that are its own.

    Gives which of the samples they are, and what was found for them.
    """

    most: int
    marks: Column
    queries: npt.NDArray[np.float64]
    rows: npt.NDArray[np.int64]

    reach = 0.0

    def __call__(self, part: Part) -> tuple[npt.NDArray[np.int64], _Nearest]:
        places = np.flatnonzero((self.rows >= part.first) & (self.rows < part.stop))
        return places, _search(part, self.most, self.marks, self.queries[places], np.inf)


@dataclass(frozen=True, eq=False)
class _SearchAround:
    """Find which of a part's own points are nearest to other parts' samples, if near enough."""

    most: int
    marks: Column
    queries: npt.NDArray[np.float64]
    rows: npt.NDArray[np.int64]
    limits: npt.NDArray[np.float64]

    reach = 0.0

    def __call__(self, part: Part) -> tuple[npt.NDArray[np.int64], _Nearest]:
        points = part.points
        box = np.stack([points.min(axis=0), points.max(axis=0)])
        is_home = (self.rows >= part.first) & (self.rows < part.stop)
        is_near = (_distances_to(box, self.queries) <= self.limits) & ~is_home
        places = np.flatnonzero(is_near)
        farthest = float(self.limits[places].max(initial=0.0))
        return places, _search(part, self.most, self.marks, self.queries[places], farthest)


def _nothing(samples: int, most: int, dimension: int) -> _Nearest:
    shape = (samples, most)
    coordinates = [np.full(shape, np.nan) for _ in range(dimension)]
    return np.full(shape, np.inf), np.full(shape, np.iinfo(np.int64).max), *coordinates


def _merge(nearest: _Nearest, places: npt.NDArray[np.int64], found: _Nearest) -> None:
    """Put what was found for the samples at some places to what is known of them."""
    if len(places):
        both = (np.concatenate([a[places], b], axis=1) for a, b in zip(nearest, found, strict=True))
        for known, merged in zip(nearest, in_order_of_distance(*both), strict=True):
            known[places] = merged[:, : known.shape[1]]


def _distances_to(
    box: npt.NDArray[np.float64], points: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Distances from points (m, d) to a box (2, d), 0 within."""
    return np.asarray(np.linalg.norm(points - np.clip(points, box[0], box[1]), axis=1))


def _search(
    part: Part,
    most: int,
    marks: Column,
    queries: npt.NDArray[np.float64],
    farthest: float,
) -> _Nearest:
    """Find which of a part's own distinct points are nearest to some positions."""
    if len(queries) == 0:
        return _nothing(0, 0, queries.shape[1])
    distinct = part.read(marks)
    points, rows = part.points, part.rows
    if not distinct.all():
        points, rows = points[distinct], rows[distinct]
    most = min(most, max(2, len(points)))
    found = _nothing(len(queries), most, points.shape[1])
    distances, places = k_nearest(points, queries, most, farthest=farthest)
    known = places < len(points)
    values = (distances[known], rows[places[known]], *points[places[known]].T)
    for column, value in zip(found, values, strict=True):
        column[known] = value
    return found
