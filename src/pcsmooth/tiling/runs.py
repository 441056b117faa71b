"""Runs of rows: pairs of a first row and the row after the last."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt


def join_runs(runs: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Join each run with the next where that goes on from it, and leave out empty runs.

    Parameters
    ----------
    runs : ndarray of int, shape (k, 2)
        First row of each run and the row after its last.

    Returns
    -------
    ndarray of int, shape (j, 2)
        The same rows in the same order, j <= k.

    Examples
    --------
    >>> join_runs(np.array([[4, 6], [6, 9], [9, 9], [0, 2]])).tolist()
    [[4, 9], [0, 2]]
    """
    runs = runs[runs[:, 0] != runs[:, 1]]
    begins = np.ones(len(runs), np.bool_)
    begins[1:] = runs[1:, 0] != runs[:-1, 1]
    firsts = np.flatnonzero(begins)
    lasts = np.append(firsts[1:], len(runs))[: len(firsts)] - 1
    return np.stack([runs[firsts, 0], runs[lasts, 1]], axis=1)


def equal_starts(ordered: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Find where each value of an ordered array begins.

    Parameters
    ----------
    ordered : ndarray of int, shape (n,)
        Equal values stand together.

    Returns
    -------
    ndarray of int, shape (u,)
        Increasing; the first is 0, unless there are no values.

    Examples
    --------
    >>> equal_starts(np.array([3, 3, 5, 8, 8])).tolist()
    [0, 2, 3]
    """
    begins = np.ones(len(ordered), np.bool_)
    np.not_equal(ordered[1:], ordered[:-1], out=begins[1:])
    return np.flatnonzero(begins)
