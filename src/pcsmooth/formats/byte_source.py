"""A file that is read at any place, any number of times, in pieces of bounded size."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from typing import BinaryIO

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.system_errors import named_system_errors
from pcsmooth.formats.unchanged import Unchanged

BLOCK = 1 << 18
"""Bytes that are read at a time."""

_SMALL_BLOCK = 1 << 13


class ByteSource:
    """Bytes of an open file, which stays open and as it is; not for several threads at once.

    Parameters
    ----------
    file : binary file
        Open for reading, and seekable.
    path : str
        Name of the file in errors.
    is_packed : bool
        Whether these are the bytes that a compressed file of that path holds.

    Attributes
    ----------
    path : str
        Name of the file in errors.
    is_packed : bool
        Whether the file of that path holds them compressed.
    size : int
        Bytes of the file.
    in_memory : bool
        Whether it is in memory.
    """

    def __init__(self, file: BinaryIO, path: str, *, is_packed: bool = False) -> None:
        self._file = file
        self.path = path
        self.is_packed = is_packed
        self.in_memory = isinstance(file, io.BytesIO)
        with named_system_errors(path):
            self._unchanged = Unchanged(path, file)
            self.size = file.seek(0, os.SEEK_END)

    def read(self, start: int, size: int) -> bytes:
        """Read so many bytes, all of them within the size that the file had.

        Raises
        ------
        CloudFileError
            They are no longer there, the file is not what it was, or the disk fails.
        """
        with named_system_errors(self.path):
            self._file.seek(start)
            data = self._file.read(size)
        if len(data) < size:
            raise self.changed()
        self._unchanged.check()
        return data

    def blocks(self, start: int, end: int) -> Iterator[bytes]:
        """Read bytes, a block at a time."""
        for position in range(start, end, BLOCK):
            yield self.read(position, min(BLOCK, end - position))

    def line_blocks(self, start: int, end: int) -> Iterator[tuple[int, bytes]]:
        """Read whole lines, about a block of them at a time.

        Parameters
        ----------
        start, end : int
            Where the first line begins and the last one ends, if only with the file.

        Yields
        ------
        position : int
            Where the lines begin.
        lines : bytes
            The lines. Between a carriage return and its line feed two blocks may meet, so that
            an empty line begins the second.
        """
        size = _SMALL_BLOCK
        while start < end:
            block = self.read(start, min(size, end - start))
            if start + len(block) < end:
                block = block[: max(block.rfind(b"\n"), block.rfind(b"\r")) + 1]
            if block:
                yield start, block
                start += len(block)
            # A line may be longer than any block.
            size = min(2 * size, BLOCK) if block else 2 * size

    def check(self) -> None:
        """Raise `CloudFileError` if the file is no longer what it was, `ValueError` if closed."""
        self.read(0, 0)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def changed(self) -> CloudFileError:
        """Error of a file that is no longer what it was."""
        return self._unchanged.error()
