"""Which file a path leads to."""

from __future__ import annotations

import errno
import os
import stat

from pcsmooth.errors import CloudFileError

_MOST_LINKS = 40
"""Links that are followed one after the other, as Linux does."""

_SHARED = stat.S_ISVTX | stat.S_IWOTH
"""Mode of a folder, such as ``/tmp``, where all may make files, and each remove his own only."""


def link_target(path: str) -> str:
    """Follow symbolic links to a file that is to be written, but no trap.

    In a shared folder somebody else may lay a link to a file that only this user may write. There
    links are followed that are of this user or of the folder's owner, and no others; so does
    Linux with ``fs.protected_symlinks``, which takes no notice of links that are merely read.

    Parameters
    ----------
    path : str
        The file, which need not exist.

    Returns
    -------
    str
        Its absolute path, which is no link.

    Raises
    ------
    CloudFileError
        A link of somebody else in a shared folder.
    OSError
        Links in a circle.
    """
    place = path
    for _ in range(_MOST_LINKS):
        if not os.path.islink(place):
            return os.path.realpath(place)
        parent = os.path.dirname(place)
        folder, link = os.stat(parent or "."), os.lstat(place)
        is_shared = folder.st_mode & _SHARED == _SHARED
        if is_shared and link.st_uid not in (os.geteuid(), folder.st_uid):
            raise CloudFileError(
                path,
                "a link of somebody else, in a folder that all may write, leads elsewhere",
                "name the file itself",
            )
        place = os.path.join(parent, os.readlink(place))
    raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), path)


def file_identity(path: str) -> object:
    """Tell files apart, whatever links lead to them.

    Parameters
    ----------
    path : str
        A file, which need not exist.

    Returns
    -------
    object
        Equal for one file alone: its place on the disk, or if it is not there its absolute path.
    """
    try:
        state = os.stat(path)
    except OSError:
        return os.path.realpath(path)
    return state.st_dev, state.st_ino
