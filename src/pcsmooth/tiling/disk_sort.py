"""Sorting rows that do not fit in memory, when it is known how many there are of each key."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.tiling.column_store import FileColumn
from pcsmooth.tiling.runs import equal_starts

#: Keys (m,) of some rows, and the rows (m,) or (m, ...) themselves.
KeyedRows = tuple[npt.NDArray[np.int64], npt.NDArray[Any]]


def sort_on_disk(
    chunks: Callable[[], Iterable[KeyedRows]],
    sorted_keys: npt.NDArray[np.int64],
    starts: npt.NDArray[np.int64],
    column: FileColumn,
) -> None:
    """Write rows into a column by increasing key, those of one key in the order they come in.

    A counting sort: each chunk is sorted in memory, and the rows of each key go to where those of
    the chunks before it ended. To start again after an interruption does no harm.

    Parameters
    ----------
    chunks : callable
        Gives the chunks of rows with their keys, in the original order; called once.
    sorted_keys : ndarray of int, shape (u,)
        All keys, increasing.
    starts : ndarray of int, shape (u + 1,)
        Row at which each key's rows begin, and the number of all rows.
    column : FileColumn
        Takes the rows.

    Raises
    ------
    InvalidInputError
        The rows are not as many of each key as `starts` says, or do not fit the column.
    CloudFileError
        The column cannot be written.
    """
    if starts[-1] != column.rows:
        raise InvalidInputError(f"{starts[-1]} sorted rows are no column of {column.rows}")
    places = starts[:-1].copy()
    for keys, rows in chunks():
        if len(keys) != len(rows):
            raise InvalidInputError(f"{len(rows)} rows have {len(keys)} keys")
        order = np.argsort(keys, kind="stable")
        ordered = keys[order]
        begins = equal_starts(ordered)
        present = ordered[begins]
        ranks = np.searchsorted(sorted_keys, present)
        if np.any(ranks == len(sorted_keys)) or np.any(sorted_keys[ranks] != present):
            raise InvalidInputError("rows have a key that was not counted")
        ends = places[ranks] + np.diff(begins, append=len(ordered))
        if np.any(ends > starts[ranks + 1]):
            raise InvalidInputError("there are more rows of a key than were counted")
        # `take` moves structures much faster than an index does.
        column.write_runs(np.stack([places[ranks], ends], axis=1), np.take(rows, order, axis=0))
        places[ranks] = ends
    if np.any(places != starts[1:]):
        raise InvalidInputError("there are fewer rows of a key than were counted")
