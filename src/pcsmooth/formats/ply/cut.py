"""Where the rows of each element are in a PLY file, found before any of them is read."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from plyfile import PlyElement, PlyListProperty

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.byte_source import BLOCK, ByteSource
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.ply.header import PlyHeader, has_lists

_CUT_SHORT = "get the whole file again"

_SMALL_WINDOW = 1 << 12
"""Bytes in which the lengths of lists are looked up at first."""

_ListStep = tuple[int, struct.Struct, int]
"""Bytes to skip before a list, the field that holds its length, and the size of an item."""


@dataclass(frozen=True)
class ElementRows:
    """The rows of an element, left in the file; iterating copies them, a block at a time.

    Attributes
    ----------
    source : ByteSource
        The file.
    header : PlyHeader
        Its header, for the encoding.
    element : plyfile.PlyElement
        Description of the element.
    start, end : int
        Where in the file the rows are.
    is_spread : bool
        Whether a row of the text takes several lines.
    """

    source: ByteSource
    header: PlyHeader
    element: PlyElement
    start: int
    end: int
    is_spread: bool = False

    def __iter__(self) -> Iterator[bytes]:
        """Give the rows as they are in the file, but in text each on a line and without others."""
        if not self.header.text:
            yield from self.source.blocks(self.start, self.end)
            return
        for lines in self.lines():
            yield b"".join(line + b"\n" for line in lines)

    def lines(self) -> Iterator[list[bytes]]:
        """Give the rows of a text file without their line ends, some at a time."""
        blocks = (
            [line for line in block.splitlines() if line.strip()]
            for _, block in self.source.line_blocks(self.start, self.end)
        )
        return _joined(blocks, len(self.element.properties)) if self.is_spread else blocks


def cut_rows(source: ByteSource, start: int, header: PlyHeader) -> list[ElementRows]:
    """Cut the part of a PLY file after its header into one piece per element.

    Nothing is allocated for the rows that the header promises.

    Parameters
    ----------
    source : ByteSource
        The file.
    start : int
        Where the header ends.
    header : PlyHeader
        The header.

    Returns
    -------
    list of ElementRows
        The rows of each element.

    Raises
    ------
    CloudFileError
        The file holds fewer rows than its header promises.
    """
    least = sum(element.count * _least_row_size(element, header) for element in header.elements)
    size = source.size - start
    # The last line of a text file may lack its newline.
    if least > size + header.text:
        promised = ", ".join(f"{element.count} {element.name}" for element in header.elements)
        raise CloudFileError(
            source.path,
            f"the header promises {excerpt(promised)} rows, which take at least {least} bytes, "
            f"but {size} bytes follow",
            _CUT_SHORT,
        )
    pieces = []
    for element in header.elements:
        is_spread = header.text and _is_spread(source, start, element)
        if not header.text:
            end = end_of_binary_rows(source, start, element, header, range(element.count))
        elif is_spread:
            end = _end_of_spread_rows(source, start, element)
        else:
            end = _end_of_lines(source, start, element)
        pieces.append(ElementRows(source, header, element, start, end, is_spread))
        start = end
    return pieces


def end_of_binary_rows(
    source: ByteSource, start: int, element: PlyElement, header: PlyHeader, rows: range
) -> int:
    """Find the end of some rows of a binary file.

    Parameters
    ----------
    source : ByteSource
        The file.
    start : int
        Where the first of the rows begins.
    element : plyfile.PlyElement
        Description of the element.
    header : PlyHeader
        The header, for the encoding.
    rows : range
        Numbers of the rows, for errors.

    Returns
    -------
    int
        Where the last of the rows ends.

    Raises
    ------
    CloudFileError
        The file ends before, or a list has a negative length.
    """
    if has_lists(element):
        end = _end_of_lists(source, start, element, header.byte_order, rows)
    else:
        end = start + len(rows) * _least_row_size(element, header)
    if end > source.size:
        raise _missing_rows(element, source.path, f"{end - source.size} bytes are missing")
    return end


def _least_row_size(element: PlyElement, header: PlyHeader) -> int:
    if header.text:
        return 2 * len(element.properties)
    return sum(
        np.dtype(prop.len_dtype if isinstance(prop, PlyListProperty) else prop.val_dtype).itemsize
        for prop in element.properties
    )


def _end_of_lines(source: ByteSource, start: int, element: PlyElement) -> int:
    """Walk over lines until the element has its rows; blank lines are none."""
    if element.count == 0:
        return start
    found = 0
    for position, block in source.line_blocks(start, source.size):
        lines = block.splitlines(keepends=True)
        places = [place for place, line in enumerate(lines) if line.strip()]
        del places[element.count - found :]
        if element.name != "vertex":  # whose values are read
            _check_widths([lines[place] for place in places], element, found, source.path)
        found += len(places)
        if found == element.count:
            return position + sum(map(len, lines[: places[-1] + 1]))
    raise _fewer_rows(element, source.path, found)


def _is_spread(source: ByteSource, start: int, element: PlyElement) -> bool:
    """Whether the first line has too few values for a row; of lists that is not to be seen."""
    if element.count == 0 or has_lists(element):
        return False
    for _, block in source.line_blocks(start, source.size):
        for line in block.splitlines():
            if line.strip():
                return len(line.split()) < len(element.properties)
    return False


def _end_of_spread_rows(source: ByteSource, start: int, element: PlyElement) -> int:
    """Walk over lines until the element has the values of all its rows."""
    found = n_values = 0
    for position, block in source.line_blocks(start, source.size):
        for line in block.splitlines(keepends=True):
            position += len(line)
            n_values += len(line.split())
            if n_values >= len(element.properties):
                found, n_values = found + 1, 0
                if found == element.count:
                    return position
    raise _fewer_rows(element, source.path, found)


def _joined(blocks: Iterable[list[bytes]], n_values: int) -> Iterator[list[bytes]]:
    """Put lines together that are one row of so many values."""
    row: list[bytes] = []
    for lines in blocks:
        rows = []
        for line in lines:
            row += line.split()
            if len(row) >= n_values:
                rows.append(b" ".join(row))
                row = []
        yield rows


def _check_widths(rows: Sequence[bytes], element: PlyElement, first: int, path: str) -> None:
    least = len(element.properties)
    for row, line in enumerate(rows, first):
        if len(line.split()) < least:
            raise CloudFileError(
                path,
                f"{excerpt(element.name)} row {row} has fewer values than properties",
                "correct the file or export it again",
            )


def _end_of_lists(
    source: ByteSource, start: int, element: PlyElement, byte_order: str, rows: range
) -> int:
    """Walk over rows that hold lists; each list begins with its own length."""
    steps, rest = _steps_of_row(element, byte_order)
    position = window_start = window_end = start
    window, size = b"", _SMALL_WINDOW
    for row in rows:
        for skipped, length_field, item_size in steps:
            position += skipped
            if position + length_field.size > window_end:
                if position + length_field.size > source.size:
                    raise _missing_rows(element, source.path, f"the data end in row {row}")
                window_start, window_end = position, min(position + size, source.size)
                window = source.read(window_start, window_end - window_start)
                size = min(2 * size, BLOCK)
            length = int(length_field.unpack_from(window, position - window_start)[0])
            if length < 0:
                raise CloudFileError(
                    source.path,
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


def _fewer_rows(element: PlyElement, path: str, found: int) -> CloudFileError:
    return CloudFileError(
        path,
        f"the header promises {element.count} {excerpt(element.name)} rows, but {found} follow",
        _CUT_SHORT,
    )


def _missing_rows(element: PlyElement, path: str, detail: str) -> CloudFileError:
    return CloudFileError(
        path,
        f"the {excerpt(element.name)} rows of the header are not all there: {detail}",
        _CUT_SHORT,
    )
