from __future__ import annotations

import threading
import time
from itertools import islice

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.kernels.threads import map_blocks, thread_limit

Range = tuple[int, int]

every_count = pytest.mark.parametrize("threads", [1, 2])


class Recorder:
    """A kernel that takes its time, and knows which blocks it was called on."""

    def __init__(self, seconds: float = 0.0) -> None:
        self.seconds = seconds
        self.started: list[int] = []
        self.threads: set[int] = set()

    def __call__(self, start: int, stop: int) -> Range:
        self.started.append(start)
        self.threads.add(threading.get_ident())
        time.sleep(self.seconds)
        return start, stop


def starts_of(n: int, block: int) -> npt.NDArray[np.int64]:
    return np.append(np.arange(0, n, block), n)


def most_ahead(threads: int) -> int:
    """How many calls may have begun whose results nobody has taken."""
    return 2 * threads + 1


@every_count
@pytest.mark.parametrize(
    ("n", "block", "expected"),
    [
        (0, 4, []),
        (1, 4, [(0, 1)]),
        (4, 4, [(0, 4)]),
        (9, 4, [(0, 4), (4, 8), (8, 9)]),
        (3, 1, [(0, 1), (1, 2), (2, 3)]),
    ],
)
def test_blocks_cover_all_points(n: int, block: int, expected: list[Range], threads: int) -> None:
    with thread_limit(threads):
        assert list(map_blocks(Recorder(), starts_of(n, block))) == expected


@every_count
def test_arguments_come_before_the_range(threads: int) -> None:
    with thread_limit(threads):
        results = list(map_blocks(lambda *a: a, starts_of(5, 3), "x", None))
    assert results == [("x", None, 0, 3), ("x", None, 3, 5)]


@every_count
def test_results_keep_their_order_whichever_is_ready_first(threads: int) -> None:
    pauses = np.random.default_rng(0).choice([0.0, 0.0, 0.004], 100)

    def kernel(start: int, stop: int) -> int:
        time.sleep(pauses[start])
        return start

    with thread_limit(threads):
        assert list(map_blocks(kernel, starts_of(100, 1))) == list(range(100))


@every_count
def test_calls_run_in_so_many_threads(threads: int) -> None:
    kernel = Recorder(0.002)
    with thread_limit(threads) as available:
        list(map_blocks(kernel, starts_of(40, 1)))
        assert len(kernel.threads) == available
    assert threading.get_ident() not in kernel.threads


def test_first_call_is_alone() -> None:
    """It may have to compile."""
    kernel = Recorder()
    results = map_blocks(kernel, starts_of(100, 1))
    assert next(results) == (0, 1)
    time.sleep(0.02)
    assert kernel.started == [0]
    results.close()  # type: ignore[attr-defined]


@every_count
def test_few_results_wait_for_a_slow_consumer(threads: int) -> None:
    kernel = Recorder()
    ahead = []
    with thread_limit(threads):
        for taken, _ in enumerate(map_blocks(kernel, starts_of(60, 1)), start=1):
            time.sleep(0.002)
            ahead.append(len(kernel.started) - taken)
    assert max(ahead) <= most_ahead(threads)
    assert max(ahead) >= threads  # but every thread has something to do


@every_count
def test_error_of_a_call_is_raised_after_the_results_before_it(threads: int) -> None:
    started = []

    def kernel(start: int, stop: int) -> int:
        started.append(start)
        if start == 10:
            raise ZeroDivisionError("block 10")
        time.sleep(0.001)
        return start

    with thread_limit(threads):
        results = map_blocks(kernel, starts_of(1000, 1))
        assert list(islice(results, 10)) == list(range(10))
        with pytest.raises(ZeroDivisionError, match="block 10"):
            next(results)
    assert max(started) <= 10 + most_ahead(threads)


@every_count
def test_error_of_the_first_call(threads: int) -> None:
    def kernel(start: int, stop: int) -> int:
        raise KeyError(start)

    with thread_limit(threads), pytest.raises(KeyError, match="0"):
        next(map_blocks(kernel, starts_of(1000, 1)))


@every_count
@pytest.mark.parametrize("taken", [0, 1, 2, 20])
def test_stopping_early_calls_no_more(taken: int, threads: int) -> None:
    kernel = Recorder(0.002)
    with thread_limit(threads):
        results = map_blocks(kernel, starts_of(1000, 1))
        assert len(list(islice(results, taken))) == taken
        begin = time.perf_counter()
        results.close()  # type: ignore[attr-defined]
        assert time.perf_counter() - begin < 1.0  # all calls would take 2 seconds a thread
    running = len(kernel.started)
    assert running <= taken + most_ahead(threads)
    time.sleep(0.01)
    assert len(kernel.started) == running  # nothing goes on in the background
    assert not [t for t in threading.enumerate() if t.ident in kernel.threads]


@every_count
def test_stopping_early_cancels_what_has_not_begun(threads: int) -> None:
    kernel, go_on = Recorder(), threading.Event()

    def blocked(start: int, stop: int) -> Range:
        result = kernel(start, stop)
        if start > 1:
            go_on.wait(5.0)
        return result

    with thread_limit(threads):
        results = map_blocks(blocked, starts_of(1000, 1))
        assert list(islice(results, 2)) == [(0, 1), (1, 2)]
        timer = threading.Timer(0.03, go_on.set)
        timer.start()
        results.close()  # type: ignore[attr-defined]
        timer.join()
    assert len(kernel.started) <= 2 + threads
