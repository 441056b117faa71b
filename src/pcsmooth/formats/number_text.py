"""Numbers as text: the shortest spelling that reads back the same, and strict parsing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

ROWS_AT_A_TIME = 10_000
"""Rows held as Python strings at one time; bounds memory, and keeps the garbage collector idle."""


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
        Numbers, ``nan`` and ``inf`` included; surrounding double quotes are ignored.

    Returns
    -------
    ndarray of float64
        The values.

    Raises
    ------
    ValueError
        A token is not a number.
    """
    joined = "".join(tokens)
    if "_" in joined:
        raise ValueError("underscore in a number")
    if '"' in joined:
        tokens = [token.strip('"') for token in tokens]
    return np.fromiter(map(float, tokens), np.float64, len(tokens))


def is_number(token: str) -> bool:
    """Whether a token can be `parsed`."""
    try:
        parsed([token])
    except ValueError:
        return False
    return True


def write_rows(
    file: BinaryIO,
    columns: Sequence[npt.NDArray[Any]],
    delimiter: str,
    fixed_marks: npt.NDArray[np.bool_] | None = None,
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
    """
    for start in range(0, len(columns[0]), ROWS_AT_A_TIME):
        part = slice(start, start + ROWS_AT_A_TIME)
        cells = [spelled(column[part]) for column in columns]
        rows = list(map(delimiter.join, zip(*cells, strict=True)))
        if fixed_marks is not None:
            for row in np.flatnonzero(fixed_marks[part]):
                rows[row] += f"{delimiter}fixed"
        rows.append("")
        file.write("\n".join(rows).encode())
