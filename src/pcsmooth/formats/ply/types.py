"""Columns of any kind as the number types that PLY knows."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.formats.number_columns import has_long_words, numbers_of

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
    numbers = numbers_of(name, values, path, "PLY")
    if numbers.dtype.kind in "iu" and numbers.dtype.itemsize == 8:
        return _narrowest(numbers)
    return numbers


def has_long_numbers(values: npt.NDArray[Any]) -> bool:
    """Whether a column has whole numbers that a float64 would round.

    Examples
    --------
    >>> has_long_numbers(np.array([2**53 + 1])), has_long_numbers(np.array(["12", "a"]))
    (True, False)
    """
    if values.dtype.kind in "iu" and values.dtype.itemsize == 8:
        return any(float(n) != n for n in values.tolist())
    return has_long_words(values)


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


def _narrowest(numbers: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if not len(numbers) or (numbers.min() >= INT32.min and numbers.max() <= INT32.max):
        return numbers.astype(np.int32)
    return numbers.astype(np.float64)
