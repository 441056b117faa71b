"""Forked processes, several threads, and how Python enters kernels."""

from __future__ import annotations

import importlib
import os
import pkgutil
import subprocess
import sys
from types import ModuleType

import pytest
from numba.core.dispatcher import Dispatcher

import pcsmooth

#: Works, then has forked processes work; a line for what came of each way to do that.
PROGRAM = """
import multiprocessing, os, sys
from concurrent.futures import ProcessPoolExecutor
import numpy as np
from pcsmooth import PcsmoothError, denoise

def work(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(300, 3))
    points *= rng.normal(1, 0.02, (300, 1)) / np.linalg.norm(points, axis=1, keepdims=True)
    try:
        return str(denoise(points, threads=1).displacement.mean())
    except PcsmoothError as error:
        return str(error)

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


def lines_of(program: str, *arguments: str, layer: str) -> list[str]:
    """What a program prints, with a threading layer of numba's; it must not hang."""
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments],
        env={**os.environ, "NUMBA_THREADING_LAYER": layer},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


class TestFork:
    def test_after_the_first_use_forked_processes_are_told_what_to_do(self) -> None:
        first, *others = lines_of(PROGRAM, "first", layer="omp")
        assert float(first) > 0.0
        assert (
            others
            == [
                "this process was forked after kernels had run, and OpenMP's threads do not "
                'survive that; start processes with multiprocessing.get_context("spawn")'
            ]
            * 5
        )

    def test_before_the_first_use_they_work(self) -> None:
        results = lines_of(PROGRAM, layer="omp")
        assert len(results) == 5
        assert len({float(result) for result in results}) == 1

    def test_threads_that_survive_serve(self) -> None:
        results = lines_of(PROGRAM, "first", layer="workqueue")
        assert len(results) == 6
        assert len({float(result) for result in results}) == 1


@pytest.mark.parametrize("layer", ["omp", "workqueue"])
def test_two_threads_may_work_at_a_time(layer: str) -> None:
    assert lines_of(THREADS, layer=layer) == ["same"]


def modules() -> list[ModuleType]:
    found = pkgutil.walk_packages(pcsmooth.__path__, "pcsmooth.")
    names = [module.name for module in found if not module.name.endswith("__main__")]
    return [importlib.import_module(name) for name in names]


def test_what_python_calls_releases_the_gil_and_is_no_parallel_kernel() -> None:
    kernels = {
        value
        for module in modules()
        if not module.__name__.startswith("pcsmooth.kernels")
        for value in vars(module).values()
        if isinstance(value, Dispatcher)
    }
    assert len(kernels) > 8
    for kernel in kernels:
        assert kernel.targetoptions.get("nogil"), kernel
        assert not kernel.targetoptions.get("parallel"), kernel
