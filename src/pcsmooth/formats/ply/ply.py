"""PLY: every property, element and comment of the file is kept."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt
from plyfile import PlyElement, PlyListProperty, PlyProperty

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.axis_names import normals_among
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.layout import lost_besides
from pcsmooth.formats.number_columns import plain_ascii
from pcsmooth.formats.ply.cut import ElementRows, cut_rows
from pcsmooth.formats.ply.header import PlyHeader, ascii_lines, name_in_header, read_header
from pcsmooth.formats.ply.rows import read_tables, write_element
from pcsmooth.formats.ply.types import has_long_numbers, list_types, ply_numbers
from pcsmooth.formats.position_type import written_position_type
from pcsmooth.formats.typed_rows import OddWords

Columns = Mapping[str, npt.NDArray[Any]]

_ROWS_IN_CACHE = 4096
"""Rows of a table that are filled column by column without leaving the processor's cache."""


@dataclass(frozen=True)
class PlyLayout:
    """What a PLY file holds besides its points.

    Attributes
    ----------
    header : PlyHeader
        The header as read: encoding, elements and properties in their order, ``obj_info``.
    axes : tuple of str
        Names of the position properties, as spelled in the file.
    rows : tuple of iterable of bytes
        The rows of each element as they are in the file, in one or more pieces; none for the
        vertices.
    odd_words : dict
        Numbers of the vertices that are not finite and spelled in their own way, by row and
        property.
    """

    header: PlyHeader
    axes: tuple[str, ...]
    rows: tuple[Iterable[bytes], ...]
    odd_words: OddWords = field(default_factory=dict)

    @property
    def columns(self) -> dict[str, str]:
        """The column that each property of the vertices is, by what plyfile calls it."""
        spelled = {prop.name: name_in_header(prop) for prop in self.vertex.properties}
        normals = normals_among(spelled.values())
        return {prop: normals.get(name, name) for prop, name in spelled.items()}

    @property
    def vertex(self) -> PlyElement:
        """Description of the vertex element."""
        return next(element for element in self.header.elements if element.name == "vertex")

    @property
    def format(self) -> str:
        """Name of the format."""
        return "ply"

    @property
    def besides(self) -> list[str]:
        """Every element but the vertices, in words."""
        return [
            f"element '{element.name}' ({element.count} row{'s' * (element.count != 1)})"
            for element in self.header.elements
            if element.name != "vertex"
        ]


NEW_FILE = PlyLayout(
    PlyHeader(text=False, byte_order="<", elements=(PlyElement("vertex", (), 0),)),
    axes=("x", "y", "z"),
    rows=((),),
)
"""Layout of a cloud that did not come from a PLY file."""


def read_ply(data: bytes, path: str, dim: int | None) -> PointCloud:
    """Read a PLY file.

    Parameters
    ----------
    data : bytes
        The whole file.
    path : str
        Name of the file in errors.
    dim : {2, 3} or None
        Number of coordinates; None takes three if the file has a ``z``.

    Returns
    -------
    PointCloud
        Row i is vertex i.

    Raises
    ------
    CloudFileError
        Not PLY, damaged, cut short, or without positions.
    """
    layout, vertices = find_rows(ByteSource(io.BytesIO(data), path), dim)
    everything = read_tables(vertices, max(vertices.element.count, 1))
    table, odd = next(everything, (no_rows(vertices), {}))
    # Kept as they are now, whatever becomes of the file.
    rows = tuple((b"".join(pieces),) for pieces in layout.rows)
    return cloud_of(table, replace(layout, rows=rows, odd_words=odd))


def find_rows(source: ByteSource, dim: int | None) -> tuple[PlyLayout, ElementRows]:
    """Find what a PLY file holds, without reading its rows.

    Parameters
    ----------
    source : ByteSource
        The file.
    dim : {2, 3} or None
        Number of coordinates; None takes three if the file has a ``z``.

    Returns
    -------
    layout : PlyLayout
        What it holds besides its points; the rows of other elements are left in the file.
    vertices : ElementRows
        Where the vertices are.

    Raises
    ------
    CloudFileError
        Not PLY, cut short, or without positions.
    """
    header, size = read_header(source)
    vertex = next((element for element in header.elements if element.name == "vertex"), None)
    if vertex is None:
        raise CloudFileError(
            source.path, "the PLY file has no vertex element", "export it with points"
        )
    axes = _axes(vertex, source.path, dim)
    pieces = cut_rows(source, size, header)
    vertices = pieces[header.elements.index(vertex)]
    others = tuple(() if rows is vertices else rows for rows in pieces)
    return PlyLayout(header, axes, others), vertices


def no_rows(rows: ElementRows) -> npt.NDArray[Any]:
    """Table of an element as it would be read, without any row."""
    return np.empty(0, rows.element.dtype(rows.header.byte_order))


def cloud_of(table: npt.NDArray[Any], layout: PlyLayout, columns: bool = True) -> PointCloud:
    """Build a cloud from vertices.

    Parameters
    ----------
    table : structured ndarray, shape (n,)
        One field per property.
    layout : PlyLayout
        Where they come from.
    columns : bool
        Whether the cloud gets more than positions.

    Returns
    -------
    PointCloud
        Row i is row i of the table, which is not referred to.
    """
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


