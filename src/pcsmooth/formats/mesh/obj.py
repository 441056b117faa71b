"""OBJ: vertices, their colors and normals; every other line of the file is kept."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import COLORS, NORMALS, PointCloud
from pcsmooth.formats.mesh.vertex_lines import (
    VertexLines,
    columns_after,
    end_of,
    own_lines,
    read_vertices,
    vertex_cloud,
    vertex_words,
    with_vertices,
    word_columns,
    words_of,
)
from pcsmooth.formats.number_columns import numbers_of
from pcsmooth.formats.number_text import spelled

#: Names of what follows the coordinates of a vertex, by their number.
_NAMES: dict[int, tuple[str, ...]] = {0: (), 1: ("w",), 3: COLORS, 4: (*COLORS, "alpha")}

#: Parts of 1 in which colors are written.
_COLOR_PARTS = 1e6


def read_obj(data: bytes, path: str, dim: int | None) -> PointCloud:
    """Read an OBJ file.

    Parameters
    ----------
    data : bytes
        The whole file.
    path : str
        Name of the file in errors.
    dim : {2, 3} or None
        Number of coordinates; with 2 the third is a column.

    Returns
    -------
    PointCloud
        Row i is the i-th line ``v``, with its color as columns of words, and with the i-th line
        ``vn`` as its normal if every face names that with it.

    Raises
    ------
    CloudFileError
        A vertex without three coordinates.
    """
    lines = tuple(data.split(b"\n"))
    kinds = [(line.split(maxsplit=1) or [b""])[0] for line in lines]
    rows = tuple(index for index, kind in enumerate(kinds) if kind == b"v")
    xyz, columns, names = read_vertices(lines, rows, 1, _NAMES.get, path)
    normal_rows = tuple(index for index, kind in enumerate(kinds) if kind == b"vn")
    corners = (line for line, kind in zip(lines, kinds, strict=True) if kind == b"f")
    normals: dict[str, npt.NDArray[np.str_]] = {}
    if rows and len(normal_rows) == len(rows) and all(map(_names_alike, corners)):
        vectors = [words_of(lines[row])[1:] for row in normal_rows]
        if all(len(vector) == len(NORMALS) for vector in vectors):
            normals = word_columns(NORMALS, vectors) or {}
    layout = VertexLines("obj", lines, rows, names, normal_rows if normals else ())
    return vertex_cloud(xyz, {**columns, **normals}, dim, layout)


def write_obj(cloud: PointCloud, file: BinaryIO, path: str) -> None:
    """Write an OBJ file, with every line of the OBJ file that the cloud came from, if any.

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
        A color that is no number.
    """
    layout = own_lines(cloud, "obj")
    columns = columns_after(cloud, layout, lambda name, column: _share(name, column, path))
    if layout is None:
        words = vertex_words(cloud, columns)
        file.write("".join(f"v {line}\n" for line in words).encode())
        return
    lines = with_vertices(layout, cloud, "v ", columns)
    if all(name in cloud.columns for name in NORMALS):
        _put_normals(lines, layout.normal_rows, [cloud.columns[name] for name in NORMALS])
    file.write(b"\n".join(lines))


def _names_alike(face: bytes) -> bool:
    """Whether every corner of a face names the normal of its vertex."""
    corners = [corner.split(b"/") for corner in face.split()[1:]]
    return all(len(names) == 3 and names[0] == names[2] for names in corners)


def _put_normals(
    lines: list[bytes], rows: Sequence[int], normals: Sequence[npt.NDArray[Any]]
) -> None:
    for row, words in zip(rows, zip(*map(spelled, normals), strict=True), strict=False):
        lines[row] = f"vn {' '.join(words)}".encode() + end_of(lines[row])


def _share(name: str, column: npt.NDArray[Any], path: str) -> npt.NDArray[Any]:
    """Turn whole numbers into shares of the largest that a color has."""
    numbers = numbers_of(name, column, path, "OBJ")
    if name not in COLORS or numbers.dtype.kind == "f":
        return numbers
    largest = np.iinfo(np.uint16 if numbers.dtype == np.uint16 else np.uint8).max
    # Upwards, because MeshLab cuts off what is left when it makes bytes of them.
    return np.ceil(np.round(numbers / largest * _COLOR_PARTS, 3)) / _COLOR_PARTS
