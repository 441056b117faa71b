"""How many threads the kernels use, and when they compile."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numba
from numba.core import event


@contextmanager
def thread_limit(count: int | None) -> Iterator[int]:
    """Run kernels on at most `count` threads (None: as many as there are); yields the number.

    A keyboard interrupt that a kernel's wrapper was caught in, which Python reports as a
    SystemError, leaves as what it was.
    """
    before = numba.get_num_threads()
    numba.set_num_threads(max(1, min(count or before, numba.config.NUMBA_NUM_THREADS)))
    try:
        yield numba.get_num_threads()
    except SystemError as error:
        if isinstance(error.__cause__, KeyboardInterrupt):
            raise KeyboardInterrupt from error
        raise
    finally:
        numba.set_num_threads(before)


class _FirstCompilation(event.Listener):
    def __init__(self, announce: Callable[[], None]) -> None:
        self._announce: Callable[[], None] | None = announce

    def on_start(self, event: event.Event) -> None:
        if self._announce is not None:
            announce, self._announce = self._announce, None
            announce()

    def on_end(self, event: event.Event) -> None:
        pass


@contextmanager
def announce_compilation(announce: Callable[[], None]) -> Iterator[None]:
    """Call `announce` once if a kernel has to be compiled (not found in the cache)."""
    with event.install_listener("numba:compile", _FirstCompilation(announce)):
        yield
