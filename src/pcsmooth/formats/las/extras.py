"""How a LAS file describes the extra bytes of its points.

laspy takes the number of bytes of what has no type for flags, and fails on names that are not
UTF-8; so the descriptions are read and written here, and hidden from it where it would fail.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import NORMALS
from pcsmooth.formats.las.positions import ExtraDimension

NORMAL_DIMENSIONS = dict(zip(NORMALS, ("NormalX", "NormalY", "NormalZ"), strict=True))
"""What normals are called in a new file; PDAL and CloudCompare know them by these names."""

#: Bytes of a description; that of no type has the number of its bytes in place of options.
_SIZE = 192
_NO_TYPE = 0

#: Bytes of the record's name, after 2 that are reserved.
_USER_AT, _USER_SIZE = 2, 16

#: Options of an extra dimension: its extremes are given. They would be those of other values.
_EXTREMES = 0b110


def descriptions_of(contents: bytes) -> list[Any]:
    """Descriptions in a record of the file; none if it is no whole number of them.

    Parameters
    ----------
    contents : bytes
        What the record holds.

    Returns
    -------
    list of laspy ExtraBytesStruct
    """
    from laspy.vlrs.known import ExtraBytesStruct

    if len(contents) % _SIZE:
        return []
    starts = range(0, len(contents), _SIZE)
    return [ExtraBytesStruct.from_buffer_copy(contents, start) for start in starts]


def hidden(data: bytes, record_at: int, descriptions: Sequence[Any]) -> bytes:
    """Take its name from the record of descriptions if laspy would fail on it.

    Parameters
    ----------
    data : bytes
        The file, at least up to its points.
    record_at : int
        Where the record begins.
    descriptions : sequence of laspy ExtraBytesStruct
        What it holds.

    Returns
    -------
    bytes
        The file as laspy can open it, without a copy where that is as it is.
    """
    if all(each.data_type != _NO_TYPE and _is_utf8(each) for each in descriptions):
        return data
    start = record_at + _USER_AT
    return data[:start] + bytes(_USER_SIZE) + data[start + _USER_SIZE :]


def described_extras(
    descriptions: Sequence[Any], n_bytes: int
) -> list[tuple[Any, np.dtype[Any], int]]:
    """Divide the extra bytes of a point into dimensions, in their order.

    Parameters
    ----------
    descriptions : sequence of laspy ExtraBytesStruct
        What the file says.
    n_bytes : int
        Number of extra bytes; if there are none, what the file says is of no matter.

    Returns
    -------
    list of (laspy ExtraBytesStruct or None, numpy.dtype, int)
        Description, type of an item and number of items; at the end, without a description, the
        bytes of which nothing is said.

    Raises
    ------
    ValueError
        More bytes are described than there are, or a dimension has none.
    """
    extras: list[tuple[Any, np.dtype[Any], int]] = []
    left = n_bytes
    for description in descriptions if n_bytes else ():
        dtype, count = description.dtype().base, description.num_elements()
        left -= dtype.itemsize * count
        if count == 0 or left < 0:
            raise ValueError(f"the {n_bytes} extra bytes of a point are not as described")
        extras.append((description, dtype, count))
    return extras + ([(None, np.dtype(np.uint8), left)] if left else [])


def scales_and_offsets(description: Any) -> tuple[Any, Any]:
    """By which an item is multiplied and what is added, (count,) each; None if it is as it is."""
    if description is None or description.data_type == _NO_TYPE:
        return None, None
    scales, offsets = description.scale, description.offset
    if scales is None and offsets is None:
        return None, None
    count = description.num_elements()
    return (
        np.ones(count) if scales is None else np.array(scales[:count]),
        np.zeros(count) if offsets is None else np.array(offsets[:count]),
    )


def has_type(description: Any) -> bool:
    """Whether it is said what the bytes mean."""
    return description is not None and description.data_type != _NO_TYPE


def name_of(description: Any) -> str:
    """Name of an extra dimension."""
    return "" if description is None else bytes(description.name).decode("utf-8", "replace")


def records_for(extras: Sequence[ExtraDimension]) -> Iterator[Any]:
    """Make the record of descriptions of a file, if there is anything to describe."""
    contents = b""
    for extra in extras:
        if extra.description is not None:
            description = type(extra.description).from_buffer_copy(extra.description)
            if has_type(description):
                description.options &= ~_EXTREMES
            contents += bytes(description)
    if contents:
        import laspy

        yield laspy.VLR("LASF_Spec", 4, "Extra Bytes Record", contents)


def add_dimensions(point_format: Any, extras: Sequence[ExtraDimension]) -> None:
    """Add extra dimensions; they are named by rank, for names in a file may be there twice."""
    import laspy

    for rank, extra in enumerate(extras):
        kind = (extra.dtype, (extra.count,)) if extra.count > 1 else extra.dtype
        point_format.add_extra_dimension(laspy.ExtraBytesParams(str(rank), np.dtype(kind)))


def items_of(table: npt.NDArray[Any], rank: int, extra: ExtraDimension) -> npt.NDArray[Any]:
    """View of the items of an extra dimension, (n, count), in a block of points."""
    return table[str(rank)].reshape(len(table), extra.count)


def scaled(values: npt.NDArray[Any], extra: ExtraDimension, item: int) -> npt.NDArray[Any]:
    """Numbers that the values of an item stand for, in an array of their own."""
    if extra.scales is None or extra.offsets is None:
        return values.copy()
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray(values * extra.scales[item] + extra.offsets[item], np.float64)


def _is_utf8(description: Any) -> bool:
    try:
        bytes(description.name).decode()
        bytes(description.description).decode()
    except UnicodeDecodeError:
        return False
    return True
