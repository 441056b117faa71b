"""The rows of a PLY file: cut into elements, read and written."""

from __future__ import annotations

import contextlib
import io
import struct
import warnings
from collections.abc import Sequence
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt
from plyfile import PlyData, PlyElement, PlyListProperty, PlyParseError

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import spelled, write_rows
from pcsmooth.formats.ply_header import PlyHeader, has_lists

_CUT_SHORT = "get the whole file again"

_ListStep = tuple[int, struct.Struct, int]
"""Bytes to skip before a list, the field that holds its length, and the size of an item."""


def cut_rows(body: bytes, header: PlyHeader, path: str) -> list[bytes]:
    """Cut the part of a PLY file after its header into one piece per element.

    Nothing is allocated before the file is known to be long enough for its header.

    Parameters
    ----------
    body : bytes
        Everything after the header.
    header : PlyHeader
        The header.
    path : str
        Name of the file in errors.

    Returns
    -------
    list of bytes
        The rows of each element, as they are in the file.

    Raises
    ------
    CloudFileError
        The file holds fewer rows than its header promises.
    """
    least = sum(element.count * _least_row_size(element, header) for element in header.elements)
    # The last line of a text file may lack its newline.
    if least > len(body) + header.text:
        promised = ", ".join(f"{element.count} {element.name}" for element in header.elements)
        raise CloudFileError(
            path,
            f"the header promises {excerpt(promised)} rows, which take at least {least} bytes, "
            f"but {len(body)} bytes follow",
            _CUT_SHORT,
        )
    return _cut_lines(body, header, path) if header.text else _cut_binary(body, header, path)


def read_rows(rows: bytes, element: PlyElement, header: PlyHeader, path: str) -> npt.NDArray[Any]:
    """Read the rows of one element.

    Parameters
    ----------
    rows : bytes
        The piece that `cut_rows` gave for the element.
    element : plyfile.PlyElement
        Its description.
    header : PlyHeader
        The header, for the encoding.
    path : str
        Name of the file in errors.

    Returns
    -------
    structured ndarray, shape (count,)
        One field per property; list properties are objects.

    Raises
    ------
    CloudFileError
        A value is not a number of its property's type; names the row.
    """
    dtype = element.dtype(header.byte_order)
    if element.count == 0:
        return np.empty(0, dtype)
    if not has_lists(element):
        if not header.text:
            return np.frombuffer(rows, dtype, element.count)
        with contextlib.suppress(ValueError):
            table = np.loadtxt(rows.splitlines(), dtype, comments=None, ndmin=1)
            if len(table) == element.count:
                return table
        # plyfile, below, says which row is wrong.
    alone = bytes(PlyHeader(header.text, header.byte_order, (element,)))
    try:
        with warnings.catch_warnings(), np.errstate(over="ignore"):
            warnings.simplefilter("ignore", UserWarning)  # about lists without items
            ply = PlyData.read(io.BytesIO(alone + rows), mmap=False)
    except (PlyParseError, ValueError, OverflowError) as error:
        raise CloudFileError(
            path,
            f"malformed PLY rows ({excerpt(str(error))})",
            "correct the file or export it again",
        ) from error
    data: npt.NDArray[Any] = ply[element.name].data
    return data


def write_element(file: BinaryIO, element: PlyElement, header: PlyHeader) -> None:
    """Write the rows of one element.

    Parameters
    ----------
    file : binary file
        Open for writing.
    element : plyfile.PlyElement
        Description and data.
    header : PlyHeader
        The header, for the encoding.
    """
    if has_lists(element):
        row_bytes = _text_row if header.text else _binary_row
        columns = [element.data[prop.name] for prop in element.properties]
        for row in zip(*columns, strict=True):
            file.write(row_bytes(row, element, header.byte_order))
    elif header.text:
        write_rows(file, [element.data[prop.name] for prop in element.properties], " ")
    else:
        table = element.data.astype(element.dtype(header.byte_order), copy=False)
        file.write(np.ascontiguousarray(table).view(np.uint8).data)


