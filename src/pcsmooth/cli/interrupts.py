"""Ctrl-C ends the process soon, whatever it is at.

Python handles a signal between two of its own instructions, not while compiled code is at work. So
another thread is told of it, too. That leaves the main thread a moment to end by an exception;
then it puts away what is to be put away and ends the process.
"""

from __future__ import annotations

import os
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

from pcsmooth.cleanup import clean_up
from pcsmooth.cli.exit_status import ExitStatus

#: Seconds that the main thread has to end by itself.
_GRACE = 0.4

#: Seconds that it has for what it is just putting away.
_PATIENCE = 1.5


class Interrupts:
    """Whether there has been one."""

    def __init__(self) -> None:
        self.happened = False

    def take(self, number: int, _frame: FrameType | None) -> None:
        """Interrupt the main thread; again would do no more than disturb it."""
        signal.signal(number, signal.SIG_IGN)
        self.happened = True
        raise KeyboardInterrupt


@contextmanager
def prompt_interrupts() -> Iterator[Interrupts]:
    """See to it that Ctrl-C ends the block, or else the process, soon.

    Where Ctrl-C is ignored, or somebody else's, nothing changes.
    """
    interrupts = Interrupts()
    before = signal.getsignal(signal.SIGINT)
    in_main_thread = threading.current_thread() is threading.main_thread()
    if before is not signal.default_int_handler or not in_main_thread:
        yield interrupts
        return
    ended = threading.Event()

    def insist() -> None:
        if not ended.wait(_GRACE):
            clean_up(_PATIENCE)
            with suppress(OSError):
                os.write(2, b"\nError: interrupted\n" if os.isatty(2) else b"Error: interrupted\n")
            os._exit(ExitStatus.INTERRUPTED)

    signal.signal(signal.SIGINT, interrupts.take)
    stop = _listen(signal.SIGINT, insist)
    try:
        yield interrupts
    finally:
        ended.set()
        stop()
        signal.signal(signal.SIGINT, before)


def end_when_told() -> None:
    """Have SIGTERM end this process, one of those at a batch, at once; nothing is left behind."""

    def end() -> None:
        clean_up(_PATIENCE)
        os._exit(ExitStatus.INTERRUPTED)

    signal.signal(signal.SIGTERM, lambda _number, _frame: None)
    _listen(signal.SIGTERM, end)


def _listen(number: int, act: Callable[[], None]) -> Callable[[], None]:
    """Call a function in another thread when a signal comes; returns what puts an end to that."""
    inner, outer = socket.socketpair()
    outer.setblocking(False)

    def listen() -> None:
        with inner:
            while numbers := inner.recv(64):  # nothing once the other end is closed
                if number in numbers:
                    act()

    def stop() -> None:
        signal.set_wakeup_fd(before)
        outer.close()

    before = signal.set_wakeup_fd(outer.fileno(), warn_on_full_buffer=False)
    threading.Thread(target=listen, name="signals", daemon=True).start()
    return stop
