"""What is around samples of a cloud in tiles, the same to the last bit as of the whole."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.surroundings import NEAREST, Surroundings, sample_ranks
from pcsmooth.neighbors import in_order_of_distance, nearest_points
from pcsmooth.tiling.runner import Runner
from pcsmooth.tiling.spacing import DISTINCT, marked_rows
from pcsmooth.tiling.tiled_cloud import TiledCloud

#: Distances are taken to be larger by this share where tiles are left out.
_MARGIN = 1e-9

#: Distances, rows and coordinates of up to `NEAREST` points nearest to some others, (m, k) each,
#: increasing; distances are infinite where there are no more.
_Nearest = tuple[npt.NDArray[Any], ...]


def look_around_in_tiles(
    cloud: TiledCloud, count: int, most: int, runner: Runner, on_tile: Callable[[], None]
) -> Surroundings:
    """Find the nearest points of up to 800 distinct points at the start: see `look_around`.

    Parameters
    ----------
    cloud : TiledCloud
        The cloud, with its column `DISTINCT`.
    count : int
        Number of distinct points, >= 2.
    most : int
        Nearest points, up to `NEAREST`, whose positions are wanted.
    runner : Runner
        Does the work.
    on_tile : callable
        Called after each piece of work; there are twice as many as tiles.

    Returns
    -------
    Surroundings

    Notes
    -----
    The points of a sample's own tile tell how far away the others can be. After that only those
    tiles are looked through that come as near.
    """
    rows = marked_rows(cloud.column(DISTINCT, np.bool_), sample_ranks(count))
    queries = cloud.start.read_runs(np.stack([rows, rows + 1], axis=1))
    first_rows = cloud.partition.starts[cloud.partition.tile_starts]
    home = np.searchsorted(first_rows, rows, side="right") - 1
    nearest = _nothing(len(rows), NEAREST, cloud.dimension)
    tiles = range(cloud.partition.n_tiles)
    boxes = []
    tasks = ((cloud, tile, queries[home == tile]) for tile in tiles)
    for tile, (box, found) in enumerate(runner.map(_search_home, tasks)):
        boxes.append(box)
        _merge(nearest, np.flatnonzero(home == tile), found)
        on_tile()

    def tasks_around() -> Iterator[tuple[Any, ...]]:
        for tile in tiles:
            # What has been found by now is looked at: it narrows the search down.
            limits = nearest[0][:, min(count, NEAREST) - 1] * (1.0 + _MARGIN)
            is_near = (_distances_to(boxes[tile], queries) <= limits) & (home != tile)
            places = np.flatnonzero(is_near)
            yield cloud, tile, places, queries[places], limits[places].max(initial=0.0)

    for places, found in runner.map(_search_around, tasks_around()):
        _merge(nearest, places, found)
        on_tile()
    distances, _, *coordinates = nearest
    known = min(count, NEAREST)
    positions = np.stack(coordinates, axis=2)[:, : min(known, most)]
    return Surroundings(count, distances[:, :known], np.ascontiguousarray(positions))


def _nothing(samples: int, most: int, dimension: int) -> _Nearest:
    shape = (samples, most)
    coordinates = [np.full(shape, np.nan) for _ in range(dimension)]
    return np.full(shape, np.inf), np.full(shape, np.iinfo(np.int64).max), *coordinates


def _merge(nearest: _Nearest, places: npt.NDArray[np.int64], found: _Nearest) -> None:
    """Put what was found for the samples at some places to what is known of them."""
    if len(places):
        both = (np.concatenate([a[places], b], axis=1) for a, b in zip(nearest, found, strict=True))
        for known, merged in zip(nearest, in_order_of_distance(*both), strict=True):
            known[places] = merged[:, :NEAREST]


def _distances_to(
    box: npt.NDArray[np.float64], points: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Distances from points (m, d) to a box (2, d), 0 within."""
    return np.asarray(np.linalg.norm(points - np.clip(points, box[0], box[1]), axis=1))


def _search_home(
    cloud: TiledCloud, tile: int, queries: npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.float64], _Nearest]:
    """Find the bounding box of a tile's points, and which of them are nearest to some positions."""
    points, rows = _distinct_of(cloud, tile)
    box = np.stack([points.min(axis=0), points.max(axis=0)])
    return box, _search(points, rows, queries, np.inf)


def _search_around(
    cloud: TiledCloud,
    tile: int,
    places: npt.NDArray[np.int64],
    queries: npt.NDArray[np.float64],
    farthest: float,
) -> tuple[npt.NDArray[np.int64], _Nearest]:
    """Find which of a tile's points are nearest to some positions; say again at which places."""
    if len(queries) == 0:
        return places, _nothing(0, 0, cloud.dimension)
    return places, _search(*_distinct_of(cloud, tile), queries, farthest)


def _distinct_of(
    cloud: TiledCloud, tile: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Read positions and rows of a tile's distinct points."""
    first, stop = cloud.partition.rows(tile)
    distinct = cloud.column(DISTINCT, np.bool_).read(first, stop)
    return cloud.start.read(first, stop)[distinct], first + np.flatnonzero(distinct)


def _search(
    points: npt.NDArray[np.float64],
    rows: npt.NDArray[np.int64],
    queries: npt.NDArray[np.float64],
    farthest: float,
) -> _Nearest:
    most = min(NEAREST, max(2, len(points)))
    found = _nothing(len(queries), most, points.shape[1])
    if len(queries):
        distances, places = nearest_points(points, queries, most, farthest=farthest)
        known = places < len(points)
        values = (distances[known], rows[places[known]], *points[places[known]].T)
        for column, value in zip(found, values, strict=True):
            column[known] = value
    return found