def write_ply(cloud: PointCloud, file: BinaryIO, path: str) -> None:
    """Write a PLY file, in the layout of the PLY file that the cloud came from, if any.

    Parameters
    ----------
    cloud : PointCloud
        What to write.
    file : binary file
        Open for writing.
    path : str
        Name of the file in errors.

    Raises
    ------
    CloudFileError
        A column holds words, or two columns would get the same name.
    """
    vertex = described_vertices(cloud, path)
    write_elements(cloud, vertex, [(vertex, _layout(cloud).odd_words)], file)


def write_elements(
    cloud: PointCloud,
    vertex: PlyElement,
    parts: Iterable[tuple[PlyElement, OddWords]],
    file: BinaryIO,
) -> None:
    """Write the header and all elements.

    Parameters
    ----------
    cloud : PointCloud
        Where the layout and the comments are from.
    vertex : plyfile.PlyElement
        Description of the vertices, with their number.
    parts : iterable of (plyfile.PlyElement, dict)
        Vertices with data, of the same description, that together are so many, and what of each
        part is spelled in its own way.
    file : binary file
        Open for writing.
    """
    layout = _layout(cloud)
    header = PlyHeader(
        text=layout.header.text,
        byte_order=layout.header.byte_order,
        elements=tuple(
            vertex if element.name == "vertex" else element for element in layout.header.elements
        ),
        comments=cloud.comments,
        obj_info=layout.header.obj_info,
    )
    file.write(bytes(header))
    for element, rows in zip(header.elements, layout.rows, strict=True):
        if element is vertex:
            for part, odd in parts:
                write_element(file, part, header, odd)
        else:
            for piece in rows:
                file.write(piece)


def lost_in_ply(cloud: PointCloud) -> list[str]:
    """Say what of a cloud a PLY file would not keep."""
    return lost_besides(cloud, PlyLayout) + [
        f"digits of the long numbers in column '{name}'"
        for name, column in cloud.columns.items()
        if has_long_numbers(column)
    ]


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


def _layout(cloud: PointCloud) -> PlyLayout:
    return cloud.layout if isinstance(cloud.layout, PlyLayout) else NEW_FILE


def described_vertices(cloud: PointCloud, path: str) -> PlyElement:
    """Describe the vertex element of a file to be written, its data included.

    Parameters
    ----------
    cloud : PointCloud
        What to write.
    path : str
        Name of the file in errors.

    Returns
    -------
    plyfile.PlyElement
        Properties of the file that the cloud came from, if any, in their order; then new ones.

    Raises
    ------
    CloudFileError
        A column holds words, or two columns would get the same name.
    """
    layout = _layout(cloud)
    old = {prop.name: prop for prop in layout.vertex.properties}
    columns = _columns(cloud, layout, path)
    columns = {name: columns[name] for name in old if name in columns} | columns

    types: list[tuple[str, Any]] = []
    lists: dict[str, tuple[str, str]] = {}
    for name, values in columns.items():
        if values.dtype.kind == "O":
            lists[name] = _list_types(values, old.get(name))
        elif name not in layout.axes[: cloud.dimension]:
            columns[name] = _as_in_file(ply_numbers(name, values, path), old.get(name))
        types.append((name, columns[name].dtype))

    table = np.empty(len(cloud), np.dtype(types))
    for start in range(0, len(cloud), _ROWS_IN_CACHE):
        part = slice(start, start + _ROWS_IN_CACHE)
        for name, values in columns.items():
            table[name][part] = values[part]
    return PlyElement.describe(
        table,
        "vertex",
        len_types={name: length for name, (length, _) in lists.items()},
        val_types={name: item for name, (_, item) in lists.items()},
        comments=ascii_lines(layout.vertex.comments),
    )


def _columns(cloud: PointCloud, layout: PlyLayout, path: str) -> dict[str, npt.NDArray[Any]]:
    """Positions, then every other column, under their names in the file."""
    position_type = written_position_type(cloud)
    columns = dict(zip(layout.axes, cloud.points.T.astype(position_type), strict=False))
    if len(columns) < len(layout.axes) and "z" not in cloud.columns:
        columns["z"] = np.zeros(len(cloud), position_type)  # viewers need three coordinates
    old = {column: prop for prop, column in layout.columns.items()}
    for column, values in cloud.columns.items():
        name = old.get(column) or plain_ascii(column)
        if name in columns:
            raise CloudFileError(
                path, f"two columns would be called '{name}'", "rename one of them"
            )
        columns[name] = values
    if cloud.fixed_marks is not None:
        columns.setdefault("fixed", cloud.fixed_marks)
    return columns


def _as_in_file(values: npt.NDArray[Any], prop: PlyProperty | None) -> npt.NDArray[Any]:
    """Cast to the file's type where that is floating."""
    if prop is None or isinstance(prop, PlyListProperty) or prop.val_dtype[0] != "f":
        return values
    return values.astype(prop.val_dtype)


def _list_types(values: npt.NDArray[Any], prop: PlyProperty | None) -> tuple[str, str]:
    length_type, item_type = list_types(values)
    if not isinstance(prop, PlyListProperty):
        return length_type, item_type
    fits = max(map(len, values), default=0) <= np.iinfo(prop.len_dtype).max
    return prop.len_dtype if fits else length_type, prop.val_dtype
