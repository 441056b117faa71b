"""Read points from text, in the dialects that people write."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import NORMALS, PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import ROWS_AT_A_TIME, is_number, parsed
from pcsmooth.formats.text_dialect import (
    WHITESPACE,
    Dialect,
    comment_text,
    detect_dialect,
    is_comment,
    is_fixed,
    plain_name,
    split_row,
)
from pcsmooth.formats.text_layout import TextLayout

_UNIT_TOLERANCE = 1e-3
"""How far from 1 the length of a vector may be that is still taken for a normal."""

_BYTES_PER_CHARACTER = 4
_BYTES_PER_COLUMN = 1 << 10
_LARGEST_GROWTH = 16
_SMALL = 16 << 20
"""Columns of words may take so many bytes, and so many times the characters of the file."""

Numbers = npt.NDArray[np.float64]
Words = npt.NDArray[np.str_]


def read_text(data: bytes, path: str, dim: int | None, format_name: str) -> PointCloud:
    """Read a text file of points.

    Parameters
    ----------
    data : bytes
        The whole file.
    path : str
        Name of the file in errors.
    dim : {2, 3} or None
        Number of coordinates; None decides by format, header and number of columns.
    format_name : str
        One of ``xyz``, ``xy``, ``txt``, ``asc``, ``csv``, ``pts``.

    Returns
    -------
    PointCloud
        Row i is row i of the file, comments and blank lines not counted.

    Raises
    ------
    CloudFileError
        Not text, a row with too few or too many columns, a coordinate that is not a number, or
        fewer rows than the count line promises.
    """
    text = _decoded(data, path)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    dialect = detect_dialect(lines)
    rows = _Rows(lines, dialect, path)
    if dialect.count is not None and dialect.count != len(rows):
        raise CloudFileError(
            path,
            f"its count line promises {dialect.count} points, but {len(rows)} rows follow",
            "get the whole file again, or correct the count",
        )
    axes = _axes(dialect, format_name, dim, path)
    points, words, marks = rows.parsed(axes, may_be_fixed="fixed" in text.lower())
    names = _names(dialect, axes)
    d = len(axes)
    if not dialect.labels:
        # Right behind the positions, or, as pcsmooth appends them, at the end of the row.
        for first in (0, len(words) - d) if len(words) >= d else ():
            if _are_normals(words[first : first + d]):
                names[d + first : 2 * d + first] = NORMALS[:d]
                break

    above = [index for index in range(dialect.first_row) if index != dialect.header_line]
    comments = _comments(lines[index] for index in above)
    comments_below = _comments(lines[dialect.first_row :])
    others = [name for column, name in enumerate(names) if column not in axes]
    return PointCloud(
        points=points,
        columns=dict(zip(others, words, strict=True)),
        comments=tuple(comment for comment, _ in comments + comments_below),
        fixed_marks=marks,
        layout=TextLayout(
            format=format_name,
            delimiter=dialect.delimiter,
            names=tuple(names),
            labels=dialect.labels,
            header_mark=dialect.header_mark,
            counted=dialect.count is not None,
            comments=comments,
            comments_below=comments_below,
        ),
    )


class _Rows:
    """The lines of a file that hold points."""

    def __init__(self, lines: Sequence[str], dialect: Dialect, path: str) -> None:
        self._lines = lines
        self._dialect = dialect
        self._path = path
        self._rows = [
            line
            for line in lines[dialect.first_row :]
            if (start := line.lstrip()) and not start.startswith(("#", "//"))
        ]

        self._largest = _LARGEST_GROWTH * sum(map(len, self._rows)) + _SMALL

    def __len__(self) -> int:
        return len(self._rows)

    def parsed(
        self, axes: Sequence[int], *, may_be_fixed: bool
    ) -> tuple[Numbers, list[Words], npt.NDArray[np.bool_] | None]:
        """Positions, the other columns, and the marks of the rows that end in ``fixed``."""
        n_columns = self._dialect.n_columns
        if len(axes) == n_columns and not may_be_fixed and self._rows:
            points = self._numbers_only()
            if points is not None:
                return np.ascontiguousarray(points[:, list(axes)]), [], None

        points = np.empty((len(self), len(axes)))
        others: list[list[Words]] = [[] for _ in range(n_columns - len(axes))]
        longest = [0] * len(others)
        marks = np.zeros(len(self), np.bool_)
        for start in range(0, len(self), ROWS_AT_A_TIME):
            fields = [
                split_row(row, self._dialect.delimiter)
                for row in self._rows[start : start + ROWS_AT_A_TIME]
            ]
            if may_be_fixed:
                for row in self._take_marks(fields):
                    marks[start + row] = True
            self._check_widths(fields, start)
            columns = list(zip(*fields, strict=True))
            for axis, column in enumerate(axes):
                points[start : start + len(fields), axis] = self._parsed_axis(
                    columns[column], start
                )
            rest = [tokens for column, tokens in enumerate(columns) if column not in axes]
            for column, tokens in enumerate(rest):
                longest[column] = max(longest[column], max(map(len, tokens)))
            self._check_size(longest)
            for chunks, tokens in zip(others, rest, strict=True):
                chunks.append(np.array(tokens, np.str_))
        words = [np.concatenate(chunks) if chunks else np.empty(0, np.str_) for chunks in others]
        return points, words, marks if marks.any() else None

    def _numbers_only(self) -> Numbers | None:
        """All rows by NumPy's own parser, or None if it finds anything but plain numbers."""
        delimiter = self._dialect.delimiter
        try:
            table = np.loadtxt(
                (row for row in self._rows),  # between two of a generator's, Ctrl-C is heard
                delimiter=None if delimiter == WHITESPACE else delimiter,
                comments=None,
                ndmin=2,
            )
        except ValueError:
            return None
        return table if table.shape[1] == self._dialect.n_columns else None

    def _take_marks(self, fields: list[list[str]]) -> Iterator[int]:
        width = self._dialect.n_columns
        for row, tokens in enumerate(fields):
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
            f"line {self._line_number(start + row)} has {_columns(len(fields[row]))}, "
            f"expected {expected}",
            "give every row the same columns",
        )

    def _check_size(self, longest: Sequence[int]) -> None:
        """Refuse what takes far more memory than the file: every word takes the longest's place."""
        size = _BYTES_PER_CHARACTER * len(self) * sum(longest) + _BYTES_PER_COLUMN * len(longest)
        if size > self._largest:
            raise CloudFileError(
                self._path,
                f"{_columns(len(longest))} of words of up to {max(longest)} characters are too "
                f"much for {len(self)} rows",
                "remove columns or shorten words",
            )

    def _parsed_axis(self, tokens: Sequence[str], start: int) -> Numbers:
        try:
            return parsed(tokens)
        except ValueError as error:
            row, token = next(
                (row, token) for row, token in enumerate(tokens) if not is_number(token)
            )
            number = self._line_number(start + row)
            raise CloudFileError(
                self._path,
                f"line {number}: '{excerpt(token)}' is not a number",
                "write decimals with a point"
                if re.search(r"\d,\d", self._rows[start + row])
                else "correct or remove the line",
            ) from error

    def _line_number(self, row: int) -> int:
        """Return the number of a row's line in the file, counted from 1."""
        numbers = (
            index + 1
            for index in range(self._dialect.first_row, len(self._lines))
            if self._lines[index].strip() and not is_comment(self._lines[index])
        )
        return next(number for position, number in enumerate(numbers) if position == row)


