"""Columns of any kind, and their names, for formats that hold numbers under plain names."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import parsed
from pcsmooth.formats.text.encoding import readable

#: Whole numbers from here on are not all apart in double precision, in which words are read.
_LARGEST_WHOLE = 2.0**63


def number_columns(cloud: PointCloud, path: str, holder: str) -> dict[str, npt.NDArray[Any]]:
    """Every column but lists as numbers; the marks of fixed points as a column ``fixed``.

    Parameters
    ----------
    cloud : PointCloud
        What is to be written.
    path : str
        Name of the file in errors.
    holder : str
        The format, for errors.

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
        name: numbers_of(name, values, path, holder)
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
