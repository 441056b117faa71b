"""How many threads the kernels use, and when they compile."""

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from itertools import pairwise
from typing import Any

import numba
import numpy as np
import numpy.typing as npt
from numba.core import event

from pcsmooth.errors import InvalidInputError


@contextmanager
def thread_limit(count: int | None) -> Iterator[int]:
    """Run kernels on at most `count` threads (None: as many as there are); yields the number.

    A keyboard interrupt that a kernel's wrapper was caught in, which Python reports as a
    SystemError, leaves as what it was. A count that is no whole number, 1 or more, is an
    `InvalidInputError`.
    """
    is_whole = isinstance(count, int | np.integer) and not isinstance(count, bool)
    if count is not None and not (is_whole and count >= 1):
        raise InvalidInputError(f"threads is {count!r}; it must be a whole number, 1 or more")
    before = numba.get_num_threads()
    numba.set_num_threads(min(count or before, numba.config.NUMBA_NUM_THREADS))
    try:
        yield numba.get_num_threads()
    except SystemError as error:
        if isinstance(error.__cause__, KeyboardInterrupt):
            raise KeyboardInterrupt from error
        raise
    finally:
        numba.set_num_threads(before)


def map_blocks(
    kernel: Callable[..., Any], starts: npt.NDArray[np.int64], *arguments: Any
) -> Iterator[Any]:
    """Call a kernel that releases the GIL on blocks of points, in parallel.

    Parameters
    ----------
    kernel : callable
        Takes the arguments, and the first point of a block and the one after its last.
    starts : ndarray of int, shape (b + 1,)
        Where the blocks begin, and where the last one ends.
    *arguments
        What every call gets.

    Yields
    ------
    object
        What it returns, block by block in their order; few results wait at a time.
    """
    threads = numba.get_num_threads()
    waiting: deque[Future[Any]] = deque()
    with ThreadPoolExecutor(threads) as pool:
        try:
            for start, stop in pairwise(starts.tolist()):
                waiting.append(pool.submit(kernel, *arguments, start, stop))
                if start == starts[0] or len(waiting) > 2 * threads:
                    yield waiting.popleft().result()  # the first call may have to compile
            while waiting:
                yield waiting.popleft().result()
        finally:
            pool.shutdown(cancel_futures=True)


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
