"""The k points that are nearest to some positions."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.threads import thread_count

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


def build_tree(points: npt.NDArray[np.float64]) -> cKDTree:
    """Build a tree of points (n, d), quickly."""
    from scipy.spatial import cKDTree

    return cKDTree(points, balanced_tree=False, compact_nodes=False)


def k_nearest(
    points: npt.NDArray[np.float64],
    queries: npt.NDArray[np.float64],
    count: int,
    farthest: float = math.inf,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Find the points that are nearest to some positions.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions, n >= 1.
    queries : ndarray, shape (m, d)
        Finite positions.
    count : int
        Nearest points of each, >= 2.
    farthest : float
        Points not nearer than this are left out, L.

    Returns
    -------
    distances : ndarray, shape (m, count)
        Increasing; infinite where there are fewer points.
    nearest : ndarray of int, shape (m, count)
        Their numbers, increasing among equal distances; n where there are fewer points. Which of
        several points at the distance of the last are left out is not defined.
    """
    tree = build_tree(points)
    found = tree.query(queries, count, distance_upper_bound=farthest, workers=thread_count())
    distances, nearest = in_order_of_distance(*found)
    return distances, nearest


def in_order_of_distance(
    distances: npt.NDArray[np.float64], numbers: npt.NDArray[np.int64], *others: npt.NDArray[Any]
) -> tuple[npt.NDArray[Any], ...]:
    """Sort the columns (m, k) of each row by distance, then by number, and others (m, k) along."""
    columns = (distances, numbers, *others)
    left = np.flatnonzero((distances[:, 1:] <= distances[:, :-1]).any(axis=1))
    if left.size == 0:
        return columns
    order = np.lexsort((numbers[left], distances[left]), axis=1)
    if left.size == len(distances):
        return tuple(np.take_along_axis(each, order, axis=1) for each in columns)
    columns = tuple(each.copy() for each in columns)
    for each in columns:
        each[left] = np.take_along_axis(each[left], order, axis=1)
    return columns
