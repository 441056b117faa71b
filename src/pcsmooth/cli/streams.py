"""The standard streams, which may be closed or full."""

from __future__ import annotations

import errno
import io
import os
import sys


def claim_standard_streams() -> None:
    """Put something in the place of streams that are closed, lest files take their numbers.

    Reading from it or writing to it is an ``OSError``; stderr swallows what it is told. A stdout
    without a buffer (PYTHONUNBUFFERED) gets one: without, what a pipe or disk does not take of a
    write is lost in silence.
    """
    for number, flags in enumerate((os.O_WRONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, flags)  # takes the lowest number that is free
    sys.stdin = sys.stdin or os.fdopen(0, closefd=False)
    sys.stdout = sys.stdout or os.fdopen(1, "w", closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, "w", closefd=False)
    is_own = isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout is sys.__stdout__
    if is_own and isinstance(sys.stdout.buffer, io.RawIOBase):
        whole = io.BufferedWriter(sys.stdout.buffer)
        sys.stdout = io.TextIOWrapper(
            whole, sys.stdout.encoding, sys.stdout.errors, line_buffering=True
        )


def settle_stdout() -> None:
    """Drop what cannot be written, lest the end of the process tries again."""
    try:
        sys.stdout.flush()
    except OSError:
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, sys.stdout.fileno())
        os.close(null)


def cause_and_remedy(error: OSError) -> str:
    """Say why a stream could not be written."""
    if error.errno == errno.EBADF:
        return "it is closed; redirect it to a file or a command"
    return f"{error.strerror or error}; check where it goes and try again"
