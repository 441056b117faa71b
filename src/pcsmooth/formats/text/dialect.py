"""The dialect of a text file of points: delimiter, header, count line, comments."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

from pcsmooth.formats.axis_names import named_axes
from pcsmooth.formats.number_text import is_missing, is_number, is_value, is_whole
from pcsmooth.formats.text.lines import TextLines

WHITESPACE = " "
"""The delimiter that stands for any run of spaces and tabs."""

COMMA_BLANK = ", "
"""The delimiter of numbers that have decimal commas themselves."""

_DECIMAL_COMMA = "[+-]?[0-9]+(?:,[0-9]+(?:e[+-]?[0-9]+)?|e[+-]?[0-9]+)"
_COMMA_BLANK_ROW = re.compile(f"(?=.*[0-9],[0-9]){_DECIMAL_COMMA}(?:, +{_DECIMAL_COMMA})+")

_STATED = re.compile(r"sep=([;,\t]) *", re.IGNORECASE)
"""How the first line states the delimiter to Excel."""

_MARKS = ("#", "//", "%", "!")
_COMMENT = re.compile(r"\s*(//+|#+|%+|!+|;+)\s*")
_FIRST_WORD = re.compile(r"\s*([^\s,;]*)")
_APART = re.compile(r"(?://+|#+)\s")
"""The mark of a comment with a blank behind it, as no name begins."""

_ANY_DELIMITER = re.compile(r"[\s,;]+")
_SPACED_LABEL = re.compile(r"[^\s,;]+(?:[ \t]+[\[(][^\])]{0,20}[\])])?")

_AMBIGUOUS_MARKS = ("%", "!", ";")
"""Marks of comments that words in rows begin with too."""

_LONGEST_TITLE = 10
"""Lines of words above a header that are looked at."""

_FIRST_FIELDS = 100
"""Fields that are enough to know a delimiter by."""


@dataclass(frozen=True)
class Dialect:
    """How the rows of one file are to be read.

    Attributes
    ----------
    delimiter : str
        ``","``, ``";"``, a tab, `COMMA_BLANK`, or `WHITESPACE`.
    labels : tuple of str
        Column names as spelled in the header; empty if there is none.
    header_mark : str
        What stands before the header: ``""``, or the mark of a comment such as ``"//"``.
    count : int or None
        Number of points that a count line promises.
    first_row : int
        Index of the line where the rows begin.
    n_columns : int
        Columns of a row, without the word ``fixed`` and an empty one behind the last delimiter;
        0 if there is no row.
    header_line : int or None
        Index of the line that holds the header.
    titles : tuple of int
        Indices of the lines above that are words of another number than there are columns.
    marks : tuple of str
        What comments begin with.
    begins_with_name : bool
        Whether the header names the first column, and not as a coordinate.
    """

    delimiter: str
    labels: tuple[str, ...]
    header_mark: str
    count: int | None
    first_row: int
    n_columns: int
    header_line: int | None
    titles: tuple[int, ...]
    marks: tuple[str, ...]
    begins_with_name: bool

    def is_row(self, line: str) -> bool:
        """Whether a line, from the first row on, is one, and no comment and not blank."""
        if not line.lstrip().startswith(self.marks) or not is_comment(line, self.marks):
            return bool(line.strip())
        return self.resembles_row(line)

    def resembles_row(self, comment: str) -> bool:
        """Whether what begins as a comment is a row of words and numbers, such as ``%1,2.5,3.5``.

        With ``#`` and ``//``, of which comments are sure, only if the first column may hold words.
        """
        fields = split_row(comment, self.delimiter)
        if not self._fits(fields):
            return False
        is_spaced = self.delimiter == WHITESPACE
        if comment.lstrip().startswith(_AMBIGUOUS_MARKS):
            return not (is_spaced and fields[0] in _AMBIGUOUS_MARKS)
        return (
            self.begins_with_name
            and not _APART.match(fields[0])
            and not (is_spaced and is_value(comment_text(fields[0])))
        )

    def may_be_row(self, comment: str) -> bool:
        """Whether a comment below the first row may have been meant as one."""
        return comment.lstrip().startswith(_AMBIGUOUS_MARKS) or self._fits(
            split_row(comment_text(comment), self.delimiter)
        )

    def _fits(self, fields: Sequence[str]) -> bool:
        """Whether there are as many fields as in a row, and numbers behind the first."""
        return any(may_be_number(plain_name(field)) for field in fields[1:]) and (
            self.n_columns in _widths(fields)
        )


def detect_dialect(lines: TextLines) -> Dialect:
    """Find out how a text file is written from the lines up to its first row.

    Parameters
    ----------
    lines : TextLines
        The lines of the file.

    Returns
    -------
    Dialect
        The dialect; whether every row keeps to it is for the reader to check.
    """
    marks = _comment_marks(lines)
    first = next(iter(lines))
    stated = _STATED.fullmatch(first)
    if stated:
        marks = (*marks, first)
    comments: list[tuple[int, str]] = []
    titles: list[int] = []
    plain_header: int | None = None
    header = row = ""
    count: int | None = None
    first_row = len(lines)
    for index, line in enumerate(lines):
        if is_comment(line, marks):
            comments.append((index, line))
        elif not line.strip():
            continue
        elif count is None and is_count(line) and _rows_follow(lines, index, marks):
            count = int(line)
        elif plain_header is None and count is None and _names_columns(line):
            if _is_title(line, islice(lines, index + 1, index + 1 + _LONGEST_TITLE), marks):
                titles.append(index)
            else:
                plain_header, header = index, line
        else:
            first_row, row = index, line
            break

    found = _delimiter(row, header) if row else _delimiter(header, "")
    delimiter = stated[1] if stated else found
    width = _width(_rows(lines, first_row, marks), delimiter)
    header_line, mark = plain_header, ""
    labels = _labels(header, delimiter)
    if not labels:
        header_line = None
        delimiter = delimiter if row else WHITESPACE
        widths = {width, *_widths(split_row(row, delimiter))} if row else None
        for index, line in comments:
            text = comment_text(line)
            names = _labels(text, delimiter)
            if (widths is None or len(names) in widths) and _names_axes(names):
                header_line, labels = index, names
                mark = line[: line.index(text)].lstrip()
    if labels and not labels[-1] and len(labels) == width + 1:
        labels = labels[:-1]
    if width > 2 and not any(labels[width - 1 :]):
        width = _used_width(_rows(lines, first_row, marks), delimiter, width)
        width = max(2, width, *(rank for rank, label in enumerate(labels, 1) if label))
        labels = labels[:width]
    dialect = Dialect(
        delimiter=delimiter,
        labels=labels,
        header_mark=mark,
        count=count,
        first_row=first_row,
        n_columns=len(labels) or width,
        header_line=header_line,
        titles=tuple(titles),
        marks=marks,
        begins_with_name=bool(labels) and not _names_first_axis(labels),
    )
    if header_line is None:
        return dialect
    below = (each for each in comments if each[0] > header_line)
    first_row = next((index for index, line in below if dialect.resembles_row(line)), first_row)
    return replace(dialect, first_row=first_row)


def split_row(line: str, delimiter: str) -> list[str]:
    """Split a line into its fields; one that is quoted as a whole may hold the delimiter.

    Examples
    --------
    >>> split_row('1, 2,"a, b"', ","), split_row('1,5",7', ",")
    (['1', '2', '"a, b"'], ['1', '5"', '7'])
    """
    if delimiter == WHITESPACE:
        return line.split()
    if '"' not in line:
        return [field.strip() for field in line.split(delimiter)]
    field = re.compile(f' *"(?:[^"]|"")*+" *(?={delimiter}|$)|(?:(?!{delimiter}).)*+')
    fields, start = [], 0
    while start <= len(line):
        found = field.match(line, start)
        assert found is not None  # a field may be empty
        fields.append(found[0].strip())
        start = found.end() + len(delimiter)
    return fields


def is_comment(line: str, marks: tuple[str, ...]) -> bool:
    """Whether a line begins with the mark of a comment."""
    if not line.lstrip().startswith(marks):
        return False
    word = _FIRST_WORD.match(line)
    # An error in the cell of a spreadsheet, such as #N/A, is no comment.
    return word is None or not word[1].startswith("#") or not is_missing(word[1])


def is_count(line: str) -> bool:
    """Whether a line is a whole number and nothing else."""
    return is_whole(line.strip(" \t"))


def comment_text(line: str) -> str:
    """Strip a comment of its mark."""
    return _COMMENT.sub("", line, count=1).rstrip()


def is_fixed(token: str) -> bool:
    """Whether a token is the word that marks a fixed point."""
    return token.lower() == "fixed"


def plain_name(label: str) -> str:
    """Strip a label of its quotes."""
    return label.strip('" ')


def may_be_number(field: str) -> bool:
    """Whether a field is a number, with a point or a comma, or stands for a missing one."""
    return is_value(field) or is_value(field.replace(",", ".", 1))


def _comment_marks(lines: Iterable[str]) -> tuple[str, ...]:
    """Find the marks of comments; a semicolon is one in files that have it nowhere else."""
    with_semicolon = (*_MARKS, ";")
    found = (line.lstrip() for line in lines if ";" in line)
    return with_semicolon if all(line.startswith(with_semicolon) for line in found) else _MARKS


def _rows_follow(lines: Iterable[str], index: int, marks: tuple[str, ...]) -> bool:
    """Whether the next row after a lone whole number has two or more columns, or is missing."""
    for line in islice(lines, index + 1, None):
        if line.strip() and not is_comment(line, marks):
            return len(_ANY_DELIMITER.split(line.strip())) > 1
    return True


def _names_columns(line: str) -> bool:
    """Whether a line is a header: it names axes, more than numbers, or holds no number at all."""
    names = _words(line)
    if {"x", "y"} <= {name.lower() for name in names}:
        return True
    n_numbers = sum(map(is_number, names))
    if n_numbers == 0 and not any(name and is_missing(name) for name in names):
        return True
    # A row may have the letters of its hemispheres: 51.9 N 7.6 E.
    return n_numbers < len(named_axes(names).candidates)


def _is_title(title: str, below: Iterable[str], marks: tuple[str, ...]) -> bool:
    """Whether words name no columns: they are more or fewer than those of the next header or row.

    Words that are names of coordinates are never a title.
    """
    words = _words(title)
    if not any(words) or _names_axes(words):
        return False
    for line in below:
        if not line.strip() or is_comment(line, marks) or is_count(line):
            continue
        if not _names_columns(line) or _names_axes(_words(line)):
            delimiter = _delimiter(line, title if len(words) > 1 else "")
            fields = _widths(split_row(line, delimiter))
            return not {*fields}.intersection(_widths(_labels(title, delimiter)))
    return False


def _words(line: str) -> list[str]:
    """Split a line wherever it may be split, without quotes."""
    return [plain_name(word) for word in _ANY_DELIMITER.split(line.strip())]


def _names_axes(labels: Iterable[str]) -> bool:
    return bool(named_axes([plain_name(label) for label in labels]).candidates)


def _names_first_axis(labels: Iterable[str]) -> bool:
    return any(0 in columns for columns in named_axes(list(map(plain_name, labels))).candidates)


def _labels(header: str, delimiter: str) -> tuple[str, ...]:
    if not header.strip():
        return ()
    if delimiter == WHITESPACE:
        return tuple(_SPACED_LABEL.findall(header))
    if delimiter not in header:
        return tuple(filter(None, _ANY_DELIMITER.split(header.strip())))
    labels = tuple(split_row(header.rstrip(" "), delimiter))
    return labels if any(labels) else ()


def _rows(lines: Iterable[str], first: int, marks: tuple[str, ...]) -> Iterator[str]:
    return (
        line for line in islice(lines, first, None) if line.strip() and not is_comment(line, marks)
    )


def _width(rows: Iterable[str], delimiter: str) -> int:
    """Columns of the first row that does not end in ``fixed``, or of a row before that word."""
    width = 0
    for row in rows:
        fields = split_row(row, delimiter)
        if not is_fixed(fields[-1]):
            return len(fields)
        width = len(fields) - 1
    return width


def _widths(fields: Sequence[str]) -> tuple[int, ...]:
    """Count the columns of a row, and without its last field if that may be none."""
    more = not fields[-1] or is_fixed(fields[-1])
    return (len(fields), len(fields) - 1) if more else (len(fields),)


def _used_width(rows: Iterable[str], delimiter: str, width: int) -> int:
    """Columns without those at the end that are empty in all rows; all, if a row ends in none."""
    used = 0
    for row in rows:
        fields = split_row(row, delimiter)
        if fields[-1]:
            return width
        used = max(used, *(rank for rank, field in enumerate(fields, 1) if field), 0)
    return used


def _delimiter(row: str, header: str) -> str:
    """First delimiter that makes the first two fields numbers, in files of such a header.

    A comma and a blank are it where they part nothing but numbers with decimal commas. If none
    does, missing numbers and decimal commas are taken for numbers too; and if that does not help,
    the one that makes most fields numbers is taken.
    """
    candidates = [*(mark for mark in ";\t," if mark in row), WHITESPACE]
    if _COMMA_BLANK_ROW.fullmatch(row.strip()):
        candidates.append(COMMA_BLANK)
    if header:
        fitting = [
            candidate
            for candidate in candidates
            if len(_labels(header, candidate)) in _widths(split_row(row, candidate))
        ]
        candidates = fitting or candidates
    if COMMA_BLANK in candidates:
        return COMMA_BLANK
    for accepts in (is_number, may_be_number):
        for candidate in candidates:
            start = [plain_name(field) for field in split_row(row, candidate)[:2]]
            if len(start) == 2 and all(map(accepts, start)):
                return candidate
    return max(
        candidates,
        key=lambda candidate: sum(
            bool(field) and may_be_number(plain_name(field))
            for field in split_row(row, candidate)[:_FIRST_FIELDS]
        ),
    )
