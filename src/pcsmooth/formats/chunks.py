"""Clouds larger than memory: files that are read and written piece by piece."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from types import TracebackType
from typing import BinaryIO, Literal, Protocol, Self

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats.atomic import atomic_write
from pcsmooth.formats.las.chunks import LasChunks, las_template, write_las_chunks
from pcsmooth.formats.ply.chunks import PlyChunks, write_ply_chunks
from pcsmooth.formats.registry import (
    PathLike,
    checked_arrays,
    coordinates_of,
    format_of,
    output_format,
)
from pcsmooth.formats.system_errors import named_system_errors

_HEAD = 1 << 16
"""Bytes that say of what format a file is."""


class CloudChunks(Protocol):
    """A file of points that is read piece by piece, any number of times.

    It stays open, and must while what came from its template is written: the rest of the file is
    copied from there. Use it in a ``with`` block; not from several threads at once.

    Attributes
    ----------
    name : str
        The file, as the user named it.
    count : int
        Number of points.
    dimension : int
        Number of coordinates, 2 or 3.
    template : PointCloud
        The cloud that `read_cloud` would give, without its points.
    """

    name: str
    count: int
    dimension: int
    template: PointCloud

    def read(self, rows: int, columns: bool = True) -> Iterator[PointCloud]:
        """Read all points from the first on, in the order of the file.

        Parameters
        ----------
        rows : int
            How many points a chunk has; the last one may have fewer. None is empty.
        columns : bool
            Whether the chunks get their columns too, or positions only.

        Returns
        -------
        iterator of PointCloud
            Chunks as `read_cloud` would give them if they were alone in the file.

        Raises
        ------
        CloudFileError
            While iterating: a value is malformed, or the file has changed.
        InvalidInputError
            `rows` is not positive.
        """

    def __enter__(self) -> Self:
        """Return the object itself."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the file."""


_READERS: dict[str, Callable[[BinaryIO, str, int | None], CloudChunks]] = {
    "ply": PlyChunks,
    "las": LasChunks,
    "laz": LasChunks,
}

_WRITERS: dict[str, Callable[[PointCloud, int, Iterable[PointCloud], BinaryIO, str], None]] = {
    "ply": write_ply_chunks,
    "las": partial(write_las_chunks, packed=False),
    "laz": partial(write_las_chunks, packed=True),
}

_TEMPLATES: dict[str, Callable[[PointCloud, Iterable[PointCloud]], PointCloud]] = {
    "las": las_template,
    "laz": las_template,
}

CHUNKED_FORMATS = tuple(_WRITERS)
"""Names of the formats that are read and written piece by piece."""


def open_chunks(source: PathLike | BinaryIO, dim: Literal["auto", 2, 3] = "auto") -> CloudChunks:
    """Open a file of points to be read piece by piece.

    Sizes are checked at once, values when they are read.

    Parameters
    ----------
    source : path
        The file. Streams are refused: they can be read only once.
    dim : {"auto", 2, 3}
        Number of coordinates, as `read_cloud` takes it.

    Returns
    -------
    CloudChunks
        To be closed by a ``with`` block.

    Raises
    ------
    CloudFileError
        A stream, a format that cannot be read piece by piece, or a file that cannot be opened or
        is cut short.
    InvalidInputError
        Unknown `dim`.
    """
    coordinates = coordinates_of(dim)
    if not isinstance(source, str | os.PathLike):
        raise _stream("<stdin>")
    path = os.fspath(source)
    with contextlib.ExitStack() as opened:
        with named_system_errors(path):
            file = opened.enter_context(open(path, "rb"))
            if not file.seekable():
                raise _stream(path)
            name = format_of(path, file.read(_HEAD))
        if name not in _READERS:
            raise CloudFileError(
                path, f"{name} files cannot be read piece by piece", "convert it to PLY first"
            )
        chunks = _READERS[name](file, path, coordinates)
        opened.pop_all()
    return chunks


def write_template(
    target: PathLike, template: PointCloud, chunks: Iterable[PointCloud]
) -> PointCloud:
    """Decide what the format of a file must know of all points before the first is written.

    Only LAS and LAZ must, and only of clouds that came from other files: how long their steps
    are. `stored_positions` of a chunk with the layout of the result tells what they make of it.

    Parameters
    ----------
    target : path
        Where the cloud will be written.
    template : PointCloud
        What `write_chunks` would be given.
    chunks : iterable of PointCloud
        All positions as they will be written; iterated only if they are needed. Of a plane cloud
        with a column ``z``, with this column.

    Returns
    -------
    PointCloud
        The template for `write_chunks`.

    Raises
    ------
    CloudFileError
        The suffix names no known format.
    """
    name = output_format(os.fspath(target), template)
    return _TEMPLATES[name](template, chunks) if name in _TEMPLATES else template


def write_chunks(
    target: PathLike,
    template: PointCloud,
    count: int,
    chunks: Iterable[PointCloud],
    *,
    overwrite: bool = True,
    tell: Callable[[str], object] | None = None,
) -> None:
    """Write a file of points piece by piece.

    The bytes are those that `write_cloud` would write if it had all points at once. A file is
    replaced as a whole or, after any error, not at all; it may be the one that is being read.

    Parameters
    ----------
    target : path
        Where to write.
    template : PointCloud
        Columns, types, comments and layout of the file; its points, if any, are not written.
        `write_template` completes that of a cloud that came from a file of another format.
    count : int
        How many points there will be.
    chunks : iterable of PointCloud
        The points, with the columns of the template in the same order. It is iterated while the
        file is written.
    overwrite : bool
        Whether a file that is there, or comes to be there meanwhile, is replaced.
    tell : callable, optional
        Gets a phrase for each attribute of a replaced file that could not be kept.

    Raises
    ------
    CloudFileError
        The file cannot, or must not, be written, or not piece by piece.
    InvalidInputError
        The chunks hold more or fewer points, or something else than the template; a column that
        is typed by its values, such as long whole numbers, must agree in all of them.
    """
    path = os.fspath(target)
    name = output_format(path, template)
    if name not in _WRITERS:
        raise CloudFileError(
            path, f"{name} files cannot be written piece by piece", "write .ply instead"
        )
    if count < 0:
        raise InvalidInputError(f"a file cannot have {count} points")
    template = checked_arrays(template)
    with (
        named_system_errors(path),
        atomic_write(path, overwrite=overwrite, tell=tell) as file,
    ):
        _WRITERS[name](template, count, _checked(chunks, count), file, path)


def _checked(chunks: Iterable[PointCloud], count: int) -> Iterator[PointCloud]:
    """Give chunks on that have points; an error unless they have so many together."""
    missing = count
    for chunk in map(checked_arrays, chunks):
        missing -= len(chunk)
        if missing < 0:
            break
        if len(chunk):
            yield chunk
    if missing:
        much = "more" if missing < 0 else f"{missing} fewer"
        raise InvalidInputError(f"the chunks hold {much} than the promised {count} points")


def _stream(path: str) -> CloudFileError:
    return CloudFileError(path, "a stream cannot be read piece by piece", "save it to a file first")
