"""Rows that can be drawn."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.positions import usable_rows


def finite_rows(*clouds: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    """List the rows that have finite coordinates in each cloud.

    Parameters
    ----------
    *clouds : ndarray, shape (n, d)
        Positions, L, of as many points.

    Returns
    -------
    ndarray of int, shape (m,)
        Increasing, m >= 1.

    Raises
    ------
    InvalidInputError
        If there is none.

    Examples
    --------
    >>> finite_rows(np.array([[0.0, 1.0], [np.nan, 0.0], [2.0, 3.0]])).tolist()
    [0, 2]
    """
    usable = np.logical_and.reduce([usable_rows(cloud) for cloud in clouds])
    if not usable.any():
        raise InvalidInputError("no point with finite coordinates is left; check the file")
    return np.flatnonzero(usable)
