"""Files that are read whole because they are small: presets and their meshes."""

from __future__ import annotations

import os
import stat

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.system_errors import named_system_errors

MOST_BYTES = 256_000_000
"""Size of the largest file that is read."""

_NO_FILES = {
    stat.S_IFIFO: "a named pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def read_small_file(path: str) -> bytes:
    """Read a file that somebody else may have named: it keeps nobody waiting and fills no memory.

    Parameters
    ----------
    path : str
        The file.

    Returns
    -------
    bytes
        All that is in it.

    Raises
    ------
    CloudFileError
        It cannot be read, is a named pipe, a socket or a device, or has more than `MOST_BYTES`.
    """
    with named_system_errors(path):
        # A pipe that nobody writes would not even open.
        kind = _NO_FILES.get(stat.S_IFMT(os.stat(path).st_mode))
        if kind is not None:
            raise CloudFileError(path, f"is {kind}", "name a file")
        with open(path, "rb") as file:
            data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise CloudFileError(
            path, f"has more than {MOST_BYTES // 1_000_000} MB", "give a smaller file"
        )
    return data
