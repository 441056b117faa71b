"""Replace a file as a whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
from collections.abc import Iterator
from functools import partial
from typing import BinaryIO

from pcsmooth.cleanup import on_failure


@contextlib.contextmanager
def atomic_write(path: str) -> Iterator[BinaryIO]:
    """Open a file for writing that takes the place of `path` only when the block succeeds.

    The bytes go to a temporary file in the folder of the target, which is then renamed. After
    any exception, ``KeyboardInterrupt`` included, the temporary file is gone and the old file
    is as it was. Symbolic links are followed; the mode of a replaced file is kept, and a new
    file gets the mode that ``open`` would give it. A device or a named pipe cannot be replaced
    and is written directly. A process that is killed outright leaves the hidden temporary file,
    ``.pcsmooth-*.tmp``, behind; as it may belong to a run that is still going on, no other run
    removes it.

    Parameters
    ----------
    path : str
        The file to create or replace.

    Yields
    ------
    binary file
        Open for writing.

    Raises
    ------
    OSError
        The folder is missing or closed to writing, the target is a folder or is write-protected,
        or the disk is full.
    """
    target = os.path.realpath(path)
    mode = _mode_of(target)
    if mode is not None and not stat.S_ISREG(mode):
        with open(target, "wb") as file:
            yield file
        return
    if mode is not None and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)

    temporary = os.path.join(os.path.dirname(target), f".pcsmooth-{secrets.token_hex(8)}.tmp")
    with on_failure(partial(os.unlink, temporary)):
        with open(temporary, "xb") as file:
            yield file
        if mode is not None:
            os.chmod(temporary, stat.S_IMODE(mode))
        os.replace(temporary, target)


def _mode_of(path: str) -> int | None:
    try:
        return os.stat(path).st_mode
    except FileNotFoundError:
        return None
