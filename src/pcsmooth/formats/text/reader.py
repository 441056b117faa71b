"""Read points from text, in the dialects that people write."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import NORMALS, PointCloud
from pcsmooth.formats.attribute_names import names_attribute
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import parsed
from pcsmooth.formats.text.axes import Columns, TextAxes, chosen_axes, column_names, found_axes
from pcsmooth.formats.text.dialect import (
    Dialect,
    comment_text,
    detect_dialect,
    is_comment,
)
from pcsmooth.formats.text.encoding import decoded, readable
from pcsmooth.formats.text.layout import TextLayout, coordinate_columns
from pcsmooth.formats.text.raster_grid import refuse_grid
from pcsmooth.formats.text.rows import TextRows

_MOST_DEGREES = (90.0, 360.0)
"""Largest latitude and longitude."""

_FIRST_ROWS = 100
"""Rows that are enough to take a column for numbers."""


def read_text(
    data: bytes, path: str, dim: int | None, format_name: str, columns: Columns | None = None
) -> PointCloud:
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
    columns : sequence of str or int, optional
        Columns of the coordinates, by names or by numbers from 1; by default the header says, or
        they are the first.

    Returns
    -------
    PointCloud
        Row i is row i of the file, comments and blank lines not counted.

    Raises
    ------
    CloudFileError
        Not text, or a grid; a row with too few or too many columns, a coordinate that is not a
        number, or no telling which columns are the coordinates.
    """
    text = decoded(data, path).replace("\r\n", "\n").replace("\r", "\n")
    refuse_grid(text, path)
    lines = text.split("\n")
    dialect = detect_dialect(lines)
    rows = TextRows(lines, dialect, path)
    axes = (
        found_axes(dialect, rows, format_name, dim, path)
        if columns is None
        else chosen_axes(columns, dialect, path)
    )
    found = rows.parsed(axes.columns)
    names = column_names(dialect, axes, found.others)
    others = [name for column, name in enumerate(names) if column not in axes.columns]
    with_commas = [name for name, has in zip(others, found.with_commas, strict=True) if has]

    comments = _comments(
        lines[index]
        for index in range(dialect.first_row)
        if index != dialect.header_line
        and (index in dialect.titles or is_comment(lines[index], dialect.marks))
    )
    comments_below = _comments(
        line
        for line in lines[dialect.first_row :]
        if is_comment(line, dialect.marks) and not dialect.is_row(line)
    )
    layout = TextLayout(
        format=format_name,
        delimiter=dialect.delimiter,
        names=tuple(names),
        labels=dialect.labels,
        header_mark=dialect.header_mark,
        blocks=rows.blocks,
        comments=comments,
        comments_below=comments_below,
        decimal_commas=frozenset(
            [*("xyz"[: len(axes.columns)] if found.has_commas else ()), *with_commas]
        ),
        odd_rows=found.odd_rows,
    )
    cloud = PointCloud(
        points=found.points,
        columns=dict(zip(others, found.others, strict=True)),
        comments=tuple(comment for comment, _ in comments + comments_below),
        fixed_marks=found.marks,
        layout=layout,
    )
    return replace(
        cloud,
        warnings=(
            *_of_counts(rows),
            *_of_titles(dialect),
            *_of_comments(dialect, layout),
            *_of_degrees(cloud, axes),
            *(_of_heights(cloud) if columns is None and dim is None else ()),
        ),
    )


def _comments(lines: Iterable[str]) -> tuple[tuple[str, str], ...]:
    return tuple((readable(comment_text(line)), line.rstrip(" ")) for line in lines)


def _of_counts(rows: TextRows) -> Iterator[str]:
    """Say what count lines promise and the file does not keep, and that there are several."""
    promised, n_blocks = sum(rows.counts), len(rows.counts)
    if n_blocks > 1:
        yield f"its points come in {n_blocks} blocks, which are read as one cloud"
    if rows.counts != rows.blocks:
        lines = "count line promises" if n_blocks == 1 else "count lines promise"
        cut = ", so that it may have been cut short" if promised > len(rows) else ""
        yield f"its {lines} {promised} points, but {len(rows)} rows follow{cut}; all are read"


def _of_titles(dialect: Dialect) -> Iterator[str]:
    """Say which lines are neither header nor row, nor marked as a comment."""
    for index in dialect.titles:
        yield f"its line {index + 1} names no columns and is taken for a comment"


def _of_comments(dialect: Dialect, layout: TextLayout) -> Iterator[str]:
    """Say how many comments may have been meant as rows."""
    below = sum(dialect.may_be_row(line) for _, line in layout.comments_below)
    above = sum(dialect.resembles_row(line) for _, line in layout.comments)
    if below or above:
        yield f"lines taken for comments that may have been meant as rows: {below + above}"


def _of_degrees(cloud: PointCloud, axes: TextAxes) -> Iterator[str]:
    if axes.in_degrees and _may_be_degrees(cloud.points):
        both = " and ".join(coordinate_columns(cloud)[:2])
        yield (
            f"its coordinates {excerpt(both)} are degrees, in which no length is right; "
            "project them to metres first"
        )


def _of_heights(cloud: PointCloud) -> Iterator[str]:
    """Say which numbers beside a header's x and y may be heights under a name that is not known."""
    layout = cloud.layout
    assert isinstance(layout, TextLayout)
    if cloud.dimension == 3 or layout.format == "xy" or not layout.labels:
        return
    unknown = [
        name
        for name, words in cloud.columns.items()
        if name not in NORMALS and not names_attribute(name) and _are_numbers(words)
    ]
    if unknown:
        chosen = ",".join([*coordinate_columns(cloud), unknown[0]])
        yield (
            f"its points are plane, as the header names no height; if {excerpt(unknown[0])} is "
            f"that, pass --columns {excerpt(chosen)}, else --dim 2"
        )


def _are_numbers(words: npt.NDArray[np.str_]) -> bool:
    try:
        return bool(np.isfinite(parsed(words[:_FIRST_ROWS].tolist())).any())
    except ValueError:
        return False


def _may_be_degrees(points: npt.NDArray[np.float64]) -> bool:
    """Whether one coordinate has the values of latitudes, and the other those of longitudes."""
    finite = points[np.isfinite(points).all(axis=1), :2]
    largest = np.sort(np.abs(finite).max(axis=0, initial=0.0))
    return bool((largest <= _MOST_DEGREES).all())
