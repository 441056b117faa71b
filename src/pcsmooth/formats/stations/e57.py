"""E57: every scan of a file in one cloud, reading only."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.cleanup import temporary_folder
from pcsmooth.cloud import COLORS, PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.axis_names import normals_among
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.stations.scans import Columns, Scan, cloud_of_scans
from pcsmooth.optional_libraries import optional_library
from pcsmooth.temporaries import folder_prefix, remove_abandoned

_MAGIC = b"ASTM-E57"
_CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
_SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
_INVALID = ("cartesianInvalidState", "sphericalInvalidState")

#: Of the extension that has fields for normals.
_NORMALS_PREFIX = "nor:"

_COLOR_FIELDS = dict(zip(("colorRed", "colorGreen", "colorBlue"), COLORS, strict=True))

#: Bytes that scans may take for each of the file, and beside them: a bit can become a double,
#: and what is the same in all points takes no room in the file.
_MOST_GROWTH = 100
_SMALL = 1 << 20

#: Types of whole numbers, narrowest first, and those that the library fills in place of some.
_WHOLE = (np.uint8, np.int8, np.uint16, np.int16, np.uint32, np.int32, np.int64)
_BUFFERS = dict.fromkeys(
    (np.dtype(np.uint32), np.dtype(np.int32), np.dtype(np.int64)), np.dtype(np.longlong)
)


def is_e57(head: bytes) -> bool:
    """Whether a file that begins with these bytes calls itself E57."""
    return head.startswith(_MAGIC)


def read_e57(data: bytes, path: str, dim: int | None) -> PointCloud:
    """Read an E57 file.

    Parameters
    ----------
    data : bytes
        The whole file.
    path : str
        Name of the file in errors; if there is a file of this name, it is what is read.
    dim : {2, 3} or None
        Number of coordinates; with 2 the third is a column.

    Returns
    -------
    PointCloud
        The points of every scan, one scan after the other, moved by the pose of the scan; points
        that the file says are invalid are NaN. The column ``scan`` counts scans from 0; fields
        that a scan lacks are NaN, or 0 where they are whole numbers. Fields of text are left out;
        comments say so.

    Raises
    ------
    CloudFileError
        Not E57, damaged, cut short, or a scan without positions.
    PcsmoothError
        pye57 is not installed.
    """
    optional_library("pye57", "e57", ".e57 files")
    if not is_e57(data):
        raise CloudFileError(path, "not an E57 file", "check the file or its suffix")
    with _named(data, path) as name:
        try:
            scans, comments = _read_scans(name, len(data))
        except ValueError as error:
            raise CloudFileError(path, excerpt(str(error)), "export it again") from error
        except Exception as error:  # the library's own, some of which are plain exceptions
            raise CloudFileError(
                path,
                f"cannot be read as E57 ({excerpt(_line(str(error)))})",
                "get the whole file again",
            ) from error
    return cloud_of_scans(scans, dim, comments)


@contextlib.contextmanager
def _named(data: bytes, path: str) -> Iterator[str]:
    """Name of a file with the data; the library opens nothing else."""
    if os.path.isfile(path):
        yield path
        return
    remove_abandoned(tempfile.gettempdir())
    with temporary_folder(folder_prefix("stream")) as folder:
        name = os.path.join(folder, "stream.e57")
        with open(name, "wb") as file:
            file.write(data)
        yield name


def _read_scans(name: str, size: int) -> tuple[list[Scan], list[str]]:
    """Positions and columns of each scan, and what the file says of them."""
    from pye57 import libe57

    image = libe57.ImageFile(name, "r")
    try:
        root = image.root()
        comments = []
        if root.isDefined("coordinateMetadata"):
            text = root["coordinateMetadata"].value()
            comments += [f"coordinates: {_line(text)}"] if text else []
        scans = []
        room = 8 * size
        for index in range(len(root["data3D"]) if root.isDefined("data3D") else 0):
            node = root["data3D"][index]
            if node.isDefined("name"):
                comments.append(f"scan {index}: {_line(node['name'].value())}")
            xyz, columns, left_out, n_bits = _read_scan(image, node, index, room)
            scans.append(Scan(xyz, columns))
            room -= n_bits  # two scans do not share their points
            comments += [f"scan {index}: text {name} is left out" for name in left_out]
        n_names = len({name for scan in scans for name in scan.columns}) + 1
        _check_size(sum(len(scan.points) for scan in scans), 8 * n_names, size)
        return scans, comments
    finally:
        image.close()


def _read_scan(
    image: Any, node: Any, index: int, room: int
) -> tuple[npt.NDArray[np.float64], Columns, list[str], int]:
    """Positions and columns of a scan, names of its fields that are text, and bits it takes."""
    from pye57 import libe57
    from pye57.utils import get_fields, get_node

    points = node["points"]
    prototype = libe57.StructureNode(points.prototype())
    nodes = {name: get_node(prototype, name) for name in get_fields(prototype)}
    numeric = {name: _type_and_bits(field) for name, field in nodes.items()}
    types = {name: known for name, known in numeric.items() if known is not None}
    n_points = points.childCount()
    n_bits = n_points * max(sum(field_bits for _, field_bits in types.values()), 1)
    if n_bits > room:
        raise ValueError(
            f"scan {index} promises {n_points} points, which do not fit into the {room // 8} bytes "
            "of the file"
        )
    _check_size(n_points, sum(dtype.itemsize for dtype, _ in types.values()), room // 8)
    fields: Columns = {
        name: np.empty(n_points, _BUFFERS.get(dtype, dtype)) for name, (dtype, _) in types.items()
    }
    if n_points:
        buffers = libe57.VectorSourceDestBuffer()
        for name, values in fields.items():
            buffers.append(libe57.SourceDestBuffer(image, name, values, n_points, True, True))
        n_read = points.reader(buffers).read()
        if n_read != n_points:
            raise ValueError(f"scan {index} holds {n_read} points of {n_points}")
    fields = {name: values.astype(types[name][0], copy=False) for name, values in fields.items()}
    xyz = _moved(_positions(fields, index), node)
    plain = {name.removeprefix(_NORMALS_PREFIX): name for name in fields}
    normals = {plain[name]: normal for name, normal in normals_among(plain).items()}
    names = _COLOR_FIELDS | normals
    columns = {
        names.get(name, name): values
        for name, values in fields.items()
        if name not in (*_CARTESIAN, *_SPHERICAL, *_INVALID)
    }
    left_out = [name for name in numeric if name not in types]
    return xyz, columns, left_out, n_bits


def _check_size(n_points: int, point_size: int, size: int) -> None:
    if n_points * point_size > _MOST_GROWTH * size + _SMALL:
        raise ValueError(
            f"{n_points} points of {point_size} bytes are too much for {size} bytes of the file"
        )


def _line(text: str) -> str:
    return " ".join(text.split())


def _type_and_bits(node: Any) -> tuple[np.dtype[Any], int] | None:
    """Type that holds the values of a field, and the bits they take; None of text."""
    from pye57 import libe57

    if isinstance(node, libe57.FloatNode):
        single = node.precision() == libe57.E57_SINGLE
        return (np.dtype(np.float32), 32) if single else (np.dtype(np.float64), 64)
    if isinstance(node, libe57.ScaledIntegerNode | libe57.IntegerNode):
        low, high = node.minimum(), node.maximum()
        bits = (high - low).bit_length()
        if isinstance(node, libe57.ScaledIntegerNode):
            return np.dtype(np.float64), bits
        for dtype in _WHOLE:
            if np.iinfo(dtype).min <= low and high <= np.iinfo(dtype).max:
                return np.dtype(dtype), bits
    return None


def _positions(fields: Mapping[str, npt.NDArray[Any]], index: int) -> npt.NDArray[np.float64]:
    """Positions in the system of the scan, (n, 3); NaN where invalid."""
    if all(name in fields for name in _CARTESIAN):
        xyz = np.stack([fields[name] for name in _CARTESIAN], axis=1).astype(np.float64)
    elif all(name in fields for name in _SPHERICAL):
        length, azimuth, elevation = (fields[name].astype(np.float64) for name in _SPHERICAL)
        level = length * np.cos(elevation)
        xyz = np.stack(
            [level * np.cos(azimuth), level * np.sin(azimuth), length * np.sin(elevation)], axis=1
        )
    else:
        raise ValueError(f"scan {index} has no positions")
    for name in _INVALID:
        if name in fields:
            xyz[fields[name] != 0] = np.nan
    return xyz


def _moved(xyz: npt.NDArray[np.float64], node: Any) -> npt.NDArray[np.float64]:
    """Move positions by the pose of their scan, if it has one."""
    if not node.isDefined("pose"):
        return xyz
    pose = node["pose"]
    if pose.isDefined("rotation"):
        rotation = pose["rotation"]
        w, x, y, z = (float(rotation[name].value()) for name in "wxyz")
        length = w * w + x * x + y * y + z * z
        if length > 0.0:
            s = 2.0 / length
            matrix = np.array(
                [
                    [1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
                    [s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
                    [s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)],
                ]
            )
            xyz = xyz @ matrix.T
    if pose.isDefined("translation"):
        xyz = xyz + [float(pose["translation"][name].value()) for name in "xyz"]
    return xyz
