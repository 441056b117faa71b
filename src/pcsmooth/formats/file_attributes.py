"""What a file has beside its bytes and its name, for the file that takes its place."""

from __future__ import annotations

import os
import stat
import sys
from contextlib import suppress

_ACCESS_LIST = "system.posix_acl_access"
"""Extended attribute of Linux that holds the access control list."""

_OF_THE_BYTES = {"security.capability", "security.evm", "security.ima"}
"""Extended attributes that speak of the old bytes: rights of a program, and seals."""

_SET_ID = stat.S_ISUID | stat.S_ISGID


def keep_attributes(path: str, old: os.stat_result, file: int) -> list[str]:
    """Give a new file what the one has whose place it will take.

    Owner and group, extended attributes, the access list and, last of all, the mode. The setuid
    and setgid bits are dropped, as when a file is written to: they were granted to other bytes.
    Nobody gets more rights than he had.

    Parameters
    ----------
    path : str
        The old file.
    old : os.stat_result
        Its state.
    file : int
        Descriptor of the new file, with mode 0600.

    Returns
    -------
    list of str
        What could not be kept, in phrases such as ``"owner 1000 is not kept"``.

    Raises
    ------
    OSError
        The mode cannot be set.
    """
    # The group comes first: who has given a file away can do no more with it.
    for owner, group in ((-1, old.st_gid), (old.st_uid, -1)):
        with suppress(OSError):
            os.fchown(file, owner, group)
    new = os.fstat(file)
    lost = [] if new.st_uid == old.st_uid else [f"owner {old.st_uid}"]
    lost += [] if new.st_gid == old.st_gid else [f"group {old.st_gid}"]
    attributes = _keep_extended(path, file)
    mode = stat.S_IMODE(old.st_mode) & ~_SET_ID
    if new.st_gid != old.st_gid or _ACCESS_LIST in attributes:
        mode &= ~0o070 | (mode & 0o007) << 3  # what others may, and no more
    os.fchmod(file, mode)
    lost += [f"extended attribute {name}" for name in attributes]
    lost += ["its setuid or setgid bit"] if old.st_mode & _SET_ID else []
    return [f"{what} is not kept" for what in lost]


def _keep_extended(path: str, file: int) -> list[str]:
    """Give a file the extended attributes of another; returns the names of those it has not."""
    lost: list[str] = []
    if sys.platform == "linux":
        old, new = _extended(path), _extended(file)
        if _ACCESS_LIST in new.keys() - old.keys():  # from the folder
            os.removexattr(file, _ACCESS_LIST)
        for name, value in old.items():
            if name not in _OF_THE_BYTES and new.get(name) != value:
                try:
                    os.setxattr(file, name, value)
                except OSError:
                    lost.append(name)
    return lost


def _extended(file: str | int) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    if sys.platform == "linux":
        with suppress(OSError):  # the disk has none
            for name in os.listxattr(file):
                with suppress(OSError):  # it may not be read, or is gone
                    found[name] = os.getxattr(file, name)
    return found
