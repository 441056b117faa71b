"""Processes that this one starts to share its work, and ends."""

from __future__ import annotations

import multiprocessing
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from multiprocessing.context import SpawnContext


def spawning() -> SpawnContext:
    """Give the way in which they start everywhere: a fork copies locks as they happen to be."""
    # The process that puts away semaphores which nobody could need not tell of it. It is started
    # here, as it would lift the mask below, and must not be the first to end.
    sys.warnoptions.append("ignore:resource_tracker:UserWarning")
    try:
        with deaf_to_interrupts():
            resource_tracker.ensure_running()
    finally:
        sys.warnoptions.pop()
    return multiprocessing.get_context("spawn")


@contextmanager
def deaf_to_interrupts() -> Iterator[None]:
    """Start processes within the block that Ctrl-C does not reach; for this one it waits.

    All processes of a terminal would get it, or SIGHUP when it closes, but the one that started
    the others decides.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_children(patience: float) -> None:
    """Ask the processes that this one started to end, and after so many seconds make them."""
    children = multiprocessing.active_children()
    deadline = time.monotonic() + patience
    for child in children:
        child.terminate()
    for child in children:
        child.join(max(0.0, deadline - time.monotonic()))
    for child in children:
        child.kill()


def when_parent_ends(act: Callable[[], None]) -> None:
    """Call a function, in another thread, once the process that started this one is gone.

    However it ended: one that is killed cannot tell the others.
    """

    def watch() -> None:
        parent = multiprocessing.parent_process()
        if parent is not None:
            parent.join()
            act()

    threading.Thread(target=watch, name="parent", daemon=True).start()
