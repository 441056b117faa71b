"""Of processes that need a kernel at the same time one compiles it, and the others wait."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from pcsmooth.kernels.cache import folder_of

try:
    import fcntl
except ImportError:  # Windows: each compiles for itself
    fcntl = None  # type: ignore[assignment]

#: Seconds between two looks, and those after which nobody waits any longer.
_GLANCE = 0.02
_PATIENCE = 120.0


@contextmanager
def claimed(family: str, name: str, *, wait: bool = True) -> Iterator[bool]:
    """Claim a kernel for the block, so that no other process compiles it meanwhile.

    The claim of a process that has ended, however it did, is void. Where files cannot be locked
    everybody is told to go ahead.

    Parameters
    ----------
    family, name : str
        Of the kernel.
    wait : bool
        Whether to wait for another process that has claimed it.

    Yields
    ------
    bool
        Whether to go ahead; not, if another process has claimed it and there is no waiting.
    """
    try:
        file = open(folder_of(family) / f"{name}.claim", "ab")  # noqa: SIM115 (closed below)
    except OSError:
        yield True
        return
    with file:
        yield _lock(file.fileno(), time.monotonic() + _PATIENCE * wait) or wait


def is_claimed(family: str, name: str) -> bool:
    """Whether another process is compiling a kernel now."""
    with claimed(family, name, wait=False) as is_free:
        return not is_free


def _lock(file: int, deadline: float) -> bool:
    """Lock a file until it is closed; whether that could be done, or locks mean nothing there."""
    while fcntl is not None:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            break
        except BlockingIOError:
            if time.monotonic() >= deadline:
                return False
            time.sleep(_GLANCE)
        except OSError:
            break
    return True
