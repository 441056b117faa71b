"""The door by which Python enters kernels that run on several threads.

Where the threads are OpenMP's, as on Linux unless the user has chosen others, they do not survive
a fork: numba then ends the process that would use them, and a pool of such processes waits for
ever. Another layer, numba's workqueue, does survive, but may not be entered by two threads at a
time, and the choice would hold for all of the user's own kernels. So a forked process is told what
to do instead. What is entered here releases the GIL, so that other threads can see to interrupts.
"""

import os
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from typing import Any

import numba

from pcsmooth.errors import PcsmoothError

#: Whether this process was forked from one whose threads it would need.
_has_lost_threads = False

#: Held by the thread that is inside: not every layer may be entered twice.
_inside = threading.Lock()


def entry(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Let Python call a compiled kernel that runs on several threads.

    Kernels call each other directly. The function that is returned raises `PcsmoothError` in a
    process that was forked when OpenMP's threads were running.
    """

    @wraps(kernel)
    def entered(*arguments: Any) -> Any:
        if _has_lost_threads:
            raise PcsmoothError(
                "this process was forked after kernels had run, and OpenMP's threads do not "
                'survive that; start processes with multiprocessing.get_context("spawn")'
            )
        with _inside:
            return kernel(*arguments)

    return entered


def _note_fork() -> None:
    global _has_lost_threads, _inside
    _inside = threading.Lock()  # whoever held it is not in this process
    with suppress(ValueError):  # no thread has been started yet
        _has_lost_threads = numba.threading_layer() == "omp"


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)
