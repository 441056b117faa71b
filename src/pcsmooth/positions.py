"""Positions as callers give them, made ready to compute with."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError

#: Coordinates beyond this are taken for "no data", like NaN: their squares overflow.
LARGEST = 1e150


def as_positions(points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Copy points into a new array of shape (n, 2) or (n, 3).

    Raises
    ------
    InvalidInputError
        If they are not numbers or have another shape.
    """
    try:
        positions = np.array(points, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise InvalidInputError(f"points are not an array of numbers ({error})") from error
    if positions.ndim != 2 or positions.shape[1] not in (2, 3):
        raise InvalidInputError(
            f"points have shape {positions.shape}; they must be (n, 2) or (n, 3)"
        )
    return positions


def usable_rows(points: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    """Rows whose coordinates are all finite and at most `LARGEST`, shape (n,)."""
    return np.asarray((np.abs(points) <= LARGEST).all(axis=1))
