"""The dialect of a text file of points: delimiter, header, count line, comments."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from pcsmooth.formats.number_text import is_number

WHITESPACE = " "
"""The delimiter that stands for any run of spaces and tabs."""

_COMMENT = re.compile(r"\s*(//+|#+)\s*")
_COUNT = re.compile(r"[ \t]*[0-9]{1,18}[ \t]*")
_ANY_DELIMITER = re.compile(r"[\s,;]+")


@dataclass(frozen=True)
class Dialect:
    """How the rows of one file are to be read.

    Attributes
    ----------
    delimiter : str
        ``","``, ``";"``, a tab, or `WHITESPACE`.
    labels : tuple of str
        Column names as spelled in the header; empty if there is none.
    header_mark : str
        What stands before the header: ``""``, or the mark of a comment such as ``"//"``.
    count : int or None
        Number of points that a count line promises.
    first_row : int
        Index of the line where the rows begin.
    n_columns : int
        Columns of a row, without the word ``fixed``; 0 if there is no row.
    header_line : int or None
        Index of the line that holds the header.
    """

    delimiter: str
    labels: tuple[str, ...]
    header_mark: str
    count: int | None
    first_row: int
    n_columns: int
    header_line: int | None


def detect_dialect(lines: Sequence[str]) -> Dialect:
    """Find out how a text file is written from the lines up to its first row.

    Parameters
    ----------
    lines : sequence of str
        The lines of the file.

    Returns
    -------
    Dialect
        The dialect; whether every row keeps to it is for the reader to check.
    """
    comments: list[int] = []
    plain_header: int | None = None
    count: int | None = None
    first_row = len(lines)
    for index, line in enumerate(lines):
        if is_comment(line):
            comments.append(index)
        elif not line.strip():
            continue
        elif count is None and _COUNT.fullmatch(line) and _rows_follow(lines, index):
            count = int(line)
        elif plain_header is None and count is None and _names_columns(line):
            plain_header = index
        else:
            first_row = index
            break

    row = lines[first_row] if first_row < len(lines) else ""
    delimiter = _delimiter(row or ("" if plain_header is None else lines[plain_header]))
    width = _width(lines[first_row:], delimiter)
    header_line, mark = plain_header, ""
    labels = _labels("" if plain_header is None else lines[plain_header], delimiter)
    if not labels:
        header_line = None
        widths = {width, len(split_row(row, delimiter))}
        for index in comments:
            text = comment_text(lines[index])
            names = _labels(text, delimiter)
            if _has_xy(names) and (not row or len(names) in widths):
                header_line, labels = index, names
                mark = lines[index][: lines[index].index(text)].lstrip()
    return Dialect(
        delimiter=delimiter,
        labels=labels,
        header_mark=mark,
        count=count,
        first_row=first_row,
        n_columns=len(labels) or width,
        header_line=header_line,
    )


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
    field = re.compile(f' *"(?:[^"]|"")*+" *(?={delimiter}|$)|[^{delimiter}]*')
    fields, start = [], 0
    while start <= len(line):
        found = field.match(line, start)
        assert found is not None  # a field may be empty
        fields.append(found[0].strip())
        start = found.end() + 1
    return fields


def is_comment(line: str) -> bool:
    """Whether a line begins with ``#`` or ``//``."""
    return line.lstrip().startswith(("#", "//"))


def comment_text(line: str) -> str:
    """Strip a comment of its mark."""
    return _COMMENT.sub("", line, count=1).rstrip()


def is_fixed(token: str) -> bool:
    """Whether a token is the word that marks a fixed point."""
    return token.lower() == "fixed"


def plain_name(label: str) -> str:
    """Strip a label of its quotes."""
    return label.strip('" ')


def _rows_follow(lines: Sequence[str], index: int) -> bool:
    """Whether the next row after a lone whole number has two or more columns, or is missing."""
    for line in lines[index + 1 :]:
        if line.strip() and not is_comment(line):
            return len(_ANY_DELIMITER.split(line.strip())) > 1
    return True


def _names_columns(line: str) -> bool:
    """Whether a line is a header: it names x and y, or holds no number at all."""
    names = _ANY_DELIMITER.split(line.strip())
    return _has_xy(names) or not any(is_number(plain_name(name)) for name in names)


def _has_xy(labels: Iterable[str]) -> bool:
    return {"x", "y"} <= {plain_name(label).lower() for label in labels}


def _labels(header: str, delimiter: str) -> tuple[str, ...]:
    if delimiter == WHITESPACE or not header.strip():
        return tuple(filter(None, _ANY_DELIMITER.split(header.strip())))
    return tuple(split_row(header.rstrip(), delimiter))


def _width(lines: Iterable[str], delimiter: str) -> int:
    """Columns of the first row that does not end in ``fixed``, or of a row before that word."""
    width = 0
    for line in lines:
        if not line.strip() or is_comment(line):
            continue
        fields = split_row(line, delimiter)
        if not is_fixed(fields[-1]):
            return len(fields)
        width = len(fields) - 1
    return width


def _delimiter(row: str) -> str:
    """First delimiter that makes the first two fields numbers; failing that, the first found."""
    candidates = [mark for mark in ";\t," if mark in row]
    for candidate in (*candidates, WHITESPACE):
        start = [plain_name(field) for field in split_row(row, candidate)[:2]]
        if len(start) == 2 and all(map(is_number, start)):
            return candidate
    return candidates[0] if candidates else WHITESPACE
