"""Numbers as text: the shortest spelling that reads back the same, and all that are read."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.formats.text.encoding import encoded

_WHOLE = re.compile("[0-9]{1,18}")

ROWS_AT_A_TIME = 10_000
"""Rows held as Python strings at one time; bounds memory, and keeps the garbage collector idle."""

_FORTRAN = re.compile(r"[+-]?(?:\d++\.?\d*+|\.\d++)d[+-]?\d++")
"""A number in double precision, with D for its exponent."""

_NOT_A_NUMBER = re.compile(r"[+-]?(?:nan\(\w*\)|1\.#\w+)")
"""How runtimes of C spell what is no number, cut after any digit: -nan(ind), 1.#QNAN0, 1.#R."""

_INFINITY = re.compile(r"[+-]?1\.#inf\d*")

_SPREADSHEET_ERRORS = (
    "name|nom|nombre|nome|null|nul|nulo|nullo|num|zahl|value|wert|valeur|valor|valore|"
    "ref|bezug|rif|div/0"
)
"""Errors that cells hold in English, German, French, Spanish and Italian."""

_MISSING = re.compile(
    r"|null|nil|none|na|n/a|<na>|\\n|\.|-+|\?+|\*+|"
    rf"#(?:na|n/a|n/d|nv|[^\w#]?(?:{_SPREADSHEET_ERRORS})[!?])"
)
"""What databases, spreadsheets, R, Python and Fortran write where there is no number."""


def spelled(values: npt.NDArray[Any]) -> list[str]:
    """Spell a column: strings verbatim, numbers as short as they read back to the same value.

    Parameters
    ----------
    values : ndarray of float, int, bool or str, shape (n,)
        One column.

    Returns
    -------
    list of str, length n
        One token per row.

    Examples
    --------
    >>> spelled(np.array([0.1, -2.0, np.nan])), spelled(np.array([0.1], np.float32))
    (['0.1', '-2.0', 'nan'], ['0.1'])
    """
    match values.dtype.kind:
        case "U":
            return list(values.tolist())
        case "f" if values.dtype.itemsize < 8:
            return list(map(str, values))
        case "f":
            return list(map(repr, values.astype(np.float64).tolist()))
        case "b":
            return list(map(str, values.astype(np.uint8).tolist()))
        case _:
            return list(map(str, values.tolist()))


def parsed(tokens: Sequence[str]) -> npt.NDArray[np.float64]:
    """Parse tokens as float64, without the underscores that ``float`` would let pass.

    Parameters
    ----------
    tokens : sequence of str
        Numbers, those of Fortran and ``nan`` and ``inf`` in every spelling included, and words
        for missing ones; surrounding double quotes are ignored.

    Returns
    -------
    ndarray of float64
        The values, NaN for what is missing.

    Raises
    ------
    ValueError
        A token is neither a number nor stands for a missing one.

    Examples
    --------
    >>> parsed(["1.0D+01", "-1.#IND", "", "-1.#INF", "NULL"]).tolist()
    [10.0, nan, nan, -inf, nan]
    """
    joined = "".join(tokens)
    if "_" in joined:
        raise ValueError("underscore in a number")
    if '"' in joined:
        tokens = [token.strip('"') for token in tokens]
    try:
        return np.fromiter(map(float, tokens), np.float64, len(tokens))
    except ValueError:
        return np.fromiter(map(_number, tokens), np.float64, len(tokens))


def is_number(token: str) -> bool:
    """Whether a token can be `parsed`, and is no word for a missing number."""
    return is_value(token) and not is_missing(token)


def is_whole(token: str) -> bool:
    """Whether a token is a whole number that may count something: 1 to 18 digits.

    One of more is more than any file holds, and more than Python would convert.
    """
    return _WHOLE.fullmatch(token) is not None


def is_missing(token: str) -> bool:
    """Whether a token stands for a missing number, as nothing does."""
    return _MISSING.fullmatch(token.strip(' "').lower()) is not None


def is_value(token: str) -> bool:
    """Whether a token can be `parsed`."""
    try:
        _number(token.strip('"'))
    except ValueError:
        return False
    return "_" not in token


def _number(token: str) -> float:
    try:
        return float(token)
    except ValueError:
        word = token.strip().lower()
        if _FORTRAN.fullmatch(word):
            return float(word.replace("d", "e"))
        if _INFINITY.fullmatch(word):
            return -math.inf if word.startswith("-") else math.inf
        if _NOT_A_NUMBER.fullmatch(word) or _MISSING.fullmatch(word):
            return math.nan
        raise


@dataclass(frozen=True)
class Exceptions:
    """What stands in rows of text in place of what their columns would give, and above them.

    Attributes
    ----------
    with_commas : frozenset of int
        Columns whose decimals have a comma.
    words, columns : dict of int to tuple of str, tuple of int
        Words by row, increasing, and the columns in which they stand.
    lines_above : dict of int to str
        Lines by the row above which they stand.
    """

    with_commas: frozenset[int] = frozenset()
    words: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    columns: tuple[int, ...] = ()
    lines_above: Mapping[int, str] = field(default_factory=dict)


def write_rows(
    file: BinaryIO,
    columns: Sequence[npt.NDArray[Any]],
    delimiter: str,
    fixed_marks: npt.NDArray[np.bool_] | None = None,
    exceptions: Exceptions | None = None,
) -> None:
    """Write columns as lines of text.

    Parameters
    ----------
    file : binary file
        Open for writing.
    columns : sequence of ndarray, each of shape (n,)
        Numbers or strings, at least one column.
    delimiter : str
        What stands between the columns.
    fixed_marks : ndarray of bool, shape (n,), optional
        Rows that end in the word ``fixed``.
    exceptions : Exceptions, optional
        What is written otherwise.
    """
    exceptions = exceptions or Exceptions()
    odd_rows, next_rows = (
        np.fromiter(rows, np.int64) for rows in (exceptions.words, exceptions.lines_above)
    )
    for start in range(0, len(columns[0]), ROWS_AT_A_TIME):
        part = slice(start, start + ROWS_AT_A_TIME)
        cells = [spelled(column[part]) for column in columns]
        for column in exceptions.with_commas:
            cells[column] = [_with_comma(word, delimiter) for word in cells[column]]
        for odd_row in _within(part, odd_rows):
            for column, word in zip(exceptions.columns, exceptions.words[odd_row], strict=True):
                cells[column][odd_row - start] = word
        rows = list(map(delimiter.join, zip(*cells, strict=True)))
        if fixed_marks is not None:
            for row in np.flatnonzero(fixed_marks[part]):
                rows[row] += f"{delimiter}fixed"
        for next_row in _within(part, next_rows):
            rows[next_row - start] = f"{exceptions.lines_above[next_row]}\n{rows[next_row - start]}"
        rows.append("")
        file.write(encoded("\n".join(rows)))


def _with_comma(word: str, delimiter: str) -> str:
    """Spell a number with a decimal comma, in quotes where that would part columns."""
    word = word.replace(".", ",")
    must_quote = delimiter == "," and delimiter in word and not word.startswith('"')
    return f'"{word}"' if must_quote else word


def _within(part: slice, rows: npt.NDArray[np.int64]) -> list[int]:
    """Rows, of increasing ones, that lie in a part."""
    first, last = np.searchsorted(rows, [part.start, part.stop])
    within: list[int] = rows[first:last].tolist()
    return within
