"""Points of a cloud in parts that are marked, by their ranks."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.parts.column import CHUNK, Column


def count_marked(column: Column) -> int:
    """Count the marks that are set."""
    return sum(int(np.count_nonzero(chunk)) for chunk in column.chunks())


def marked_rows(
    column: Column, ranks: npt.NDArray[np.int64], rows: int = CHUNK
) -> npt.NDArray[np.int64]:
    """Find the points of some ranks among those that are marked.

    Parameters
    ----------
    column : Column
        Marks of points.
    ranks : ndarray of int, shape (s,)
        Ranks, increasing, below the number of marked points.
    rows : int
        Rows that are looked through at a time.

    Returns
    -------
    ndarray of int, shape (s,)
        Their rows.
    """
    found = []
    begin, before = 0, 0
    for marks in column.chunks(rows):
        places = np.flatnonzero(marks)
        wanted = ranks[np.searchsorted(ranks, before) :] - before
        found.append(begin + places[wanted[wanted < len(places)]])
        begin += len(marks)
        before += len(places)
    return np.concatenate(found)
