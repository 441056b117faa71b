"""Temporary files and folders that a killed process left, and how to know them.

Each name says which process made it: on which host, its number, and when it started, as numbers
are given out again. So the next run in the folder can tell what nobody needs any more.
"""

from __future__ import annotations

import os
import re
import secrets
import shutil
from contextlib import suppress
from functools import cache
from hashlib import blake2b
from pathlib import Path

#: Only folders have a purpose, and only files a suffix.
_NAME = re.compile(
    r"\.pcsmooth-(?:(?P<purpose>[a-z]+)-)?"
    r"(?P<host>[0-9a-f]{8})-(?P<process>\d+)-(?P<start>\d+)-\w+(?(purpose)|\.tmp)"
)


def temporary_name() -> str:
    """Make a name for a temporary file of this process, in whatever folder."""
    return f".pcsmooth-{process_mark()}-{secrets.token_hex(8)}.tmp"


def folder_prefix(purpose: str) -> str:
    """Say how the name of a temporary folder of this process begins; the purpose is a word."""
    return f".pcsmooth-{purpose}-{process_mark()}-"


def process_mark() -> str:
    """Words that no other process has in its names: host, number, and start in clock ticks."""
    process = os.getpid()
    return f"{_host()}-{process}-{_start_of(process) or 0}"


def remove_abandoned(folder: str | os.PathLike[str]) -> list[str]:
    """Remove the temporary files and folders of processes of this host that are gone.

    Parameters
    ----------
    folder : path
        Where to look; not in folders within it.

    Returns
    -------
    list of str
        Names of what is gone; what cannot be removed stays, and is none of them.
    """
    removed = []
    with suppress(OSError):  # whoever writes there says what is wrong with it
        for entry in sorted(os.listdir(folder)):
            made_by = _NAME.fullmatch(entry)
            if made_by is None or made_by["host"] != _host():
                continue
            if not _is_gone(int(made_by["process"]), int(made_by["start"])):
                continue
            path = Path(folder) / entry
            with suppress(OSError):
                if made_by["purpose"]:
                    shutil.rmtree(path)
                else:
                    path.unlink()
                removed.append(entry)
    return removed


def _is_gone(process: int, start: int) -> bool:
    """Whether a process has ended, or another one has its number now."""
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:
        pass  # somebody else's
    now = _start_of(process)
    return now is not None and now != start


def _start_of(process: int) -> int | None:
    """When a process started, in clock ticks; 0 for one that has ended, None if nobody says."""
    try:
        with open(f"/proc/{process}/stat", "rb") as file:
            state, *fields = file.read().rpartition(b")")[2].split()
    except (OSError, ValueError):
        return None
    return 0 if state in b"ZX" else int(fields[18])


@cache
def _host() -> str:
    """Words for this host, and for the container if this is one: numbers mean nothing elsewhere."""
    words = [os.uname().nodename]
    with suppress(OSError):
        words.append(Path("/etc/machine-id").read_text(encoding="ascii"))
    with suppress(OSError):
        words.append(os.readlink("/proc/self/ns/pid"))
    return blake2b("\0".join(words).encode(errors="surrogateescape"), digest_size=4).hexdigest()
