"""What is known of a text file once all its rows have been looked through, and found amiss."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import NORMALS, PointCloud
from pcsmooth.formats.attribute_names import names_attribute
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import parsed
from pcsmooth.formats.text.axes import TextAxes, UnitVectors
from pcsmooth.formats.text.dialect import Dialect
from pcsmooth.formats.text.layout import TextLayout, coordinate_columns
from pcsmooth.formats.text.rows import TextRows
from pcsmooth.formats.text.values import ParsedRows

_MOST_DEGREES = (90.0, 360.0)
"""Largest latitude and longitude."""

_FIRST_ROWS = 100
"""Rows that are enough to take a column for numbers."""


class TextFacts:
    """What depends on the values of all rows.

    Parameters
    ----------
    nothing : ParsedRows
        What no rows hold.
    axes : TextAxes
        Columns of the coordinates.
    parts : iterable of ParsedRows
        All rows.
    may_have_normals : bool
        Whether unit vectors are looked for among the other columns.

    Attributes
    ----------
    nothing : ParsedRows
        What no rows hold, in the widest types of all.
    has_marks : bool
        Whether some rows are fixed.
    unit_vectors : sequence of int
        Columns of unit vectors, if there are any.
    head : sequence of ndarray of str
        The other columns of the first rows.
    may_be_degrees : bool
        Whether one coordinate has the values of latitudes, and the other those of longitudes.
    """

    def __init__(
        self,
        nothing: ParsedRows,
        axes: TextAxes,
        parts: Iterable[ParsedRows],
        may_have_normals: bool,
    ) -> None:
        self.has_marks = False
        self.head = nothing.others
        types = [words.dtype for words in nothing.others]
        unit_vectors = UnitVectors(axes, len(types))
        largest = np.zeros(2)
        for rank, part in enumerate(parts):
            if rank == 0:
                self.head = tuple(words[:_FIRST_ROWS] for words in part.others)
            self.has_marks |= bool(part.marks.any())
            if may_have_normals:
                unit_vectors.add(part.others)
            types = [max(a, b.dtype) for a, b in zip(types, part.others, strict=True)]
            if axes.in_degrees:
                finite = part.points[np.isfinite(part.points).all(axis=1), :2]
                largest = np.maximum(largest, np.abs(finite).max(axis=0, initial=0.0))
        self.unit_vectors = unit_vectors.columns
        self.may_be_degrees = bool((np.sort(largest) <= _MOST_DEGREES).all())
        widest = tuple(np.empty(0, kind) for kind in types)
        self.nothing = replace(nothing, others=widest)


def of_counts(rows: TextRows) -> Iterator[str]:
    """Say what count lines promise and the file does not keep, and that there are several."""
    promised, n_blocks = sum(rows.counts), len(rows.counts)
    if n_blocks > 1:
        yield f"its points come in {n_blocks} blocks, which are read as one cloud"
    if rows.counts != rows.blocks:
        lines = "count line promises" if n_blocks == 1 else "count lines promise"
        cut = ", so that it may have been cut short" if promised > len(rows) else ""
        yield f"its {lines} {promised} points, but {len(rows)} rows follow{cut}; all are read"


def of_titles(dialect: Dialect) -> Iterator[str]:
    """Say which lines are neither header nor row, nor marked as a comment."""
    for index in dialect.titles:
        yield f"its line {index + 1} names no columns and is taken for a comment"


def of_comments(dialect: Dialect, layout: TextLayout) -> Iterator[str]:
    """Say how many comments may have been meant as rows."""
    below = sum(dialect.may_be_row(line) for _, line in layout.comments_below)
    above = sum(dialect.resembles_row(line) for _, line in layout.comments)
    if below or above:
        yield f"lines taken for comments that may have been meant as rows: {below + above}"


def of_degrees(cloud: PointCloud) -> Iterator[str]:
    """Say that coordinates are degrees."""
    both = " and ".join(coordinate_columns(cloud)[:2])
    yield (
        f"its coordinates {excerpt(both)} are degrees, in which no length is right; "
        "project them to metres first"
    )


def of_heights(cloud: PointCloud, head: Sequence[npt.NDArray[np.str_]]) -> Iterator[str]:
    """Say which numbers beside a header's x and y may be heights under a name that is not known."""
    layout = cloud.layout
    assert isinstance(layout, TextLayout)
    if cloud.dimension == 3 or layout.format == "xy" or not layout.labels:
        return
    unknown = [
        name
        for name, words in zip(cloud.columns, head, strict=True)
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
        return bool(np.isfinite(parsed(words.tolist())).any())
    except ValueError:
        return False
