"""Columns of any kind, and their names, for formats that hold numbers under plain names."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import parsed
from pcsmooth.formats.text.encoding import readable

#: Whole numbers from here on are not all apart in double precision, in which words are read.
_LARGEST_WHOLE = 2.0**63


Types = Mapping[str, np.dtype[Any]]
NO_TYPES: Types = MappingProxyType({})
"""Types of columns by name, as far as they are settled."""


def number_columns(
    cloud: PointCloud, path: str, holder: str, types: Types = NO_TYPES
) -> dict[str, npt.NDArray[Any]]:
    """Every column but lists as numbers; the marks of fixed points as a column ``fixed``.

    Parameters
    ----------
    cloud : PointCloud
        What is to be written.
    path : str
        Name of the file in errors.
    holder : str
        The format, for errors.
    types : mapping of str to numpy.dtype
        Types of the columns of the whole cloud of which these are rows.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        Under their names.

    Raises
    ------
    CloudFileError
        A column holds words.
    """
    columns = {
        name: widened(numbers_of(name, values, path, holder), types.get(name))
        for name, values in cloud.columns.items()
        if values.dtype.kind != "O"
    }
    if cloud.fixed_marks is not None:
        columns.setdefault("fixed", cloud.fixed_marks.astype(np.uint8))
    return columns


def numbers_of(name: str, values: npt.NDArray[Any], path: str, holder: str) -> npt.NDArray[Any]:
    """Convert a column to numbers of 8 to 64 bits.

    Parameters
    ----------
    name : str
        Name of the column, for the error.
    values : ndarray, shape (n,)
        Numbers, booleans or strings.
    path : str
        Name of the file in errors.
    holder : str
        The format, for errors.

    Returns
    -------
    ndarray of int8 ... int64, uint8 ... uint64, float32 or float64
        The same values. Booleans become uint8, floats longer than 64 bits float64, whole numbers
        in strings int64, other strings float64, missing ones NaN.

    Raises
    ------
    CloudFileError
        The column holds words.
    """
    kind, size = values.dtype.kind, values.dtype.itemsize
    if kind == "U":
        return _numbers_in_words(name, values, path, holder)
    if kind == "b":
        return values.astype(np.uint8)
    if kind in "iu":
        return values
    if kind == "f":
        return values.astype(np.float32 if size <= 4 else np.float64, copy=False)
    raise CloudFileError(
        path,
        f"column '{name}' has type {values.dtype}, which {holder} cannot hold",
        "remove the column",
    )


def widened(values: npt.NDArray[Any], wanted: np.dtype[Any] | None) -> npt.NDArray[Any]:
    """Whole numbers as floats where others of their column are; other values as they are."""
    is_wider = wanted is not None and wanted.kind == "f" and values.dtype.kind in "iu"
    return values.astype(wanted) if is_wider else values


class ValueRanges:
    """The values of some columns of a cloud that comes in chunks, as far as they tell a type.

    Parameters
    ----------
    template : PointCloud
        The cloud without its points.
    is_typed : callable
        Says of the type of a column whether its values matter.
    path : str
        Name of the file that is to be written, in errors.
    holder : str
        Its format, for errors.
    """

    def __init__(
        self,
        template: PointCloud,
        is_typed: Callable[[np.dtype[Any]], bool],
        path: str,
        holder: str,
    ) -> None:
        self._template, self._path, self._holder = template, path, holder
        self._ends = {
            name: numbers_of(name, values[:0], path, holder)
            for name, values in template.columns.items()
            if is_typed(values.dtype)
        }

    def add(self, chunk: PointCloud) -> PointCloud:
        """Take the values of a chunk into account; gives it on.

        Raises
        ------
        CloudFileError
            A column holds words that are no numbers.
        InvalidInputError
            The chunk lacks a column of the template.
        """
        missing = self._ends.keys() - chunk.columns.keys()
        if missing:
            raise InvalidInputError(f"a chunk has no column '{min(missing)}' of the template")
        for name in self._ends if len(chunk) else ():
            values = numbers_of(name, chunk.columns[name], self._path, self._holder)
            ends = np.concatenate([self._ends[name], [values.min(), values.max()]])
            self._ends[name] = np.array([ends.min(), ends.max()])
        return chunk

    def template(self, chunks: Iterable[PointCloud] = ()) -> PointCloud:
        """Give a template whose columns have the type, and the ends, of all values.

        Parameters
        ----------
        chunks : iterable of PointCloud
            Points that are still to be added; iterated only if there are such columns.

        Returns
        -------
        PointCloud
            Of two rows, or the one that was given if no column is typed by its values.
        """
        if self._ends:
            for chunk in chunks:
                self.add(chunk)
        if not any(map(len, self._ends.values())):
            return self._template
        columns = {name: _two_rows(values) for name, values in self._template.columns.items()}
        marks = self._template.fixed_marks
        return replace(
            self._template,
            points=np.zeros((2, self._template.dimension)),
            columns=columns | self._ends,
            fixed_marks=None if marks is None else _two_rows(marks),
        )


def plain_ascii(name: str) -> str:
    """Name of a column: as given, with '_' for spaces and for what is not ASCII.

    Examples
    --------
    >>> plain_ascii("Scalar field")
    'Scalar_field'
    """
    return re.sub(r"[^!-~]", "_", name)


def has_long_words(values: npt.NDArray[Any]) -> bool:
    """Whether a column has whole numbers in words that a float64 would round.

    Examples
    --------
    >>> has_long_words(np.array(["9007199254740993"])), has_long_words(np.array(["12", "a"]))
    (True, False)
    """
    if values.dtype.kind != "U":
        return False
    long = filter(re.compile(r"[+-]?\d{16,}").fullmatch, values.tolist())
    return any(float(word) != int(word) for word in long)


def lost_columns(cloud: PointCloud) -> list[str]:
    """Say which columns a format of numbers would not hold, or not in full."""
    lists = [f"lists '{name}'" for name, column in cloud.columns.items() if column.dtype == object]
    return lists + [
        f"digits of the long numbers in column '{name}'"
        for name, column in cloud.columns.items()
        if has_long_words(column)
    ]


def _numbers_in_words(
    name: str, words: npt.NDArray[Any], path: str, holder: str
) -> npt.NDArray[Any]:
    tokens = [readable(word.strip('"')) for word in words.tolist()]
    try:
        numbers = parsed(tokens)
    except ValueError as error:
        raise CloudFileError(
            path,
            f"column '{name}' holds words ({excerpt(str(error))}), which {holder} cannot hold",
            "write .csv or .txt, or remove the column",
        ) from error
    whole = all(re.fullmatch(r"[+-]?\d+", token) for token in tokens)
    if whole and np.all(np.abs(numbers) < _LARGEST_WHOLE):
        return numbers.astype(np.int64)
    return numbers


def _two_rows(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    rows = np.zeros(2, values.dtype)
    if values.dtype == object:
        rows[:] = [np.empty(0, np.int32)] * 2
    return rows
