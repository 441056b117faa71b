"""Lines of numbers, with a type for each column: the rows of PLY and PCD files of text."""

from __future__ import annotations

import contextlib
import re
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.formats.number_text import ROWS_AT_A_TIME, is_value, parsed

Table = npt.NDArray[Any]

#: What is exact as a Python integer, and not so long that this takes time.
_WHOLE = re.compile(r"[+-]?[0-9]{1,20}")


def read_rows(
    lines: Sequence[bytes], dtype: np.dtype[Any], names: Sequence[str], first: int = 0
) -> Table:
    """Read lines of numbers that stand between blanks.

    Parameters
    ----------
    lines : sequence of bytes, length n
        None of them blank.
    dtype : structured numpy.dtype
        A field of one number for each column.
    names : sequence of str
        What errors call the columns.
    first : int
        Number of the first row, for errors.

    Returns
    -------
    structured ndarray, shape (n,)
        Whole numbers may be written with a point; floats that are not finite in any spelling that
        `parsed` knows.

    Raises
    ------
    ValueError
        A row has more or fewer values, or one that is no number of its type; says which.

    Examples
    --------
    >>> read_rows([b"1.5 255.0"], np.dtype("f4, u1"), ("x", "red")).tolist()
    [(1.5, 255)]
    """
    with contextlib.suppress(ValueError, OverflowError), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # about lines without values
        table = np.loadtxt(lines, dtype, comments=None, ndmin=1)
        if len(table) == len(lines):
            return table
    return _read_words(lines, dtype, names, first)


def _read_words(
    lines: Sequence[bytes], dtype: np.dtype[Any], names: Sequence[str], first: int
) -> Table:
    table = np.empty(len(lines), dtype)
    for start in range(0, len(lines), ROWS_AT_A_TIME):
        part = slice(start, start + ROWS_AT_A_TIME)
        rows = [line.split() for line in lines[part]]
        for row, values in enumerate(rows, first + start):
            if len(values) != len(names):
                raise ValueError(f"row {row}: {len(values)} values, expected {len(names)}")
        columns = zip(*rows, strict=True)
        for field, name, column in zip(dtype.names or (), names, columns, strict=True):
            words = [word.decode("latin-1") for word in column]
            kind = dtype[field]
            try:
                with np.errstate(over="ignore"):
                    table[field][part] = (
                        parsed(words) if kind.kind == "f" else _whole_numbers(words, kind)
                    )
            except ValueError as error:
                row = next(row for row, word in enumerate(words) if not _fits(word, kind))
                wanted = "" if kind.kind == "f" else f" of type {kind.name}"
                raise ValueError(
                    f"row {first + start + row}: {name} is '{words[row]}', not a number{wanted}"
                ) from error
    return table


def _fits(word: str, kind: np.dtype[Any]) -> bool:
    if kind.kind == "f":
        return is_value(word)
    try:
        _whole_numbers([word], kind)
    except ValueError:
        return False
    return True


def _whole_numbers(words: Sequence[str], kind: np.dtype[Any]) -> npt.NDArray[Any]:
    """Numbers of a type; `ValueError` if one has a part behind the point, or is beyond the type."""
    limits = np.iinfo(kind)
    numbers = [int(word) if _WHOLE.fullmatch(word) else float(parsed([word])[0]) for word in words]
    if not all(limits.min <= number <= limits.max and number == int(number) for number in numbers):
        raise ValueError("a number is not of the type")
    return np.array(list(map(int, numbers)), kind)
