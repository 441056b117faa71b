"""How threads share out blocks, several callers, and forked processes."""

from __future__ import annotations

import importlib
import pkgutil
import subprocess
import sys
import threading
import time
from itertools import pairwise
from types import ModuleType

import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

import pcsmooth
from pcsmooth.errors import InvalidInputError
from pcsmooth.kernels.compiled import Kernel
from pcsmooth.kernels.threads import share_out, thread_count, thread_limit

every_count = pytest.mark.parametrize("threads", [1, 2])

#: Works, then has forked processes work; a line for what came of each way to do that.
FORKS = """
import multiprocessing, os, sys
from concurrent.futures import ProcessPoolExecutor
import numpy as np
from pcsmooth import denoise

def work(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(600, 3))
    points *= rng.normal(1, 0.02, (600, 1)) / np.linalg.norm(points, axis=1, keepdims=True)
    return str(denoise(points, threads=2).displacement.mean())

def forked():
    pid = os.fork()
    if pid == 0:
        print(work(0), flush=True)
        os._exit(0)
    os.waitpid(pid, 0)

if __name__ == "__main__":
    if "first" in sys.argv:
        print(work(0), flush=True)
    fork = multiprocessing.get_context("fork")
    with fork.Pool(2) as pool:
        print(*pool.map(work, [0, 0]), sep="\\n", flush=True)
    forked()
    with ProcessPoolExecutor(2, fork) as pool:
        print(*pool.map(work, [0, 0]), sep="\\n", flush=True)
"""

#: Works in two threads at a time.
THREADS = """
from concurrent.futures import ThreadPoolExecutor
import numpy as np
from pcsmooth import measure_balls

points = np.random.default_rng(0).normal(size=(2000, 3))
with ThreadPoolExecutor(2) as pool:
    volumes = list(pool.map(lambda _: measure_balls(points, 0.2).volume, range(20)))
assert len(set(volumes)) == 1
print("same")
"""


def lines_of(program: str, *arguments: str) -> list[str]:
    """What a program prints; it must not hang."""
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="nothing forks there")
@pytest.mark.parametrize("first", [[], ["first"]])
def test_forked_processes_work(first: list[str]) -> None:
    results = lines_of(FORKS, *first)
    assert len(results) == 5 + len(first)
    assert len({float(result) for result in results}) == 1


@pytest.mark.slow
def test_two_threads_may_work_at_a_time() -> None:
    assert lines_of(THREADS) == ["same"]


@every_count
@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 1000])
@pytest.mark.parametrize("least", [1, 4, 2000])
def test_blocks_cover_all_items_in_order(count: int, least: int, threads: int) -> None:
    with thread_limit(threads):
        blocks = share_out(lambda *a: a, count, "x", least=least)
    assert all(text == "x" for text, _, _ in blocks)
    assert blocks[0][1] == 0
    assert blocks[-1][2] == count
    assert all(one[2] == other[1] for one, other in pairwise(blocks))
    assert all(stop - start >= min(least, count) for _, start, stop in blocks)


@every_count
def test_blocks_run_in_so_many_threads(threads: int) -> None:
    seen = set()

    def kernel(_start: int, _stop: int) -> None:
        seen.add(threading.get_ident())
        time.sleep(0.01)

    with thread_limit(threads) as available:
        share_out(kernel, 100)
        assert len(seen) == available
    assert threading.get_ident() in seen


@every_count
def test_what_a_block_raises_is_raised_when_no_other_is_at_work(threads: int) -> None:
    at_work = []

    def kernel(start: int, _stop: int) -> None:
        at_work.append(start)
        if start == 0:
            raise MemoryError
        time.sleep(0.02)
        at_work.remove(start)

    with thread_limit(threads), pytest.raises(MemoryError):
        share_out(kernel, 1000)
    assert at_work == [0]


def test_an_interrupt_ends_the_work() -> None:
    """The blocks that nobody has begun are left."""
    begun = []

    def kernel(start: int, _stop: int) -> None:
        begun.append(start)
        if threading.current_thread() is threading.main_thread():
            raise KeyboardInterrupt
        time.sleep(0.05)

    with thread_limit(2), pytest.raises(KeyboardInterrupt):
        share_out(kernel, 1000)
    assert len(begun) < 8


def test_a_limit_holds_within_it_and_for_its_thread() -> None:
    before = thread_count()
    elsewhere = []
    with thread_limit(1):
        assert thread_count() == 1
        other = threading.Thread(target=lambda: elsewhere.append(thread_count()))
        other.start()
        other.join()
        with thread_limit(None) as inner:
            assert inner == 1
    assert thread_count() == before
    with thread_limit(10**9) as most:
        assert elsewhere == [most]


@pytest.mark.parametrize("count", [0, -1, 1.5, "2", True, np.nan])
def test_other_counts_are_refused(count: int) -> None:
    with (
        pytest.raises(InvalidInputError, match="it must be a whole number, 1 or more"),
        thread_limit(count),
    ):
        pass


def modules() -> list[ModuleType]:
    found = pkgutil.walk_packages(pcsmooth.__path__, "pcsmooth.")
    names = [module.name for module in found if not module.name.endswith("__main__")]
    return [importlib.import_module(name) for name in names]


def test_only_kernels_are_called_from_elsewhere() -> None:
    """They release the GIL, and of those at once in several processes one compiles them."""
    found = [
        value
        for module in modules()
        if not module.__name__.startswith("pcsmooth.kernels")
        for value in vars(module).values()
        if isinstance(value, Dispatcher | Kernel)
    ]
    assert len(found) > 8
    assert all(isinstance(value, Kernel) for value in found)
