"""PLY: every property, element and comment of the file is kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt
from plyfile import PlyElement, PlyListProperty, PlyProperty

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.layout import lost_besides
from pcsmooth.formats.number_columns import plain_ascii
from pcsmooth.formats.ply_header import PlyHeader, ascii_lines, parse_header
from pcsmooth.formats.ply_rows import cut_rows, read_rows, write_element
from pcsmooth.formats.ply_types import has_long_numbers, list_types, ply_numbers
from pcsmooth.formats.position_type import written_position_type

Columns = Mapping[str, npt.NDArray[Any]]


@dataclass(frozen=True)
class PlyLayout:
    """What a PLY file holds besides its points.

    Attributes
    ----------
    header : PlyHeader
        The header as read: encoding, elements and properties in their order, ``obj_info``.
    axes : tuple of str
        Names of the position properties, as spelled in the file.
    rows : tuple of bytes
        The rows of each element as they are in the file; empty for the vertices.
    """

    header: PlyHeader
    axes: tuple[str, ...]
    rows: tuple[bytes, ...]

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
    rows=(b"",),
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
    header, size = parse_header(data, path)
    vertex = next((element for element in header.elements if element.name == "vertex"), None)
    if vertex is None:
        raise CloudFileError(path, "the PLY file has no vertex element", "export it with points")
    axes = _axes(vertex, path, dim)

    pieces = cut_rows(data[size:], header, path)
    position = header.elements.index(vertex)
    table = read_rows(pieces[position], vertex, header, path)
    pieces[position] = b""

    points = np.empty((len(table), len(axes)))
    with np.errstate(invalid="ignore"):  # signalling NaNs become quiet ones
        for axis, name in enumerate(axes):
            points[:, axis] = table[name]
    return PointCloud(
        points=points,
        columns={
            prop.name: _native(table[prop.name])
            for prop in vertex.properties
            if prop.name not in axes
        },
        position_type=np.result_type(*(table[name].dtype.newbyteorder("=") for name in axes)),
        comments=header.comments,
        layout=PlyLayout(header, axes, tuple(pieces)),
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
    layout = cloud.layout if isinstance(cloud.layout, PlyLayout) else NEW_FILE
    vertex = _vertex(cloud, layout, path)
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
            write_element(file, vertex, header)
        else:
            file.write(rows)


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


def _vertex(cloud: PointCloud, layout: PlyLayout, path: str) -> PlyElement:
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
    for name, values in columns.items():
        table[name] = values
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
    for name, values in cloud.columns.items():
        if plain_ascii(name) in columns:
            raise CloudFileError(
                path, f"two columns would be called '{plain_ascii(name)}'", "rename one of them"
            )
        columns[plain_ascii(name)] = values
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
