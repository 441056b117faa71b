"""The formats by name, and the one door to read and write each of them."""

from __future__ import annotations

import os
from typing import BinaryIO, Literal

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats.atomic import atomic_write
from pcsmooth.formats.ply import PlyLayout, read_ply, write_ply
from pcsmooth.formats.ply_header import is_ply
from pcsmooth.formats.ply_types import has_long_numbers
from pcsmooth.formats.system_errors import named_system_errors
from pcsmooth.formats.text_layout import HEADERLESS, TextLayout
from pcsmooth.formats.text_reader import read_text
from pcsmooth.formats.text_writer import write_text, written_names

FORMATS = ("ply", "xyz", "xy", "txt", "asc", "csv", "pts")
"""Names of the formats, each also the suffix of its files."""

PathLike = str | os.PathLike[str]


def read_cloud(
    source: PathLike | BinaryIO,
    *,
    dim: Literal["auto", 2, 3] = "auto",
    format: str | None = None,
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

    Returns
    -------
    PointCloud
        Row i is point i of the file; an empty text file gives no points.

    Raises
    ------
    CloudFileError
        The file cannot be opened, or is not a whole and well-formed point cloud.
    InvalidInputError
        Unknown `dim` or `format`.

    Examples
    --------
    >>> import io
    >>> cloud = read_cloud(io.BytesIO(b"0 1 fixed\n2.5 3\n"))
    >>> cloud.points.tolist(), cloud.fixed_marks.tolist()
    ([[0.0, 1.0], [2.5, 3.0]], [True, False])
    """
    coordinates = coordinates_of(dim)
    _check_name(format)
    if isinstance(source, str | os.PathLike):
        path = suffixed = os.fspath(source)
        with named_system_errors(path), open(path, "rb") as file:
            data = file.read()
    else:
        path, suffixed = "<stdin>", None
        with named_system_errors(path):
            data = source.read()

    name = format or format_of(suffixed, data)
    if name == "ply":
        return read_ply(data, path, coordinates)
    return read_text(data, path, coordinates, name)


def write_cloud(
    cloud: PointCloud, target: PathLike | BinaryIO, *, format: str | None = None
) -> None:
    """Write a point cloud to a file or a stream.

    A file is replaced as a whole or, after any error, not at all.

    Parameters
    ----------
    cloud : PointCloud
        What to write. Its layout is used where it is of the same kind of format.
    target : path or binary stream
        Where to write.
    format : str, optional
        One of `FORMATS`; by default as `output_format` says.

    Raises
    ------
    CloudFileError
        The file cannot be written, or its format cannot hold the cloud.
    InvalidInputError
        Unknown `format`, or a column of another length than the cloud.
    """
    check_lengths(cloud)
    if not isinstance(target, str | os.PathLike):
        name = output_format(None, cloud, format)
        with named_system_errors("<stdout>"):
            _write(cloud, target, "<stdout>", name)
        return
    path = os.fspath(target)
    name = output_format(path, cloud, format)
    with named_system_errors(path), atomic_write(path) as file:
        _write(cloud, file, path, name)


def coordinates_of(dim: Literal["auto", 2, 3]) -> int | None:
    """Say how many coordinates a reader is to take; None where the file says.

    Raises
    ------
    InvalidInputError
        Unknown `dim`.
    """
    if dim not in ("auto", 2, 3):
        raise InvalidInputError(f"dim must be 'auto', 2 or 3, not {dim!r}")
    return None if dim == "auto" else dim


def check_lengths(cloud: PointCloud) -> None:
    """Raise `InvalidInputError` if a column has another length than the cloud."""
    for name, column in cloud.columns.items():
        if len(column) != len(cloud):
            raise InvalidInputError(
                f"column '{name}' has {len(column)} rows, the cloud has {len(cloud)}"
            )


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
        ``"ply"`` for what begins like PLY, whatever its name; else what the suffix says; else
        ``"txt"``.

    Examples
    --------
    >>> format_of("scan.XYZ"), format_of("scan.xyz", b"ply\n"), format_of(None, b"1 2 3")
    ('xyz', 'ply', 'txt')
    """
    if is_ply(head):
        return "ply"
    return _format_of_suffix(path) or "txt"


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
        One of `FORMATS`; ``"ply"`` where nothing says otherwise.

    Raises
    ------
    CloudFileError
        A file name without a known suffix.
    InvalidInputError
        Unknown `format`.
    """
    _check_name(format)
    if format is not None:
        return format
    if path is None:
        layout = None if cloud is None else cloud.layout
        return layout.format if isinstance(layout, TextLayout) else "ply"
    name = _format_of_suffix(path)
    if name is None:
        known = ", ".join(f".{name}" for name in FORMATS)
        raise CloudFileError(path, "its suffix names no known format", f"use one of {known}")
    return name


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
    if format == "ply":
        return [
            f"digits of the long numbers in column '{name}'"
            for name, column in cloud.columns.items()
            if has_long_numbers(column)
        ]
    lost = cloud.layout.other_elements if isinstance(cloud.layout, PlyLayout) else []
    kept = written_names(cloud, format)
    for name, column in cloud.columns.items():
        if name not in kept:
            lost.append(f"{'lists' if column.dtype.kind == 'O' else 'column'} '{name}'")
    alike = isinstance(cloud.layout, TextLayout) and cloud.layout.format == format
    if cloud.comments and not alike:
        lost.append("the comments")
    if (
        format in HEADERLESS
        and not alike
        and isinstance(cloud.layout, TextLayout)
        and cloud.layout.labels
    ):
        lost.append("the column names")
    return lost


def _write(cloud: PointCloud, file: BinaryIO, path: str, name: str) -> None:
    if name == "ply":
        write_ply(cloud, file, path)
    else:
        write_text(cloud, file, path, name)


def _format_of_suffix(path: str | None) -> str | None:
    suffix = os.path.splitext(path or "")[1][1:].lower()
    return suffix if suffix in FORMATS else None


def _check_name(format: str | None) -> None:
    if format is not None and format not in FORMATS:
        raise InvalidInputError(f"format must be one of {', '.join(FORMATS)}, not {format!r}")
