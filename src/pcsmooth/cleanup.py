"""What is to be put away when work ends before its time.

An exception puts it away on its way out. But an interrupt is no exception before the interpreter
gets its turn, which compiled code may keep from it for long: then another thread puts away what
there is, by `clean_up`, and ends the process.
"""

from __future__ import annotations

import atexit
import shutil
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial

_pending: list[Callable[[], object]] = []

#: Held while something is put away: each thing is put away once, and nobody leaves meanwhile.
_lock = threading.RLock()


@contextmanager
def on_failure(put_away: Callable[[], object]) -> Iterator[None]:
    """Call a function if the block does not come to its end, by an exception or by `clean_up`.

    Parameters
    ----------
    put_away : callable
        Called once; it may be in another thread. Its own errors are lost.
    """
    action = partial(put_away)  # differs from every other, even one of the same function
    _pending.append(action)
    try:
        yield
    except BaseException:
        _run(action)
        raise
    with _lock:
        if action in _pending:
            _pending.remove(action)


def at_end(put_away: Callable[[], object]) -> None:
    """Call a function when the process ends, be it by `clean_up`.

    Parameters
    ----------
    put_away : callable
        Called once; it may be in another thread. Its own errors are lost.
    """
    action = partial(put_away)
    _pending.append(action)
    atexit.register(_run, action)


def clean_up(patience: float) -> None:
    """Put away everything, the latest first.

    Parameters
    ----------
    patience : float
        Most seconds to wait for another thread that is putting something away.
    """
    if _lock.acquire(timeout=patience):
        try:
            for action in reversed(_pending.copy()):
                _run(action)
        finally:
            _lock.release()


@contextmanager
def temporary_folder(prefix: str, parent: str | None = None) -> Iterator[str]:
    """Make a folder that is gone in the end.

    Parameters
    ----------
    prefix : str
        How its name begins.
    parent : str, optional
        Where it is made; by default where the system has such folders.

    Yields
    ------
    str
        Its path.

    Raises
    ------
    OSError
        It cannot be made there.
    """
    folder = tempfile.mkdtemp(prefix=prefix, dir=parent)
    with on_failure(partial(shutil.rmtree, folder, ignore_errors=True)):
        yield folder
        shutil.rmtree(folder)


def _run(action: Callable[[], object]) -> None:
    with _lock:
        if action in _pending:
            _pending.remove(action)
            with suppress(Exception):
                action()
