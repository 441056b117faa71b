"""The local spacing of a cloud: how far its points are apart along the surface, place by place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid.box_tree import build_box_tree, least_in_boxes
from pcsmooth.kernels.grid.lower_envelope import lower_to_envelope
from pcsmooth.kernels.surface.covering_neighborhoods import SEEN_FIRST, measure_spacings
from pcsmooth.kernels.surface.neighbor_averages import take_means, take_medians
from pcsmooth.neighbors.coincident import first_coincident
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.positions import as_positions, usable_rows

#: Points of the least neighbourhood, by dimension: those around one on a curve and on a surface.
LEAST = {2: 2, 3: 6}

#: Most that the spacing changes per length: balls of two spacings then differ less than they are
#: apart.
SLOPE = 0.25

#: How often spacings are averaged over neighbours after their median has been taken.
_AVERAGINGS = 2

#: How often neighbours are looked at in all.
SMOOTHINGS = 1 + _AVERAGINGS


def local_spacings(points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Find how far points are apart along the surface around each of them, L.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3)
        Positions, L. Rows with a NaN, an infinity or a masked coordinate take no part.

    Returns
    -------
    ndarray, shape (n,)
        L, > 0; coincident points have the same. 0 for rows that take no part, and if there are
        fewer than two distinct points.

    Raises
    ------
    InvalidInputError
        Wrong shape, no finite point, or points that are too near or too far to be measured.

    Notes
    -----
    Where points are even it is the mean distance to the 6 nearest (2 in the plane), as in
    `measure_spacing`. Where lines of a scan are far apart it is about the distance of the lines:
    the neighbourhood, of up to 128 points, is the least with some on all sides along the surface
    (second eigenvalue of the moments of their offsets at least 0.22 times the first; in the plane,
    some on both sides). Where there never are, as on cables, it is that of the 6 nearest.

    The median over 25 points, and twice the mean over as many, take out what is chance, and from
    any point to another it rises by no more than a quarter of their distance, so that points far
    from a surface have no more than that asks for.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(60.0), 10 * np.arange(6.0))  # lines, ten times denser along
    >>> spacings = local_spacings(np.c_[x.ravel(), y.ravel(), np.zeros(360)])
    >>> bool(np.all((spacings > 8) & (spacings < 11)))
    True
    """
    positions = as_positions(points)
    cloud = WholeCloud.of(positions, usable_rows(positions))
    spacings = np.zeros(len(positions))
    spacings[cloud.input_rows] = spacings_in_order(cloud.start.values) * cloud.unit
    return spacings


def spacings_in_order(points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Find the local spacing of finite points (n, d) in the order of `order_by_position`, (n,)."""
    first = first_coincident(points)
    distinct = np.flatnonzero(first == np.arange(len(points)))
    spacings = np.zeros(len(points))
    if len(distinct) > 1:
        spacings[distinct] = _spacings_of_distinct(points[distinct])
    return spacings[first]


def _spacings_of_distinct(points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Find it for two or more points."""
    n = len(points)
    tree = BoxedPoints.of(points)
    found = tree.spacings_at(np.arange(n), min(SEEN_FIRST, n - 1))
    return tree.lowered(smoothed(positive(found.spacings), found.neighbors))


@dataclass(frozen=True, eq=False)
class FoundSpacings:
    """Spacings of some points by themselves.

    Attributes
    ----------
    spacings : ndarray, shape (s,)
        L.
    neighbors : ndarray of int32, shape (s, k)
        Numbers of their nearest points.
    reaches : ndarray, shape (s,)
        How far the points are that this depends on, L.
    """

    spacings: npt.NDArray[np.float64]
    neighbors: npt.NDArray[np.int32]
    reaches: npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BoxedPoints:
    """Two or more distinct points in a tree of boxes.

    Attributes
    ----------
    coordinates : ndarray, shape (3, n)
        Where they are, L (z = 0 in 2D).
    boxes : ndarray, shape (2 m, 6)
        Their tree.
    dimension : int
        d.
    """

    coordinates: npt.NDArray[np.float64]
    boxes: npt.NDArray[np.float64]
    dimension: int

    @classmethod
    def of(cls, points: npt.NDArray[np.float64]) -> BoxedPoints:
        """Put points (n, d), of which those that follow each other are near, into a tree."""
        coordinates = np.zeros((3, len(points)))
        coordinates[: points.shape[1]] = points.T
        return cls(coordinates, build_box_tree(coordinates), points.shape[1])

    def spacings_at(self, numbers: npt.NDArray[np.int64], neighbors: int) -> FoundSpacings:
        """Measure the spacing at some of the points, and find so many nearest ones of each."""
        least = min(LEAST[self.dimension], self.coordinates.shape[1] - 1)
        count = len(numbers)
        found = FoundSpacings(
            np.empty(count), np.empty((count, neighbors), np.int32), np.empty(count)
        )
        measure_spacings(
            self.coordinates, self.boxes, self.dimension, least, numbers, found.spacings,
            found.neighbors, found.reaches,
        )  # fmt: skip
        return found

    def lowered(self, values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Lower values (n,) of the points until they rise slowly enough."""
        lowered = np.empty(len(values))
        least = least_in_boxes(values)
        lower_to_envelope(self.coordinates, self.boxes, values, least, SLOPE, lowered)
        return lowered


def positive(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Make spacings positive where squares of distances are 0, (n,), L."""
    return np.maximum(values, np.finfo(np.float64).tiny)


def smoothed(
    values: npt.NDArray[np.float64], neighbors: npt.NDArray[np.int32]
) -> npt.NDArray[np.float64]:
    """Take the median of the values (n,) of points and their neighbours (n, m), then means."""
    others = np.empty_like(values)
    take_medians(values, neighbors, others)
    values = values.copy()
    for _ in range(_AVERAGINGS):
        values, others = others, values
        take_means(values, neighbors, others)
    return others
