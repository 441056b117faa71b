from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pcsmooth.neighbors.marked import count_marked, marked_rows
from pcsmooth.parts.column import ArrayColumn, Column
from pcsmooth.tiling.column_store import FileColumn


@pytest.fixture(params=["memory", "file"])
def column(request: pytest.FixtureRequest, tmp_path: Path) -> Column:
    """Room for the marks of 1000 points."""
    if request.param == "memory":
        return ArrayColumn.zeros(np.bool_, 1000)
    return FileColumn.create(str(tmp_path / "marks"), np.bool_, 1000)


def test_rows_of_ranks_among_marked_points(column: Column) -> None:
    marked = np.random.default_rng(3).random(1000) < 0.3
    marked[100:300] = False  # chunks without any
    column.write(0, marked)
    rows = np.flatnonzero(marked)
    assert count_marked(column) == len(rows)
    for ranks in (np.arange(len(rows)), np.arange(3, len(rows), 17), np.empty(0, np.int64)):
        for at_a_time in (64, 1, 5000):
            np.testing.assert_array_equal(marked_rows(column, ranks, at_a_time), rows[ranks])


def test_without_marks(column: Column) -> None:
    assert count_marked(column) == 0
    assert len(marked_rows(column, np.empty(0, np.int64))) == 0
