"""The order in which the points of a cloud are taken, whatever that of its rows.

Points are taken along a Morton curve. Sums, samples and ties between points then are the same
for every order of the rows, to the last bit; and points close in memory are close in space.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid.grid import bounding_box, code_points
from pcsmooth.kernels.grid.radix_sort import sort_pairs
from pcsmooth.positions import local_origin

#: The extent of a cloud is halved this often to get the cells that the curve goes through.
HALVINGS = 20

#: Factors of the hash of a number: splitmix64's (Steele, Lea and Flood 2014).
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX = (np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB))


@dataclass(frozen=True, eq=False)
class OrderedPoints:
    """The finite points of a cloud, in the order in which they are taken.

    Attributes
    ----------
    points : ndarray, shape (m, d)
        Positions, L, seen from the origin.
    origin : ndarray, shape (d,)
        What was subtracted, L.
    rows : ndarray of int, shape (m,)
        Row of each.
    """

    points: npt.NDArray[np.float64]
    origin: npt.NDArray[np.float64]
    rows: npt.NDArray[np.int64]


def take_in_order(
    positions: npt.NDArray[np.float64],
    usable: npt.NDArray[np.bool_],
    vectors: npt.NDArray[np.float64] | None = None,
) -> OrderedPoints:
    """Take some points of a cloud (n, d), marked in (n,), by their positions.

    Vectors (n, d) order those that coincide (see `order_by_position`). At least one is marked.
    """
    rows = np.flatnonzero(usable)
    points = positions[rows]
    origin = local_origin(points)
    points -= origin
    order = order_by_position(points, None if vectors is None else vectors[rows])
    return OrderedPoints(points[order], origin, rows[order])


def order_by_position(
    points: npt.NDArray[np.float64],
    vectors: npt.NDArray[np.float64] | None = None,
    box: npt.NDArray[np.float64] | None = None,
) -> npt.NDArray[np.int64]:
    """Order points along a Morton curve, those of a cell by their coordinates.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions, L, n >= 1.
    vectors : ndarray, shape (n, d), optional
        What orders coincident points; by default, and where that is equal too, they are left in
        order.
    box : ndarray, shape (2, d), optional
        Bounding box of the whole cloud, L, if the points are a part of one.

    Returns
    -------
    ndarray of int, shape (n,)
        Numbers of the points. Those of a part of a cloud are in the order they have in the whole.
    """
    dimension = points.shape[1]
    if box is None:
        box = np.array(bounding_box(points))[:, :dimension]
    pairs = np.empty((len(points), 2), np.int64)
    width = least_width(float(np.ptp(box, axis=0).max()))
    lowest, highest = code_points(points, box[0], width, np.zeros(dimension), pairs)
    pairs = sort_pairs(pairs, int(lowest ^ highest).bit_length())
    codes, order = pairs[:, 0], pairs[:, 1].copy()
    alike = codes[1:] == codes[:-1]
    places = np.flatnonzero(np.r_[False, alike] | np.r_[alike, False])
    if places.size:
        numbers = order[places]
        keys = [*points[numbers].T[::-1], codes[places]]
        if vectors is not None:
            keys = [*vectors[numbers].T[::-1], *keys]
        order[places] = numbers[np.lexsort(keys)]
    return order


def least_width(extent: float) -> float:
    """Side of the cells of a cloud's Morton curve, L; 1.0 if all points are at one place."""
    width = extent / 2**HALVINGS
    return width if width >= np.finfo(np.float64).tiny else 1.0


def scattered_ranks(n: int, samples: int) -> npt.NDArray[np.int64]:
    """Choose ranks of up to so many of n points, one anywhere in each of as many equal runs.

    Regular ranks would meet the same part of each row of a raster. Increasing; all if there are
    no more than samples.
    """
    width = -(-n // samples)
    starts = np.arange(0, n, width)
    mixed = (np.arange(len(starts), dtype=np.uint64) + np.uint64(1)) * _GOLDEN
    for factor, shift in zip(_MIX, (30, 27), strict=True):
        mixed = (mixed ^ (mixed >> np.uint64(shift))) * factor
    mixed ^= mixed >> np.uint64(31)
    sizes = np.minimum(width, n - starts).astype(np.uint64)
    return starts + (mixed % sizes).astype(np.int64)
