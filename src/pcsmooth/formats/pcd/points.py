"""The points of a PCD file, field by field."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import write_rows
from pcsmooth.formats.pcd.header import PcdField, PcdHeader
from pcsmooth.formats.pcd.lzf import LARGEST_RATIO, unpack_lzf
from pcsmooth.formats.typed_rows import OddWords, exceptions_in, odd_words, read_rows

_SIZES = struct.Struct("<II")
_CUT_SHORT = "get the whole file again"


def read_fields(
    body: bytes, header: PcdHeader, path: str
) -> tuple[list[npt.NDArray[Any]], OddWords]:
    """Read the fields of all points.

    Nothing is allocated before the file is known to be long enough for its header.

    Parameters
    ----------
    body : bytes
        Everything after the header.
    header : PcdHeader
        The header.
    path : str
        Name of the file in errors.

    Returns
    -------
    fields : list of ndarray, each of shape (n, count)
        In the order of the header.
    odd : dict
        Words of text that are not finite and not spelled as usual, by row and by `item_name`.

    Raises
    ------
    CloudFileError
        Fewer points than the header promises, more lines than that, damaged compressed data, or
        a value that is not a number of its field's type.
    """
    least = header.n_points * (
        2 * sum(field.count for field in header.fields)
        if header.encoding == "ascii"
        else header.point_size
    )
    # The last line of a text may lack its newline.
    room = {
        "ascii": len(body) + 1,
        "binary": len(body),
        "binary_compressed": LARGEST_RATIO * len(body),
    }[header.encoding]
    if least > room:
        raise CloudFileError(
            path,
            f"the header promises {header.n_points} points, which take at least {least} bytes, "
            f"but {len(body)} {'compressed ' * (room > len(body) + 1)}bytes follow",
            _CUT_SHORT,
        )
    if header.encoding == "ascii":
        return _read_lines(body, header, path)
    if header.encoding == "binary":
        table = np.frombuffer(body, _row_type(header.fields), header.n_points)
        return [np.ascontiguousarray(table[name]) for name in table.dtype.names or ()], {}
    return _read_compressed(body, header, path), {}


def item_name(rank: int, item: int) -> str:
    """Name an item of a field apart from all others, for names of fields may be there twice."""
    return f"{rank} {item}"


def write_fields(
    file: BinaryIO,
    fields: Sequence[PcdField],
    values: Sequence[npt.NDArray[Any]],
    as_text: bool,
    odd: OddWords,
) -> None:
    """Write the fields of all points.

    Parameters
    ----------
    file : binary file
        Open for writing.
    fields : sequence of PcdField
        Their descriptions.
    values : sequence of ndarray, each of shape (n, count)
        Their values, of the types described.
    as_text : bool
        As lines of text rather than binary.
    odd : dict
        Words that stay in text as they were, as `read_fields` gives them, of these fields.
    """
    if as_text:
        columns = [column for items in values for column in items.T]
        exceptions = (
            exceptions_in(np.rec.fromarrays(columns, _item_type(fields)), odd) if odd else None
        )
        write_rows(file, columns, " ", exceptions=exceptions)
        return
    table = np.empty(len(values[0]), _row_type(fields))
    for name, items in zip(table.dtype.names or (), values, strict=True):
        table[name] = items
    file.write(table.view(np.uint8).data)


def _row_type(fields: Sequence[PcdField]) -> np.dtype[Any]:
    """Type of a point; its names are ranks, for those of the file may be there twice."""
    return np.dtype([(str(rank), field.dtype, (field.count,)) for rank, field in enumerate(fields)])


def _item_type(fields: Sequence[PcdField]) -> np.dtype[Any]:
    """Type of a line of text."""
    return np.dtype(
        [
            (item_name(rank, item), field.dtype)
            for rank, field in enumerate(fields)
            for item in range(field.count)
        ]
    )


def _read_compressed(body: bytes, header: PcdHeader, path: str) -> list[npt.NDArray[Any]]:
    """Unpack points that are stored field after field."""
    if header.n_points == 0:
        return [np.empty((0, field.count), field.dtype) for field in header.fields]
    packed_size, size = _SIZES.unpack_from(body) if len(body) >= _SIZES.size else (0, 0)
    packed = body[_SIZES.size : _SIZES.size + packed_size]
    expected = header.n_points * header.point_size
    if len(packed) < packed_size or size != expected:
        raise CloudFileError(
            path,
            f"its compressed data are {len(packed)} bytes that stand for {size}, but should be "
            f"{packed_size} that stand for {expected}",
            _CUT_SHORT,
        )
    try:
        data = unpack_lzf(packed, size)
    except ValueError as error:
        raise CloudFileError(path, str(error), _CUT_SHORT) from error
    values, start = [], 0
    for field in header.fields:
        items = np.frombuffer(data, field.dtype, header.n_points * field.count, start)
        values.append(items.reshape(header.n_points, field.count))
        start += items.nbytes
    return values


def _read_lines(
    body: bytes, header: PcdHeader, path: str
) -> tuple[list[npt.NDArray[Any]], OddWords]:
    lines = [line for line in body.splitlines() if line.strip()]
    if len(lines) != header.n_points:
        raise CloudFileError(
            path,
            f"the header promises {header.n_points} points, but {len(lines)} lines follow",
            _CUT_SHORT,
        )
    if not lines:
        return [np.empty((0, field.count), field.dtype) for field in header.fields], {}
    names = [field.name for field in header.fields for _ in range(field.count)]
    try:
        table = read_rows(lines, _item_type(header.fields), names)
    except ValueError as error:
        raise CloudFileError(
            path,
            f"malformed PCD points ({excerpt(str(error))})",
            "correct the file or export it again",
        ) from error
    values = [
        np.stack([table[item_name(rank, item)] for item in range(field.count)], axis=1)
        for rank, field in enumerate(header.fields)
    ]
    return values, odd_words(lines, table)
