"""STL: the corners of triangles are points; names, attributes and order are kept."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.coordinates import three_coordinates
from pcsmooth.formats.layout import lost_besides
from pcsmooth.formats.mesh.vertex_lines import (
    VertexLines,
    end_of,
    read_vertices,
    vertex_cloud,
    with_vertices,
)
from pcsmooth.formats.number_text import spelled
from pcsmooth.formats.stored_positions import StoredPositions, stored_as_floats

_HEAD = 84
_COUNT = slice(80, 84)
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


@dataclass(frozen=True)
class StlLayout:
    """What an STL file holds besides the corners of its triangles.

    Attributes
    ----------
    corners : ndarray of float64, shape (n, 3)
        The corners as they were read, L.
    facets : structured ndarray, shape (n / 3,), or None
        The triangles of a binary file.
    head, tail : bytes
        What stands before and after these.
    text : VertexLines or None
        The lines of a text file; its normals are those of the triangles.
    """

    corners: npt.NDArray[np.float64]
    facets: npt.NDArray[Any] | None = None
    head: bytes = b""
    tail: bytes = b""
    text: VertexLines | None = None

    @property
    def format(self) -> str:
        """Name of the format."""
        return "stl"

    @property
    def besides(self) -> list[str]:
        """The triangles, in words."""
        return [f"triangles of the STL file ({len(self.corners) // 3})"]


def is_stl(head: bytes) -> bool:
    """Whether a file that begins with these bytes is STL in text."""
    return head[:5] == b"solid" and b"facet" in head[:1000]


def read_stl(data: bytes, path: str, dim: int | None) -> PointCloud:
    """Read an STL file, binary or text.

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
        Rows 3 i to 3 i + 2 are the corners of triangle i, so that each vertex is there once for
        each triangle around it.

    Raises
    ------
    CloudFileError
        Cut short, or a corner without three coordinates.
    """
    promised = int.from_bytes(data[_COUNT], "little")
    size = _HEAD + promised * _FACET.itemsize
    if is_stl(data) and len(data) != size:
        return _read_text(data, path, dim)
    if len(data) < max(size, _HEAD):
        raise CloudFileError(
            path,
            f"its header promises {promised} triangles, which take {size} bytes, but the file has "
            f"{len(data)}",
            "get the whole file again",
        )
    facets = np.frombuffer(data, _FACET, promised, _HEAD)
    with np.errstate(invalid="ignore"):  # NaN of all kinds
        corners = facets["corners"].reshape(-1, 3).astype(np.float64)
    layout = StlLayout(corners, facets, data[:_HEAD], data[size:])
    return replace(vertex_cloud(corners, {}, dim, layout), position_type=np.dtype(np.float32))


def write_stl(cloud: PointCloud, file: BinaryIO, path: str) -> None:
    """Write an STL file in the layout of that which the cloud came from.

    Parameters
    ----------
    cloud : PointCloud
        What to write; the normals of triangles that moved are computed anew.
    file : binary file
        Open for writing.
    path : str
        Name of the file in errors.

    Raises
    ------
    CloudFileError
        As `check_stl`.
    """
    layout = check_stl(cloud, path)
    corners = three_coordinates(cloud)
    stayed = (corners == layout.corners) | (np.isnan(corners) & np.isnan(layout.corners))
    moved = ~stayed.reshape(-1, 9).all(axis=1)
    normals = _facet_normals(corners.reshape(-1, 3, 3)[moved])
    if layout.facets is None:
        assert layout.text is not None
        file.write(_text(cloud, layout.text, moved, normals))
        return
    facets = layout.facets.copy()
    facets["corners"] = corners.reshape(-1, 3, 3)
    facets["normal"][moved] = normals
    file.write(layout.head + facets.tobytes() + layout.tail)


def check_stl(cloud: PointCloud, path: str) -> StlLayout:
    """Find the triangles whose corners the points are.

    Raises
    ------
    CloudFileError
        The points are not the corners of an STL file.
    """
    if isinstance(cloud.layout, StlLayout) and len(cloud.layout.corners) == len(cloud):
        return cloud.layout
    raise CloudFileError(
        path, "an .stl file holds triangles, which these points are not", "write .ply instead"
    )


def lost_in_stl(cloud: PointCloud) -> list[str]:
    """Say what of a cloud an STL file would not keep."""
    lost = lost_besides(cloud, StlLayout)
    lost += [f"column '{name}'" for name in cloud.columns if name != "z"]
    if cloud.fixed_marks is not None:
        lost.append("the marks of fixed points")
    return lost + (["the comments"] if cloud.comments else [])


def stored_in_stl(cloud: PointCloud, path: str) -> StoredPositions:
    """Positions as an STL file holds them: float in a binary one."""
    layout = check_stl(cloud, path)
    if layout.facets is None:
        return stored_as_floats(cloud, path)
    stored = stored_as_floats(replace(cloud, position_type=np.dtype(np.float32)), path)
    return replace(stored, remedy=".ply with --double keeps them")


def _read_text(data: bytes, path: str, dim: int | None) -> PointCloud:
    lines = tuple(data.split(b"\n"))
    kinds = [(line.split(maxsplit=1) or [b""])[0].lower() for line in lines]
    rows = tuple(index for index, kind in enumerate(kinds) if kind == b"vertex")
    facets = tuple(index for index, kind in enumerate(kinds) if kind == b"facet")
    if len(rows) != 3 * len(facets) or b"endsolid" not in kinds:
        raise CloudFileError(
            path,
            f"its {len(facets)} triangles have {len(rows)} corners and the last line is "
            f"{'' if b'endsolid' in kinds else 'not '}there",
            "get the whole file again",
        )
    corners, _, names = read_vertices(lines, rows, 1, {0: ()}.get, path)
    text = VertexLines("stl", lines, rows, names, facets)
    return vertex_cloud(corners, {}, dim, StlLayout(corners, text=text))


def _text(
    cloud: PointCloud,
    text: VertexLines,
    moved: npt.NDArray[np.bool_],
    normals: npt.NDArray[np.float64],
) -> bytes:
    lines = with_vertices(text, cloud, "vertex ", [])
    rows = np.asarray(text.normal_rows, np.intp)[moved]
    for row, words in zip(rows, zip(*map(spelled, normals.T), strict=True), strict=True):
        old = lines[row]
        margin = old[: len(old) - len(old.lstrip())].decode("ascii", "replace")
        lines[row] = f"{margin}facet normal {' '.join(words)}".encode() + end_of(old)
    return b"\n".join(lines)


def _facet_normals(triangles: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Compute unit normals of triangles (m, 3, 3) -> (m, 3); 0 where one has no area, or no end."""
    with np.errstate(over="ignore", invalid="ignore"):
        sides = triangles[:, 1:] - triangles[:, :1]
    sides = np.where(np.isfinite(sides).all(axis=(1, 2), keepdims=True), sides, 0.0)
    largest = np.abs(sides).max(axis=(1, 2), keepdims=True, initial=0.0)
    sides = sides / np.where(largest > 0.0, largest, 1.0)  # or products could be beyond all numbers
    normals = np.cross(sides[:, 0], sides[:, 1])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(lengths > 0.0, lengths, 1.0))
