"""PLY files that are read and written piece by piece, in bounded memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from types import TracebackType
from typing import BinaryIO

from plyfile import PlyElement

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import InvalidInputError
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.ply.ply import (
    PlyLayout,
    cloud_of,
    described_vertices,
    find_rows,
    no_rows,
    write_elements,
)
from pcsmooth.formats.ply.rows import read_tables
from pcsmooth.formats.typed_rows import OddWords


class PlyChunks:
    """The vertices of a PLY file, piece by piece; see `CloudChunks`.

    Parameters
    ----------
    file : binary file
        Open for reading, and seekable; closed with this object.
    path : str
        Name of the file in errors.
    dim : {2, 3} or None
        Number of coordinates; None takes three if the file has a ``z``.

    Raises
    ------
    CloudFileError
        Not PLY, cut short, or without positions.
    """

    def __init__(self, file: BinaryIO, path: str, dim: int | None) -> None:
        self._file = file
        layout, self._rows = find_rows(ByteSource(file, path), dim)
        self.name = path
        self.count: int = self._rows.element.count
        self.template = cloud_of(no_rows(self._rows), layout)
        self._layout = layout
        self.dimension = self.template.dimension

    def read(self, rows: int, columns: bool = True) -> Iterator[PointCloud]:
        """Read all points from the first on, some at a time; see `CloudChunks.read`."""
        if rows < 1:
            raise InvalidInputError(f"a chunk must have 1 point or more, not {rows}")
        tables = read_tables(self._rows, rows)
        return (
            cloud_of(table, replace(self._layout, odd_words=odd), columns) for table, odd in tables
        )

    def __enter__(self) -> PlyChunks:
        """Return the object itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the file."""
        self._file.close()


def write_ply_chunks(
    template: PointCloud, count: int, chunks: Iterable[PointCloud], file: BinaryIO, path: str
) -> None:
    """Write a PLY file piece by piece, as `write_ply` would write all at once.

    Parameters
    ----------
    template : PointCloud
        Columns, types, comments and layout of the file; its points are not written.
    count : int
        How many points there will be.
    chunks : iterable of PointCloud
        So many points, with the columns of the template.
    file : binary file
        Open for writing.
    path : str
        Name of the file in errors.

    Raises
    ------
    CloudFileError
        A column holds words, or two columns would get the same name.
    InvalidInputError
        The chunks hold something else than the template.
    """
    described = described_vertices(template, path)
    vertex = PlyElement("vertex", described.properties, count, described.comments)
    write_elements(template, vertex, _parts(template, vertex, chunks, path), file)


def _parts(
    template: PointCloud, vertex: PlyElement, chunks: Iterable[PointCloud], path: str
) -> Iterator[tuple[PlyElement, OddWords]]:
    for chunk in chunks:
        same = replace(chunk, layout=template.layout, position_type=template.position_type)
        part = described_vertices(same, path)
        expected, found = (list(map(str, element.properties)) for element in (vertex, part))
        # A flat chunk would be given a third coordinate of zero.
        if found != expected or chunk.dimension != template.dimension:
            raise InvalidInputError(
                f"a chunk in {chunk.dimension}D has {', '.join(found)}; "
                f"the file in {template.dimension}D has {', '.join(expected)}"
            )
        yield part, chunk.layout.odd_words if isinstance(chunk.layout, PlyLayout) else {}
