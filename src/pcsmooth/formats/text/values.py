"""What the rows of a text file hold: positions, and every other column in words."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import ROWS_AT_A_TIME, is_value, parsed, spelled
from pcsmooth.formats.text.dialect import WHITESPACE, is_fixed, may_be_number, split_row
from pcsmooth.formats.text.encoding import readable
from pcsmooth.formats.text.rows import TextRows, columns_in_words

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
    """What some rows hold.

    Attributes
    ----------
    points : ndarray, shape (n, d)
        Positions.
    others : tuple of ndarray of str, each of shape (n,)
        The other columns.
    marks : ndarray of bool, shape (n,)
        Rows that end in ``fixed``.
    odd_rows : dict of int to tuple of str
        Coordinates of the rows that are not finite as they are spelled, unless as usual.
    """

    points: Numbers
    others: tuple[Words, ...]
    marks: npt.NDArray[np.bool_]
    odd_rows: dict[int, tuple[str, ...]] = field(default_factory=dict)


class RowValues:
    """The values of the rows of a file.

    Parameters
    ----------
    rows : TextRows
        All rows.
    axes : sequence of int
        Columns of the coordinates.
    path : str
        Name of the file in errors.

    Raises
    ------
    CloudFileError
        A number in a coordinate's place may have commas between thousands.
    """

    def __init__(self, rows: TextRows, axes: Sequence[int], path: str) -> None:
        self._all, self._axes, self._path = rows, axes, path
        self._delimiter, self._width = rows.dialect.delimiter, rows.dialect.n_columns
        self.n_others = max(self._width - len(axes), 0)
        self._largest = _LARGEST_GROWTH * rows.n_characters + _SMALL
        # A decimal comma stands between no columns, or is quoted.
        quoted = '" *[+-]?[0-9]+,'
        self._with_commas = rows.chosen(
            re.compile(quoted if self._delimiter == "," else ",").search
        )
        self._axes_have_commas = self._hold(",", self._with_commas)
        thousands = self._thousands()
        if thousands is not None:
            if self._axes_have_commas:
                raise CloudFileError(
                    path,
                    f"the commas in numbers such as {excerpt(thousands)} may part thousands",
                    "write numbers without them, and decimals with a point",
                )
            self._with_commas = ()

    def parsed(self, at_a_time: int, words: bool = True) -> Iterator[ParsedRows]:
        """Read positions from some columns, words from the others, and which rows are fixed.

        Parameters
        ----------
        at_a_time : int
            How many rows are read at a time.
        words : bool
            Whether the words are wanted.

        Raises
        ------
        CloudFileError
            A row has too few or too many columns, a coordinate is not a number, or words would
            take far more memory than the file.
        """
        rows = iter(self._all)
        first = 0
        while part := list(islice(rows, at_a_time)):
            yield self._parsed(part, first, words)
            first += len(part)

    @cached_property
    def nothing(self) -> ParsedRows:
        """What no rows hold."""
        nothing = np.empty(0, np.str_)
        points = np.empty((0, len(self._axes)))
        return ParsedRows(points, (nothing,) * self.n_others, np.zeros(0, np.bool_))

    def comma_columns(self, parts: Iterable[ParsedRows]) -> list[bool]:
        """Which of the other columns have decimal commas, and are to be spelled with points.

        They are looked for only where there may be some; they hold nothing but numbers, of which
        none has a point.

        Parameters
        ----------
        parts : iterable of ParsedRows
            All rows; iterated only if need be.
        """
        are_numbers, have_commas = [True] * self.n_others, [False] * self.n_others
        if self._axes_have_commas or (
            any(True for _ in self._with_commas) and not self._hold(".", self._all)
        ):
            for part in parts:
                for column, words in enumerate(part.others):
                    if are_numbers[column]:
                        tokens = words.tolist()
                        have_commas[column] |= any("," in token for token in tokens)
                        are_numbers[column] = not any("." in token for token in tokens) and all(
                            is_value(token.replace(",", ".")) for token in tokens
                        )
        return [a and b for a, b in zip(are_numbers, have_commas, strict=True)]

    def have_commas(self, comma_columns: Iterable[bool]) -> bool:
        """Whether decimals of positions have commas, or those of others beside whole numbers."""
        return self._axes_have_commas or any(comma_columns)

    def _parsed(self, rows: Sequence[str], first: int, words: bool) -> ParsedRows:
        table = self._numbers_only(rows) if len(self._axes) == self._width else None
        if table is not None:
            points = np.ascontiguousarray(table[:, list(self._axes)])
            found = ParsedRows(points, (), np.zeros(len(rows), np.bool_))
        else:
            found = self._words(rows, first, words)
        return replace(found, odd_rows=self._odd_rows(rows, found.points))

    def _thousands(self) -> str | None:
        """Last number with a comma, if the commas of all in quotes may part thousands."""
        if self._delimiter != ",":
            return None
        last = None
        for row in self._with_commas:
            for token in split_row(row, ","):
                if "," in token and _QUOTED_NUMBER.fullmatch(token):
                    if not _THOUSANDS.fullmatch(token):
                        return None
                    last = token
        return last

    def _hold(self, sign: str, rows: Iterable[str]) -> bool:
        """Whether coordinates of these rows have a sign in them."""
        return any(
            sign in field
            for row in rows
            for column, field in enumerate(split_row(row, self._delimiter))
            if column in self._axes
        )

    def _numbers_only(self, rows: Sequence[str]) -> Numbers | None:
        """Rows by NumPy's own parser, or None if it finds anything but plain numbers."""
        if self._axes_have_commas:
            if "," in self._delimiter or any("." in row for row in rows):
                return None
            rows = [row.replace(",", ".") for row in rows]
        try:
            table = np.loadtxt(
                (row for row in rows),  # between two of a generator's, Ctrl-C is heard
                delimiter=None if self._delimiter == WHITESPACE else self._delimiter,
                comments=None,
                ndmin=2,
            )
        except ValueError:
            return None
        return table if table.shape[1] == self._width else None

    def _words(self, rows: Sequence[str], first: int, words: bool) -> ParsedRows:
        """Positions, the other columns as they are spelled, and marks of fixed rows."""
        points = np.empty((len(rows), len(self._axes)))
        others: list[list[Words]] = [[] for _ in range(self.n_others)]
        longest = [0] * self.n_others
        marks = np.zeros(len(rows), np.bool_)
        for start in range(0, len(rows), ROWS_AT_A_TIME):
            fields = [
                split_row(row, self._delimiter) for row in rows[start : start + ROWS_AT_A_TIME]
            ]
            for row in self._trim(fields):
                marks[start + row] = True
            self._check_widths(fields, first + start)
            columns = list(zip(*fields, strict=True))
            for axis, column in enumerate(self._axes):
                points[start : start + len(fields), axis] = self._parsed_axis(
                    columns[column], first + start
                )
            if not words:
                continue
            rest = [tokens for column, tokens in enumerate(columns) if column not in self._axes]
            for column, tokens in enumerate(rest):
                longest[column] = max(longest[column], max(map(len, tokens)))
            self._check_size(longest)
            for chunks, tokens in zip(others, rest, strict=True):
                chunks.append(np.array(tokens, np.str_))
        return ParsedRows(points, tuple(map(np.concatenate, others)) if words else (), marks)

    def _trim(self, fields: list[list[str]]) -> Iterator[int]:
        """Take what is no column from the ends of rows; gives those that ended in ``fixed``."""
        width = self._width
        for row, tokens in enumerate(fields):
            while len(tokens) > width and not tokens[-1]:
                tokens.pop()
            if len(tokens) == width + 1 and is_fixed(tokens[-1]):
                tokens.pop()
                yield row

    def _check_widths(self, fields: list[list[str]], start: int) -> None:
        expected = self._width
        if {len(tokens) for tokens in fields} == {expected}:
            return
        row = next(row for row, tokens in enumerate(fields) if len(tokens) != expected)
        raise CloudFileError(
            self._path,
            f"line {self._all.line_number(start + row)} has {columns_in_words(len(fields[row]))}, "
            f"expected {expected}",
            "give every row the same columns",
        )

    def _check_size(self, longest: Sequence[int]) -> None:
        """Refuse what takes far more memory than the file: every word takes the longest's place.

        That of some rows is judged as if all had words so long, so that a part, too, takes no more
        than its share.
        """
        n_rows = len(self._all)
        size = _BYTES_PER_CHARACTER * n_rows * sum(longest) + _BYTES_PER_COLUMN * len(longest)
        if size > self._largest:
            raise CloudFileError(
                self._path,
                f"{columns_in_words(len(longest))} of words of up to {max(longest)} characters "
                f"are too much for {n_rows} rows",
                "remove columns or shorten words",
            )

    def _parsed_axis(self, tokens: Sequence[str], start: int) -> Numbers:
        read = _with_point if self._axes_have_commas else str
        try:
            return parsed(list(map(read, tokens)) if self._axes_have_commas else tokens)
        except ValueError as error:
            row, token = next(
                (row, token) for row, token in enumerate(tokens) if not _is_read(token, read)
            )
            number = self._all.line_number(start + row)
            raise CloudFileError(
                self._path,
                f"line {number}: '{excerpt(readable(token))}' is not a number",
                "write all decimals alike, with a point or with a comma"
                if may_be_number(token)
                else "correct or remove the line, or choose other columns by --columns X,Y,Z",
            ) from error

    def _odd_rows(self, rows: Sequence[str], points: Numbers) -> dict[int, tuple[str, ...]]:
        """Rows that are not finite, unless they are spelled as they would be written anyway."""
        found = np.flatnonzero(~np.isfinite(points).all(axis=1)).tolist()
        usual = zip(*(spelled(coordinates) for coordinates in points[found].T), strict=True)
        odd: dict[int, tuple[str, ...]] = {}
        for row, words in zip(found, usual, strict=True):
            fields = split_row(rows[row], self._delimiter)
            spelling = tuple(fields[column] for column in self._axes)
            if spelling != words:
                odd[row] = spelling
        return odd


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


def with_points(parsed: ParsedRows, comma_columns: Sequence[bool]) -> ParsedRows:
    """Spell the decimals of some of the other columns with points."""
    if not any(comma_columns):
        return parsed
    others = tuple(
        np.array([word.replace(",", ".") for word in words.tolist()], np.str_) if has else words
        for words, has in zip(parsed.others, comma_columns, strict=False)
    )
    return replace(parsed, others=others)
