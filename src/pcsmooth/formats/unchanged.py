"""Whether a file is still what it was when it began to be read."""

from __future__ import annotations

import os
import stat
from typing import BinaryIO

from pcsmooth.errors import CloudFileError


class Unchanged:
    """Knows a file again, by its place on the disk, its size and its time.

    Parameters
    ----------
    path : str
        The file. A pipe or a device has nothing to be known by.
    file : binary file, optional
        The same file, open: then it may lose its name meanwhile, or be in memory, where nobody
        else changes it.

    Raises
    ------
    OSError
        It is not there.
    """

    def __init__(self, path: str, file: BinaryIO | None = None) -> None:
        self._path = path
        self._place: str | int | None = path
        if file is not None:
            self._place = _descriptor(file)
        self._before = self._now()

    def check(self) -> None:
        """Raise `CloudFileError` if the file has changed, or another one has its name."""
        try:
            now = self._now()
        except OSError:  # it is gone
            raise self.error() from None
        if now != self._before:
            raise self.error()

    def error(self) -> CloudFileError:
        """Error of a file that is no longer what it was."""
        return CloudFileError(
            self._path, "it has changed while it was read", "run again when nothing writes it"
        )

    def _now(self) -> tuple[int, ...]:
        if self._place is None:
            return ()
        state = os.stat(self._place)
        if not stat.S_ISREG(state.st_mode):
            return ()
        return state.st_dev, state.st_ino, state.st_size, state.st_mtime_ns


def _descriptor(file: BinaryIO) -> int | None:
    try:
        return file.fileno()
    except OSError:  # in memory
        return None
