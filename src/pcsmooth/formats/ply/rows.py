"""The rows of an element of a PLY file, read and written."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator, Sequence
from itertools import chain, islice
from typing import Any, BinaryIO

import numpy as np
from plyfile import PlyData, PlyElement, PlyElementParseError, PlyListProperty, PlyParseError

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import spelled, write_rows
from pcsmooth.formats.ply.cut import ElementRows, end_of_binary_rows
from pcsmooth.formats.ply.header import PlyHeader, has_lists, name_in_header
from pcsmooth.formats.typed_rows import OddWords, Table, exceptions_in, odd_words, read_rows


def read_tables(rows: ElementRows, at_a_time: int) -> Iterator[tuple[Table, OddWords]]:
    """Read the rows of one element, some at a time.

    Parameters
    ----------
    rows : ElementRows
        Where they are.
    at_a_time : int
        How many rows a table has at most, 1 or more.

    Yields
    ------
    table : structured ndarray
        One field per property; list properties are objects.
    odd : dict
        What is not spelled in text as it would be written.

    Raises
    ------
    CloudFileError
        A value is not a number of its property's type; names the row. Or the file is no longer
        what it was when its rows were cut.
    """
    count = rows.element.count
    parts = (range(row, min(row + at_a_time, count)) for row in range(0, count, at_a_time))
    return _text_tables(rows, parts) if rows.header.text else _binary_tables(rows, parts)


def _text_tables(rows: ElementRows, parts: Iterator[range]) -> Iterator[tuple[Table, OddWords]]:
    dtype = rows.element.dtype(rows.header.byte_order)
    names = [name_in_header(prop) for prop in rows.element.properties]
    every_line = chain.from_iterable(rows.lines())
    for part in parts:
        lines = list(islice(every_line, len(part)))
        if len(lines) < len(part):
            raise rows.source.changed()
        if has_lists(rows.element):
            yield _by_plyfile(b"".join(line + b"\n" for line in lines), rows, part), {}
            continue
        try:
            table = read_rows(lines, dtype, names, part.start)
        except ValueError as error:
            raise _malformed(rows, error) from error
        yield table, odd_words(lines, table)


def _binary_tables(rows: ElementRows, parts: Iterator[range]) -> Iterator[tuple[Table, OddWords]]:
    dtype = rows.element.dtype(rows.header.byte_order)
    start = rows.start
    for part in parts:
        end = end_of_binary_rows(rows.source, start, rows.element, rows.header, part)
        data = rows.source.read(start, end - start)
        start = end
        table = _by_plyfile(data, rows, part) if dtype.hasobject else np.frombuffer(data, dtype)
        yield table, {}


def _by_plyfile(data: bytes, rows: ElementRows, part: range) -> Table:
    element = PlyElement(rows.element.name, rows.element.properties, len(part))
    alone = PlyData((element,), text=rows.header.text, byte_order=rows.header.byte_order)
    header = f"{alone.header}\n".encode("ascii")
    try:
        with warnings.catch_warnings(), np.errstate(over="ignore"):
            warnings.simplefilter("ignore", UserWarning)  # about lists without items
            ply = PlyData.read(io.BytesIO(header + data), mmap=False)
    except (PlyParseError, ValueError, OverflowError) as error:
        raise _malformed(rows, _in_file(error, part)) from error
    table: Table = ply[element.name].data
    return table


def _malformed(rows: ElementRows, error: Exception) -> CloudFileError:
    return CloudFileError(
        rows.source.path,
        f"malformed PLY rows ({excerpt(str(error))})",
        "correct the file or export it again",
    )


def _in_file(error: Exception, part: range) -> Exception:
    """Count the row of an error from the first of the file."""
    if not isinstance(error, PlyElementParseError) or error.row is None:
        return error
    row = part.start + error.row
    counted: Exception = PlyElementParseError(error.message, error.element, row, error.prop)
    return counted


def write_element(file: BinaryIO, element: PlyElement, header: PlyHeader, odd: OddWords) -> None:
    """Write the rows of one element.

    Parameters
    ----------
    file : binary file
        Open for writing.
    element : plyfile.PlyElement
        Description and data.
    header : PlyHeader
        The header, for the encoding.
    odd : dict
        What is spelled in text in its own way, as it was read.
    """
    if has_lists(element):
        row_bytes = _text_row if header.text else _binary_row
        columns = [element.data[prop.name] for prop in element.properties]
        for row in zip(*columns, strict=True):
            file.write(row_bytes(row, element, header.byte_order))
    elif header.text:
        columns = [element.data[prop.name] for prop in element.properties]
        write_rows(file, columns, " ", exceptions=exceptions_in(element.data, odd))
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
