"""What is around some points of a cloud: all that a filter is planned from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.neighbors import nearest_points
from pcsmooth.point_order import scattered_ranks

#: Points at which a cloud is looked at, and the nearest points there.
_SAMPLES = 800
NEAREST = 1000


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


def sample_ranks(n: int) -> npt.NDArray[np.int64]:
    """Ranks of the points, of n distinct ones, at which a cloud is looked at, increasing."""
    return scattered_ranks(n, _SAMPLES)


def look_around(points: npt.NDArray[np.float64], most: int, threads: int = 1) -> Surroundings:
    """Find the nearest points of up to 800 points of a cloud.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite, distinct positions, L, n >= 2.
    most : int
        Nearest points, up to `NEAREST`, whose positions are wanted.
    threads : int
        Threads of the search.

    Returns
    -------
    Surroundings
        Points at equal distances are in the order of their numbers. Which of them are among the
        positions is undefined only where all the nearest points beyond the last position are
        exactly as far away as that.
    """
    queries = points[sample_ranks(len(points))]
    distances, nearest = nearest_points(points, queries, min(len(points), NEAREST), threads)
    return Surroundings(len(points), distances, points[nearest[:, :most]])
