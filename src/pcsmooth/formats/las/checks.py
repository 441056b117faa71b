"""What must hold before laspy is given a LAS file: it takes every number in a file on trust."""

from __future__ import annotations

import contextlib
import io
import struct
from collections.abc import Iterator
from typing import Any, NamedTuple

from pcsmooth.errors import CloudFileError, PcsmoothError
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.las.streams import SourceFile

WAVE_FORMATS = frozenset({4, 5, 9, 10})
"""Formats whose points refer to recorded waves, elsewhere in the file or in another."""

MOST_PACKED_BYTES = 4096
"""Bytes of the longest points that are packed: lazrs takes up to 18 kB of memory for each."""

#: Bytes of the shortest header.
_HEAD = 227

_MAGIC = b"LASF"
_LAST_MINOR = 5
_LAST_FORMAT = 10

#: Where in a header the version and the sizes are.
_VERSION_AT = 24
_SIZES = struct.Struct("<HIIBHI")
_SIZES_AT = 94
_FORMAT_AT = 104
_COMPRESSED = 0x80
_FORMAT_BITS = 0x3F

#: Name, number, size and description of a record.
_RECORD = struct.Struct("<2x16sHH32s")
_EXTENDED_RECORD = struct.Struct("<2x16sHQ32s")
#: Records that are written anew.
_COMPRESSION = ("laszip encoded", 22204)
_DESCRIPTIONS = ("LASF_Spec", 4)

#: At which packed points begin, of where their chunks are listed.
_LISTED_AT = struct.Struct("<q")
#: Version and number of chunks, at which the list begins.
_LIST = struct.Struct("<II")
#: Way of packing, and number of items, at which its record begins; then type, size and version.
_PACKING = struct.Struct("<H30xH")
_ITEM = struct.Struct("<3H")
_LAYERED = 3
#: Bytes of an item by its type, and of those in layers the number that a chunk has of these.
_ITEM_SIZES = {6: 20, 7: 8, 8: 6, 9: 29}
_LAYERED_SIZES = {10: 30, 11: 6, 12: 8, 13: 29}
_LAYERS = {10: 9, 11: 1, 12: 2, 13: 1}
#: Types of extra bytes, of which there may be any number; a layer is one of them.
_EXTRA_BYTES, _LAYERED_EXTRA_BYTES = 0, 14

_CUT_SHORT = "get the whole file again"

#: Module of what lazrs raises where it finds itself wrong; it is no `Exception`.
_PANICS = "pyo3_runtime"


@contextlib.contextmanager
def named_failures(path: str, cause: str, remedy: str) -> Iterator[None]:
    """Turn whatever laspy and lazrs raise into `CloudFileError`.

    Parameters
    ----------
    path : str
        Name of the file in errors.
    cause, remedy : str
        What failed, to which the words of the library are added, and what can be done.
    """
    try:
        yield
    except (PcsmoothError, MemoryError):
        raise
    except BaseException as error:  # of many kinds, plain ones of Python too
        if not isinstance(error, Exception) and type(error).__module__ != _PANICS:
            raise
        words = " ".join(str(error).split())
        if " " not in words:
            words = f"{type(error).__name__} {words}".strip()
        raise CloudFileError(path, f"{cause} ({excerpt(words)})", remedy) from error


def is_las(head: bytes) -> bool:
    """Whether a file that begins with these bytes is LAS without compression."""
    return head.startswith(_MAGIC) and not _is_packed(head)


def is_laz(head: bytes) -> bool:
    """Whether a file that begins with these bytes is LAZ."""
    return head.startswith(_MAGIC) and _is_packed(head)


class Record(NamedTuple):
    """A record of a file: who uses it, for what, and where in the file it begins."""

    user: str
    number: int
    description: str
    contents: bytes
    position: int

    @property
    def key(self) -> tuple[str, int]:
        """By which readers know it."""
        return self.user, self.number


class Checked(NamedTuple):
    """What a header is checked for.

    Attributes
    ----------
    head : bytes
        All that is before the points.
    records : tuple of laspy.VLR
        As `records_of` gives them.
    descriptions : Record or None
        The record that describes the extra bytes.
    n_points : int
        Number of points as readers of LAS 1.3 and earlier see it.
    """

    head: bytes
    records: tuple[Any, ...]
    descriptions: Record | None
    n_points: int


def check_header(source: ByteSource) -> Checked:
    """Check the header of a file as far as laspy does not, and take out its records.

    Parameters
    ----------
    source : ByteSource
        The file.

    Returns
    -------
    Checked

    Raises
    ------
    CloudFileError
        Not LAS, of an unknown version or point format, or cut short.
    """
    path = source.path
    data = source.read(0, min(source.size, _HEAD))
    if not data.startswith(_MAGIC):
        raise CloudFileError(
            path, "not a LAS file: it does not begin with 'LASF'", "check the file or its suffix"
        )
    if len(data) < _HEAD:
        raise _cut_short(path, "header")
    major, minor = data[_VERSION_AT : _VERSION_AT + 2]
    if major != 1 or minor > _LAST_MINOR:
        raise CloudFileError(
            path,
            f"it is of LAS version {major}.{minor}, which is not known",
            f"export it as LAS 1.{_LAST_MINOR} or earlier",
        )
    size, start, n_records, form, _, n_points = _SIZES.unpack_from(data, _SIZES_AT)
    number = form & _FORMAT_BITS
    if number > _LAST_FORMAT or number in WAVE_FORMATS:
        kind = "has waves, which are" if number in WAVE_FORMATS else "is"
        raise CloudFileError(
            path,
            f"its point format {number} {kind} not known",
            "export it in point format 0 to 3 or 6 to 8",
        )
    if start < max(size, _HEAD) or source.size < start:
        raise _cut_short(path, "header")
    head = source.read(0, start)
    place = ByteSource(io.BytesIO(head), path), size, n_records
    described = (each for each in _walk(*place, extended=False) if each.key == _DESCRIPTIONS)
    return Checked(head, records_of(*place, extended=False), next(described, None), n_points)


