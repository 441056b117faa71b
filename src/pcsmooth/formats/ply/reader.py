"""The vertices of a PLY file: every property, element and comment is kept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from plyfile import PlyElement, PlyListProperty

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.cloud_file import CloudChunks
from pcsmooth.formats.ply.cut import cut_rows
from pcsmooth.formats.ply.header import read_header
from pcsmooth.formats.ply.layout import PlyLayout
from pcsmooth.formats.ply.rows import read_tables


class PlyChunks(CloudChunks):
    """The vertices of a PLY file; row i is vertex i.

    Parameters
    ----------
    source : ByteSource
        The file.
    dim : {2, 3} or None
        Number of coordinates; None takes three if the file has a ``z``.

    Raises
    ------
    CloudFileError
        Not PLY, cut short, or without positions.
    """

    def __init__(self, source: ByteSource, dim: int | None) -> None:
        super().__init__(source)
        header, size = read_header(source)
        vertex = next((element for element in header.elements if element.name == "vertex"), None)
        if vertex is None:
            raise CloudFileError(
                source.path, "the PLY file has no vertex element", "export it with points"
            )
        axes = _axes(vertex, source.path, dim)
        pieces = cut_rows(source, size, header)
        self._rows = pieces[header.elements.index(vertex)]
        others = tuple(() if rows is self._rows else rows for rows in pieces)
        self._layout = PlyLayout(header, axes, others)
        self.count: int = vertex.count

    @cached_property
    def template(self) -> PointCloud:
        """The cloud without its points; the rows of other elements are left in the file."""
        element, header = self._rows.element, self._layout.header
        return _cloud_of(np.empty(0, element.dtype(header.byte_order)), self._layout)

    def whole(self) -> PointCloud:
        """Read all points, and the rows of all other elements; see `CloudFile.whole`."""
        cloud = super().whole()
        rows = tuple((b"".join(pieces),) for pieces in self._layout.rows)
        assert isinstance(cloud.layout, PlyLayout)
        return replace(cloud, layout=replace(cloud.layout, rows=rows))

    def _clouds(self, rows: int, columns: bool) -> Iterator[PointCloud]:
        return (
            _cloud_of(table, replace(self._layout, odd_words=odd), columns)
            for table, odd in read_tables(self._rows, rows)
        )


def _cloud_of(table: npt.NDArray[Any], layout: PlyLayout, columns: bool = True) -> PointCloud:
    """Build a cloud from a table of vertices, which is not referred to."""
    axes, names = layout.axes, layout.columns
    points = np.empty((len(table), len(axes)))
    with np.errstate(invalid="ignore"):  # signalling NaNs become quiet ones
        for axis, name in enumerate(axes):
            points[:, axis] = table[name]
    return PointCloud(
        points=points,
        columns={
            name: _native(table[prop])
            for prop, name in names.items()
            if columns and prop not in axes
        },
        position_type=np.result_type(*(table[name].dtype.newbyteorder("=") for name in axes)),
        comments=layout.header.comments,
        layout=layout,
    )


def _axes(vertex: PlyElement, path: str, dim: int | None) -> tuple[str, ...]:
    """Names of the position properties; lower case is preferred where both are there."""
    scalars = [prop.name for prop in vertex.properties if not isinstance(prop, PlyListProperty)]
    spelled = {name.lower(): name for name in scalars} | {name: name for name in scalars}
    for name in "xy":
        if name not in spelled:
            raise CloudFileError(
                path, f"its vertices have no number '{name}'", "export it with x and y"
            )
    if dim == 3 and "z" not in spelled:
        raise CloudFileError(path, "its vertices have no number 'z'", "read it as a 2D cloud")
    axes = "xyz" if "z" in spelled and dim != 2 else "xy"
    return tuple(spelled[name] for name in axes)


def _native(column: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Own copy of a column in native byte order, so that the table can go."""
    if column.dtype.kind != "O":
        return column.astype(column.dtype.newbyteorder("="))
    lists = np.empty(len(column), object)
    for row, values in enumerate(column):
        lists[row] = values.astype(values.dtype.newbyteorder("="))
    return lists
