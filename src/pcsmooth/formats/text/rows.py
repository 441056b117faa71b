"""The rows of a text file of points: which lines they are, and in which blocks they come."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import islice

from pcsmooth.formats.text.dialect import WHITESPACE, Dialect, is_comment, is_count, split_row
from pcsmooth.formats.text.lines import TextLines


class TextRows(Iterable[str]):
    """The lines of a file that hold points.

    Parameters
    ----------
    lines : TextLines
        All lines of the file.
    dialect : Dialect
        How they are to be read.

    Attributes
    ----------
    dialect : Dialect
        The same.
    counts : tuple of int
        What count lines promise of the blocks of rows below them.
    blocks : tuple of int
        How many rows each of these blocks has.
    n_characters : int
        Characters of all rows.
    """

    def __init__(self, lines: TextLines, dialect: Dialect) -> None:
        self._lines = lines
        self.dialect = dialect
        self._rows = lines.chosen(self._make)
        self.counts: tuple[int, ...] = () if dialect.count is None else (dialect.count,)
        self.blocks: tuple[int, ...] = ()
        if self.counts:
            self._take_counts()
            self._rows = self.chosen(lambda row: not is_count(row))
        self._count = self.n_characters = 0
        for row in self._rows:
            self._count += 1
            self.n_characters += len(row)

    def __iter__(self) -> Iterator[str]:
        """Give the rows."""
        return iter(self._rows)

    def __len__(self) -> int:
        """Return the number of rows."""
        return self._count

    def chosen(self, is_chosen: Callable[[str], object]) -> Iterable[str]:
        """Rows of which something is true, again and again."""
        rows = self._rows
        return self._lines.chosen(lambda: filter(is_chosen, rows))

    def comments_below(self) -> Iterator[str]:
        """Comments from the first row on."""
        dialect = self.dialect
        return (
            line
            for line in islice(self._lines, dialect.first_row, None)
            if is_comment(line, dialect.marks) and not dialect.is_row(line)
        )

    def head(self, n: int) -> Iterator[list[str]]:
        """Fields of the first rows."""
        return (split_row(row, self.dialect.delimiter) for row in islice(self, n))

    def first_fields(self) -> Iterator[str]:
        """First field of every row."""
        delimiter = self.dialect.delimiter
        separator = None if delimiter == WHITESPACE else delimiter
        return (row.split(separator, 1)[0] for row in self)

    def line_number(self, row: int) -> int:
        """Return the number of a row's line in the file, counted from 1."""
        first = self.dialect.first_row
        numbers = (
            number
            for number, line in enumerate(islice(self._lines, first, None), first + 1)
            if self.dialect.is_row(line) and not (self.counts and is_count(line))
        )
        return next(islice(numbers, row, None))

    def _make(self) -> Iterator[str]:
        dialect = self.dialect
        return (
            line
            for line in islice(self._lines, dialect.first_row, None)
            if (start := line.lstrip())
            and (not start.startswith(dialect.marks) or dialect.is_row(line))
        )

    def _take_counts(self) -> None:
        """Count the rows below each line that counts them."""
        counts, blocks = list(self.counts), [0]
        for row in self._rows:
            if is_count(row):
                counts.append(int(row))
                blocks.append(0)
            else:
                blocks[-1] += 1
        self.counts, self.blocks = tuple(counts), tuple(blocks)


def columns_in_words(count: int) -> str:
    """Say how many columns there are."""
    return f"{count} column" if count == 1 else f"{count} columns"
