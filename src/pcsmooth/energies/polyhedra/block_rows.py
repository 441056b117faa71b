"""Rows of all points, from blocks of points whose measures also belong to points of others."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.polyhedra.union_rows import N_COLUMNS, add_spilled

#: Rows of a block's points, and numbers and rows of points of other blocks.
Block = tuple[npt.NDArray[np.float64], npt.NDArray[np.int64], npt.NDArray[np.float64]]


def add_up(blocks: Iterable[Block], n: int) -> npt.NDArray[np.float64]:
    """Add the rows of n points up, block by block in their order, (n, N_COLUMNS)."""
    rows = np.zeros((n, N_COLUMNS))
    start = 0
    for own, spilled, spilled_rows in blocks:
        rows[start : start + len(own)] += own
        add_spilled(rows, spilled, spilled_rows)
        start += len(own)
    return rows
