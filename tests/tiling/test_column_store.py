from __future__ import annotations

import errno
import multiprocessing
import os
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.tiling.column_store import FileColumn

TYPES: list[Any] = [
    "f4",
    ">i2",
    "?",
    ("f8", (3,)),
    ("u1", (2, 2)),
    [("place", "f8", (3,)), ("number", "u4"), ("flag", "u1")],
]


def filled(dtype: npt.DTypeLike, rows: int) -> npt.NDArray[Any]:
    """Rows of any type, of small numbers."""
    row_type = np.dtype(dtype)
    values = np.zeros(rows, row_type)
    parts = [values[name] for name in row_type.names] if row_type.names else [values]
    for part in parts:
        part[...] = np.random.default_rng(rows).integers(0, 2, part.shape)
    return values


@pytest.mark.parametrize("dtype", TYPES)
def test_rows_come_back_as_written(tmp_path: Path, dtype: npt.DTypeLike) -> None:
    values = filled(dtype, 20)
    column = FileColumn.create(str(tmp_path / "column"), dtype, 20)
    column.write(11, values[11:])
    column.write(0, values[:11])
    read = column.read(0, 20)
    assert read.dtype == values.dtype
    np.testing.assert_array_equal(read, values)
    np.testing.assert_array_equal(column.read(3, 7), values[3:7])
    assert column.read(20, 20).shape == values[:0].shape
    assert (tmp_path / "column").stat().st_size == 20 * np.dtype(dtype).itemsize


