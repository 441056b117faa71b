"""Header and variable length records of a LAS file, kept byte for byte."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import CloudFileError

_MAGIC = b"LASF"

#: Bytes of the header by minor version.
_HEADER_SIZES = {0: 227, 1: 227, 2: 227, 3: 235, 4: 375, 5: 393}

_COMPRESSED = 0x80
_FORMAT_BITS = 0x3F

# Where the entries of the header are.
_MINOR = 25
_SIZES = struct.Struct("<HIIBHI")
_SIZES_AT = 94
_RETURNS_AT = 111
_SCALES_AT = 131
_BOUNDS_AT = 179
_EVLRS = struct.Struct("<QIQ")
_EVLRS_AT = 235
_LONG_RETURNS_AT = 255

_RECORD = struct.Struct("<2s16sHH32s")
_EXTENDED_RECORD = struct.Struct("<2s16sHQ32s")

MOST_BYTES = 2**16 - 1
"""Bytes that a record which is not extended can hold."""

_CUT_SHORT = "get the whole file again"


@dataclass(frozen=True)
class LasRecord:
    """A variable length record.

    Attributes
    ----------
    user, description : bytes
        16 and 32 bytes.
    record_id : int
        What the user calls it.
    data : bytes
        What it holds.
    reserved : bytes
        2 bytes.
    """

    user: bytes
    record_id: int
    description: bytes
    data: bytes
    reserved: bytes = b"\0\0"

    def is_called(self, user: bytes, record_id: int | None = None) -> bool:
        """Whether it has this name and, if given, number."""
        name = self.user.split(b"\0")[0]
        return name == user and record_id in (None, self.record_id)

    def to_bytes(self, *, extended: bool) -> bytes:
        """Compose it as it stands in a file."""
        form = _EXTENDED_RECORD if extended else _RECORD
        head = (self.reserved, self.user, self.record_id, len(self.data), self.description)
        return form.pack(*head) + self.data


@dataclass(frozen=True)
class LasHeader:
    """What a LAS file holds besides its points.

    Attributes
    ----------
    block : bytes
        The header, with what may follow its last entry.
    records : tuple of LasRecord
        The records between header and points, that of the compression apart.
    gap : bytes
        What stands between these and the points.
    extended : tuple of LasRecord
        The records after the points.
    packing : bytes or None
        The record of the compression; None if the points are not compressed.
    """

    block: bytes
    records: tuple[LasRecord, ...] = ()
    gap: bytes = b""
    extended: tuple[LasRecord, ...] = ()
    packing: bytes | None = None

    @property
    def minor(self) -> int:
        """Minor version."""
        return self.block[_MINOR]

    @property
    def point_format(self) -> int:
        """Number of the format of the points."""
        return int(_SIZES.unpack_from(self.block, _SIZES_AT)[3]) & _FORMAT_BITS

    @property
    def point_size(self) -> int:
        """Bytes of a point."""
        return int(_SIZES.unpack_from(self.block, _SIZES_AT)[4])

    @property
    def n_points(self) -> int:
        """Number of points."""
        short = int(_SIZES.unpack_from(self.block, _SIZES_AT)[5])
        if self.minor < 4:
            return short
        return int(_EVLRS.unpack_from(self.block, _EVLRS_AT)[2]) or short

    @property
    def scales(self) -> npt.NDArray[np.float64]:
        """Steps of the coordinates, L, shape (3,)."""
        return np.frombuffer(self.block, "<f8", 3, _SCALES_AT)

    @property
    def offsets(self) -> npt.NDArray[np.float64]:
        """Where the coordinates begin, L, shape (3,)."""
        return np.frombuffer(self.block, "<f8", 3, _SCALES_AT + 24)


def is_las(head: bytes) -> bool:
    """Whether a file that begins with these bytes is LAS without compression."""
    return head.startswith(_MAGIC) and not _is_packed(head)


def is_laz(head: bytes) -> bool:
    """Whether a file that begins with these bytes is LAZ."""
    return head.startswith(_MAGIC) and _is_packed(head)


def parse_header(data: bytes, path: str) -> tuple[LasHeader, int]:
    """Parse what a LAS file holds besides its points.

    Parameters
    ----------
    data : bytes
        The whole file.
    path : str
        Name of the file in errors.

    Returns
    -------
    header : LasHeader
        The parsed header.
    start : int
        Where the points begin.

    Raises
    ------
    CloudFileError
        Not LAS, of an unknown version, cut short, or scales that are not numbers.
    """
    if not data.startswith(_MAGIC):
        raise CloudFileError(
            path, "not a LAS file: it does not begin with 'LASF'", "check the file or its suffix"
        )
    if len(data) < _HEADER_SIZES[0]:
        raise _cut_short(path, "header")
    version = tuple(data[_MINOR - 1 : _MINOR + 1])
    if version[0] != 1 or version[1] not in _HEADER_SIZES:
        raise CloudFileError(
            path,
            f"it is of LAS version {version[0]}.{version[1]}, which is not known",
            f"export it as LAS 1.{max(_HEADER_SIZES)} or earlier",
        )
    size, start, n_records = _SIZES.unpack_from(data, _SIZES_AT)[:3]
    if size < _HEADER_SIZES[version[1]] or start < size or len(data) < start:
        raise _cut_short(path, "header")
    records, end = _records(data[:start], size, n_records, _RECORD, path)
    packed = _is_packed(data)
    packing = [record.data for record in records if record.is_called(b"laszip encoded")]
    if packed and len(packing) != 1:
        raise CloudFileError(
            path, "it does not say how its points are compressed", "export it again"
        )
    extended: list[LasRecord] = []
    if version[1] >= 4:
        first, n_extended = _EVLRS.unpack_from(data, _EVLRS_AT)[:2]
        extended, _ = _records(data, first, n_extended, _EXTENDED_RECORD, path)
    header = LasHeader(
        data[:size],
        tuple(record for record in records if not record.is_called(b"laszip encoded")),
        data[end:start],
        tuple(extended),
        packing[0] if packed else None,
    )
    steps = header.scales
    if not (np.isfinite(steps) & (steps != 0.0) & np.isfinite(header.offsets)).all():
        raise CloudFileError(
            path, f"its scales are {steps.tolist()}, which are no steps", "export it again"
        )
    return header, start


def new_header(
    scales: npt.NDArray[np.float64], offsets: npt.NDArray[np.float64], point_format: int
) -> LasHeader:
    """Make the header of a file of LAS 1.4 that has nothing but points.

    Parameters
    ----------
    scales, offsets : ndarray of float64, shape (3,)
        Steps and origin of the coordinates, L.
    point_format : int
        6 to 8.

    Returns
    -------
    LasHeader
    """
    block = bytearray(_HEADER_SIZES[4])
    block[:4] = _MAGIC
    block[6] = 0x10  # a coordinate system, if there is one, is in WKT: such points demand it
    block[_MINOR - 1 : _MINOR + 1] = bytes([1, 4])
    block[26:34] = block[58:66] = b"pcsmooth"
    _SIZES.pack_into(block, _SIZES_AT, len(block), 0, 0, point_format, 0, 0)
    block[_SCALES_AT : _SCALES_AT + 48] = np.concatenate([scales, offsets]).astype("<f8").tobytes()
    return LasHeader(bytes(block))


def composed(
    header: LasHeader,
    *,
    point_format: int,
    point_size: int,
    integers: npt.NDArray[np.int32],
    returns: npt.NDArray[np.uint8],
) -> tuple[bytes, bytes]:
    """Compose what stands before and after the points.

    Parameters
    ----------
    header : LasHeader
        What is to be composed.
    point_format, point_size : int
        Format and size of a point.
    integers : ndarray of int32, shape (n, 3)
        The points in steps.
    returns : ndarray of uint8, shape (n,)
        Which return each point is, from 1.

    Returns
    -------
    head : bytes
        Header, records and gap.
    tail : bytes
        The extended records. The header does not say yet where they are.
    """
    records = list(header.records)
    if header.packing is not None:
        description = b"http://laszip.org".ljust(32, b"\0")
        user = b"laszip encoded".ljust(16, b"\0")
        records.append(LasRecord(user, 22204, description, header.packing))
    between = b"".join(record.to_bytes(extended=False) for record in records) + header.gap
    block = bytearray(header.block)
    n_points = len(integers)
    if point_format in (2, 3):  # which came with this version, whose header is the same
        block[_MINOR] = max(header.minor, 2)
    is_new = header.minor >= 4
    short = 0 if point_format >= 6 or n_points >= 2**32 else n_points
    counts = np.bincount(returns, minlength=16)[1:16]
    _SIZES.pack_into(
        block,
        _SIZES_AT,
        len(block),
        len(block) + len(between),
        len(records),
        point_format | (_COMPRESSED if header.packing is not None else 0),
        point_size,
        short,
    )
    block[_RETURNS_AT:_SCALES_AT] = (counts[:5] * (short > 0)).astype("<u4").tobytes()
    if n_points:
        bounds = integers.min(axis=0), integers.max(axis=0)
        low, high = (steps * header.scales + header.offsets for steps in bounds)
        low, high = np.minimum(low, high), np.maximum(low, high)  # scales may be negative
        extent = np.stack([high, low], axis=1).astype("<f8")
        block[_BOUNDS_AT : _BOUNDS_AT + extent.nbytes] = extent.tobytes()
    tail = b"".join(record.to_bytes(extended=True) for record in header.extended)
    if is_new:
        _EVLRS.pack_into(block, _EVLRS_AT, 0, len(header.extended), n_points)
        block[_LONG_RETURNS_AT : _LONG_RETURNS_AT + 120] = counts.astype("<u8").tobytes()
    return bytes(block) + between, tail


def with_extended_at(head: bytes, position: int) -> bytes:
    """Enter into a header where its extended records begin."""
    return head[:_EVLRS_AT] + struct.pack("<Q", position) + head[_EVLRS_AT + 8 :]


def _is_packed(head: bytes) -> bool:
    at = _SIZES_AT + 10
    return len(head) > at and bool(head[at] & _COMPRESSED)


def _records(
    data: bytes, position: int, count: int, form: struct.Struct, path: str
) -> tuple[list[LasRecord], int]:
    records: list[LasRecord] = []
    for _ in range(count):
        start = position + form.size
        if start > len(data):
            raise _cut_short(path, "records")
        head: tuple[Any, ...] = form.unpack_from(data, position)
        reserved, user, record_id, size, description = head
        position = start + size
        if position > len(data):
            raise _cut_short(path, "records")
        records.append(LasRecord(user, record_id, description, data[start:position], reserved))
    return records, position


def _cut_short(path: str, what: str) -> CloudFileError:
    return CloudFileError(path, f"not all of the LAS {what} is there", _CUT_SHORT)
