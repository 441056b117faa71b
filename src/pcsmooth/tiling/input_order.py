"""Rows of a cloud in tiles, put back in the order of the input."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.parts.column import Column
from pcsmooth.progress import Callback, Progress, ignore
from pcsmooth.tiling.column_store import FileColumn
from pcsmooth.tiling.disk_sort import sort_on_disk
from pcsmooth.tiling.tile_store import TileStore

#: Points that are put in order at a time.
_SEGMENT = 1 << 20


def in_input_order(
    store: TileStore, columns: Mapping[str, Column], callback: Callback = ignore
) -> FileColumn:
    """Sort columns by the points' numbers.

    Parameters
    ----------
    store : TileStore
        The tiles.
    columns : mapping of str to Column
        What there is of each point.
    callback : callable
        Told how far it is.

    Returns
    -------
    FileColumn
        A structure for each finite point of the input, in its order, with a field for each column.
    """
    fields: dict[str, Column] = {"number": store.numbers, **columns}
    row_type = np.dtype(
        [(name, column.dtype.base, column.dtype.shape) for name, column in fields.items()]
    )
    starts = np.append(np.arange(0, store.count, _SEGMENT), store.count)
    total = 2 * (len(starts) - 1)
    done = 0
    callback(Progress("putting in order", done, total))

    def count() -> None:
        nonlocal done
        done += 1
        callback(Progress("putting in order", done, total))

    def chunks() -> Iterator[tuple[npt.NDArray[np.int64], npt.NDArray[np.void]]]:
        read = (column.chunks(_SEGMENT) for column in fields.values())
        for chunks_of_fields in zip(*read, strict=True):
            rows = np.empty(len(chunks_of_fields[0]), row_type)
            for name, values in zip(fields, chunks_of_fields, strict=True):
                rows[name] = values
            yield rows["number"] // _SEGMENT, rows
            count()

    ordered = store.create("ordered", row_type)
    sort_on_disk(chunks, np.arange(len(starts) - 1), starts, ordered)
    for start, stop in zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True):
        rows: npt.NDArray[Any] = ordered.read(start, stop)
        in_order = np.empty_like(rows)
        in_order[rows["number"] - start] = rows
        ordered.write(start, in_order)
        count()
    return ordered
