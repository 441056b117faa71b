"""Folders in which nobody else can have put a file, or nobody but root."""

from __future__ import annotations

import errno
import os
import stat
import tempfile
from pathlib import Path

_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def private_folder(wanted: Path) -> Path:
    """Make a folder for this user alone, or make sure that it is one.

    Parameters
    ----------
    wanted : Path
        The folder; its parents are made like it.

    Returns
    -------
    Path
        The same, without symbolic links, with mode 0700 and writable.

    Raises
    ------
    OSError
        It cannot be made or written, is somebody else's, or group or others may write it or, but
        for folders such as ``/tmp``, one that it is in, so that they could put another in its
        place.
    """
    if not wanted.is_absolute():
        raise FileNotFoundError(errno.ENOENT, "there is no home folder", str(wanted))
    folder = Path(os.path.realpath(wanted))
    for part in (*reversed(folder.parents), folder):
        if not part.is_dir():
            part.mkdir(0o700, exist_ok=True)
    if folder.stat().st_uid != os.geteuid():
        raise PermissionError(errno.EPERM, f"{folder} is somebody else's", str(wanted))
    _check_that_no_other_writes(folder)
    folder.chmod(0o700)
    with tempfile.TemporaryFile(dir=folder):
        return folder


def trusted_files(folder: Path) -> frozenset[str]:
    """List the files of a folder, if nobody but root and this user can have written any of them.

    Parameters
    ----------
    folder : Path
        The folder, which this user need not be able to write.

    Returns
    -------
    frozenset of str
        Their names; none if there is no such folder, or if it, a file of it or a folder that it is
        in is somebody else's or may be written by group or others, or if it holds anything but
        plain files.
    """
    try:
        real = Path(os.path.realpath(folder))
        _check_that_no_other_writes(real)
        with os.scandir(real) as files:
            states = {file.name: file.stat(follow_symlinks=False) for file in files}
    except OSError:
        return frozenset()
    is_safe = all(
        stat.S_ISREG(state.st_mode) and _is_ours(state) and not state.st_mode & _OTHERS_WRITE
        for state in states.values()
    )
    return frozenset(states) if is_safe else frozenset()


def _check_that_no_other_writes(folder: Path) -> None:
    """Make sure that only root and this user can put a file there or another in its place."""
    for part in (folder, *folder.parents):
        state = os.stat(part)
        if not _is_ours(state):
            raise PermissionError(errno.EPERM, f"{part} is somebody else's", str(folder))
        is_shared = part != folder and state.st_mode & stat.S_ISVTX
        if state.st_mode & _OTHERS_WRITE and not is_shared:
            raise PermissionError(errno.EPERM, f"others may write {part}", str(folder))


def _is_ours(state: os.stat_result) -> bool:
    return state.st_uid in (os.geteuid(), 0)
