"""Clouds larger than memory: files that are read and written piece by piece."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable, Iterator
from tempfile import TemporaryFile
from typing import BinaryIO, Literal, cast

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats.atomic import atomic_write
from pcsmooth.formats.cloud_file import CloudChunks
from pcsmooth.formats.compression import compression_of, packing, unpack
from pcsmooth.formats.registry import (
    HEAD,
    TABLE,
    PathLike,
    checked_arrays,
    coordinates_of,
    format_of,
    open_source,
    output_format,
)
from pcsmooth.formats.system_errors import named_system_errors
from pcsmooth.formats.text.axes import Columns

WRITTEN_IN_PIECES = tuple(
    name for name, format in TABLE.items() if format.write and format.in_pieces
)
"""Names of the formats that are written piece by piece."""


def open_chunks(
    source: PathLike | BinaryIO,
    dim: Literal["auto", 2, 3] = "auto",
    columns: Columns | None = None,
) -> CloudChunks:
    """Open a file of points to be read piece by piece.

    Sizes are checked at once, values when they are read. A compressed file is unpacked into a
    temporary one, without a name, which is gone when this is closed.

    Parameters
    ----------
    source : path
        The file. Streams are refused: they can be read only once.
    dim : {"auto", 2, 3}
        Number of coordinates, as `read_cloud` takes it.
    columns : sequence of str or int, optional
        Columns of these in a text file, as `read_cloud` takes them.

    Returns
    -------
    CloudChunks
        To be closed by a ``with`` block.

    Raises
    ------
    CloudFileError
        A stream, a file that can only be read at once, or one that cannot be opened or is cut
        short.
    InvalidInputError
        Unknown `dim`, or as many `columns` as no point has coordinates.
    """
    coordinates = coordinates_of(dim, columns)
    if not isinstance(source, str | os.PathLike):
        raise _stream("<stdin>")
    path = os.fspath(source)
    with contextlib.ExitStack() as opened:
        with named_system_errors(path):
            file: BinaryIO = opened.enter_context(open(path, "rb"))
            if not file.seekable():
                raise _stream(path)
            head = file.read(HEAD)
            is_packed = bool(compression_of(head))
            if is_packed:
                packed, file = file, cast(BinaryIO, opened.enter_context(TemporaryFile()))
                packed.seek(0)
                unpack(packed, file, path)
                packed.close()
                file.seek(0)
                head = file.read(HEAD)
            name = format_of(path, head)
        chunks = open_source(name, file, path, coordinates, columns, is_packed=is_packed)
        if not isinstance(chunks, CloudChunks):
            raise CloudFileError(
                path,
                f"it is {chunks.what}, which cannot be read piece by piece",
                "convert it to PLY first",
            )
        opened.pop_all()
    return chunks


def write_template(
    target: PathLike, template: PointCloud, chunks: Iterable[PointCloud]
) -> PointCloud:
    """Decide what the format of a file must know of all points before the first is written.

    LAS and LAZ must, of clouds that came from other files: how long their steps are, and which
    dimensions hold the columns. `stored_positions` of a chunk with the layout of the result tells
    what the steps make of it. PLY and PCD must where columns are typed by their values: words, as
    text has them, and in PLY long whole numbers.

    Parameters
    ----------
    target : path
        Where the cloud will be written.
    template : PointCloud
        What `write_chunks` would be given.
    chunks : iterable of PointCloud
        All points, with the positions and columns that will be written; iterated only if they
        are needed.

    Returns
    -------
    PointCloud
        The template for `write_chunks`.

    Raises
    ------
    CloudFileError
        The suffix names no known format, or a column holds words where they cannot be.
    """
    name = output_format(os.fspath(target), template)
    return TABLE[name].template(template, chunks, os.fspath(target))


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
    write = TABLE[name].write
    if write is None or not TABLE[name].in_pieces:
        raise CloudFileError(
            path, f"{name} files cannot be written piece by piece", "write .ply instead"
        )
    if count < 0:
        raise InvalidInputError(f"a file cannot have {count} points")
    template = checked_arrays(template)
    with (
        named_system_errors(path),
        atomic_write(path, overwrite=overwrite, tell=tell) as file,
        packing(file, path) as whole,
    ):
        write(template, count, _checked(chunks, count), whole, path)


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
