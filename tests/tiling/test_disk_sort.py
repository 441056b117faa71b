from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pcsmooth.errors import InvalidInputError
from pcsmooth.tiling.column_store import FileColumn
from pcsmooth.tiling.disk_sort import sort_on_disk


def sort(
    folder: Path, keys: npt.NDArray[np.int64], rows: npt.NDArray[Any], cuts: list[int]
) -> FileColumn:
    sorted_keys, counts = np.unique(keys, return_counts=True)
    starts = np.concatenate([[0], np.cumsum(counts)])
    column = FileColumn.create(
        str(folder / "sorted"), np.dtype((rows.dtype, rows.shape[1:])), len(rows)
    )

    def chunks() -> Iterator[tuple[npt.NDArray[np.int64], npt.NDArray[Any]]]:
        yield from zip(np.split(keys, cuts), np.split(rows, cuts), strict=True)

    sort_on_disk(chunks, sorted_keys, starts, column)
    return column


@given(
    st.lists(st.sampled_from([-7, 0, 1, 2, 2**62]), max_size=40),
    st.lists(st.integers(0, 40), max_size=5),
)
@settings(deadline=None, max_examples=60)
def test_order_is_that_of_a_stable_sort_in_memory(
    tmp_path_factory: pytest.TempPathFactory, values: list[int], cuts: list[int]
) -> None:
    keys = np.array(values, np.int64)
    rows = np.stack([np.arange(len(keys)), keys], axis=1)
    column = sort(tmp_path_factory.mktemp("sort"), keys, rows, sorted(cuts))
    np.testing.assert_array_equal(column.read(0, len(keys)), rows[np.argsort(keys, kind="stable")])


def test_structures_in_chunks_of_any_size(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    keys = rng.integers(0, 300, 5000)
    rows = np.zeros(5000, [("number", "u4"), ("place", "f8", (3,))])
    rows["number"], rows["place"] = np.arange(5000), rng.random((5000, 3))
    column = sort(tmp_path, keys, rows, sorted(rng.integers(0, 5000, 9).tolist()))
    np.testing.assert_array_equal(column.read(0, 5000), rows[np.argsort(keys, kind="stable")])


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ([1, 1, 3, 3, 3], "more rows of a key"),
        ([1, 1, 3], "fewer rows of a key"),
        ([1, 2, 3, 3], "not counted"),
        ([1, 3, 3, 4], "not counted"),
        ([1, 1, 3, 3, None], "4 rows have 5 keys|5 rows have 4 keys"),
    ],
)
def test_counts_that_do_not_fit(tmp_path: Path, keys: list[int | None], message: str) -> None:
    column = FileColumn.create(str(tmp_path / "sorted"), "i8", 4)
    known = np.array([key for key in keys if key is not None], np.int64)
    with pytest.raises(InvalidInputError, match=message):
        sort_on_disk(
            lambda: [(known, np.arange(len(keys)))], np.array([1, 3]), np.array([0, 2, 4]), column
        )


def test_no_keys_were_counted(tmp_path: Path) -> None:
    column = FileColumn.create(str(tmp_path / "sorted"), "i8", 0)
    none = np.zeros(0, np.int64)
    sort_on_disk(lambda: [], none, np.array([0]), column)
    with pytest.raises(InvalidInputError, match="not counted"):
        sort_on_disk(lambda: [(np.ones(1, np.int64), np.ones(1))], none, np.array([0]), column)


def test_column_of_another_length(tmp_path: Path) -> None:
    column = FileColumn.create(str(tmp_path / "sorted"), "i8", 5)
    with pytest.raises(InvalidInputError, match="4 sorted rows are no column of 5"):
        sort_on_disk(lambda: [], np.array([1, 3]), np.array([0, 2, 4]), column)
