"""The points of a PCD file, field by field."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from itertools import chain, islice
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import write_rows
from pcsmooth.formats.pcd.header import PcdField, PcdHeader
from pcsmooth.formats.pcd.lzf import LARGEST_RATIO, unpack_lzf
from pcsmooth.formats.typed_rows import OddWords, exceptions_in, odd_words, read_rows

_SIZES = struct.Struct("<II")
_CUT_SHORT = "get the whole file again"


FieldValues = Sequence[npt.NDArray[Any]]
"""Values of each field, of shape (n, count), in the order of the header."""


class PcdRows:
    """The points of a file, left in it.

    Nothing is allocated before the file is known to be long enough for its header.

    Parameters
    ----------
    source : ByteSource
        The file.
    start : int
        Where its points begin.
    header : PcdHeader
        Its header; not compressed.

    Raises
    ------
    CloudFileError
        Fewer points than the header promises, or more lines than that.
    """

    def __init__(self, source: ByteSource, start: int, header: PcdHeader) -> None:
        self._source, self._start, self._header = source, start, header
        is_text = header.encoding == "ascii"
        size = source.size - start
        least = 2 * sum(field.count for field in header.fields) if is_text else header.point_size
        # The last line of a text may lack its newline.
        _check_size(header, least, size, size + is_text, source.path)
        n_lines = sum(map(len, self._lines())) if is_text else header.n_points
        if n_lines != header.n_points:
            raise CloudFileError(
                source.path,
                f"the header promises {header.n_points} points, but {n_lines} lines follow",
                _CUT_SHORT,
            )

    def read(self, at_a_time: int) -> Iterator[tuple[FieldValues, OddWords]]:
        """Read the fields of all points, some at a time.

        Yields
        ------
        fields : sequence of ndarray, each of shape (n, count)
            In the order of the header.
        odd : dict
            Words of text that are not finite and not spelled as usual, by row and by `item_name`.

        Raises
        ------
        CloudFileError
            A value is not a number of its field's type, or the file has changed.
        """
        header = self._header
        lines = chain.from_iterable(self._lines())
        dtype = _row_type(header.fields)
        for first in range(0, header.n_points, at_a_time):
            count = min(at_a_time, header.n_points - first)
            if header.encoding == "ascii":
                yield self._parsed(list(islice(lines, count)), first)
                continue
            data = self._source.read(
                self._start + first * header.point_size, count * header.point_size
            )
            table = np.frombuffer(data, dtype)
            yield [np.ascontiguousarray(table[name]) for name in table.dtype.names or ()], {}

    def _lines(self) -> Iterator[list[bytes]]:
        for _, block in self._source.line_blocks(self._start, self._source.size):
            yield [line for line in block.splitlines() if line.strip()]

    def _parsed(self, lines: Sequence[bytes], first: int) -> tuple[FieldValues, OddWords]:
        fields = self._header.fields
        names = [field.name for field in fields for _ in range(field.count)]
        try:
            table = read_rows(lines, _item_type(fields), names, first)
        except ValueError as error:
            raise CloudFileError(
                self._source.path,
                f"malformed PCD points ({excerpt(str(error))})",
                "correct the file or export it again",
            ) from error
        values = [
            np.stack([table[item_name(rank, item)] for item in range(field.count)], axis=1)
            for rank, field in enumerate(fields)
        ]
        return values, odd_words(lines, table)


def no_fields(header: PcdHeader) -> FieldValues:
    """Values of no points."""
    return [np.empty((0, field.count), field.dtype) for field in header.fields]


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


def unpacked_fields(body: bytes, header: PcdHeader, path: str) -> FieldValues:
    """Unpack points that are stored field after field, in one stream.

    Parameters
    ----------
    body : bytes
        Everything after the header.
    header : PcdHeader
        The header.
    path : str
        Name of the file in errors.

    Raises
    ------
    CloudFileError
        Damaged or cut short.
    """
    room = LARGEST_RATIO * len(body)
    _check_size(header, header.point_size, len(body), room, path, "compressed ")
    if header.n_points == 0:
        return no_fields(header)
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


def _check_size(
    header: PcdHeader, least: int, size: int, room: int, path: str, packed: str = ""
) -> None:
    """Raise `CloudFileError` if points of so many bytes at least do not fit into their room."""
    if header.n_points * least > room:
        raise CloudFileError(
            path,
            f"the header promises {header.n_points} points, which take at least "
            f"{header.n_points * least} bytes, but {size} {packed}bytes follow",
            _CUT_SHORT,
        )
