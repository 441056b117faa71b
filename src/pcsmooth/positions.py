"""Positions as callers give them, made ready to compute with."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.real_numbers import real_array

#: Coordinates beyond this are taken for "no data", like NaN: their squares overflow.
LARGEST = 1e150


def as_positions(points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Copy points into a new array of shape (n, 2) or (n, 3); masked coordinates are NaN.

    Raises
    ------
    InvalidInputError
        If they are not real numbers or have another shape.
    """
    positions = real_array(points, "points")
    if positions.ndim != 2 or positions.shape[1] not in (2, 3):
        raise InvalidInputError(
            f"points have shape {positions.shape}; they must be (n, 2) or (n, 3)"
        )
    return positions


def usable_rows(points: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    """Rows whose coordinates are all finite and at most `LARGEST`, shape (n,)."""
    if points.size and np.abs(points).max() <= LARGEST:  # false if it is NaN
        return np.ones(len(points), np.bool_)
    return np.asarray((np.abs(points) <= LARGEST).all(axis=1))


def local_origin(points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Origin near the points from which their coordinates can be taken without rounding.

    Where an axis lies farther from 0 than twice its extent, every coordinate is within a factor
    of two of the centre, so that subtracting the centre is exact (Sterbenz); elsewhere 0 serves.
    Finite points (n, d), n >= 1 -> (d,).
    """
    low = np.array([column.min() for column in points.T])  # faster than along an axis
    high = np.array([column.max() for column in points.T])
    center = 0.5 * low + 0.5 * high
    return np.where(np.abs(center) > 2.0 * (high - low), center, 0.0)