@given(st.data())
@settings(deadline=None, max_examples=50)
def test_runs_are_rows_in_the_order_of_the_runs(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    rows = data.draw(st.integers(0, 12))
    run = st.tuples(st.integers(0, rows), st.integers(0, rows)).map(sorted)
    runs = np.array(data.draw(st.lists(run, max_size=6)), np.int64).reshape(-1, 2)
    values = filled(("f8", (3,)), rows)
    column = FileColumn.create(str(tmp_path_factory.mktemp("runs") / "column"), values.dtype, rows)
    column = FileColumn(column.path, np.dtype(("f8", (3,))), rows)
    column.write(0, values)
    order = np.concatenate([np.arange(0), *(np.arange(*bounds) for bounds in runs)])
    np.testing.assert_array_equal(column.read_runs(runs), values[order])
    again = np.random.default_rng(0).random((len(order), 3))
    column.write_runs(runs, again)
    expected = values.copy()
    for row, value in zip(order, again, strict=True):
        expected[row] = value
    np.testing.assert_array_equal(column.read(0, rows), expected)


def test_adjoining_runs_cost_one_access(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    column = FileColumn.create(str(tmp_path / "column"), "i8", 10)
    written: list[tuple[int, int]] = []
    pwrite = os.pwrite

    def noted(file: int, room: memoryview, start: int) -> int:
        written.append((start, len(room)))
        return pwrite(file, room, start)

    monkeypatch.setattr(os, "pwrite", noted)
    column.write_runs(np.array([[2, 4], [4, 4], [4, 5], [8, 9]]), np.arange(4))
    assert written == [(16, 24), (64, 8)]


def test_rows_never_written_are_zero_and_take_no_room(tmp_path: Path) -> None:
    column = FileColumn.create(str(tmp_path / "column"), "f8", 10_000_000)
    assert not column.read(9_999_990, 10_000_000).any()
    assert (tmp_path / "column").stat().st_blocks * 512 < 1_000_000


def test_an_old_file_is_emptied(tmp_path: Path) -> None:
    (tmp_path / "column").write_bytes(b"something old, and longer")
    column = FileColumn.create(str(tmp_path / "column"), "u1", 4)
    assert column.read(0, 4).tolist() == [0, 0, 0, 0]


@pytest.mark.parametrize("rows", [0, 1, 6, 7])
def test_chunks_are_the_column_in_pieces(tmp_path: Path, rows: int) -> None:
    column = FileColumn.create(str(tmp_path / "column"), "i8", rows)
    column.write(0, np.arange(rows))
    chunks = list(column.chunks(3))
    assert [len(chunk) for chunk in chunks] == [3] * (rows // 3) + [rows % 3] * (rows % 3 > 0)
    assert [value for chunk in chunks for value in chunk] == list(range(rows))


@pytest.mark.parametrize("dtype", TYPES)
def test_a_pickled_column_is_the_same(tmp_path: Path, dtype: npt.DTypeLike) -> None:
    column = FileColumn.create(str(tmp_path / "column"), dtype, 3)
    column.write(0, filled(dtype, 3))
    copy = pickle.loads(pickle.dumps(column))
    assert copy == column
    np.testing.assert_array_equal(copy.read(0, 3), column.read(0, 3))


def _write_part(column: FileColumn, start: int, stop: int) -> None:
    for row in range(start, stop, 10):
        column.write(row, np.arange(row, min(row + 10, stop)))


@pytest.mark.slow
def test_several_processes_write_disjoint_rows(tmp_path: Path) -> None:
    column = FileColumn.create(str(tmp_path / "column"), "i8", 2000)
    context = multiprocessing.get_context("spawn")
    workers = [
        context.Process(target=_write_part, args=(column, start, start + 1000))
        for start in (0, 1000)
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    np.testing.assert_array_equal(column.read(0, 2000), np.arange(2000))


def test_a_write_that_the_system_cuts_short_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    column = FileColumn.create(str(tmp_path / "column"), "i8", 10)
    pwrite = os.pwrite
    monkeypatch.setattr(os, "pwrite", lambda file, room, start: pwrite(file, room[:7], start))
    column.write(0, np.arange(10))
    np.testing.assert_array_equal(column.read(0, 10), np.arange(10))


@pytest.mark.parametrize(
    ("number", "cause"),
    [(errno.ENOSPC, "No space left"), (errno.EDQUOT, "quota"), (errno.EIO, "Input/output")],
)
def test_a_full_disk_is_named_with_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, cause: str
) -> None:
    column = FileColumn.create(str(tmp_path / "column"), "i8", 10)
    pwrite, calls = os.pwrite, [0]

    def full(file: int, room: memoryview, start: int) -> int:
        calls[0] += 1
        if calls[0] > 1:
            raise OSError(number, os.strerror(number))
        return pwrite(file, room[:24], start)

    open_files = len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else 0
    monkeypatch.setattr(os, "pwrite", full)
    with pytest.raises(CloudFileError, match=cause) as caught:
        column.write(0, np.arange(10))
    assert caught.value.path == column.path
    assert caught.value.remedy == "check the disk and try again"
    if open_files:
        assert len(os.listdir("/proc/self/fd")) == open_files
    monkeypatch.undo()
    column.write(0, np.arange(10))  # to write again mends it
    np.testing.assert_array_equal(column.read(0, 10), np.arange(10))


def test_a_missing_folder_or_file_is_named(tmp_path: Path) -> None:
    path = str(tmp_path / "none" / "column")
    actions: list[Callable[[], object]] = [
        lambda: FileColumn.create(path, "i8", 1),
        lambda: FileColumn(path, np.dtype("i8"), 1).read(0, 1),
        lambda: FileColumn(path, np.dtype("i8"), 1).write(0, np.zeros(1, np.int64)),
    ]
    for action in actions:
        with pytest.raises(CloudFileError, match="no such file or folder"):
            action()


def test_a_file_cut_short_is_named(tmp_path: Path) -> None:
    column = FileColumn.create(str(tmp_path / "column"), "i8", 10)
    os.truncate(column.path, 75)
    column.read(0, 9)
    with pytest.raises(CloudFileError, match="ends before row 10, 5 bytes short"):
        column.read(8, 10)


@pytest.mark.parametrize(("start", "stop"), [(-1, 2), (3, 2), (2, 6), (7, 9)])
def test_rows_that_are_not_there(tmp_path: Path, start: int, stop: int) -> None:
    column = FileColumn.create(str(tmp_path / "column"), "i8", 5)
    with pytest.raises(InvalidInputError, match="column of 5 rows has no rows"):
        column.read(start, stop)
    with pytest.raises(InvalidInputError, match="column of 5 rows has no rows"):
        column.write_runs(np.array([[start, stop]]), np.zeros(stop - start + 9, np.int64))


def test_values_that_are_no_rows(tmp_path: Path) -> None:
    column = FileColumn.create(str(tmp_path / "column"), ("i4", (3,)), 5)
    with pytest.raises(InvalidInputError, match="shape"):
        column.write(0, np.zeros((2, 2), np.int32))
    with pytest.raises(InvalidInputError, match="float64 are no rows of type"):
        column.write(0, np.zeros((2, 3)))
    with pytest.raises(InvalidInputError, match="2 values are no 3 rows"):
        column.write_runs(np.array([[0, 3]]), np.zeros((2, 3), np.int32))
    column.write(0, np.ones((2, 3), np.int64))  # of the same kind
    assert column.read(1, 2).tolist() == [[1, 1, 1]]


def test_columns_that_cannot_be(tmp_path: Path) -> None:
    for dtype in ("O", "V0", [("name", "O")]):
        with pytest.raises(InvalidInputError, match="cannot stand in a file"):
            FileColumn.create(str(tmp_path / "column"), dtype, 5)
    with pytest.raises(InvalidInputError, match="cannot have -1 rows"):
        FileColumn.create(str(tmp_path / "column"), "f8", -1)