def _binary_row(row: Sequence[Any], element: PlyElement, byte_order: str) -> bytes:
    # plyfile would write the numbers beside a list in native order, whatever the header says.
    fields = []
    for prop, value in zip(element.properties, row, strict=True):
        if isinstance(prop, PlyListProperty):
            length_type, item_type = prop.list_dtype(byte_order)
            fields.append(np.array(len(value), length_type).tobytes())
            fields.append(np.asarray(value, item_type).tobytes())
        else:
            fields.append(np.asarray(value, prop.dtype(byte_order)).tobytes())
    return b"".join(fields)


def _text_row(row: Sequence[Any], element: PlyElement, byte_order: str) -> bytes:
    tokens = []
    for prop, value in zip(element.properties, row, strict=True):
        if isinstance(prop, PlyListProperty):
            tokens.append(str(len(value)))
        tokens += spelled(np.atleast_1d(np.asarray(value, byte_order + prop.val_dtype)))
    return " ".join(tokens).encode() + b"\n"


def _least_row_size(element: PlyElement, header: PlyHeader) -> int:
    if header.text:
        return 2 * len(element.properties)
    return sum(
        np.dtype(prop.len_dtype if isinstance(prop, PlyListProperty) else prop.val_dtype).itemsize
        for prop in element.properties
    )


def _cut_lines(body: bytes, header: PlyHeader, path: str) -> list[bytes]:
    lines = [line for line in body.splitlines() if line.strip()]
    pieces, start = [], 0
    for element in header.elements:
        rows = lines[start : start + element.count]
        if len(rows) < element.count:
            raise CloudFileError(
                path,
                f"the header promises {element.count} {excerpt(element.name)} rows, "
                f"but {len(rows)} follow",
                _CUT_SHORT,
            )
        if element.name != "vertex":  # whose values are read
            _check_widths(rows, element, path)
        pieces.append(b"".join(row + b"\n" for row in rows))
        start += element.count
    return pieces


def _check_widths(rows: Sequence[bytes], element: PlyElement, path: str) -> None:
    least = len(element.properties)
    for row, line in enumerate(rows):
        if len(line.split()) < least:
            raise CloudFileError(
                path,
                f"{excerpt(element.name)} row {row} has fewer values than properties",
                "correct the file or export it again",
            )


def _cut_binary(body: bytes, header: PlyHeader, path: str) -> list[bytes]:
    pieces, start = [], 0
    for element in header.elements:
        if has_lists(element):
            end = _end_of_lists(body, start, element, header.byte_order, path)
        else:
            end = start + element.count * _least_row_size(element, header)
        if end > len(body):
            raise _missing_rows(element, path, f"{end - len(body)} bytes are missing")
        pieces.append(body[start:end])
        start = end
    return pieces


def _end_of_lists(body: bytes, start: int, element: PlyElement, byte_order: str, path: str) -> int:
    """Walk over rows that hold lists; each list begins with its own length."""
    steps, rest = _steps_of_row(element, byte_order)
    position = start
    for row in range(element.count):
        for skipped, length_field, item_size in steps:
            position += skipped
            try:
                length = int(length_field.unpack_from(body, position)[0])
            except struct.error as error:
                raise _missing_rows(element, path, f"the data end in row {row}") from error
            if length < 0:
                raise CloudFileError(
                    path,
                    f"{excerpt(element.name)} row {row} has a list of {length} items",
                    "correct the file or export it again",
                )
            position += length_field.size + length * item_size
        position += rest
    return position


def _steps_of_row(element: PlyElement, byte_order: str) -> tuple[list[_ListStep], int]:
    """How to walk over a row: one step per list, and the bytes after the last list."""
    steps, skipped = [], 0
    for prop in element.properties:
        size = np.dtype(prop.val_dtype).itemsize
        if isinstance(prop, PlyListProperty):
            length_field = struct.Struct(byte_order + np.dtype(prop.len_dtype).char)
            steps.append((skipped, length_field, size))
            skipped = 0
        else:
            skipped += size
    return steps, skipped


def _missing_rows(element: PlyElement, path: str, detail: str) -> CloudFileError:
    return CloudFileError(
        path,
        f"the {excerpt(element.name)} rows of the header are not all there: {detail}",
        _CUT_SHORT,
    )
