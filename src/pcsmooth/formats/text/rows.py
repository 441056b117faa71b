"""The rows of a text file of points: positions, and every other column in words."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import ROWS_AT_A_TIME, is_value, parsed, spelled
from pcsmooth.formats.text.dialect import (
    WHITESPACE,
    Dialect,
    is_count,
    is_fixed,
    may_be_number,
    split_row,
)
from pcsmooth.formats.text.encoding import readable

_POINT = re.compile(r"\d\.\d|\d\.$|^[+-]?\.\d")

_QUOTED_NUMBER = re.compile(r'"[+-]?[0-9][0-9.,]*"')
_THOUSANDS = re.compile(r'"[+-]?[1-9][0-9]{0,2}(?:,[0-9]{3})+(?:\.[0-9]*)?"')

_BYTES_PER_CHARACTER = 4
_BYTES_PER_COLUMN = 1 << 10
_LARGEST_GROWTH = 16
_SMALL = 16 << 20
"""Columns of words may take so many bytes, and so many times the characters of the file."""

Numbers = npt.NDArray[np.float64]
Words = npt.NDArray[np.str_]


@dataclass(frozen=True)
class ParsedRows:
    """What rows hold.

    Attributes
    ----------
    points : ndarray, shape (n, d)
        Positions.
    has_commas : bool
        Whether their decimals had a comma, or those of others beside whole numbers.
    others : list of ndarray of str, each of shape (n,)
        The other columns; if decimals had a comma, those of nothing but numbers have a point now.
    with_commas : list of bool
        Which of them this is true of.
    marks : ndarray of bool, shape (n,), or None
        Rows that end in ``fixed``; None if there are none.
    odd_rows : dict of int to tuple of str
        Coordinates of the rows that are not finite as they are spelled, unless as usual.
    """

    points: Numbers
    has_commas: bool
    others: list[Words] = field(default_factory=list)
    with_commas: list[bool] = field(default_factory=list)
    marks: npt.NDArray[np.bool_] | None = None
    odd_rows: dict[int, tuple[str, ...]] = field(default_factory=dict)


class TextRows:
    """The lines of a file that hold points.

    Parameters
    ----------
    lines : sequence of str
        All lines of the file.
    dialect : Dialect
        How they are to be read.
    path : str
        Name of the file in errors.
    """

    def __init__(self, lines: Sequence[str], dialect: Dialect, path: str) -> None:
        self._lines = lines
        self._dialect = dialect
        self._path = path
        self._rows = [
            line
            for line in lines[dialect.first_row :]
            if (start := line.lstrip())
            and (not start.startswith(dialect.marks) or dialect.is_row(line))
        ]
        self.counts: tuple[int, ...] = () if dialect.count is None else (dialect.count,)
        """What count lines promise of the blocks of rows below them."""
        self.blocks: tuple[int, ...] = ()
        """How many rows each of these blocks has."""
        if self.counts:
            self._take_counts()
        self._largest = _LARGEST_GROWTH * sum(map(len, self._rows)) + _SMALL

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self._rows)

    def head(self, n: int) -> Iterator[list[str]]:
        """Fields of the first rows."""
        return (split_row(row, self._dialect.delimiter) for row in self._rows[:n])

    def first_fields(self) -> Iterator[str]:
        """First field of every row."""
        delimiter = self._dialect.delimiter
        separator = None if delimiter == WHITESPACE else delimiter
        return (row.split(separator, 1)[0] for row in self._rows)

    def parsed(self, axes: Sequence[int]) -> ParsedRows:
        """Read positions from some columns, words from the others, and which rows are fixed.

        Raises
        ------
        CloudFileError
            A row has too few or too many columns, a coordinate is not a number or may have commas
            between thousands, or words would take far more memory than the file.
        """
        commas = self._with_commas()
        has_commas = self._hold(axes, ",", commas)
        thousands = self._thousands(commas)
        if thousands is not None:
            if has_commas:
                raise CloudFileError(
                    self._path,
                    f"the commas in numbers such as {excerpt(thousands)} may part thousands",
                    "write numbers without them, and decimals with a point",
                )
            commas = []
        if len(axes) == self._dialect.n_columns and self._rows:
            table = self._numbers_only(has_commas)
            if table is not None:
                points = np.ascontiguousarray(table[:, list(axes)])
                return ParsedRows(points, has_commas, odd_rows=self._odd_rows(points, axes))
        points, others, marks = self._words(axes, has_commas)
        with_commas = [False] * len(others)
        if has_commas or (commas and not self._hold(axes, ".", self._rows)):
            plain = list(map(_with_points, others))
            with_commas = [words is not None for words in plain]
            has_commas = has_commas or any(with_commas)
            others = [
                old if words is None else words for old, words in zip(others, plain, strict=True)
            ]
        return ParsedRows(
            points, has_commas, others, with_commas, marks if marks.any() else None,
            self._odd_rows(points, axes),
        )  # fmt: skip

    def _take_counts(self) -> None:
        """Part the lines that count further blocks from the rows."""
        counts, blocks, rows = list(self.counts), [0], []
        for row in self._rows:
            if is_count(row):
                counts.append(int(row))
                blocks.append(0)
            else:
                rows.append(row)
                blocks[-1] += 1
        self._rows, self.counts, self.blocks = rows, tuple(counts), tuple(blocks)

    def _with_commas(self) -> list[str]:
        """Rows with a comma that may be a decimal one: between no columns, or quoted."""
        quoted = '" *[+-]?[0-9]+,'
        may_have = re.compile(quoted if self._dialect.delimiter == "," else ",").search
        return [row for row in self._rows if may_have(row)]

    def _thousands(self, rows: Sequence[str]) -> str | None:
        """Last number with a comma, if the commas of all in quotes may part thousands."""
        if self._dialect.delimiter != ",":
            return None
        last = None
        for row in rows:
            for token in split_row(row, ","):
                if "," in token and _QUOTED_NUMBER.fullmatch(token):
                    if not _THOUSANDS.fullmatch(token):
                        return None
                    last = token
        return last

    def _hold(self, axes: Sequence[int], sign: str, rows: Sequence[str]) -> bool:
        """Whether coordinates of these rows have a sign in them."""
        return any(
            sign in field
            for row in rows
            for column, field in enumerate(split_row(row, self._dialect.delimiter))
            if column in axes
        )

    def _numbers_only(self, has_commas: bool) -> Numbers | None:
        """All rows by NumPy's own parser, or None if it finds anything but plain numbers."""
        delimiter, rows = self._dialect.delimiter, self._rows
        if has_commas:
            if "," in delimiter or any("." in row for row in rows):
                return None
            rows = [row.replace(",", ".") for row in rows]
        try:
            table = np.loadtxt(
                (row for row in rows),  # between two of a generator's, Ctrl-C is heard
                delimiter=None if delimiter == WHITESPACE else delimiter,
                comments=None,
                ndmin=2,
            )
        except ValueError:
            return None
        return table if table.shape[1] == self._dialect.n_columns else None

    def _words(
        self, axes: Sequence[int], has_commas: bool
    ) -> tuple[Numbers, list[Words], npt.NDArray[np.bool_]]:
        """Positions, the other columns as they are spelled, and marks of fixed rows."""
        points = np.empty((len(self), len(axes)))
        others: list[list[Words]] = [[] for _ in range(self._dialect.n_columns - len(axes))]
        longest = [0] * len(others)
        marks = np.zeros(len(self), np.bool_)
        for start in range(0, len(self), ROWS_AT_A_TIME):
            fields = [
                split_row(row, self._dialect.delimiter)
                for row in self._rows[start : start + ROWS_AT_A_TIME]
            ]
            for row in self._trim(fields):
                marks[start + row] = True
            self._check_widths(fields, start)
            columns = list(zip(*fields, strict=True))
            for axis, column in enumerate(axes):
                points[start : start + len(fields), axis] = self._parsed_axis(
                    columns[column], start, has_commas
                )
            rest = [tokens for column, tokens in enumerate(columns) if column not in axes]
            for column, tokens in enumerate(rest):
                longest[column] = max(longest[column], max(map(len, tokens)))
            self._check_size(longest)
            for chunks, tokens in zip(others, rest, strict=True):
                chunks.append(np.array(tokens, np.str_))
        words = [np.concatenate(chunks) if chunks else np.empty(0, np.str_) for chunks in others]
        return points, words, marks

    def _trim(self, fields: list[list[str]]) -> Iterator[int]:
        """Take what is no column from the ends of rows; gives those that ended in ``fixed``."""
        width = self._dialect.n_columns
        for row, tokens in enumerate(fields):
            while len(tokens) > width and not tokens[-1]:
                tokens.pop()
            if len(tokens) == width + 1 and is_fixed(tokens[-1]):
                tokens.pop()
                yield row

    def _check_widths(self, fields: list[list[str]], start: int) -> None:
        expected = self._dialect.n_columns
        if {len(tokens) for tokens in fields} == {expected}:
            return
        row = next(row for row, tokens in enumerate(fields) if len(tokens) != expected)
        raise CloudFileError(
            self._path,
            f"line {self._line_number(start + row)} has {columns_in_words(len(fields[row]))}, "
            f"expected {expected}",
            "give every row the same columns",
        )

    def _check_size(self, longest: Sequence[int]) -> None:
        """Refuse what takes far more memory than the file: every word takes the longest's place."""
        size = _BYTES_PER_CHARACTER * len(self) * sum(longest) + _BYTES_PER_COLUMN * len(longest)
        if size > self._largest:
            raise CloudFileError(
                self._path,
                f"{columns_in_words(len(longest))} of words of up to {max(longest)} characters "
                f"are too much for {len(self)} rows",
                "remove columns or shorten words",
            )

    def _parsed_axis(self, tokens: Sequence[str], start: int, has_commas: bool) -> Numbers:
        read = _with_point if has_commas else str
        try:
            return parsed(list(map(read, tokens)) if has_commas else tokens)
        except ValueError as error:
            row, token = next(
                (row, token) for row, token in enumerate(tokens) if not _is_read(token, read)
            )
            number = self._line_number(start + row)
            raise CloudFileError(
                self._path,
                f"line {number}: '{excerpt(readable(token))}' is not a number",
                "write all decimals alike, with a point or with a comma"
                if may_be_number(token)
                else "correct or remove the line, or choose other columns by --columns X,Y,Z",
            ) from error

    def _odd_rows(self, points: Numbers, axes: Sequence[int]) -> dict[int, tuple[str, ...]]:
        """Rows that are not finite, unless they are spelled as they would be written anyway."""
        rows = np.flatnonzero(~np.isfinite(points).all(axis=1)).tolist()
        usual = zip(*(spelled(coordinates) for coordinates in points[rows].T), strict=True)
        odd: dict[int, tuple[str, ...]] = {}
        for row, words in zip(rows, usual, strict=True):
            fields = split_row(self._rows[row], self._dialect.delimiter)
            spelling = tuple(fields[column] for column in axes)
            if spelling != words:
                odd[row] = spelling
        return odd

    def _line_number(self, row: int) -> int:
        """Return the number of a row's line in the file, counted from 1."""
        numbers = (
            number
            for number, line in enumerate(self._lines, 1)
            if number > self._dialect.first_row
            and self._dialect.is_row(line)
            and not (self.counts and is_count(line))
        )
        return next(number for position, number in enumerate(numbers) if position == row)


def columns_in_words(count: int) -> str:
    """Say how many columns there are."""
    return f"{count} column" if count == 1 else f"{count} columns"


def _with_point(token: str) -> str:
    """Spell a number that has a decimal comma with a point; ValueError if it has a point too."""
    if _POINT.search(token):
        raise ValueError("decimal point")
    return token.replace(",", ".")


def _is_read(token: str, read: Callable[[str], str]) -> bool:
    try:
        return is_value(read(token))
    except ValueError:
        return False


def _with_points(words: Words) -> Words | None:
    """Spell a column with decimal points; None unless it has commas, and numbers alone."""
    tokens = words.tolist()
    if not any("," in token for token in tokens) or any("." in token for token in tokens):
        return None
    plain = [token.replace(",", ".") for token in tokens]
    return np.array(plain, np.str_) if all(map(is_value, plain)) else None
