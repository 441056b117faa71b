"""The points of LAS and LAZ files as bytes; LAZ is packed and unpacked by lazrs."""

from __future__ import annotations

import io
import struct
from types import ModuleType

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.las_dimensions import point_type
from pcsmooth.formats.las_header import LasHeader
from pcsmooth.formats.optional_libraries import optional_library

_LIBRARY = ("lazrs", "las", ".laz files")

#: Points unpacked at a time: memory is taken as the data call for it, not the header.
_AT_A_TIME = 200_000

#: Bytes at which packed points begin, of where their chunks are listed.
_LISTED_AT = struct.Struct("<q")
#: Version and number of chunks, at which the list begins.
_LIST = struct.Struct("<II")

#: Layers of a chunk by point format; each extra byte has one more.
_LAYERS = {6: 9, 7: 10, 8: 11}


def check_lazrs() -> None:
    """Raise `PcsmoothError` if lazrs, which LAZ needs, is not installed."""
    optional_library(*_LIBRARY)


def read_points(data: bytes, start: int, header: LasHeader, path: str) -> bytes | bytearray:
    """Cut out the points of a file, or unpack them.

    Nothing is allocated before the file is known to hold it.

    Parameters
    ----------
    data : bytes
        The whole file.
    start : int
        Where the points begin.
    header : LasHeader
        The header.
    path : str
        Name of the file in errors.

    Returns
    -------
    bytes
        All points, one after the other.

    Raises
    ------
    CloudFileError
        Fewer points than the header promises, or damaged compressed data.
    PcsmoothError
        The points are compressed and lazrs is not installed.
    """
    size = header.n_points * header.point_size
    if header.packing is not None:
        return _unpacked(data, start, header, path) if size else b""
    if start + size > len(data):
        raise CloudFileError(
            path,
            f"its header promises {header.n_points} points, which take {size} bytes, but "
            f"{len(data) - start} bytes follow",
            "get the whole file again",
        )
    return data[start : start + size]


def _unpacked(data: bytes, start: int, header: LasHeader, path: str) -> bytearray:
    lazrs = optional_library(*_LIBRARY)
    stream = io.BytesIO(data)
    stream.seek(start)
    points = bytearray()
    try:
        size = lazrs.LazVlr(header.packing).item_size()
        if size != header.point_size:
            raise ValueError(f"points of {header.point_size} bytes are packed as {size}")
        _check_chunks(data, start, header, lazrs)
        unpacker = lazrs.LasZipDecompressor(stream, header.packing)
        while len(points) < header.n_points * size:
            part = bytearray(min(_AT_A_TIME * size, header.n_points * size - len(points)))
            unpacker.decompress_many(part)
            points += part
    except (lazrs.LazrsError, ValueError, OSError) as error:
        raise CloudFileError(
            path,
            f"its {header.n_points} compressed points cannot be read ({error})",
            "get the whole file again",
        ) from error
    return points


def _check_chunks(data: bytes, start: int, header: LasHeader, lazrs: ModuleType) -> None:
    """Raise `ValueError` unless chunks and layers are as long as is said, and in the file.

    The library takes memory for whatever a damaged list promises.
    """
    first = start + _LISTED_AT.size
    damaged = ValueError("the list of their chunks is damaged")
    if first > len(data):
        raise damaged
    (listed_at,) = _LISTED_AT.unpack_from(data, start)
    if listed_at == -1:  # written as a stream: it is said at the end
        (listed_at,) = _LISTED_AT.unpack_from(data, len(data) - _LISTED_AT.size)
    if not first <= listed_at <= len(data) - _LIST.size:
        raise damaged
    _, n_chunks = _LIST.unpack_from(data, listed_at)
    if n_chunks * header.point_size > listed_at - first:
        raise damaged
    stream = io.BytesIO(data)
    stream.seek(start)
    chunks = lazrs.read_chunk_table(stream, lazrs.LazVlr(header.packing))
    if first + sum(size for _, size in chunks) > listed_at:
        raise damaged
    if sum(count for count, _ in chunks) < header.n_points:
        raise ValueError("their chunks hold fewer")
    n_layers = _LAYERS.get(header.point_format)
    if n_layers is None:
        return
    n_layers += header.point_size - point_type(header.point_format, ()).itemsize
    sizes = struct.Struct(f"<I{n_layers}I")
    for _, size in chunks:
        place = first + header.point_size
        least = header.point_size + sizes.size
        if size < least or size < least + sum(sizes.unpack_from(data, place)[1:]):
            raise ValueError("a chunk is shorter than its layers")
        first += size


def packing_for(point_format: int, n_extra_bytes: int) -> bytes:
    """Record that says how points will be packed."""
    record: bytes = (
        optional_library(*_LIBRARY)
        .LazVlr.new_for_compression(point_format, n_extra_bytes)
        .record_data()
    )
    return record


def pack_points(head: bytes, points: bytes, packing: bytes) -> bytes:
    """Pack points behind a header, in which they find their place."""
    lazrs = optional_library(*_LIBRARY)
    stream = io.BytesIO(head)
    stream.seek(0, io.SEEK_END)
    packer = lazrs.LasZipCompressor(stream, lazrs.LazVlr(packing))
    packer.compress_many(points)
    packer.done()
    return stream.getvalue()
