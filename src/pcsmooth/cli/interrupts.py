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
from typing import NoReturn

from pcsmooth.cleanup import clean_up
from pcsmooth.cli.exit_status import ExitStatus

#: Seconds that the main thread has to end by itself.
_GRACE = 0.4

#: Seconds that it has for what it is just putting away.
_PATIENCE = 1.5


class Interrupts:
    """Takes Ctrl-C.

    Attributes
    ----------
    happened : bool
        Whether there was one.
    """

    def __init__(self) -> None:
        self.happened = False

    @contextmanager
    def end_promptly(self) -> Iterator[None]:
        """See to it that Ctrl-C ends the block, or else the process, soon.

        Where Ctrl-C is ignored, or somebody else's, nothing changes.
        """
        before = signal.getsignal(signal.SIGINT)
        in_main_thread = threading.current_thread() is threading.main_thread()
        if before is not signal.default_int_handler or not in_main_thread:
            yield
            return
        ended = threading.Event()
        leaving = threading.Lock()  # one of the two threads leaves, and the other does no more

        def insist() -> None:
            ended.wait(_GRACE)
            with leaving:
                if not ended.is_set():
                    _end(b"\nError: interrupted\n" if os.isatty(2) else b"Error: interrupted\n")

        signal.signal(signal.SIGINT, self._take)
        stop = _listen(signal.SIGINT, insist)
        try:
            yield
        finally:
            with leaving:
                ended.set()
            stop()
            signal.signal(signal.SIGINT, before)

    def _take(self, number: int, _frame: FrameType | None) -> None:
        """Interrupt the main thread; again would do no more than disturb it."""
        signal.signal(number, signal.SIG_IGN)
        self.happened = True
        raise KeyboardInterrupt


def end_when_told() -> None:
    """Have SIGTERM end this process, one of those at a batch, at once; nothing is left behind."""
    signal.signal(signal.SIGTERM, lambda _number, _frame: None)
    _listen(signal.SIGTERM, lambda: _end(b""))


def _end(last_words: bytes) -> NoReturn:
    """End the process from any of its threads."""
    clean_up(_PATIENCE)
    with suppress(OSError):
        os.write(2, last_words)
    os._exit(ExitStatus.INTERRUPTED)


def _listen(number: int, act: Callable[[], None]) -> Callable[[], None]:
    """Call a function in another thread when a signal comes; returns what puts an end to that."""
    inner, outer = socket.socketpair()
    outer.setblocking(False)

    def listen(_kept: socket.socket) -> None:
        with inner:
            while numbers := inner.recv(64):  # nothing once the other end is closed
                if number in numbers:
                    act()

    def stop() -> None:
        signal.set_wakeup_fd(before)
        outer.close()

    before = signal.set_wakeup_fd(outer.fileno(), warn_on_full_buffer=False)
    threading.Thread(target=listen, args=(outer,), name="signals", daemon=True).start()
    return stop
