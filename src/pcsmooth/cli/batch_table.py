"""The table at the end of a batch: what came of each file."""

from __future__ import annotations

import math
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from pcsmooth.printable import printable, shortened

#: Fewest letters that are left of a name.
_LEAST_NAME = 12


@dataclass(frozen=True)
class Column:
    """A column of the table.

    Attributes
    ----------
    title : str
        Its name.
    cell : callable
        What it says of a summary.
    """

    title: str
    cell: Callable[[dict[str, Any]], str]


def count_column(title: str, key: str) -> Column:
    """Make a column of a count in summaries."""
    return Column(title, lambda summary: "-" if summary.get(key) is None else str(summary[key]))


def number_column(title: str, key: str) -> Column:
    """Make a column of a number in summaries, to three digits."""
    return Column(title, lambda summary: _short(summary.get(key)))


def _short(number: Any) -> str:
    try:
        is_known = isinstance(number, int | float) and math.isfinite(number)
    except OverflowError:  # of a record that somebody else may have written
        is_known = False
    return f"{number:.3g}" if is_known else "-"


def table_lines(
    names: Sequence[str],
    columns: Sequence[Column],
    summaries: Sequence[dict[str, Any] | str],
    seconds: Sequence[float],
    warnings: Sequence[int],
    width: int | None,
) -> Iterator[str]:
    """Write a line for each file under a line of titles.

    Parameters
    ----------
    names : sequence of str
        Of the files.
    columns : sequence of Column
        What is said of those that are done.
    summaries : sequence of dict or str
        What was found, or in a word what became of the file instead.
    seconds : sequence of float
        Time that each took.
    warnings : sequence of int
        How many came with each; nothing is said if there are none at all.
    width : int or None
        Letters of a line, for which long names lose their middle; None for lines of any length.

    Yields
    ------
    str
    """
    titles = [*(column.title for column in columns), "seconds"]
    cells = [
        [summary, *[""] * len(columns)]
        if isinstance(summary, str)
        else [*(column.cell(summary) for column in columns), f"{spent:.2f}"]
        for summary, spent in zip(summaries, seconds, strict=True)
    ]
    if any(warnings):
        titles.append("warnings")
        for row, count in zip(cells, warnings, strict=True):
            row.append(str(count) if count else "")
    widths = [max(map(len, column)) for column in zip(titles, *cells, strict=True)]
    shown = [printable(name) for name in names]
    room = max(map(len, [*shown, "file"]))
    if width is not None:
        room = min(room, max(_LEAST_NAME, width - sum(widths) - 2 * len(widths)))
    for name, row in zip(["file", *shown], [titles, *cells], strict=True):
        right = "".join(f"  {cell:>{wide}}" for cell, wide in zip(row, widths, strict=True))
        yield f"{shortened(name, room):<{room}}{right}".rstrip()


def terminal_width() -> int | None:
    """Letters of a line on stderr; None if it is no terminal."""
    return (shutil.get_terminal_size().columns or 80) if sys.stderr.isatty() else None
