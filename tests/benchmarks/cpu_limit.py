"""A bound of processor time."""

import contextlib
import signal
from collections.abc import Iterator
from types import FrameType


class OverTimeError(BaseException):
    """Something takes more processor time than it may; what catches errors lets it through."""


@contextlib.contextmanager
def cpu_limit(seconds: float) -> Iterator[None]:
    """Raise `OverTimeError` within the block once it has taken so much processor time."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        raise OverTimeError

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
