"""Folders in which nobody else can have put a file."""

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
    for part in (folder, *folder.parents):
        state = os.stat(part)
        owners = (os.geteuid(),) if part == folder else (os.geteuid(), 0)
        if state.st_uid not in owners:
            raise PermissionError(errno.EPERM, f"{part} is somebody else's", str(wanted))
        is_shared = part != folder and state.st_mode & stat.S_ISVTX
        if state.st_mode & _OTHERS_WRITE and not is_shared:
            raise PermissionError(errno.EPERM, f"others may write {part}", str(wanted))
    folder.chmod(0o700)
    with tempfile.TemporaryFile(dir=folder):
        return folder
