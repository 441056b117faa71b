"""Read points from text, in the dialects that people write."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.raster_grid import refuse_grid
from pcsmooth.formats.text_axes import Columns, TextAxes, chosen_axes, column_names, found_axes
from pcsmooth.formats.text_dialect import comment_text, detect_dialect, is_comment
from pcsmooth.formats.text_encoding import decoded, readable
from pcsmooth.formats.text_layout import TextLayout, coordinate_columns
from pcsmooth.formats.text_rows import TextRows

_MOST_DEGREES = (360.0, 90.0)
"""Largest longitude and latitude."""


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

    marks = dialect.marks
    above = (index for index in range(dialect.first_row) if index != dialect.header_line)
    comments = _comments((lines[index] for index in above), marks)
    comments_below = _comments(lines[dialect.first_row :], marks)
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
    return replace(cloud, warnings=(*_of_counts(rows), *_of_degrees(cloud, axes)))


def _comments(lines: Iterable[str], marks: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    return tuple(
        (readable(comment_text(line)), line.rstrip()) for line in lines if is_comment(line, marks)
    )


def _of_counts(rows: TextRows) -> Iterator[str]:
    """Say what count lines promise and the file does not keep, and that there are several."""
    promised, n_blocks = sum(rows.counts), len(rows.counts)
    if n_blocks > 1:
        yield f"its points come in {n_blocks} blocks, which are read as one cloud"
    if rows.counts != rows.blocks:
        lines = "count line promises" if n_blocks == 1 else "count lines promise"
        cut = ", so that it may have been cut short" if promised > len(rows) else ""
        yield f"its {lines} {promised} points, but {len(rows)} rows follow{cut}; all are read"


def _of_degrees(cloud: PointCloud, axes: TextAxes) -> Iterator[str]:
    if axes.in_degrees and _may_be_degrees(cloud.points):
        both = " and ".join(coordinate_columns(cloud)[:2])
        yield (
            f"its coordinates {excerpt(both)} are degrees, in which no length is right; "
            "project them to metres first"
        )


def _may_be_degrees(points: npt.NDArray[np.float64]) -> bool:
    finite = points[np.isfinite(points).all(axis=1), :2]
    return bool((np.abs(finite) <= _MOST_DEGREES).all())
