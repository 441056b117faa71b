"""The mean spacing of a cloud."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid.grid import CELLS_PER_AXIS
from pcsmooth.kernels.grid.k_nearest import mean_k_nearest_distances
from pcsmooth.kernels.threads import thread_count
from pcsmooth.neighbors.coincident import Distinct, mark_distinct
from pcsmooth.neighbors.grid import Grid, build_grid
from pcsmooth.neighbors.k_nearest import build_tree
from pcsmooth.neighbors.marked import marked_rows
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.point_order import scattered_ranks

#: Neighbours whose mean distance is a point's spacing, by dimension: those around it on a curve
#: and on a surface.
_NEIGHBORS = {2: 2, 3: 6}

#: Points at which the spacing is sampled.
_SAMPLES = 20_000

#: A point whose own spacing is larger than this times the median is an outlier.
_OUTLIER_SPACING = 4.0

#: Cells in which spacings are looked for first, in units of the spacing that the extent suggests,
#: and mean number of points in a point's cell beyond which there would be too many to look at.
_GUESS = 5.0
_CROWDING = 1000.0


def mean_spacing(points: npt.NDArray[np.float64]) -> float:
    """Mean distance between neighbouring points of a cloud in memory, L: see `measure_spacing`.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions, L, n >= 1.
    """
    cloud = WholeCloud.of(points)
    return measure_spacing(cloud, mark_distinct(cloud)) * cloud.unit


def measure_spacing(parts: Parts, distinct: Distinct) -> float:
    """Measure the mean distance between neighbouring points at the start.

    The spacing at a point is the mean distance to its 6 nearest distinct points (2 in 2D). The
    result is the mean over up to 20,000 points, one in each of as many runs of equal length,
    leaving out the points whose own spacing exceeds four times the median (outliers).

    Parameters
    ----------
    parts : Parts
        The cloud.
    distinct : Distinct
        Its points that are the first at their position.

    Returns
    -------
    float
        L; 0.0 if there are fewer than two distinct points.

    Notes
    -----
    A grid as wide as the spacing would be if the points filled a rectangle (in the plane, a line)
    finds it for most at little cost; k-d trees find the others.
    """
    n = distinct.count
    if n < 2:
        return 0.0
    count = min(_NEIGHBORS[parts.dimension], n - 1)
    samples = marked_rows(distinct.marks, scattered_ranks(n, _SAMPLES))
    spacings = np.full(len(samples), np.nan)
    cell_size = _cell_for(parts.box, n)
    if cell_size > 0.0:
        within_cells = 0
        most = _CROWDING * n
        step = _InCells(distinct.marks, samples, cell_size, count, most)
        for places, found, crowd in parts.map("spacing", step, parts.start):
            spacings[places] = found
            within_cells += crowd
        if within_cells >= most:  # a tree is faster
            spacings[:] = np.nan
    left = np.flatnonzero(np.isnan(spacings))
    if left.size:
        spacings[left] = _spacings_far(parts, distinct.marks, samples[left], count)
    return _mean_without_outliers(spacings)


@dataclass(frozen=True, eq=False)
class _InCells:
    """Find the spacings of a part's own samples within the cells around them.

    Gives which of the samples they are, their spacings, NaN where there are too few points, and
    how many points are in the cells of the part's own, summed over these.
    """

    marks: Column
    samples: npt.NDArray[np.int64]
    cell_size: float
    count: int
    most_within: float

    @property
    def reach(self) -> float:
        """Points look into the cells that adjoin theirs; a margin."""
        return 3.0 * self.cell_size

    def __call__(self, part: Part) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64], int]:
        distinct = part.read(self.marks)
        points = part.points
        is_own = np.zeros(len(distinct), np.bool_)
        is_own[part.own] = True
        grid = build_grid(points if distinct.all() else points[distinct], self.cell_size)
        sizes = np.diff(grid.cells.starts)
        crowd = int(np.repeat(sizes, sizes)[is_own[distinct][grid.order]].sum())
        places = np.flatnonzero((self.samples >= part.first) & (self.samples < part.stop))
        if crowd >= self.most_within:  # then a tree does it, for all parts
            return places, np.full(len(places), np.nan), crowd
        own = np.searchsorted(part.rows[distinct], self.samples[places])
        dimension = points.shape[1]
        return places, _spacings_in_cells(grid, dimension, self.cell_size, self.count, own), crowd


@dataclass(frozen=True, eq=False)
class _NearestOwn:
    """Find the distances from some positions to the nearest of a part's own points, increasing."""

    marks: Column
    positions: npt.NDArray[np.float64]
    count: int

    reach = 0.0

    def __call__(self, part: Part) -> npt.NDArray[np.float64]:
        tree = build_tree(part.points[part.read(self.marks)])
        return np.asarray(tree.query(self.positions, self.count + 1, workers=thread_count())[0])


def _spacings_far(
    parts: Parts, marks: Column, samples: npt.NDArray[np.int64], count: int
) -> npt.NDArray[np.float64]:
    """Find the spacings of samples whose nearest points may be anywhere."""
    step = _NearestOwn(marks, parts.start.take(samples), count)
    nearest = np.full((len(samples), count + 1), np.inf)
    for distances in parts.map("spacing", step, parts.start):
        both = np.concatenate([nearest, distances], axis=1)
        nearest = np.sort(both, axis=1)[:, : count + 1]
    return np.asarray(nearest[:, 1:].mean(axis=1))


def _mean_without_outliers(spacings: npt.NDArray[np.float64]) -> float:
    """Mean of the spacings (s,) of some points that are not four times the median, L."""
    return float(spacings[spacings <= _OUTLIER_SPACING * np.median(spacings)].mean())


def _cell_for(box: npt.NDArray[np.float64], n: int) -> float:
    """Choose cells in which to look for the nearest of n points in a box (2, d), L; 0 for none."""
    dimension = box.shape[1]
    extents = np.sort(box[1] - box[0])[::-1]
    cell_size = _GUESS * float(np.prod(extents[: dimension - 1]) / n) ** (1.0 / (dimension - 1))
    return cell_size if cell_size > extents[0] / CELLS_PER_AXIS else 0.0


def _spacings_in_cells(
    grid: Grid, dimension: int, cell_size: float, count: int, samples: npt.NDArray[np.int64]
) -> npt.NDArray[np.float64]:
    """Mean distance from some distinct points of a grid to their nearest others, (samples,), L.

    NaN for those that have fewer than `count` others nearer than the cell size.
    """
    places = np.empty(len(grid.order), np.int64)
    places[grid.order] = np.arange(len(places))
    spacings = np.empty(len(samples))
    mean_k_nearest_distances(
        grid.coordinates,
        grid.cells,
        dimension,
        count,
        cell_size,
        places[samples],
        spacings,
    )
    return spacings
