"""E57: every scan of a file in one cloud, reading only."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from pcsmooth.cleanup import temporary_folder
from pcsmooth.cloud import COLORS
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.axis_names import normals_among
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.stations.scans import Scan, ScanChunks, ScanPoints, moved
from pcsmooth.formats.unchanged import Unchanged
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


class E57Chunks(ScanChunks):
    """The points of an E57 file, those of each scan moved by its pose.

    Points that the file says are invalid are NaN. Fields of text are left out; comments say so.

    Parameters
    ----------
    source : ByteSource
        The file; if there is one of its name, that is what the library reads.
    dim : {2, 3} or None
        Number of coordinates; with 2 the third is a column.

    Raises
    ------
    CloudFileError
        Not E57, damaged, cut short, or a scan without positions.
    PcsmoothError
        pye57 is not installed.
    """

    def __init__(self, source: ByteSource, dim: int | None) -> None:
        optional_library("pye57", "e57", ".e57 files")
        if not is_e57(source.read(0, min(source.size, len(_MAGIC)))):
            raise CloudFileError(source.path, "not an E57 file", "check the file or its suffix")
        with contextlib.ExitStack() as opened:
            self._library_name = opened.enter_context(_named(source))
            with _reading(source):
                self._by_name = Unchanged(self._library_name)
            with _reading(source), _image(self._library_name) as image:
                self._fields, comments = _fields_of_scans(image, source.size)
            self._opened = opened.pop_all()
        scans = [Scan(fields.size, fields.column_types) for fields in self._fields]
        super().__init__(source, dim, scans, comments)

    def __exit__(self, *failure: Any) -> None:
        """Close the file."""
        self._opened.close()
        super().__exit__(*failure)

    def _check(self) -> None:
        """Raise `CloudFileError` if what the library reads is not what was opened."""
        self.source.check()
        self._by_name.check()

    def _blocks(self, rows: int) -> Iterator[tuple[int, ScanPoints]]:
        self._check()
        with contextlib.ExitStack() as opened:
            with _reading(self.source):
                image = opened.enter_context(_image(self._library_name))
            for number, fields in enumerate(self._fields):
                for points in self._points(image, number, fields, min(rows, fields.size)):
                    yield number, points

    def _points(self, image: Any, number: int, fields: _Fields, rows: int) -> Iterator[ScanPoints]:
        """Read the points of a scan, so many at a time."""
        from pye57 import libe57

        reader, n_read = None, 0
        values = {
            name: np.empty(rows, _BUFFERS.get(kind, kind)) for name, kind in fields.types.items()
        }
        while n_read < fields.size:
            self._check()
            with _reading(self.source):
                node = image.root()["data3D"][number]
                if reader is None:
                    buffers = libe57.VectorSourceDestBuffer()
                    for name, column in values.items():
                        buffers.append(
                            libe57.SourceDestBuffer(image, name, column, rows, True, True)
                        )
                    reader = node["points"].reader(buffers)
                size = min(reader.read(), fields.size - n_read)
                if size == 0:
                    raise ValueError(f"scan {number} holds {n_read} points of {fields.size}")
                found = {
                    name: column[:size].astype(fields.types[name])
                    for name, column in values.items()
                }
                xyz = _at_their_place(_positions(found), node)
            n_read += size
            yield ScanPoints(xyz, {new: found[old] for new, old in fields.columns.items()})


class _Fields(NamedTuple):
    """The fields of a scan.

    Attributes
    ----------
    size : int
        Number of points.
    types : dict of str to numpy.dtype
        Types of those that are numbers.
    columns : dict of str to str
        The columns of the cloud, and the fields that hold them.
    """

    size: int
    types: dict[str, np.dtype[Any]]
    columns: dict[str, str]

    @property
    def column_types(self) -> dict[str, np.dtype[Any]]:
        """Types of the columns."""
        return {column: self.types[field] for column, field in self.columns.items()}


@contextlib.contextmanager
def _reading(source: ByteSource) -> Iterator[None]:
    """Turn what the library raises into `CloudFileError`."""
    path = source.path
    try:
        yield
    except CloudFileError:
        raise
    except ValueError as error:
        source.check()
        raise CloudFileError(path, excerpt(str(error)), "export it again") from error
    except Exception as error:  # the library's own, some of which are plain exceptions
        source.check()
        raise CloudFileError(
            path,
            f"cannot be read as E57 ({excerpt(_line(str(error)))})",
            "get the whole file again",
        ) from error


@contextlib.contextmanager
def _named(source: ByteSource) -> Iterator[str]:
    """Name of a file with the data; the library opens nothing else."""
    if os.path.isfile(source.path) and not source.is_packed:
        yield source.path
        return
    remove_abandoned(tempfile.gettempdir())
    with temporary_folder(folder_prefix("stream")) as folder:
        name = os.path.join(folder, "stream.e57")
        with open(name, "wb") as file:
            file.writelines(source.blocks(0, source.size))
        yield name


@contextlib.contextmanager
def _image(name: str) -> Iterator[Any]:
    from pye57 import libe57

    image = libe57.ImageFile(name, "r")
    try:
        yield image
    finally:
        image.close()


def _fields_of_scans(image: Any, size: int) -> tuple[list[_Fields], list[str]]:
    """Fields of each scan, and what the file, of so many bytes, says of them."""
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
        fields, left_out, n_bits = _fields_of_scan(node, index, room)
        scans.append(fields)
        room -= n_bits  # two scans do not share their points
        comments += [f"scan {index}: text {name} is left out" for name in left_out]
    n_names = len({name for fields in scans for name in fields.columns}) + 1
    _check_size(sum(fields.size for fields in scans), 8 * n_names, size)
    return scans, comments


def _fields_of_scan(node: Any, index: int, room: int) -> tuple[_Fields, list[str], int]:
    """Fields of a scan, names of those that are text, and bits that its points take."""
    from pye57 import libe57
    from pye57.utils import get_fields, get_node

    points = node["points"]
    prototype = libe57.StructureNode(points.prototype())
    nodes = {name: get_node(prototype, name) for name in get_fields(prototype)}
    numeric = {name: _type_and_bits(field) for name, field in nodes.items()}
    types = {name: known[0] for name, known in numeric.items() if known is not None}
    n_points = points.childCount()
    n_bits = n_points * max(sum(known[1] for known in numeric.values() if known is not None), 1)
    if n_bits > room:
        raise ValueError(
            f"scan {index} promises {n_points} points, which do not fit into the {room // 8} bytes "
            "of the file"
        )
    _check_size(n_points, sum(dtype.itemsize for dtype in types.values()), room // 8)
    if not any(all(name in types for name in names) for names in (_CARTESIAN, _SPHERICAL)):
        raise ValueError(f"scan {index} has no positions")
    plain = {name.removeprefix(_NORMALS_PREFIX): name for name in types}
    normals = {plain[name]: normal for name, normal in normals_among(plain).items()}
    names = _COLOR_FIELDS | normals
    columns = {
        names.get(name, name): name
        for name in types
        if name not in (*_CARTESIAN, *_SPHERICAL, *_INVALID)
    }
    return _Fields(n_points, types, columns), [n for n in numeric if n not in types], n_bits


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


def _positions(fields: Mapping[str, npt.NDArray[Any]]) -> npt.NDArray[np.float64]:
    """Positions in the system of the scan, (n, 3); NaN where invalid."""
    if all(name in fields for name in _CARTESIAN):
        xyz = np.stack([fields[name] for name in _CARTESIAN], axis=1).astype(np.float64)
    else:
        length, azimuth, elevation = (fields[name].astype(np.float64) for name in _SPHERICAL)
        level = length * np.cos(elevation)
        xyz = np.stack(
            [level * np.cos(azimuth), level * np.sin(azimuth), length * np.sin(elevation)], axis=1
        )
    for name in _INVALID:
        if name in fields:
            xyz[fields[name] != 0] = np.nan
    return xyz


def _at_their_place(xyz: npt.NDArray[np.float64], node: Any) -> npt.NDArray[np.float64]:
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
            xyz = moved(xyz, matrix.T, np.zeros(3))
    if pose.isDefined("translation"):
        xyz = xyz + [float(pose["translation"][name].value()) for name in "xyz"]
    return xyz
