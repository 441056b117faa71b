"""PLY, in the layout of the PLY file that a cloud came from, if any."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt
from plyfile import PlyElement, PlyListProperty, PlyProperty

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.cloud_file import check_alike
from pcsmooth.formats.layout import lost_besides
from pcsmooth.formats.number_columns import (
    NO_TYPES,
    Types,
    ValueRanges,
    plain_ascii,
    widened,
)
from pcsmooth.formats.ply.header import PlyHeader, ascii_lines
from pcsmooth.formats.ply.layout import PlyLayout, layout_of
from pcsmooth.formats.ply.rows import write_element
from pcsmooth.formats.ply.types import has_long_numbers, list_types, ply_numbers
from pcsmooth.formats.position_type import written_position_type
from pcsmooth.formats.typed_rows import OddWords

_ROWS_IN_CACHE = 4096
"""Rows of a table that are filled column by column without leaving the processor's cache."""


def ply_template(template: PointCloud, chunks: Iterable[PointCloud], path: str) -> PointCloud:
    """Type the columns that are typed by their values as all of them together are.

    See `MakeTemplate`: the chunks are iterated only if there are such columns, which are those of
    words and of long whole numbers.
    """
    ranges = ValueRanges(
        template,
        lambda kind: kind.kind == "U" or (kind.kind in "iu" and kind.itemsize == 8),
        path,
        "PLY",
    )
    return ranges.template(chunks)


def write_ply(
    template: PointCloud, count: int, chunks: Iterable[PointCloud], file: BinaryIO, path: str
) -> None:
    """Write a PLY file.

    Parameters
    ----------
    template, count, chunks, file, path
        See `WriteChunks`.

    Raises
    ------
    CloudFileError
        A column holds words, or two columns would get the same name.
    InvalidInputError
        The chunks hold something else than the template.
    """
    layout = layout_of(template)
    described = _described(template, path)
    vertex = PlyElement("vertex", described.properties, count, described.comments)
    header = PlyHeader(
        text=layout.header.text,
        byte_order=layout.header.byte_order,
        elements=tuple(
            vertex if element.name == "vertex" else element for element in layout.header.elements
        ),
        comments=template.comments,
        obj_info=layout.header.obj_info,
    )
    file.write(bytes(header))
    for element, rows in zip(header.elements, layout.rows, strict=True):
        if element is vertex:
            for part, odd in _parts(template, described, chunks, path):
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


def _parts(
    template: PointCloud, vertex: PlyElement, chunks: Iterable[PointCloud], path: str
) -> Iterator[tuple[PlyElement, OddWords]]:
    """Vertices of each chunk, and what of them is spelled in its own way."""
    expected = list(map(str, vertex.properties))
    types = {name: vertex.data.dtype[name] for name in vertex.data.dtype.names or ()}
    for chunk in chunks:
        part = vertex
        if chunk is not template:
            same = replace(chunk, layout=template.layout, position_type=template.position_type)
            part = _described(same, path, types)
            check_alike(template, expected, chunk, list(map(str, part.properties)))
        yield part, layout_of(chunk).odd_words


def _described(cloud: PointCloud, path: str, settled: Types = NO_TYPES) -> PlyElement:
    """Describe the vertex element of a file to be written, its data included.

    The properties of the file that the cloud came from come first, in their order. Whole numbers
    become floats where the settled types of the properties say so.
    """
    layout = layout_of(cloud)
    old = {prop.name: prop for prop in layout.vertex.properties}
    columns = _columns(cloud, layout, path)
    columns = {name: columns[name] for name in old if name in columns} | columns

    types: list[tuple[str, Any]] = []
    lists: dict[str, tuple[str, str]] = {}
    for name, values in columns.items():
        if values.dtype.kind == "O":
            lists[name] = _list_types(values, old.get(name))
        elif name not in layout.axes[: cloud.dimension]:
            numbers = _as_in_file(ply_numbers(name, values, path), old.get(name))
            columns[name] = widened(numbers, settled.get(name))
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