def records_of(source: ByteSource, position: int, count: int, *, extended: bool) -> tuple[Any, ...]:
    """Take records out of a file as they are; laspy would reword those that it knows.

    Parameters
    ----------
    source : ByteSource
        The file, or what of it can have records.
    position, count : int
        Where the first of them begins, and their number.
    extended : bool
        Whether they are extended.

    Returns
    -------
    tuple of laspy.VLR
        All but those of the compression and of the extra bytes.

    Raises
    ------
    CloudFileError
        They reach beyond the end.
    """
    import laspy

    return tuple(
        laspy.VLR(record.user, record.number, record.description, record.contents)
        for record in _walk(source, position, count, extended=extended)
        if record.key not in (_DESCRIPTIONS, _COMPRESSION)
    )


def check_points(source: ByteSource, header: Any) -> None:
    """Raise `CloudFileError` unless the file can hold the points that its header promises.

    Parameters
    ----------
    source : ByteSource
        The file.
    header : laspy.LasHeader
        Its header.
    """
    if header.are_points_compressed:
        if header.point_count:
            cause = f"its {header.point_count} compressed points cannot be read"
            file = SourceFile(source, header.offset_to_point_data)
            with file.own_errors(), named_failures(source.path, cause, _CUT_SHORT):
                _check_chunks(source, header, file)
        return
    size = header.point_count * header.point_format.size
    follow = source.size - header.offset_to_point_data
    if size > follow:
        raise CloudFileError(
            source.path,
            f"its header promises {header.point_count} points, which take {size} bytes, but "
            f"{follow} bytes follow",
            _CUT_SHORT,
        )


def _check_chunks(source: ByteSource, header: Any, file: SourceFile) -> None:
    """Raise `ValueError` unless chunks and layers are as long as is said, and in the file.

    lazrs takes memory for whatever a damaged list promises, or ends the process.
    """
    import lazrs

    packing = header.vlrs.get("LasZipVlr")
    if len(packing) != 1:
        raise ValueError("it does not say how they are compressed")
    record = lazrs.LazVlr(packing[0].record_data)
    point_size, start = header.point_format.size, header.offset_to_point_data
    if record.item_size() != point_size:
        raise ValueError(f"points of {point_size} bytes are packed as {record.item_size()}")
    if point_size > MOST_PACKED_BYTES:
        raise ValueError(f"points of {point_size} bytes are too long")
    first = start + _LISTED_AT.size
    damaged = ValueError("the list of their chunks is damaged")
    if first > source.size:
        raise damaged
    (listed_at,) = _numbers(_LISTED_AT, source, start)
    if listed_at == -1:  # written as a stream: it is said at the end
        (listed_at,) = _numbers(_LISTED_AT, source, source.size - _LISTED_AT.size)
    if not first <= listed_at <= source.size - _LIST.size:
        raise damaged
    _, n_chunks = _numbers(_LIST, source, listed_at)
    if n_chunks * point_size > listed_at - first:
        raise damaged
    chunks = lazrs.read_chunk_table(file, record)
    if first + sum(size for _, size in chunks) > listed_at:
        raise damaged
    if sum(count for count, _ in chunks) < header.point_count:
        raise ValueError("their chunks hold fewer")
    way, n_items = _PACKING.unpack_from(packing[0].record_data)
    items = packing[0].record_data[_PACKING.size :][: n_items * _ITEM.size]
    in_layers = way == _LAYERED
    known = _LAYERED_SIZES if in_layers else _ITEM_SIZES
    extra_bytes = _LAYERED_EXTRA_BYTES if in_layers else _EXTRA_BYTES
    n_layers = 0
    for kind, size, _ in _ITEM.iter_unpack(items):
        if kind != extra_bytes and known.get(kind) != size:
            raise ValueError("they are packed in an unknown way")
        n_layers += size if kind == extra_bytes else _LAYERS.get(kind, 0)
    if not in_layers:
        return
    sizes = struct.Struct(f"<I{n_layers}I")
    least = point_size + sizes.size
    for _, size in chunks:
        place = first + point_size
        if size < least or size < least + sum(_numbers(sizes, source, place)[1:]):
            raise ValueError("a chunk is shorter than its layers")
        first += size


def _walk(source: ByteSource, position: int, count: int, *, extended: bool) -> Iterator[Record]:
    form = _EXTENDED_RECORD if extended else _RECORD
    for _ in range(count):
        start = position + form.size
        if start > source.size:
            raise _cut_short(source.path, "records")
        user, number, size, description = _numbers(form, source, position)
        end = start + size
        if end > source.size:
            raise _cut_short(source.path, "records")
        yield Record(_ascii(user), number, _ascii(description), source.read(start, size), position)
        position = end


def _numbers(form: struct.Struct, source: ByteSource, position: int) -> tuple[Any, ...]:
    return form.unpack(source.read(position, form.size))


def _is_packed(head: bytes) -> bool:
    return len(head) > _FORMAT_AT and bool(head[_FORMAT_AT] & _COMPRESSED)


def _ascii(name: bytes) -> str:
    return name.split(b"\0")[0].decode("ascii", "ignore")


def _cut_short(path: str, what: str) -> CloudFileError:
    return CloudFileError(path, f"not all of the LAS {what} is there", _CUT_SHORT)
