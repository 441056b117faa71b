"""Ctrl-C and the other signals that tell a process to end do so soon, whatever it is at.

Python handles a signal between two of its own instructions, not while compiled code is at work. So
another thread is told of it, too. That leaves the main thread a moment to end by an exception;
then it puts away what is to be put away and ends the process.
"""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import NoReturn

from pcsmooth.child_processes import when_parent_ends
from pcsmooth.cleanup import clean_up
from pcsmooth.cli.exit_status import ExitStatus

#: Seconds that the main thread has to end by itself.
_GRACE = 0.4

#: Seconds that it has for what it is just putting away.
_PATIENCE = 1.5

#: What each signal is called, and the exit status then.
_ENDINGS = {
    signal.SIGINT: ("interrupted", ExitStatus.INTERRUPTED),
    signal.SIGTERM: ("terminated", ExitStatus.TERMINATED),
    signal.SIGHUP: ("hung up", ExitStatus.HUNG_UP),
}


class Interrupts:
    """Takes Ctrl-C, SIGTERM and SIGHUP.

    Attributes
    ----------
    signal : signal.Signals or None
        The one that came.
    """

    def __init__(self) -> None:
        self.signal: signal.Signals | None = None

    @property
    def ending(self) -> tuple[str, ExitStatus]:
        """What ended the run, in words and for the shell; Ctrl-C if no signal has come."""
        return _ENDINGS[self.signal or signal.SIGINT]

    @contextmanager
    def end_promptly(self) -> Iterator[None]:
        """See to it that such a signal ends the block, or else the process, soon.

        Where one is ignored, as under nohup, or somebody else's, nothing changes for it.
        """
        usual = {signal.default_int_handler, signal.SIG_DFL}
        before = {each: signal.getsignal(each) for each in _ENDINGS}
        ours = [number for number, handler in before.items() if handler in usual]
        if not ours or threading.current_thread() is not threading.main_thread():
            yield
            return
        ended = threading.Event()
        leaving = threading.Lock()  # one of the two threads leaves, and the other does no more

        def insist(number: signal.Signals) -> None:
            ended.wait(_GRACE)
            with leaving:
                if not ended.is_set():
                    words, status = _ENDINGS[number]
                    end(status, f"{os.linesep if os.isatty(2) else ''}Error: {words}\n")

        hook = sys.unraisablehook
        for number in ours:
            signal.signal(number, self._take)
        stop = _listen(ours, insist)
        try:
            yield
        finally:
            with leaving:
                ended.set()
            stop()
            for number in ours:
                signal.signal(number, before[number])
            sys.unraisablehook = hook

    def _take(self, number: int, _frame: FrameType | None) -> None:
        """Interrupt the main thread; another signal would do no more than disturb it."""
        for each in _ENDINGS:
            if signal.getsignal(each) == self._take:
                signal.signal(each, signal.SIG_IGN)
        self.signal = signal.Signals(number)
        sys.unraisablehook = lambda _: None  # callbacks of the compiler cannot pass it on
        raise KeyboardInterrupt


def end_when_told() -> None:
    """End this process, one of those at a batch, at SIGTERM or with the one that started it.

    At once, and nothing is left behind.
    """
    signal.signal(signal.SIGTERM, lambda _number, _frame: None)
    _listen([signal.SIGTERM], lambda _number: end(ExitStatus.TERMINATED))
    when_parent_ends(lambda: end(ExitStatus.TERMINATED))


def end(status: ExitStatus, last_words: str = "") -> NoReturn:
    """End the process from any of its threads, at once but for what is to be put away."""
    clean_up(_PATIENCE)
    with suppress(OSError):
        os.write(2, last_words.encode())
    os._exit(status)


def _listen(
    numbers: list[signal.Signals], act: Callable[[signal.Signals], None]
) -> Callable[[], None]:
    """Call a function in another thread when a signal comes; returns what puts an end to that."""
    inner, outer = socket.socketpair()
    outer.setblocking(False)

    def listen(_kept: socket.socket) -> None:
        with inner:
            while came := inner.recv(64):  # nothing once the other end is closed
                for number in numbers:
                    if number in came:
                        act(number)

    def stop() -> None:
        signal.set_wakeup_fd(before)
        outer.close()

    before = signal.set_wakeup_fd(outer.fileno(), warn_on_full_buffer=False)
    threading.Thread(target=listen, args=(outer,), name="signals", daemon=True).start()
    return stop
