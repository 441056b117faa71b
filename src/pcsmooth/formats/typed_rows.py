"""Lines of numbers, with a type for each column: the rows of PLY and PCD files of text."""

from __future__ import annotations

import contextlib
import re
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from pcsmooth.formats.number_text import ROWS_AT_A_TIME, Exceptions, is_value, parsed, spelled

Table = npt.NDArray[Any]

_Words = TypeVar("_Words")

OddWords = Mapping[int, Mapping[str, str]]
"""Numbers that are not finite and spelled in a file in their own way: by row, then by field."""

#: How they are written.
_USUAL = ("nan", "inf", "-inf")

#: What is exact as a Python integer, and not so long that this takes time.
_WHOLE = re.compile(r"[+-]?[0-9]{1,20}")


def renumbered(odd: Mapping[int, _Words], kept: npt.NDArray[np.bool_]) -> dict[int, _Words]:
    """Give what is known of rows to those of them that stay (n,), by their new numbers."""
    places = np.cumsum(kept) - 1
    return {int(places[row]): words for row, words in odd.items() if row < len(kept) and kept[row]}


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


def odd_words(lines: Sequence[bytes], table: Table) -> OddWords:
    """Find numbers that are not finite and not spelled as they would be written.

    Parameters
    ----------
    lines : sequence of bytes, length n
        Rows of a file.
    table : structured ndarray, shape (n,)
        What `read_rows` made of them.
    """
    names = table.dtype.names or ()
    is_odd = {
        place: ~np.isfinite(table[name])
        for place, name in enumerate(names)
        if table.dtype[name].kind == "f"
    }
    found: dict[int, Mapping[str, str]] = {}
    kinds: dict[tuple[tuple[str, str], ...], Mapping[str, str]] = {}  # most rows are alike
    for row in np.flatnonzero(np.any([*is_odd.values()], axis=0)).tolist() if is_odd else ():
        words = lines[row].decode("latin-1").split()  # as NumPy does, at control characters too
        kept = tuple(
            (names[place], words[place])
            for place, odd in is_odd.items()
            if len(words) == len(names) and odd[row]
            if words[place].isascii() and words[place] not in _USUAL
        )
        if kept:
            found[row] = kinds.setdefault(kept, dict(kept))
    return found


def exceptions_in(table: Table, odd: OddWords) -> Exceptions:
    """Say what of a table is to be written as it was spelled: what still has its value."""
    odd_names = {name for words in odd.values() for name in words}
    places = {
        name: place for place, name in enumerate(table.dtype.names or ()) if name in odd_names
    }
    return Exceptions(
        words={
            row: tuple(
                words[name]
                if name in words and _is_still(table[name][row], words[name])
                else spelled(table[name][row : row + 1])[0]
                for name in places
            )
            for row, words in odd.items()
            if row < len(table)
        },
        columns=tuple(places.values()),
    )


def _is_still(value: Any, word: str) -> bool:
    if np.isfinite(value):
        return False
    with np.errstate(over="ignore"):
        return bool(np.array_equal(value, parsed([word])[0].astype(value.dtype), equal_nan=True))


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
