"""File objects for laspy and lazrs, of which the latter forgets what goes wrong in them."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from typing import Any, BinaryIO

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.byte_source import ByteSource


class _Remembering:
    """Something that raises again what was raised in it, once that was turned into other words."""

    _error: BaseException | None = None

    @contextlib.contextmanager
    def own_errors(self) -> Iterator[None]:
        """Raise the error of the file in place of what became of it."""
        try:
            yield
        except CloudFileError:
            if self._error is None:
                raise
            raise self._error from None

    @contextlib.contextmanager
    def _remembered(self) -> Iterator[None]:
        try:
            yield
        except BaseException as error:  # an interruption too must not become a damaged file
            self._error = error
            raise


class SourceFile(_Remembering, io.RawIOBase):
    """A source as a file object with a place of its own.

    Parameters
    ----------
    source : ByteSource
        Where the bytes are.
    place : int
        Where reading begins.
    """

    def __init__(self, source: ByteSource, place: int) -> None:
        super().__init__()
        self._source = source
        self._place = place

    def readable(self) -> bool:
        """Return true."""
        return True

    def seekable(self) -> bool:
        """Return true."""
        return True

    def tell(self) -> int:
        """Return the place."""
        return self._place

    def seek(self, offset: int, whence: int = io.SEEK_SET, /) -> int:
        """Go to another place."""
        starts = {io.SEEK_SET: 0, io.SEEK_CUR: self._place, io.SEEK_END: self._source.size}
        self._place = max(0, starts[whence] + offset)
        return self._place

    def readinto(self, buffer: Any, /) -> int:
        """Fill a buffer, as far as there are bytes."""
        size = max(0, min(len(buffer), self._source.size - self._place))
        with self._remembered():
            buffer[:size] = self._source.read(self._place, size)
        self._place += size
        return size


class TargetFile(_Remembering):
    """A file that is written by others.

    Parameters
    ----------
    file : binary file
        Open for writing, at its beginning, and seekable.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file

    def seekable(self) -> bool:
        """Return true."""
        return True

    def write(self, data: Any) -> int:
        """Write bytes."""
        with self._remembered():
            return self._file.write(data)

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Go to another place."""
        with self._remembered():
            return self._file.seek(offset, whence)

    def tell(self) -> int:
        """Return the place."""
        return self._file.tell()

    def flush(self) -> None:
        """Hand over what is held back."""
        with self._remembered():
            self._file.flush()
