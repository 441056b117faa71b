"""The dimensions of LAS points: what each format holds, and extra bytes."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.colors import COLORS
from pcsmooth.formats.las_header import LasRecord

WITH_COLORS = {0: 2, 1: 3, 6: 7}
"""Formats without colors, and those that are the same with them."""

WAVE_FORMATS = frozenset({4, 5, 9, 10})
"""Formats whose points refer to recorded waves."""

MOST_NAME_BYTES = 32
"""Bytes of the longest name of an extra dimension."""

_FIRST = [("X", "<i4"), ("Y", "<i4"), ("Z", "<i4"), ("intensity", "<u2")]
_OLD = [
    *_FIRST,
    ("return bits", "u1"),
    ("class bits", "u1"),
    ("scan_angle_rank", "i1"),
    ("user_data", "u1"),
    ("point_source_id", "<u2"),
]
_NEW = [
    *_FIRST,
    ("return bits", "u1"),
    ("flag bits", "u1"),
    ("classification", "u1"),
    ("user_data", "u1"),
    ("scan_angle", "<i2"),
    ("point_source_id", "<u2"),
    ("gps_time", "<f8"),
]
_TIME = [("gps_time", "<f8")]
_COLORS = [(name, "<u2") for name in COLORS]

#: Fields of a point by format, in the order of the file.
_FIELDS = {
    0: _OLD,
    1: _OLD + _TIME,
    2: _OLD + _COLORS,
    3: _OLD + _TIME + _COLORS,
    6: _NEW,
    7: _NEW + _COLORS,
    8: [*_NEW, *_COLORS, ("nir", "<u2")],
}

#: Dimensions that are parts of a field: its name, the first bit, the number of bits.
_OLD_BITS = {
    "return_number": ("return bits", 0, 3),
    "number_of_returns": ("return bits", 3, 3),
    "scan_direction_flag": ("return bits", 6, 1),
    "edge_of_flight_line": ("return bits", 7, 1),
    "classification": ("class bits", 0, 5),
    "synthetic": ("class bits", 5, 1),
    "key_point": ("class bits", 6, 1),
    "withheld": ("class bits", 7, 1),
}
_NEW_BITS = {
    "return_number": ("return bits", 0, 4),
    "number_of_returns": ("return bits", 4, 4),
    "synthetic": ("flag bits", 0, 1),
    "key_point": ("flag bits", 1, 1),
    "withheld": ("flag bits", 2, 1),
    "overlap": ("flag bits", 3, 1),
    "scanner_channel": ("flag bits", 4, 2),
    "scan_direction_flag": ("flag bits", 6, 1),
    "edge_of_flight_line": ("flag bits", 7, 1),
}

#: Types of extra dimensions from 1 on; pairs and triples of them follow.
_TYPES = ("u1", "i1", "<u2", "<i2", "<u4", "<i4", "<u8", "<i8", "<f4", "<f8")
_DESCRIPTION = struct.Struct("<2sBB32s4s24s24s24s3d3d32s")
_HAS_SCALE, _HAS_OFFSET = 8, 16
_EXTRA_BYTES = (b"LASF_Spec", 4)
#: Bytes that are described together where nothing is known of them: readers that take their number
#: for options find none that matters to them.
_MOST_UNKNOWN = 7


@dataclass(frozen=True)
class ExtraDimension:
    """A dimension in the extra bytes of a point.

    Attributes
    ----------
    name : str
        Its name.
    dtype : numpy.dtype
        Type of an item.
    count : int
        Number of items.
    description : bytes
        How the file describes it.
    scales, offsets : tuple of float, or None
        By which each item is multiplied, and what is added; None if it is as it is.
    is_opaque : bool
        Whether its bytes mean nothing that the file tells.
    """

    name: str
    dtype: np.dtype[Any]
    count: int
    description: bytes
    scales: tuple[float, ...] | None = None
    offsets: tuple[float, ...] = ()
    is_opaque: bool = False


def is_known(point_format: int) -> bool:
    """Whether points of a format can be read."""
    return point_format in _FIELDS


def fields_of(point_format: int) -> list[tuple[str, str]]:
    """Names and types of the fields of a format, in the order of the file."""
    return list(_FIELDS[point_format])


def parts_of(point_format: int) -> dict[str, tuple[str, int, int]]:
    """Dimensions that are parts of a field: its name, the first bit, the number of bits."""
    return _NEW_BITS if point_format >= 6 else _OLD_BITS


def standard_names(point_format: int) -> list[str]:
    """Names of the dimensions of a format but for the coordinates, in the order of the file."""
    parts = parts_of(point_format)
    names: list[str] = []
    for field, _ in _FIELDS[point_format][3:]:
        inside = [name for name, (whole, _, _) in parts.items() if whole == field]
        names += inside or [field]
    return names


def point_type(point_format: int, extras: Sequence[ExtraDimension]) -> np.dtype[Any]:
    """Type of a point; the fields of extra dimensions are called by their rank."""
    more = [(str(rank), extra.dtype, (extra.count,)) for rank, extra in enumerate(extras)]
    return np.dtype([*fields_of(point_format), *more])


def new_extra(name: str, dtype: np.dtype[Any]) -> ExtraDimension:
    """Describe an extra dimension of one item; the name has at most `MOST_NAME_BYTES`."""
    kind = np.dtype(dtype).newbyteorder("<")
    code = next(rank for rank, known in enumerate(_TYPES, 1) if np.dtype(known) == kind)
    return ExtraDimension(name, kind, 1, _described(name, code, 0))


def is_extra_bytes(record: LasRecord) -> bool:
    """Whether a record describes the extra bytes."""
    return record.is_called(*_EXTRA_BYTES)


def extra_bytes_record(extras: Sequence[ExtraDimension], old: LasRecord | None) -> LasRecord | None:
    """Compose the record that describes the extra bytes; None if there are none."""
    if not extras:
        return None
    user, number = _EXTRA_BYTES
    data = b"".join(extra.description for extra in extras)
    if old is not None:
        return LasRecord(old.user, number, old.description, data, old.reserved)
    return LasRecord(user.ljust(16, b"\0"), number, b"extra bytes".ljust(32, b"\0"), data)


def parse_extras(records: Sequence[LasRecord], n_bytes: int) -> list[ExtraDimension]:
    """Parse the descriptions of the extra bytes of a point.

    Parameters
    ----------
    records : sequence of LasRecord
        Those of the file.
    n_bytes : int
        How many bytes a point has beyond its format; what is not described is opaque.

    Returns
    -------
    list of ExtraDimension

    Raises
    ------
    ValueError
        More is described than there are bytes, or by an unknown type.
    """
    extras: list[ExtraDimension] = []
    for record in filter(is_extra_bytes, records):
        if len(record.data) % _DESCRIPTION.size:
            raise ValueError("the description of the extra bytes is cut short")
        for start in range(0, len(record.data), _DESCRIPTION.size):
            extras.append(_parsed(record.data[start : start + _DESCRIPTION.size]))
    left = n_bytes - sum(extra.dtype.itemsize * extra.count for extra in extras)
    if left < 0:
        raise ValueError(f"{-left} more extra bytes are described than a point has")
    return extras + list(_unknown(left))


def _parsed(description: bytes) -> ExtraDimension:
    entries = _DESCRIPTION.unpack(description)
    code, options = entries[1:3]
    name = entries[3].split(b"\0")[0].decode("utf-8", "replace")
    if code == 0:
        return ExtraDimension(name, np.dtype("u1"), options, description, is_opaque=True)
    if code > 3 * len(_TYPES):
        raise ValueError(f"extra dimension '{name}' is of the unknown type {code}")
    dtype, count = np.dtype(_TYPES[(code - 1) % len(_TYPES)]), (code - 1) // len(_TYPES) + 1
    if not options & (_HAS_SCALE | _HAS_OFFSET):
        return ExtraDimension(name, dtype, count, description)
    scales = entries[8 : 8 + count] if options & _HAS_SCALE else (1.0,) * count
    offsets = entries[11 : 11 + count] if options & _HAS_OFFSET else (0.0,) * count
    return ExtraDimension(name, dtype, count, description, scales, offsets)


def _unknown(n_bytes: int) -> Iterator[ExtraDimension]:
    """Dimensions for bytes that no record describes."""
    for start in range(0, n_bytes, _MOST_UNKNOWN):
        count = min(_MOST_UNKNOWN, n_bytes - start)
        name = f"unknown {start}"
        description = _described(name, 0, count)
        yield ExtraDimension(name, np.dtype("u1"), count, description, is_opaque=True)


def _described(name: str, code: int, options: int) -> bytes:
    zeros = bytes(24)
    return _DESCRIPTION.pack(
        bytes(2), code, options, name.encode(), bytes(4), zeros, zeros, zeros, *[0.0] * 6, bytes(32)
    )


def bits_of(whole: npt.NDArray[np.uint8], first: int, count: int) -> npt.NDArray[np.uint8]:
    """Take some bits out of a field."""
    return (whole >> np.uint8(first)) & np.uint8(2**count - 1)


def put_bits(
    whole: npt.NDArray[np.uint8], first: int, count: int, values: npt.NDArray[Any]
) -> npt.NDArray[np.uint8]:
    """Put values of so many bits into a field, whose other bits stay."""
    others = np.uint8(0xFF ^ ((2**count - 1) << first))
    return (whole & others) | (values.astype(np.uint8) << np.uint8(first))
