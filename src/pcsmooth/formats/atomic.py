"""A file is replaced as a whole or not at all, and a new one takes no other's place."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Callable, Iterator
from functools import partial
from typing import BinaryIO

from pcsmooth.cleanup import on_failure
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.file_attributes import keep_attributes
from pcsmooth.formats.link_target import link_target
from pcsmooth.temporaries import temporary_name


@contextlib.contextmanager
def atomic_write(
    path: str, *, overwrite: bool = True, tell: Callable[[str], object] | None = None
) -> Iterator[BinaryIO]:
    """Open a file for writing that takes its place only when the block succeeds.

    The bytes go to a temporary file in the folder of the target and from there to the disk; then
    it gets its name. After any exception, ``KeyboardInterrupt`` included, the temporary file is
    gone and the old file is as it was. Symbolic links are followed, see `link_target`. The file
    that replaces another is for this user alone until it gets the other's attributes, see
    `keep_attributes`; a new one has the mode that ``open`` would give it. A device or a named
    pipe cannot be replaced and is written directly. What a process that is killed outright
    leaves, `pcsmooth.temporaries` removes.

    Parameters
    ----------
    path : str
        The file to create or replace.
    overwrite : bool
        Whether a file that is there is replaced, even one that comes to be there meanwhile.
    tell : callable, optional
        Gets a phrase for each attribute of a replaced file that could not be kept.

    Yields
    ------
    binary file
        Open for writing; the block leaves it open.

    Raises
    ------
    CloudFileError
        There is a file that must not be replaced, or somebody else's link.
    OSError
        The folder is missing or closed to writing, the target is a folder or is write-protected,
        or the disk is full.
    """
    target = link_target(path)
    old = _state_of(target)
    if old is not None and not stat.S_ISREG(old.st_mode):
        with open(target, "wb") as file:
            yield file
        return
    if old is not None and not overwrite:
        raise _taken(path)
    if old is not None and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)

    folder = os.path.dirname(target)
    temporary = os.path.join(folder, temporary_name())
    mode = 0o666 if old is None else 0o600
    lost: list[str] = []
    with on_failure(partial(os.unlink, temporary)):
        with open(temporary, "xb", opener=partial(os.open, mode=mode)) as file:
            yield file
            file.flush()
            if old is not None:
                lost = keep_attributes(target, old, file.fileno())
            os.fsync(file.fileno())
        if overwrite:
            os.replace(temporary, target)
        else:
            try:
                _name_anew(temporary, target)
            except FileExistsError as error:
                raise _taken(path) from error
    _sync_folder(folder)
    if tell is not None:
        for phrase in lost:
            tell(phrase)


def _state_of(path: str) -> os.stat_result | None:
    try:
        return os.stat(path)
    except FileNotFoundError:
        return None


def _name_anew(temporary: str, target: str) -> None:
    """Rename a file, unless the name is taken: only a link can do both in one step."""
    try:
        os.link(temporary, target)
    except FileExistsError:
        raise
    except OSError:
        # A disk without hard links: an empty file claims the name.
        with open(target, "xb"), on_failure(partial(os.unlink, target)):
            os.replace(temporary, target)
    else:
        os.unlink(temporary)


def _sync_folder(folder: str) -> None:
    """Put the names in a folder on the disk, where the system can."""
    with contextlib.suppress(OSError):
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)


def _taken(path: str) -> CloudFileError:
    return CloudFileError(
        path, "exists already, perhaps since a moment ago", "pass --overwrite to replace it"
    )
