"""The mean spacing of a cloud in tiles, the same to the last bit as `mean_spacing` of the whole."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from pcsmooth.neighbors import (
    SPACING_NEIGHBORS,
    build_grid,
    first_coincident,
    is_crowded,
    mean_without_outliers,
    spacing_cell,
    spacing_samples,
    spacings_in_cells,
)
from pcsmooth.tiling.column_store import Column
from pcsmooth.tiling.runner import Runner
from pcsmooth.tiling.tiled_cloud import TiledCloud

#: Column that tells the points which are the first at their position.
DISTINCT = "distinct"


def measure_spacing(cloud: TiledCloud, runner: Runner, on_tile: Callable[[], None]) -> float:
    """Measure the mean distance between neighbouring points at the start.

    Parameters
    ----------
    cloud : TiledCloud
        The cloud.
    runner : Runner
        Does the work.
    on_tile : callable
        Called after each piece of work; there are twice as many as tiles.

    Returns
    -------
    float
        L; 0.0 if there are fewer than two distinct points.
    """
    cloud.create(DISTINCT, np.bool_)
    tiles = range(cloud.partition.n_tiles)
    n = 0
    for count in runner.map(_mark_distinct, ((cloud, tile) for tile in tiles)):
        n += count
        on_tile()
    if n < 2:
        return 0.0
    count = min(SPACING_NEIGHBORS[cloud.dimension], n - 1)
    samples = marked_rows(cloud.column(DISTINCT, np.bool_), spacing_samples(n))
    cell_size = spacing_cell(cloud.box, n)
    spacings = np.full(len(samples), np.nan)
    within_cells = 0
    tasks = ((cloud, tile, samples, cell_size, count) for tile in tiles)
    for places, found, crowd in runner.map(_spacings_of_tile, tasks):
        spacings[places] = found
        within_cells += crowd
        on_tile()
    if cell_size == 0.0 or is_crowded(within_cells, n):
        spacings[:] = np.nan
    left = np.flatnonzero(np.isnan(spacings))
    if left.size:
        spacings[left] = _spacings_far(cloud, runner, samples[left], count)
    return mean_without_outliers(spacings)


def _mark_distinct(cloud: TiledCloud, tile: int) -> int:
    """Find the points of a tile that are the first at their position; coincident ones share it."""
    first, stop = cloud.partition.rows(tile)
    points = cloud.start.read(first, stop)
    distinct = first_coincident(points) == np.arange(len(points))
    cloud.column(DISTINCT, np.bool_).write(first, distinct)
    return int(np.count_nonzero(distinct))


def marked_rows(
    column: Column, ranks: npt.NDArray[np.int64], rows: int = 1 << 22
) -> npt.NDArray[np.int64]:
    """Find the points of some ranks among those that are marked.

    Parameters
    ----------
    column : Column
        Marks of points.
    ranks : ndarray of int, shape (s,)
        Ranks, increasing, below the number of marked points.
    rows : int
        Rows that are looked through at a time.

    Returns
    -------
    ndarray of int, shape (s,)
        Their rows.
    """
    found = []
    begin, before = 0, 0
    for marks in column.chunks(rows):
        places = np.flatnonzero(marks)
        wanted = ranks[np.searchsorted(ranks, before) :] - before
        found.append(begin + places[wanted[wanted < len(places)]])
        begin += len(marks)
        before += len(places)
    return np.concatenate(found)


def _spacings_of_tile(
    cloud: TiledCloud, tile: int, samples: npt.NDArray[np.int64], cell_size: float, count: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64], int]:
    """Find the spacings of a tile's samples: which they are, the spacings, points within cells."""
    if cell_size == 0.0:
        return np.empty(0, np.int64), np.empty(0), 0
    loaded = cloud.tile(tile, cloud.start, 3.0 * cell_size, 0.0)
    distinct = loaded.read(cloud.column(DISTINCT, np.bool_))
    is_own = np.zeros(len(distinct), np.bool_)
    is_own[loaded.own] = True
    grid = build_grid(loaded.points[distinct], cell_size)
    sizes = np.diff(grid.cell_starts)
    crowd = int(np.repeat(sizes, sizes)[is_own[distinct][grid.order]].sum())
    first, stop = cloud.partition.rows(tile)
    places = np.flatnonzero((samples >= first) & (samples < stop))
    own = np.searchsorted(loaded.rows[distinct], samples[places])
    return places, spacings_in_cells(grid, cloud.dimension, cell_size, count, own), crowd


def _spacings_far(
    cloud: TiledCloud, runner: Runner, samples: npt.NDArray[np.int64], count: int
) -> npt.NDArray[np.float64]:
    """Find the spacings of samples whose nearest points may be anywhere."""
    positions = cloud.start.read_runs(np.stack([samples, samples + 1], axis=1))
    nearest = np.full((len(samples), count + 1), np.inf)
    tasks = ((cloud, tile, positions, count) for tile in range(cloud.partition.n_tiles))
    for distances in runner.map(_nearest_in_tile, tasks):
        both = np.concatenate([nearest, distances], axis=1)
        nearest = np.sort(both, axis=1)[:, : count + 1]
    return np.asarray(nearest[:, 1:].mean(axis=1))


def _nearest_in_tile(
    cloud: TiledCloud, tile: int, positions: npt.NDArray[np.float64], count: int
) -> npt.NDArray[np.float64]:
    """Distances from some positions to the nearest distinct points of a tile, increasing."""
    first, stop = cloud.partition.rows(tile)
    distinct = cloud.column(DISTINCT, np.bool_).read(first, stop)
    points = cloud.start.read(first, stop)[distinct]
    tree = cKDTree(points, balanced_tree=False, compact_nodes=False)
    return np.asarray(tree.query(positions, count + 1)[0])
