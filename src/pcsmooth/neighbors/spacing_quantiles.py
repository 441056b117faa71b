"""How far the points of a cloud in parts are apart where it is dense and where it is sparse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid.box_tree import build_box_tree, find_nearest_of_each
from pcsmooth.kernels.surface.covering_neighborhoods import measure_spacings
from pcsmooth.neighbors.coincident import Distinct
from pcsmooth.neighbors.local_spacing import LEAST
from pcsmooth.neighbors.marked import marked_rows
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts
from pcsmooth.point_order import scattered_ranks

#: Points at which the spacing is sampled.
_SAMPLES = 500

#: Nearest points of a sample among which those that it is measured with are looked for, and of
#: whose spacings it has the median: as many as a local spacing is smoothed over.
_AROUND = 256
_SMOOTHED = 60


@dataclass(frozen=True)
class SpacingQuantiles:
    """Local spacings that 5, 50 and 95 % of the points have at most, L."""

    dense: float
    median: float
    sparse: float

    @property
    def variation(self) -> float | None:
        """How many times farther points are apart where they are sparse; None at one place."""
        return self.sparse / self.dense if self.dense > 0.0 else None


def spacing_quantiles(parts: Parts, distinct: Distinct) -> SpacingQuantiles:
    """Sample the local spacing of a cloud at its start: see `local_spacings`.

    Parameters
    ----------
    parts : Parts
        The cloud.
    distinct : Distinct
        Its points that are the first at their position.

    Returns
    -------
    SpacingQuantiles
        0 if there are fewer than two distinct points.

    Notes
    -----
    Each of up to 500 samples has the median of what is measured at it and at the 60 nearest
    points, with nothing but the 256 nearest: these are found part by part.
    """
    n = distinct.count
    if n < 2:
        return SpacingQuantiles(0.0, 0.0, 0.0)
    samples = parts.start.take(marked_rows(distinct.marks, scattered_ranks(n, _SAMPLES)))
    count = min(_AROUND, n)
    squares = np.full((len(samples), count), np.inf)
    nearest = np.zeros((len(samples), count, parts.dimension))
    step = _NearestOwn(distinct.marks, samples, count)
    for more_squares, more in parts.map("local spacing", step, parts.start):
        squares = np.concatenate([squares, more_squares], axis=1)
        kept = np.argsort(squares, axis=1, kind="stable")[:, :count]  # rows increase over parts
        squares = np.take_along_axis(squares, kept, axis=1)
        nearest = np.concatenate([nearest, more], axis=1)
        nearest = np.take_along_axis(nearest, kept[:, :, np.newaxis], axis=1)
    spacings = [_spacing_at_first(points) for points in nearest]
    dense, median, sparse = np.quantile(spacings, (0.05, 0.5, 0.95)).tolist()
    return SpacingQuantiles(dense, median, sparse)


@dataclass(frozen=True, eq=False)
class _NearestOwn:
    """Find the nearest of a part's own points to some positions.

    Gives the squares of their distances, increasing, and where they are; where there are fewer,
    infinities.
    """

    marks: Column
    positions: npt.NDArray[np.float64]
    count: int

    reach = 0.0

    def __call__(self, part: Part) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        points = part.points[part.read(self.marks)]
        found = np.empty((len(self.positions), self.count), np.int64)
        squares = np.empty(found.shape)
        if len(points) == 0:
            return np.full(found.shape, np.inf), np.zeros((*found.shape, points.shape[1]))
        coordinates = _rows(points)
        boxes = build_box_tree(coordinates)
        find_nearest_of_each(coordinates, boxes, _rows(self.positions), found, squares)
        return squares, points[np.minimum(found, len(points) - 1)]


def _spacing_at_first(points: npt.NDArray[np.float64]) -> float:
    """Find the spacing at the first of some distinct points (m, d), the others by distance."""
    n, dimension = points.shape
    coordinates = _rows(points)
    spacings = np.empty(min(_SMOOTHED + 1, n))
    none = np.empty((len(spacings), 0), np.int32)
    least = min(LEAST[dimension], n - 1)
    measure_spacings(coordinates, build_box_tree(coordinates), dimension, least, spacings, none)
    return float(np.median(spacings))


def _rows(points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Lay out points (n, d) as the kernels take them, (3, n)."""
    coordinates = np.zeros((3, len(points)))
    coordinates[: points.shape[1]] = points.T
    return coordinates
