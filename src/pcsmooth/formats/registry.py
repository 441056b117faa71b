"""The formats by name, and the one door to read and write each of them."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import BinaryIO, Literal, cast

import numpy as np

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats.atomic import atomic_write
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.cloud_file import CloudFile, MakeTemplate, WriteChunks
from pcsmooth.formats.compression import (
    Forward,
    beginning,
    check_compression,
    compression_of,
    packing,
    unpack,
    without_compression,
)
from pcsmooth.formats.las.checks import is_las, is_laz
from pcsmooth.formats.las.positions import check_las, stored_in_las
from pcsmooth.formats.las.reader import LasChunks
from pcsmooth.formats.las.writer import las_template, lost_in_las, write_las
from pcsmooth.formats.layout import Layout
from pcsmooth.formats.mesh.at_once import open_mesh, write_mesh
from pcsmooth.formats.mesh.obj import read_obj, write_obj
from pcsmooth.formats.mesh.off import is_off, read_off, write_off
from pcsmooth.formats.mesh.stl import (
    check_stl,
    is_stl,
    lost_in_stl,
    read_stl,
    stored_in_stl,
    write_stl,
)
from pcsmooth.formats.mesh.vertex_lines import lost_in_lines
from pcsmooth.formats.pcd.header import is_pcd
from pcsmooth.formats.pcd.reader import open_pcd
from pcsmooth.formats.pcd.writer import lost_in_pcd, pcd_template, write_pcd
from pcsmooth.formats.ply.header import is_ply
from pcsmooth.formats.ply.reader import PlyChunks
from pcsmooth.formats.ply.writer import lost_in_ply, ply_template, write_ply
from pcsmooth.formats.stations.e57 import E57Chunks, is_e57
from pcsmooth.formats.stations.ptx import PtxChunks, is_ptx
from pcsmooth.formats.stored_positions import StoredPositions, stored_as_floats
from pcsmooth.formats.system_errors import named_system_errors
from pcsmooth.formats.text.axes import Columns
from pcsmooth.formats.text.reader import TextChunks
from pcsmooth.formats.text.writer import lost_in_text, write_text
from pcsmooth.formats.unchanged import Unchanged

Naming = Literal["ply", "pcd", "las", "text", "mesh"]
"""Families of formats that give columns the same names."""


@dataclass(frozen=True)
class Format:
    """What there is to know of a format.

    Attributes
    ----------
    name : str
        Its name, which is also the suffix of its files.
    naming : {"ply", "pcd", "las", "text", "mesh"}
        What it calls the columns of estimates.
    open : callable
        Takes a file and the number of coordinates wanted, and finds what is in it.
    write : WriteChunks or None
        Writes files; None if they can only be read.
    lost : callable
        Takes a cloud and says what of it a file would not keep.
    stored : callable
        Takes a cloud and the name of the file in errors; gives the positions that would be kept.
    is_it : callable
        Takes how a file begins and says whether that is the format beyond doubt.
    check : callable
        Takes a cloud and the name of the file in errors; raises what stands against writing it.
    template : MakeTemplate
        Completes a template; by default there is nothing to complete.
    in_pieces : bool
        Whether it is written piece by piece.
    """

    name: str
    naming: Naming
    open: Callable[[ByteSource, int | None], CloudFile]
    write: WriteChunks | None
    lost: Callable[[PointCloud], list[str]]
    stored: Callable[[PointCloud, str], StoredPositions] = stored_as_floats
    is_it: Callable[[bytes], bool] = lambda _head: False
    check: Callable[[PointCloud, str], object] = lambda _cloud, _path: None
    template: MakeTemplate = lambda template, _chunks, _path: template
    in_pieces: bool = True


def _text(name: str) -> Format:
    return Format(
        name,
        "text",
        partial(TextChunks, format_name=name),
        partial(write_text, format_name=name),
        partial(lost_in_text, format_name=name),
    )


def _mesh(
    name: str,
    read: Callable[[bytes, str, int | None], PointCloud],
    write: Callable[[PointCloud, BinaryIO, str], None],
) -> Format:
    return Format(
        name,
        "mesh",
        partial(open_mesh, read=read),
        partial(write_mesh, write=write),
        partial(lost_in_lines, format_name=name),
        in_pieces=False,
    )


def _nothing(_cloud: PointCloud) -> list[str]:
    return []


_LAS = Format(
    "las",
    "las",
    LasChunks,
    partial(write_las, packed=False),
    lost_in_las,
    stored_in_las,
    is_las,
    check_las,
    las_template,
)
TABLE = {
    format.name: format
    for format in (
        Format(
            "ply", "ply", PlyChunks, write_ply, lost_in_ply, is_it=is_ply, template=ply_template
        ),
        *map(_text, ("xyz", "xy", "txt", "asc", "csv", "pts")),
        _LAS,
        replace(
            _LAS, name="laz", write=partial(write_las, packed=True), is_it=is_laz,
        ),
        Format("pcd", "pcd", open_pcd, write_pcd, lost_in_pcd, is_it=is_pcd, template=pcd_template),
        Format("e57", "ply", E57Chunks, None, _nothing, is_it=is_e57),
        Format("ptx", "ply", PtxChunks, None, _nothing, is_it=is_ptx),
        _mesh("obj", read_obj, write_obj),
        replace(_mesh("off", read_off, write_off), is_it=is_off),
        replace(
            _mesh("stl", read_stl, write_stl), lost=lost_in_stl, stored=stored_in_stl,
            is_it=is_stl, check=check_stl,
        ),
    )
}  # fmt: skip
"""Every format by its name."""

FORMATS = tuple(TABLE)
"""Names of the formats, each also the suffix of its files."""

WRITTEN_FORMATS = tuple(name for name, format in TABLE.items() if format.write is not None)
"""Names of the formats that can be written."""

_DEFAULT = "ply"
"""Format of clouds whose own cannot be written, or that have none."""

HEAD = 1 << 16
"""Bytes that say of what format a file is."""

_COPC = ".copc.laz"
"""How the names of files end that are LAZ with an index, which is not written."""

PathLike = str | os.PathLike[str]


def read_cloud(
    source: PathLike | BinaryIO,
    *,
    dim: Literal["auto", 2, 3] = "auto",
    format: str | None = None,
    columns: Columns | None = None,
) -> PointCloud:
    r"""Read a point cloud from a file or a stream.

    Parameters
    ----------
    source : path or binary stream
        What to read. A stream is read to its end and need not be seekable.
    dim : {"auto", 2, 3}
        Number of coordinates. ``"auto"`` takes what the file says: its header, the suffix
        ``.xy``, or two columns.
    format : str, optional
        One of `FORMATS`; by default the content and the suffix say.
    columns : sequence of str or int, optional
        Columns of x, y and z, or of x and y, in a text file: names, or numbers from 1. By default
        the header says, in words that are known, or they are the first; where neither is sure,
        that is an error.

    Returns
    -------
    PointCloud
        Row i is point i of the file; an empty text file gives no points.

    Raises
    ------
    CloudFileError
        The file cannot be opened, changes while it is read, or is not a whole and well-formed
        point cloud.
    PcsmoothError
        A library that the format needs is not installed.
    InvalidInputError
        Unknown `dim` or `format`, or as many `columns` as no point has coordinates.

    Examples
    --------
    >>> import io
    >>> cloud = read_cloud(io.BytesIO(b"0 1 fixed\n2.5 3\n"))
    >>> cloud.points.tolist(), cloud.fixed_marks.tolist()
    ([[0.0, 1.0], [2.5, 3.0]], [True, False])
    >>> read_cloud(io.BytesIO(b"7 0 1 2\n"), columns=[2, 3, 4]).points.tolist()
    [[0.0, 1.0, 2.0]]
    """
    coordinates = coordinates_of(dim, columns)
    _check_name(format)
    if isinstance(source, str | os.PathLike):
        path = os.fspath(source)
        with named_system_errors(path), open(path, "rb") as file:
            unchanged = Unchanged(path)
            data = file.read()
        cloud = _read(data, path, path, format, coordinates, columns)
        unchanged.check()  # only now, as some libraries read the file by its name
        return cloud
    with named_system_errors("<stdin>"):
        data = source.read()
    return _read(data, "<stdin>", None, format, coordinates, columns)


def _read(
    data: bytes,
    path: str,
    name: str | None,
    format: str | None,
    coordinates: int | None,
    columns: Columns | None,
) -> PointCloud:
    """Read the cloud of a file in memory, perhaps of a name that may say the format."""
    file = io.BytesIO(data)
    is_packed = bool(compression_of(data))
    if is_packed:
        file = io.BytesIO()
        unpack(io.BytesIO(data), file, path)
        file.seek(0)
    head = file.read(HEAD)
    with open_source(
        format or format_of(name, head), file, path, coordinates, columns, is_packed=is_packed
    ) as opened:
        return opened.whole()


def write_cloud(
    cloud: PointCloud,
    target: PathLike | BinaryIO,
    *,
    format: str | None = None,
    overwrite: bool = True,
    tell: Callable[[str], object] | None = None,
) -> None:
    """Write a point cloud to a file or a stream.

    A file is replaced as a whole or, after any error, not at all. It keeps owner, group, mode,
    access list and extended attributes where that is permitted, but no setuid and setgid bits.

    Parameters
    ----------
    cloud : PointCloud
        What to write. Its layout is used where it is of the same kind of format.
    target : path or binary stream
        Where to write.
    format : str, optional
        One of `FORMATS`; by default as `output_format` says.
    overwrite : bool
        Whether a file that is there, or comes to be there meanwhile, is replaced.
    tell : callable, optional
        Gets a phrase for each attribute of a replaced file that could not be kept.

    Raises
    ------
    CloudFileError
        The file cannot, or must not, be written, or its format cannot hold the cloud.
    InvalidInputError
        Unknown `format`, a masked column or one of another length than the cloud, or points that
        are not real numbers.
    """
    cloud = checked_arrays(cloud)
    if not isinstance(target, str | os.PathLike):
        name = output_format(None, cloud, format)
        with named_system_errors("<stdout>"), _taking_all(target) as stream:
            _write(cloud, stream, "<stdout>", name)
        return
    path = os.fspath(target)
    name = output_format(path, cloud, format)
    with (
        named_system_errors(path),
        atomic_write(path, overwrite=overwrite, tell=tell) as file,
        packing(file, path) as whole,
    ):
        _write(cloud, whole, path, name)


@contextmanager
def _taking_all(stream: BinaryIO) -> Iterator[BinaryIO]:
    """Give a stream that takes all of what it gets, as those without a buffer need not."""
    if not isinstance(stream, io.RawIOBase):
        yield cast(BinaryIO, Forward(stream))
        return
    buffered = io.BufferedWriter(stream)
    try:
        yield cast(BinaryIO, Forward(buffered))
        buffered.flush()
    finally:
        with suppress(OSError):  # of what comes after another
            buffered.detach()


def coordinates_of(dim: Literal["auto", 2, 3], columns: Columns | None = None) -> int | None:
    """Say how many coordinates a reader is to take; None where the file says.

    Raises
    ------
    InvalidInputError
        Unknown `dim`, or as many `columns` as no point has coordinates.
    """
    if dim not in ("auto", 2, 3):
        raise InvalidInputError(f"dim must be 'auto', 2 or 3, not {dim!r}")
    if columns is not None and len(columns) not in ((2, 3) if dim == "auto" else (dim,)):
        wanted = "2 or 3" if dim == "auto" else dim
        raise InvalidInputError(
            f"columns must be those of {wanted} coordinates, not {len(columns)}"
        )
    return None if dim == "auto" else dim


def checked_arrays(cloud: PointCloud) -> PointCloud:
    """Convert the points of a cloud to double precision, in which all writers expect them.

    Raises
    ------
    InvalidInputError
        A masked array, a column of another length than the cloud, or points that are not real
        numbers, so that they cannot be written as rows.
    """
    if cloud.points.dtype.kind not in "iuf":
        raise InvalidInputError(
            f"points are not real numbers, but of type {cloud.points.dtype}; convert them to float"
        )
    if np.ma.is_masked(cloud.points):
        raise InvalidInputError("points are masked; fill them (numpy.ma.filled)")
    for name, column in cloud.columns.items():
        if np.ma.is_masked(column):
            raise InvalidInputError(f"column '{name}' is masked; fill it (numpy.ma.filled)")
        if len(column) != len(cloud):
            raise InvalidInputError(
                f"column '{name}' has {len(column)} rows, the cloud has {len(cloud)}"
            )
    return replace(cloud, points=np.asarray(cloud.points, np.float64))


def format_of(path: str | None, head: bytes = b"") -> str:
    r"""Name of the format of a file to be read.

    Parameters
    ----------
    path : str or None
        Name of the file; None for a stream.
    head : bytes
        How the file begins.

    Returns
    -------
    str
        What the first bytes say, whatever the name; else what the suffix says; else ``"txt"``.
        Of a compressed file it is that of what it holds.

    Examples
    --------
    >>> format_of("scan.XYZ"), format_of("scan.xyz", b"ply\n"), format_of(None, b"1 2 3")
    ('xyz', 'ply', 'txt')
    """
    head = beginning(head)
    found = next((name for name, format in TABLE.items() if format.is_it(head)), None)
    return found or _format_of_suffix(path) or "txt"


def format_of_file(path: str) -> tuple[str, str]:
    """Say of what format a file is, and how it is compressed.

    Parameters
    ----------
    path : str
        The file.

    Returns
    -------
    name, compression : str
        One of `FORMATS`; and ``"gzip"`` or ``"zstd"``, or nothing.

    Raises
    ------
    OSError
        It cannot be read.
    """
    with open(path, "rb") as file:
        head = file.read(HEAD)
    return format_of(path, head), compression_of(head)


def output_format(
    path: str | None, cloud: PointCloud | None = None, format: str | None = None
) -> str:
    """Name of the format of a file to be written.

    Parameters
    ----------
    path : str or None
        Name of the file; None for a stream.
    cloud : PointCloud, optional
        What will be written; on a stream its own format is the default.
    format : str, optional
        One of `FORMATS`; comes before all else.

    Returns
    -------
    str
        One of `WRITTEN_FORMATS`; ``"ply"`` where nothing says otherwise.

    Raises
    ------
    CloudFileError
        A file name without a known suffix, or a format that can only be read, as COPC is.
    PcsmoothError
        The library that compresses such a file is not installed.
    InvalidInputError
        Unknown `format`.
    """
    _check_name(format)
    check_compression(path or "")
    name = format
    if name is None and path is None:
        layout = None if cloud is None else cloud.layout
        name = layout.format if isinstance(layout, Layout) else _DEFAULT
    elif name is None:
        name = _format_of_suffix(path)
    known = f"use one of {', '.join(f'.{name}' for name in WRITTEN_FORMATS)}"
    if name is None:
        raise CloudFileError(str(path), "its suffix names no known format", known)
    if path is not None and _is_copc(path) and format is None:
        raise CloudFileError(
            path, "COPC can be read but not written", "name it .laz, without .copc"
        )
    if name not in WRITTEN_FORMATS:
        raise CloudFileError(path or "<stdout>", f".{name} can be read but not written", known)
    return name


def result_name(source: str) -> tuple[str, str]:
    """Name of a result that is to be as its source: the same, unless that can only be read.

    Parameters
    ----------
    source : str
        Name of the source, without its folder.

    Returns
    -------
    stem, suffix : str
        The name before its last dot, without the ``.copc`` of an index that is not written, and
        the rest.

    Examples
    --------
    >>> result_name("a.LAZ"), result_name("a.e57"), result_name("a.copc.laz"), result_name("a")
    (('a', '.LAZ'), ('a', '.ply'), ('a', '.laz'), ('a', ''))
    >>> result_name("a.xyz.gz")
    ('a', '.xyz.gz')
    """
    inner, packed = without_compression(source)
    stem, suffix = os.path.splitext(inner)
    if _is_copc(source):
        stem = os.path.splitext(stem)[0]
    name = suffix[1:].lower()
    only_read = name in FORMATS and name not in WRITTEN_FORMATS
    return stem, (f".{_DEFAULT}" if only_read else suffix) + packed


def has_known_suffix(path: str) -> bool:
    """Whether the name of a file says that it is of a known format, perhaps compressed."""
    return _format_of_suffix(path) is not None


def naming_of(format: str) -> Naming:
    """Family of a format, one of `FORMATS`, by which the columns of estimates have their names."""
    _check_name(format)
    return TABLE[format].naming


def is_text(format: str) -> bool:
    """Whether files of a format, one of `FORMATS`, may be shown on a terminal."""
    return naming_of(format) == "text"


def check_cloud(cloud: PointCloud, format: str, path: str) -> None:
    """Find out early whether a cloud can be written in a format.

    Parameters
    ----------
    cloud : PointCloud
        What is to be written, whatever its positions will be.
    format : str
        One of `FORMATS`.
    path : str
        Name of the file in errors.

    Raises
    ------
    CloudFileError
        The format cannot hold such a cloud.
    """
    _check_name(format)
    TABLE[format].check(cloud, path)


def stored_positions(cloud: PointCloud, format: str, path: str) -> StoredPositions:
    """Find out what a format keeps of the positions of a cloud.

    Parameters
    ----------
    cloud : PointCloud
        What is to be written.
    format : str
        One of `FORMATS`.
    path : str
        Name of the file in errors.

    Returns
    -------
    StoredPositions
        What would be read back, and what to say of it.

    Raises
    ------
    CloudFileError
        The format cannot hold the positions.
    InvalidInputError
        Unknown `format`, or arrays that `write_cloud` refuses.
    """
    _check_name(format)
    return TABLE[format].stored(checked_arrays(cloud), path)


def lost_in(cloud: PointCloud, format: str) -> list[str]:
    """Say what of a cloud a format would not keep.

    Parameters
    ----------
    cloud : PointCloud
        What would be written.
    format : str
        One of `FORMATS`.

    Returns
    -------
    list of str
        Phrases such as ``"element 'face' (1234 rows)"``; empty if all is kept.

    Raises
    ------
    InvalidInputError
        Unknown `format`.
    """
    _check_name(format)
    return TABLE[format].lost(cloud)


def open_source(
    name: str,
    file: BinaryIO,
    path: str,
    coordinates: int | None,
    columns: Columns | None,
    *,
    is_packed: bool = False,
) -> CloudFile:
    """Open a cloud in a file of a format.

    Parameters
    ----------
    name : str
        Name of the format.
    file : binary file
        Open for reading, and seekable.
    path : str
        Name of the file in errors.
    coordinates : {2, 3} or None
        Number of coordinates; None where the file says.
    columns : sequence of str or int, optional
        Columns of these in a text file, as `read_cloud` takes them.
    is_packed : bool
        Whether it is what a compressed file of that path holds.

    Raises
    ------
    CloudFileError
        What it holds cannot be found, or columns are chosen in a file that is no text.
    """
    source = ByteSource(file, path, is_packed=is_packed)
    if columns is None:
        return TABLE[name].open(source, coordinates)
    if not is_text(name):
        raise CloudFileError(
            path,
            f"{name} files say which columns are coordinates",
            "choose them (--columns) in text files only",
        )
    return TextChunks(source, coordinates, name, columns)


def _write(cloud: PointCloud, file: BinaryIO, path: str, name: str) -> None:
    write = TABLE[name].write
    assert write is not None  # `output_format` has seen to that
    write(cloud, len(cloud), [cloud], file, path)


def _is_copc(path: str) -> bool:
    return without_compression(path)[0].lower().endswith(_COPC)


def _format_of_suffix(path: str | None) -> str | None:
    suffix = os.path.splitext(without_compression(path or "")[0])[1][1:].lower()
    return suffix if suffix in FORMATS else None


def _check_name(format: str | None) -> None:
    if format is not None and format not in FORMATS:
        raise InvalidInputError(f"format must be one of {', '.join(FORMATS)}, not {format!r}")
