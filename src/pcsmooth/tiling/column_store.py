"""Columns of per-point data: flat files of rows of one size."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats.system_errors import named_system_errors
from pcsmooth.tiling.runs import join_runs


@dataclass(frozen=True)
class FileColumn:
    """A flat file of rows of one size, the same row for the same point in every column.

    Nothing is mapped or kept open: a column takes no memory beside the rows that are read, can be
    pickled, and serves any process that sees the file. Several processes may write disjoint rows
    at the same time.

    Attributes
    ----------
    path : str
        The file.
    dtype : dtype
        Type of a row: a number, a structure, or a sub-array such as ``("f8", (3,))``.
    rows : int
        How many rows the file holds.
    """

    path: str
    dtype: np.dtype[Any]
    rows: int

    @classmethod
    def create(cls, path: str, dtype: npt.DTypeLike, rows: int) -> FileColumn:
        """Make a file of rows that are all zero bytes, which take no room on disk as yet.

        Parameters
        ----------
        path : str
            The file; one that exists is emptied first.
        dtype : dtype
            Type of a row, of at least one byte and without Python objects.
        rows : int
            Rows, >= 0.

        Returns
        -------
        FileColumn
            The column.

        Raises
        ------
        InvalidInputError
            Negative rows, or a type that cannot stand in a file.
        CloudFileError
            The file cannot be made.
        """
        row_type = np.dtype(dtype)
        if rows < 0:
            raise InvalidInputError(f"a column cannot have {rows} rows")
        if row_type.hasobject or row_type.itemsize == 0:
            raise InvalidInputError(f"rows of type {row_type} cannot stand in a file")
        with named_system_errors(path), open(path, "wb") as file:
            file.truncate(rows * row_type.itemsize)
        return cls(path, row_type, rows)

    def read(self, start: int, stop: int) -> npt.NDArray[Any]:
        """Read the rows from `start` up to, not including, `stop`.

        Parameters
        ----------
        start, stop : int
            0 <= start <= stop <= rows.

        Returns
        -------
        ndarray, shape (stop - start,) or, of sub-arrays, (stop - start, ...)
            A new array.

        Raises
        ------
        InvalidInputError
            Rows that the column does not have.
        CloudFileError
            The file cannot be read or is too short.
        """
        return self.read_runs(np.array([[start, stop]]))

    def take(self, rows: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
        """Read some rows (k,), increasing: see `read_runs`."""
        return self.read_runs(np.stack([rows, rows + 1], axis=1))

    def read_runs(self, runs: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
        """Read runs of rows, one after the other.

        Parameters
        ----------
        runs : ndarray of int, shape (k, 2)
            First row of each run and the row after its last. Runs that go on from one another
            cost one access to the file.

        Returns
        -------
        ndarray, shape (r,) or, of sub-arrays, (r, ...)
            The r rows of all runs, in the order of the runs.

        Raises
        ------
        InvalidInputError
            Rows that the column does not have.
        CloudFileError
            The file cannot be read or is too short.
        """
        self._check_runs(runs)
        values = np.empty(int(np.diff(runs).sum()), self.dtype)
        room = _bytes_of(values)
        done = 0
        with named_system_errors(self.path), open(self.path, "rb", buffering=0) as file:
            for start, stop in (join_runs(runs) * self.dtype.itemsize).tolist():
                self._fill(file, start, room[done : done + stop - start])
                done += stop - start
        return values

    def write(self, start: int, values: npt.NDArray[Any]) -> None:
        """Write rows from `start` on; to write the same rows again changes nothing.

        Parameters
        ----------
        start : int
            First row.
        values : ndarray, shape (k,) or, of sub-arrays, (k, ...)
            The rows, of the column's type or one that becomes it without loss of kind.

        Raises
        ------
        InvalidInputError
            Rows that the column does not have, or values of another shape or type.
        CloudFileError
            The file cannot be written; the disk is full.
        """
        self.write_runs(np.array([[start, start + len(values)]]), values)

    def write_runs(self, runs: npt.NDArray[np.int64], values: npt.NDArray[Any]) -> None:
        """Write runs of rows, the counterpart of `read_runs`.

        Parameters
        ----------
        runs : ndarray of int, shape (k, 2)
            First row of each run and the row after its last.
        values : ndarray, shape (r,) or, of sub-arrays, (r, ...)
            The rows of all runs, in the order of the runs.

        Raises
        ------
        InvalidInputError
            Rows that the column does not have, or values of another shape, number or type.
        CloudFileError
            The file cannot be written; the disk is full.
        """
        self._check_runs(runs)
        if len(values) != np.diff(runs).sum():
            raise InvalidInputError(f"{len(values)} values are no {np.diff(runs).sum()} rows")
        room = _bytes_of(self._as_rows(values))
        done = 0
        with named_system_errors(self.path), _opened_for_writing(self.path) as file:
            for start, stop in (join_runs(runs) * self.dtype.itemsize).tolist():
                _write_all(file, room[done : done + stop - start], start)
                done += stop - start

    def chunks(self, rows: int = 1 << 20) -> Iterator[npt.NDArray[Any]]:
        """Read the whole column, so many rows at a time.

        Parameters
        ----------
        rows : int
            Rows of every chunk but the last, >= 1.

        Yields
        ------
        ndarray, shape (rows,) or, of sub-arrays, (rows, ...)
            A new array.

        Raises
        ------
        CloudFileError
            The file cannot be read or is too short.
        """
        for start in range(0, self.rows, rows):
            yield self.read(start, min(start + rows, self.rows))

    def _check_runs(self, runs: npt.NDArray[np.int64]) -> None:
        starts, stops = runs.T
        if runs.size and not (
            starts.min() >= 0 and stops.max() <= self.rows and np.all(starts <= stops)
        ):
            raise InvalidInputError(
                f"the column of {self.rows} rows has no rows {starts.min()} to {stops.max()}"
            )

    def _as_rows(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        if values.shape[1:] != self.dtype.shape:
            raise InvalidInputError(
                f"values of shape {values.shape} are no rows of shape {self.dtype.shape}"
            )
        try:
            return values.astype(self.dtype.base, order="C", casting="same_kind", copy=False)
        except TypeError as error:
            raise InvalidInputError(
                f"values of type {values.dtype} are no rows of type {self.dtype}"
            ) from error

    def _fill(self, file: BinaryIO, start: int, room: memoryview) -> None:
        file.seek(start)
        while room:
            count = file.readinto(room)  # type: ignore[attr-defined]  # a raw file's
            if not count:
                raise CloudFileError(
                    self.path,
                    f"it ends before row {self.rows}, {len(room)} bytes short of what is asked",
                    "start again in an empty folder",
                )
            room = room[count:]


@contextlib.contextmanager
def _opened_for_writing(path: str) -> Iterator[int]:
    """Open an existing file for `os.pwrite`, which leaves no position for processes to share."""
    file = os.open(path, os.O_WRONLY)
    try:
        yield file
    finally:
        os.close(file)


def _write_all(file: int, room: memoryview, start: int) -> None:
    """Write all bytes: the system may take fewer at a time, 2 GiB at most."""
    while room:
        count = os.pwrite(file, room, start)
        start += count
        room = room[count:]


def _bytes_of(values: npt.NDArray[Any]) -> memoryview:
    """Show the bytes of a contiguous array."""
    return memoryview(values.reshape(-1).view(np.uint8))  # type: ignore[arg-type]
