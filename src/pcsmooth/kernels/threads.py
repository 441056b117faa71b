"""How many threads the kernels use, and how they share out the work.

Compiled code releases the GIL, so that Python's own threads do: they share out blocks of points
or of cells. They survive a fork (a child starts its own), several may be at work for several
callers, and what goes wrong in a block is raised.
"""

import os
import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from itertools import pairwise
from typing import Any

import numba
import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError

#: Blocks for each thread: enough that those of uneven work come out even.
_BLOCKS_PER_THREAD = 8

#: Points that a kernel which only moves numbers about takes at least, so that 20 us to call it
#: do not count.
MANY = 1 << 14

_limit: ContextVar[int | None] = ContextVar("pcsmooth_threads", default=None)


def thread_count() -> int:
    """Tell how many threads kernels use: those of `thread_limit`, or one for each core."""
    return min(_limit.get() or _most_threads(), _most_threads())


def _most_threads() -> int:
    """Count the cores, or what NUMBA_NUM_THREADS says in their place."""
    return int(numba.config.NUMBA_NUM_THREADS)


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
    token = _limit.set(int(count)) if count is not None else None
    try:
        yield thread_count()
    except SystemError as error:
        if isinstance(error.__cause__, KeyboardInterrupt):
            raise KeyboardInterrupt from error
        raise
    finally:
        if token is not None:
            _limit.reset(token)


def share_out(kernel: Callable[..., Any], count: int, *arguments: Any, least: int = 1) -> list[Any]:
    """Call a kernel that releases the GIL on blocks of items, in parallel.

    Parameters
    ----------
    kernel : callable
        Takes the arguments, and the first item of a block and the one after its last. What it
        makes of an item must not depend on the block.
    count : int
        How many items there are. The kernel is called once if there is none.
    *arguments
        What every call gets.
    least : int
        Items that are worth a call.

    Returns
    -------
    list
        What the calls returned, in the order of the blocks.
    """
    threads = thread_count()
    n_blocks = max(1, min(_BLOCKS_PER_THREAD * threads, count // least))
    starts = [count * block // n_blocks for block in range(n_blocks + 1)]
    results: list[Any] = [None] * n_blocks
    blocks = iter(range(n_blocks))
    taking = threading.Lock()

    def work() -> None:
        while True:
            with taking:
                block = next(blocks, None)
            if block is None:
                return
            results[block] = kernel(*arguments, starts[block], starts[block + 1])

    helpers = [_pool().submit(work) for _ in range(min(threads, n_blocks) - 1)]
    try:
        work()
    finally:
        with taking:
            deque(blocks, maxlen=0)  # after an error or an interrupt there is no more to do
        for helper in helpers:
            if not helper.cancel():
                helper.exception()  # its block reads and writes arrays of the caller's
    for helper in helpers:
        if not helper.cancelled():
            helper.result()
    return results


def shared_out(by: str, least: int = 1) -> Callable[[Callable[..., Any]], Callable[..., list[Any]]]:
    """Make a function that calls a kernel on blocks, in parallel, of all items: `share_out`.

    Parameters
    ----------
    by : str
        The argument that has a row for each item, or, if its name ends in "starts", where each of
        them begins and where the last one ends; or a field of an argument: ``"cells.codes"``.
    least : int
        Items that are worth a call.
    """

    def decorate(kernel: Callable[..., Any]) -> Callable[..., list[Any]]:
        code = kernel.py_func.__code__  # type: ignore[attr-defined]
        name, _, field = by.partition(".")
        place = code.co_varnames.index(name)
        ends = int(by.endswith("starts"))

        @wraps(kernel)
        def on_all_items(*arguments: Any) -> list[Any]:
            items = getattr(arguments[place], field) if field else arguments[place]
            return share_out(kernel, len(items) - ends, *arguments, least=least)

        return on_all_items

    return decorate


_helpers: ThreadPoolExecutor | None = None


def _pool() -> ThreadPoolExecutor:
    """Threads that help the one which shares out."""
    global _helpers
    if _helpers is None:
        _helpers = ThreadPoolExecutor(max(1, _most_threads() - 1), "kernels")
    return _helpers


def _forget_pool() -> None:
    global _helpers
    _helpers = None  # a forked process has none of the threads


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_pool)


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
    threads = thread_count()
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
