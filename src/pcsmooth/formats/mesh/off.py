"""OFF: vertices, their normals and colors; every other line of the file is kept."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import COLORS, NORMALS, PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.mesh.vertex_lines import (
    VertexLines,
    columns_after,
    names_after,
    own_lines,
    read_vertices,
    vertex_cloud,
    vertex_words,
    with_vertices,
)
from pcsmooth.formats.number_columns import numbers_of
from pcsmooth.formats.number_text import is_whole

_FIRST_WORD = re.compile(rb"(?:\s|#[^\n]*\n)*+(?P<word>(ST)?(?P<c>C)?(?P<n>N)?4?n?OFF)\b")
_UNKNOWN = re.compile(rb"4|n|BINARY")
_LESS_COLOR = 257


def is_off(head: bytes) -> bool:
    """Whether a file that begins with these bytes calls itself OFF."""
    return _FIRST_WORD.match(head) is not None


def read_off(data: bytes, path: str, dim: int | None) -> PointCloud:
    """Read an OFF file.

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
        Row i is vertex i; normals of NOFF and colors of COFF are columns of words.

    Raises
    ------
    CloudFileError
        Not OFF, binary, of points with four or n coordinates, cut short, or a vertex without
        three coordinates.
    """
    start = _FIRST_WORD.match(data)
    if start is None:
        raise CloudFileError(
            path, "not an OFF file: its first word is not 'OFF'", "check the file or its suffix"
        )
    lines = tuple(data.split(b"\n"))
    first = data[: start.start("word")].count(b"\n")
    title = lines[first].split(b"#")[0]
    if _UNKNOWN.search(title):
        raise CloudFileError(
            path,
            f"it is of a kind of OFF that is not known, {excerpt(title.strip().decode('latin-1'))}",
            "export it as plain OFF",
        )
    counts = title.split(b"OFF", 1)[1]
    rows, n_vertices = _rows(lines, first, counts, path)
    if len(rows) < n_vertices:
        raise CloudFileError(
            path,
            f"its header promises {n_vertices} vertices, but {len(rows)} lines follow",
            "get the whole file again",
        )
    names = (NORMALS if start["n"] else ()) + (COLORS if start["c"] else ())
    known = (
        {len(names): names, len(names) + 1: (*names, "alpha")}
        if start["c"]
        else {len(names): names}
    )
    xyz, columns, found = read_vertices(lines, rows, 0, known.get, path)
    return vertex_cloud(
        xyz, columns, dim, VertexLines("off", lines, rows, found, n_frame=1 + (not counts.split()))
    )


def write_off(cloud: PointCloud, file: BinaryIO, path: str) -> None:
    """Write an OFF file, with every line of the OFF file that the cloud came from, if any.

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
    layout = own_lines(cloud, "off")
    names = names_after(cloud, layout)
    columns = columns_after(cloud, layout, lambda name, column: _whole(name, column, path))
    if layout is None:
        words = vertex_words(cloud, columns)
        title = "COFF" if names else "OFF"
        file.write("".join(f"{line}\n" for line in (title, f"{len(cloud)} 0 0", *words)).encode())
        return
    if names and not layout.names:
        layout = replace(layout, lines=_colored(layout.lines))
    file.write(b"\n".join(with_vertices(layout, cloud, "", columns)))


def _rows(
    lines: tuple[bytes, ...], first: int, counts: bytes, path: str
) -> tuple[tuple[int, ...], int]:
    """Find the lines of the vertices, and how many there should be."""
    used = (index for index in range(first + 1, len(lines)) if lines[index].split(b"#")[0].strip())
    words = counts.split() or lines[next(used, len(lines) - 1)].split(b"#")[0].split()
    if not words or not is_whole(words[0].decode("latin-1")):
        raise CloudFileError(
            path, "its header does not say how many vertices it has", "export it again"
        )
    n_vertices = int(words[0])
    return tuple(index for index, _ in zip(used, range(n_vertices), strict=False)), n_vertices


def _colored(lines: tuple[bytes, ...]) -> tuple[bytes, ...]:
    """Say in the title that the vertices have colors."""
    first = next(index for index, line in enumerate(lines) if is_off(line))
    return (*lines[:first], lines[first].replace(b"OFF", b"COFF", 1), *lines[first + 1 :])


def _whole(name: str, column: npt.NDArray[Any], path: str) -> npt.NDArray[Any]:
    """Colors of 16 bits as 8 bits; other numbers as they are."""
    numbers = numbers_of(name, column, path, "OFF")
    return numbers // _LESS_COLOR if numbers.dtype == np.uint16 else numbers