def _decoded(data: bytes, path: str) -> str:
    """Decode a file; the mark that begins it, or what was appended to it, becomes a space."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise CloudFileError(path, "it is UTF-16 text", "save it as UTF-8")
    try:
        text = data.decode().replace("\ufeff", " ")
    except UnicodeDecodeError as error:
        raise _not_a_cloud(path) from error
    if "\0" in text:
        raise _not_a_cloud(path)
    return text


def _not_a_cloud(path: str) -> CloudFileError:
    return CloudFileError(
        path, "not a point cloud: neither PLY nor text", "convert it to .ply, .xyz or .csv"
    )


def _comments(lines: Iterable[str]) -> tuple[tuple[str, str], ...]:
    return tuple((comment_text(line), line.rstrip()) for line in lines if is_comment(line))


def _axes(dialect: Dialect, format_name: str, dim: int | None, path: str) -> list[int]:
    """Which columns hold x, y and, in 3D, z."""
    columns = dialect.n_columns
    names = [plain_name(label).lower() for label in dialect.labels]
    found = [names.index(name) for name in "xyz" if name in names]
    named = "x" in names and "y" in names
    if dim is None:
        flat = format_name == "xy" or columns == 2 or (named and len(found) == 2)
        dim = 2 if flat else 3
    if columns == 0:
        return list(range(dim))
    available = len(found) if named else columns
    if columns < 2:
        raise CloudFileError(
            path,
            f"its rows have {_columns(columns)}, a point needs at least 2",
            "check that the file holds points",
        )
    if available < dim:
        raise CloudFileError(
            path, f"its points have {available} coordinates, not {dim}", "read it as a 2D cloud"
        )
    return found[:dim] if named else list(range(dim))


def _names(dialect: Dialect, axes: Sequence[int]) -> list[str]:
    """Name every column, each differently; positions and normals in lower case."""
    names: dict[str, None] = {}
    for column in range(max(dialect.n_columns, len(axes))):
        name = plain_name(dialect.labels[column]) if dialect.labels else ""
        if name.lower() in ("x", "y", "z", *NORMALS):
            name = name.lower()
        if column in axes:
            name = "xyz"[axes.index(column)]
        if not name or name in names:
            name = f"column_{column + 1}"
        while name in names:
            name += "_"
        names[name] = None
    return list(names)


def _are_normals(words: Sequence[Words]) -> bool:
    """Whether columns hold the coordinates of unit vectors; zero vectors are let pass."""
    if not len(words[0]):
        return False
    # A few rows are enough to say no.
    return _are_unit(words, 100) and _are_unit(words, len(words[0]))


def _are_unit(words: Sequence[Words], n_rows: int) -> bool:
    try:
        vectors = np.stack([parsed(column[:n_rows].tolist()) for column in words], axis=1)
    except ValueError:
        return False
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(vectors[np.isfinite(vectors).all(axis=1)], axis=1)
    unit = np.abs(lengths - 1) <= _UNIT_TOLERANCE
    return bool(np.all(unit | (lengths == 0)) and unit.any())


def _columns(count: int) -> str:
    return f"{count} column" if count == 1 else f"{count} columns"
