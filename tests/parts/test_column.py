"""What every column must do; a further kind needs one more entry in `KINDS`."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.parts.column import CHUNK, ArrayColumn, Column
from pcsmooth.tiling.column_store import FileColumn

Create = Callable[[npt.DTypeLike, int], Column]

KINDS: dict[str, Callable[[Path], Create]] = {
    "array": lambda _folder: ArrayColumn.zeros,
    "file": lambda folder: (
        lambda dtype, rows: FileColumn.create(str(folder / "column"), dtype, rows)
    ),
}

#: Rows as clouds have them.
TYPES = {
    "marks": np.dtype(np.bool_),
    "bytes": np.dtype(np.uint8),
    "numbers": np.dtype(np.float64),
    "rows": np.dtype(np.int64),
    "vectors": np.dtype((np.float64, (3,))),
    "tensors": np.dtype((np.float64, (2, 2))),
    "structures": np.dtype([("place", np.float64, (3,)), ("mark", np.bool_)]),
}

every_type = pytest.mark.parametrize("dtype", TYPES.values(), ids=TYPES)


@pytest.fixture(params=KINDS)
def create(request: pytest.FixtureRequest, tmp_path: Path) -> Create:
    return KINDS[request.param](tmp_path)


def some_rows(dtype: npt.DTypeLike, count: int, seed: int = 0) -> npt.NDArray[np.generic]:
    """Rows in which every byte may be set."""
    rng = np.random.default_rng(seed)
    rows = np.zeros(count, dtype)
    if rows.dtype.names:
        for name in rows.dtype.names:
            rows[name] = rng.integers(0, 100, rows[name].shape)
    else:
        rows[...] = rng.integers(0, 100, rows.shape)
    return rows


@every_type
def test_columns_begin_with_zeros(create: Create, dtype: np.dtype[np.generic]) -> None:
    column = create(dtype, 7)
    assert column.rows == 7
    assert column.dtype == dtype
    rows = column.read(0, 7)
    assert rows.tobytes() == bytes(7 * dtype.itemsize)
    assert rows.shape == (7, *dtype.shape)
    assert rows.dtype == dtype.base


@every_type
def test_what_is_written_is_read(create: Create, dtype: np.dtype[np.generic]) -> None:
    column = create(dtype, 50)
    rows = some_rows(dtype, 50)
    column.write(0, rows.copy())
    np.testing.assert_array_equal(column.read(0, 50), rows)
    np.testing.assert_array_equal(column.read(10, 23), rows[10:23])
    np.testing.assert_array_equal(column.read(50, 50), rows[:0])
    chosen = np.array([0, 3, 4, 5, 31, 49])
    np.testing.assert_array_equal(column.take(chosen), rows[chosen])
    np.testing.assert_array_equal(column.take(np.empty(0, np.int64)), rows[:0])


@every_type
def test_rows_are_written_in_any_order_and_again(
    create: Create, dtype: np.dtype[np.generic]
) -> None:
    column = create(dtype, 30)
    rows = some_rows(dtype, 30)
    for start, stop in ((20, 30), (0, 7), (7, 20), (20, 30), (12, 13), (4, 4)):
        column.write(start, rows[start:stop].copy())
    np.testing.assert_array_equal(column.read(0, 30), rows)


@every_type
@pytest.mark.parametrize("at_a_time", [1, 7, 20, 21, CHUNK])
def test_chunks_are_all_rows_in_order(
    create: Create, dtype: np.dtype[np.generic], at_a_time: int
) -> None:
    column = create(dtype, 20)
    rows = some_rows(dtype, 20)
    column.write(0, rows.copy())
    chunks = list(column.chunks(at_a_time))
    assert [len(chunk) for chunk in chunks[:-1]] == [at_a_time] * (len(chunks) - 1)
    assert 0 < len(chunks[-1]) <= at_a_time
    np.testing.assert_array_equal(np.concatenate(chunks), rows)


def test_columns_without_rows_have_no_chunks(create: Create) -> None:
    column = create(np.float64, 0)
    assert list(column.chunks()) == []
    assert column.read(0, 0).shape == (0,)


def test_chunks_may_be_written_as_they_are_read(create: Create) -> None:
    """Each chunk is read when it is asked for, and stays as it was where others are written."""
    column = create(np.int64, 20)
    column.write(0, np.arange(20))
    start = 0
    for chunk in column.chunks(6):
        before = chunk.copy()
        column.write(start, chunk + 100)
        start += len(before)
    np.testing.assert_array_equal(column.read(0, 20), np.arange(20) + 100)


def test_numbers_of_the_same_kind_become_those_of_the_column(create: Create) -> None:
    column = create(np.float64, 4)
    column.write(1, np.array([1.5, 2.5], np.float32))
    column.write(0, np.array([3.0]))
    assert column.read(0, 4).tolist() == [3.0, 1.5, 2.5, 0.0]
    assert column.dtype == np.float64


@every_type
def test_a_structure_takes_up_the_rows_of_columns(
    create: Create, dtype: np.dtype[np.generic]
) -> None:
    """As rows are put in the order of the input."""
    column = create(dtype, 5)
    column.write(0, some_rows(dtype, 5))
    wide = np.zeros(5, np.dtype([("number", np.int64), ("value", dtype.base, dtype.shape)]))
    wide["value"] = column.read(0, 5)
    np.testing.assert_array_equal(wide["value"], some_rows(dtype, 5))


def test_columns_can_be_sent_to_others(create: Create) -> None:
    """Steps hold them, and steps can be pickled."""
    column = create((np.float64, (2,)), 3)
    column.write(0, np.arange(6.0).reshape(3, 2))
    same = pickle.loads(pickle.dumps(column))
    np.testing.assert_array_equal(same.read(0, 3), column.read(0, 3))


def test_a_column_in_memory_takes_over_what_is_written_as_a_whole() -> None:
    column = ArrayColumn.zeros(np.float64, 4)
    values = np.arange(4.0)
    column.write(0, values)
    assert column.values is values
    other = np.arange(2.0)
    column.write(1, other)
    assert column.values is values
    assert values.tolist() == [0.0, 0.0, 1.0, 3.0]
