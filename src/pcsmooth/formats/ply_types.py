"""Columns of any kind as the number types that PLY knows."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import parsed

INT32 = np.iinfo(np.int32)


def ply_numbers(name: str, values: npt.NDArray[Any], path: str) -> npt.NDArray[Any]:
    """Convert a column to a type that PLY can hold.

    Parameters
    ----------
    name : str
        Name of the column, for the error.
    values : ndarray, shape (n,)
        Numbers, booleans or strings.
    path : str
        Name of the file in errors.

    Returns
    -------
    ndarray of int8 ... int32, uint8 ... uint32, float32 or float64
        The same values. Whole numbers beyond 32 bits and longer floats become float64; empty
        strings become NaN.

    Raises
    ------
    CloudFileError
        The column holds words.
    """
    kind, size = values.dtype.kind, values.dtype.itemsize
    if kind == "U":
        return _numbers_in_words(name, values, path)
    if kind == "b":
        return values.astype(np.uint8)
    if kind in "iu":
        return values if size < 8 else _narrowest(values)
    if kind == "f":
        return values.astype(np.float32 if size <= 4 else np.float64, copy=False)
    raise CloudFileError(
        path, f"column '{name}' has type {values.dtype}, which PLY cannot hold", "remove the column"
    )


def has_long_numbers(values: npt.NDArray[Any]) -> bool:
    """Whether a column has whole numbers that a float64 would round.

    Examples
    --------
    >>> has_long_numbers(np.array(["9007199254740993"])), has_long_numbers(np.array(["12", "a"]))
    (True, False)
    """
    if values.dtype.kind == "U":
        long = filter(re.compile(r"[+-]?\d{16,}").fullmatch, values.tolist())
        return any(float(word) != int(word) for word in long)
    return values.dtype.kind in "iu" and any(float(n) != n for n in values.tolist())


def ply_name(name: str) -> str:
    """Name of a property: as given, with '_' for spaces and for what is not ASCII.

    Examples
    --------
    >>> ply_name("Scalar field")
    'Scalar_field'
    """
    return re.sub(r"[^!-~]", "_", name)


def list_types(values: npt.NDArray[Any]) -> tuple[str, str]:
    """Types of length and items for a column of lists that no file has typed.

    Parameters
    ----------
    values : ndarray of object, shape (n,)
        One sequence of numbers per row.

    Returns
    -------
    tuple of str
        Type codes as plyfile takes them, such as ``("u1", "i4")``.
    """
    longest = max(map(len, values), default=0)
    whole = all(np.asarray(row).dtype.kind in "biu" for row in values)
    return "u1" if longest < 256 else "i4", "i4" if whole else "f8"


def _numbers_in_words(name: str, words: npt.NDArray[Any], path: str) -> npt.NDArray[Any]:
    tokens = [word.strip('"') or "nan" for word in words.tolist()]
    try:
        numbers = parsed(tokens)
    except ValueError as error:
        raise CloudFileError(
            path,
            f"column '{name}' holds words ({excerpt(str(error))}), which PLY cannot hold",
            "write .csv or .txt, or remove the column",
        ) from error
    if all(re.fullmatch(r"[+-]?\d+", token) for token in tokens):
        return _narrowest(numbers)
    return numbers


def _narrowest(numbers: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if not len(numbers) or (numbers.min() >= INT32.min and numbers.max() <= INT32.max):
        return numbers.astype(np.int32)
    return numbers.astype(np.float64)
