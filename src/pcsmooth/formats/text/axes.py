"""Which columns of a text file hold the coordinates, and what all columns are called."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import NORMALS
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.attribute_names import names_attribute
from pcsmooth.formats.axis_names import named_axes, named_normals
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import ROWS_AT_A_TIME, is_whole, parsed
from pcsmooth.formats.text.dialect import Dialect, may_be_number, plain_name
from pcsmooth.formats.text.encoding import readable
from pcsmooth.formats.text.rows import TextRows, columns_in_words

Columns = Sequence[str | int]
"""Columns of coordinates that the user chose: names, or numbers from 1."""

_FEWEST = 3
"""Rows in which numbers that follow one another are no coincidence."""

_LARGEST_LENGTH = 1e8
"""Seconds of GPS and Unix are more, coordinates in metres are not."""

_UNIT_TOLERANCE = 1e-3
"""How far from 1 the length of a vector may be that is still taken for a normal."""

_FEW = 100
"""First rows that tell that columns are no unit vectors."""

_DIGITS = re.compile("[0-9]{1,100}")
"""Digits of a running number; those of timestamps and identifiers may be many."""

_REMEDY = "name those of x, y and z, or of x and y: --columns"


@dataclass(frozen=True)
class TextAxes:
    """Which columns hold the coordinates.

    Attributes
    ----------
    columns : list of int
        Indices of those of x, y and, in 3D, z.
    height : int or None
        Index of z where the cloud is to be plane, if it is known.
    in_degrees : bool
        Whether they are named as longitudes and latitudes.
    """

    columns: list[int]
    height: int | None = None
    in_degrees: bool = False


def chosen_axes(columns: Columns, dialect: Dialect, path: str) -> TextAxes:
    """Find the columns that the user chose.

    Raises
    ------
    CloudFileError
        There is no such column, or one is chosen twice.
    """
    if dialect.n_columns == 0:
        return TextAxes(list(range(len(columns))))
    labels = _plain_labels(dialect)
    found = [_place(column, labels, dialect.n_columns, path) for column in columns]
    for column, place in zip(columns, found, strict=True):
        if found.count(place) > 1:
            raise CloudFileError(
                path, f"'{excerpt(str(column))}' is two coordinates at once", "choose others"
            )
    named = named_axes([labels[place] for place in found[:2]] if labels else [])
    return TextAxes(found, in_degrees=named.in_degrees)


def found_axes(
    dialect: Dialect, rows: TextRows, format_name: str, dim: int | None, path: str
) -> TextAxes:
    """Find the columns of the coordinates by their names, or take the first ones.

    Parameters
    ----------
    dialect : Dialect
        Width and header of the file.
    rows : TextRows
        Its rows.
    format_name : str
        Name of the format; in ``xy`` points are plane.
    dim : {2, 3} or None
        Number of coordinates; None decides by format, header and number of columns.
    path : str
        Name of the file in errors.

    Raises
    ------
    CloudFileError
        There are too few columns, or no telling which of them are coordinates.
    """
    width = dialect.n_columns
    labels = _plain_labels(dialect)
    named = named_axes(labels)
    candidates = named.candidates
    if dim is None:
        dim = 2 if format_name == "xy" or 2 in (width, len(candidates)) else 3
    if width == 0:
        return TextAxes(list(range(dim)))
    if width < 2:
        raise CloudFileError(
            path,
            f"its rows have {columns_in_words(width)}, a point needs at least 2",
            "check that the file holds points",
        )
    if labels and not candidates and len(rows):
        raise CloudFileError(
            path,
            f"its header names no coordinates ({excerpt(', '.join(labels))})",
            f"{_REMEDY} {_likely_columns(labels, dim)}",
        )
    available = len(candidates) if candidates else width
    if available < dim:
        raise CloudFileError(
            path, f"its points have {available} coordinates, not {dim}", "read it as a 2D cloud"
        )
    if not candidates:
        if _begin_with_running_number(rows):
            raise CloudFileError(
                path,
                "its rows begin with a running number, which may be no coordinate",
                f"{_REMEDY} 2,3,4, or --columns 1,2,3 if it is",
            )
        if _begin_with_time(rows):
            raise CloudFileError(
                path,
                "its rows begin with what may be a time, and no coordinate",
                f"{_REMEDY} 2,3,4, or --columns 1,2,3 if it is",
            )
        return TextAxes(list(range(dim)))
    for axis, rivals in zip("xyz", candidates[:dim], strict=False):
        if len(rivals) > 1:
            both = " and ".join(f"'{labels[column]}'" for column in rivals[:2])
            raise CloudFileError(
                path, f"its columns {excerpt(both)} may both be {axis}", f"{_REMEDY} X,Y,Z"
            )
    columns = [rivals[0] for rivals in candidates]
    return TextAxes(columns[:dim], next(iter(columns[dim:]), None), named.in_degrees)


def column_names(dialect: Dialect, axes: TextAxes, unit_vectors: Sequence[int]) -> list[str]:
    """Name every column, each differently; positions and normals in lower case.

    Parameters
    ----------
    dialect : Dialect
        Width and header of the file.
    axes : TextAxes
        Columns of the coordinates.
    unit_vectors : sequence of int
        Columns that hold the coordinates of unit vectors, which are normals where there is no
        header.

    Returns
    -------
    list of str
        A name for each column of the file, and for each coordinate if there are no columns.
    """
    d = len(axes.columns)
    labels = _plain_labels(dialect)
    known = dict(zip(axes.columns, "xyz", strict=False))
    if axes.height is not None:
        known[axes.height] = "z"
    normals = named_normals(labels, d) if labels else unit_vectors
    if known.keys().isdisjoint(normals):
        known.update(zip(normals, NORMALS, strict=False))
    reserved = {*known.values()}
    names: dict[str, None] = {}
    for column in range(max(dialect.n_columns, d)):
        name = labels[column] if labels else ""
        if name.lower() in ("x", "y", "z", *NORMALS):
            name = name.lower()
        if column in known:
            name = known[column]
        elif name in reserved:
            name = f"{name}_{column + 1}"
        elif not name or name in names:
            name = f"column_{column + 1}"
        while name in names:
            name += "_"
        names[name] = None
    return list(names)


def _plain_labels(dialect: Dialect) -> list[str]:
    return [readable(plain_name(label)) for label in dialect.labels]


def _place(wanted: str | int, labels: Sequence[str], n_columns: int, path: str) -> int:
    """Index of a column by its name, spelled in any case if that is clear, or by its number."""
    lowered = [label.lower() for label in labels]
    for name, among in ((str(wanted), labels), (str(wanted).lower(), lowered)):
        if isinstance(wanted, str) and among.count(name) == 1:
            return among.index(name)
    if is_whole(str(wanted)) and 1 <= int(wanted) <= n_columns:
        return int(wanted) - 1
    known = f"{', '.join(labels)}, or a number" if labels else "a number"
    raise CloudFileError(
        path,
        f"there is no column '{excerpt(str(wanted))}', or more than one",
        f"choose {excerpt(known)} from 1 to {n_columns}",
    )


def _likely_columns(labels: Sequence[str], dim: int) -> str:
    """Numbers of the first columns, or of those behind a name or number of the points."""
    # Single letters may be anything.
    is_named = len(labels[0]) > 1 and names_attribute(labels[0])
    first = 2 if is_named and len(labels) > dim else 1
    return ",".join(map(str, range(first, first + dim)))


def _begin_with_running_number(rows: TextRows) -> bool:
    """Whether rows of four numbers or more begin with whole ones that only grow, or only fall.

    Numbers with gaps count only beside others that are not whole; those that are spelled as if
    they were not whole, such as 1.0, count only there and without gaps.
    """
    head = _head_of_four(rows)
    if not head:
        return False
    as_digits = all(_value_of_digits(fields[0]) is not None for fields in head)
    value = _value_of_digits if as_digits else _whole_value
    has_gaps = not _follow([value(fields[0]) for fields in head], largest_step=1)
    beside_whole = all(value(field) is not None for fields in head for field in fields[1:])
    if (has_gaps and beside_whole) or (not as_digits and (has_gaps or beside_whole)):
        return False
    numbers = map(value, map(plain_name, rows.first_fields()))
    return _follow(numbers, largest_step=math.inf if as_digits else 1)


def _begin_with_time(rows: TextRows) -> bool:
    """Whether rows of four numbers or more begin with large ones that never fall, beside others."""
    head = _head_of_four(rows)
    if not head:
        return False
    values = np.array([parsed(_with_points(fields)) for fields in head])
    if not (values[:, 0] > _LARGEST_LENGTH).all() or (values[:, 1:] > _LARGEST_LENGTH).any():
        return False
    last = -math.inf
    fields = rows.first_fields()
    while part := list(islice(fields, ROWS_AT_A_TIME)):
        try:
            times = parsed(_with_points(part))
        except ValueError:
            return False
        steps = np.diff(times, prepend=last)
        if not (times > _LARGEST_LENGTH).all() or not (steps >= 0.0).all():
            return False
        last = times[-1]
    return True


def _head_of_four(rows: TextRows) -> list[list[str]]:
    """First four fields of the first rows; none if these are few, or not all are numbers."""
    head = [[plain_name(field) for field in fields[:4]] for fields in rows.head(_FEWEST)]
    are_numbers = all(len(fields) == 4 and all(map(_is_number, fields)) for fields in head)
    return head if are_numbers and len(head) == _FEWEST else []


def _follow(numbers: Iterable[int | None], largest_step: float) -> bool:
    """Whether all are whole, and each larger, or each smaller, than the last by so much at most."""
    up = down = True
    for a, b in pairwise(numbers):
        step = 0 if a is None or b is None else b - a
        up = up and 1 <= step <= largest_step
        down = down and 1 <= -step <= largest_step
        if not up and not down:
            return False
    return True


def _with_points(fields: Iterable[str]) -> list[str]:
    return [field.replace(",", ".") for field in fields]


def _is_number(field: str) -> bool:
    return field != "" and may_be_number(field)


def _value_of_digits(field: str) -> int | None:
    return int(field) if _DIGITS.fullmatch(field) else None


def _whole_value(field: str) -> int | None:
    """Value of a field that is 0 or a positive whole number, however it is spelled; else None."""
    try:
        (value,) = parsed(_with_points([field])).tolist()
    except ValueError:
        return None
    return int(value) if value >= 0.0 and value.is_integer() else None


class UnitVectors:
    """Looks for columns that hold the coordinates of unit vectors, in rows that come in parts.

    Parameters
    ----------
    axes : TextAxes
        Columns of the coordinates of points.
    n_others : int
        Number of the other columns: those of normals are right behind the positions, or where
        pcsmooth appends them.
    """

    def __init__(self, axes: TextAxes, n_others: int) -> None:
        d = len(axes.columns)
        others = [column for column in range(d + n_others) if column not in axes.columns]
        behind = sum(column < max(axes.columns) for column in others)
        self._found = {
            first: others[first : first + d]
            for first in (behind, n_others - d)
            if 0 <= first <= n_others - d
        }
        self._is_first = True

    def add(self, words: Sequence[npt.NDArray[np.str_]]) -> None:
        """Take rows of the other columns into account."""
        for first, columns in list(self._found.items()):
            found = words[first : first + len(columns)]
            # A few rows are enough to say no.
            if (self._is_first and not _are_unit(found, _FEW)) or not _are_unit(found):
                del self._found[first]
        self._is_first = False

    @property
    def columns(self) -> Sequence[int]:
        """Columns of unit vectors, by their places in the file; none if nothing was added."""
        return () if self._is_first else next(iter(self._found.values()), ())


def _are_unit(words: Sequence[npt.NDArray[np.str_]], n_rows: int | None = None) -> bool:
    """Whether rows are unit vectors or zero; of a given number of rows not all may be zero."""
    try:
        vectors = np.stack([parsed(column[:n_rows].tolist()) for column in words], axis=1)
    except ValueError:
        return False
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(vectors[np.isfinite(vectors).all(axis=1)], axis=1)
    unit = np.abs(lengths - 1) <= _UNIT_TOLERANCE
    return bool(np.all(unit | (lengths == 0)) and (n_rows is None or unit.any()))
