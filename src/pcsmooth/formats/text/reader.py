"""Read points from text, in the dialects that people write."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from itertools import islice

from pcsmooth.cloud import PointCloud
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.cloud_file import CloudChunks
from pcsmooth.formats.text.axes import Columns, chosen_axes, column_names, found_axes
from pcsmooth.formats.text.dialect import comment_text, detect_dialect, is_comment
from pcsmooth.formats.text.encoding import readable
from pcsmooth.formats.text.facts import (
    TextFacts,
    of_comments,
    of_counts,
    of_degrees,
    of_heights,
    of_titles,
)
from pcsmooth.formats.text.layout import TextLayout
from pcsmooth.formats.text.lines import TextLines
from pcsmooth.formats.text.raster_grid import refuse_grid
from pcsmooth.formats.text.rows import TextRows
from pcsmooth.formats.text.values import ParsedRows, RowValues, with_points

_ROWS_LOOKED_THROUGH = 1 << 16
"""Rows that are looked through at a time."""


class TextChunks(CloudChunks):
    """The points of a text file; row i is row i of the file, comments and blank lines not counted.

    What a column is depends on all rows: whether its decimals have commas, whether there are
    normals, whether some points are fixed. They are looked through once before the first chunk is
    made.

    Parameters
    ----------
    source : ByteSource
        The file.
    dim : {2, 3} or None
        Number of coordinates; None decides by format, header and number of columns.
    format_name : str
        One of ``xyz``, ``xy``, ``txt``, ``asc``, ``csv``, ``pts``.
    columns : sequence of str or int, optional
        Columns of the coordinates, by names or by numbers from 1; by default the header says, or
        they are the first.

    Raises
    ------
    CloudFileError
        Not text, or a grid; or no telling which columns are the coordinates.
    """

    def __init__(
        self, source: ByteSource, dim: int | None, format_name: str, columns: Columns | None = None
    ) -> None:
        super().__init__(source)
        lines = TextLines(source)
        refuse_grid(lines, self.name)
        self._dialect = dialect = detect_dialect(lines)
        self._rows = rows = TextRows(lines, dialect)
        self._axes = (
            found_axes(dialect, rows, format_name, dim, self.name)
            if columns is None
            else chosen_axes(columns, dialect, self.name)
        )
        self._values = RowValues(rows, self._axes.columns, self.name)
        self._may_lack_height = columns is None and dim is None
        self.count = len(rows)
        above = enumerate(islice(lines, dialect.first_row))
        self._layout = TextLayout(
            format=format_name,
            delimiter=dialect.delimiter,
            names=(),
            labels=dialect.labels,
            header_mark=dialect.header_mark,
            blocks=rows.blocks,
            comments=_comments(
                line
                for index, line in above
                if index != dialect.header_line
                and (index in dialect.titles or is_comment(line, dialect.marks))
            ),
            comments_below=_comments(rows.comments_below()),
        )

    def whole(self) -> PointCloud:
        """Read all points as one chunk; see `CloudFile.whole`."""
        found = next(self._values.parsed(max(1, self.count)), self._values.nothing)
        self._comma_columns = self._values.comma_columns([found])
        found = with_points(found, self._comma_columns)
        self._facts = self._facts_of([found])
        return self._cloud(found)

    @cached_property
    def template(self) -> PointCloud:
        """The cloud without its points."""
        dialect, axes, facts = self._dialect, self._axes, self._facts
        names = column_names(dialect, axes, facts.unit_vectors)
        others = [name for column, name in enumerate(names) if column not in axes.columns]
        with_commas = [name for name, has in zip(others, self._comma_columns, strict=True) if has]
        if self._values.have_commas(self._comma_columns):
            with_commas += "xyz"[: len(axes.columns)]
        layout = replace(
            self._layout,
            names=tuple(names),
            decimal_commas=frozenset(with_commas),
        )
        cloud = PointCloud(
            points=facts.nothing.points,
            columns=dict(zip(others, facts.nothing.others, strict=True)),
            comments=tuple(comment for comment, _ in layout.comments + layout.comments_below),
            fixed_marks=facts.nothing.marks if facts.has_marks else None,
            layout=layout,
        )
        return replace(
            cloud,
            warnings=(
                *of_counts(self._rows),
                *of_titles(dialect),
                *of_comments(dialect, layout),
                *(of_degrees(cloud) if axes.in_degrees and facts.may_be_degrees else ()),
                *(of_heights(cloud, facts.head) if self._may_lack_height else ()),
            ),
        )

    @cached_property
    def _comma_columns(self) -> list[bool]:
        return self._values.comma_columns(self._values.parsed(_ROWS_LOOKED_THROUGH))

    @cached_property
    def _facts(self) -> TextFacts:
        return self._facts_of(self._parts(_ROWS_LOOKED_THROUGH, True))

    def _facts_of(self, parts: Iterable[ParsedRows]) -> TextFacts:
        return TextFacts(self._values.nothing, self._axes, parts, not self._dialect.labels)

    def _parts(self, rows: int, columns: bool) -> Iterator[ParsedRows]:
        return (
            with_points(part, self._comma_columns) for part in self._values.parsed(rows, columns)
        )

    def _clouds(self, rows: int, columns: bool) -> Iterator[PointCloud]:
        return (self._cloud(part) for part in self._parts(rows, columns))

    def _cloud(self, part: ParsedRows) -> PointCloud:
        """Make a cloud of some rows."""
        cloud = self.template
        assert isinstance(cloud.layout, TextLayout)
        return replace(
            cloud,
            points=part.points,
            columns=dict(zip(cloud.columns, part.others, strict=False)),
            fixed_marks=None if cloud.fixed_marks is None else part.marks,
            layout=replace(cloud.layout, odd_rows=part.odd_rows),
        )


def _comments(lines: Iterable[str]) -> tuple[tuple[str, str], ...]:
    return tuple((readable(comment_text(line)), line.rstrip(" ")) for line in lines)
