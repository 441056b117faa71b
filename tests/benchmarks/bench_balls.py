"""Time of one evaluation of all restricted cells, beside a k-d tree on the same cloud.

The yardstick is scipy's cKDTree, built and asked for the 24 nearest neighbours of every point
with 2 workers, in the same run. Usage: python bench_balls.py [POINTS ...]
"""

import platform
import sys
import time
from collections.abc import Callable
from functools import partial

import numpy as np
import numpy.typing as npt
from clouds import noisy_ellipse, noisy_torus
from scipy.spatial import cKDTree

from pcsmooth import measure_balls


def seconds(work: Callable[[], object], repeats: int = 3) -> float:
    """Median wall time of some work."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def yardstick(points: npt.NDArray[np.float64]) -> None:
    """Build a tree and query 24 neighbours of every point."""
    cKDTree(points).query(points, 24, workers=2)


def main(sizes: list[int]) -> None:
    """Print a table."""
    print(f"{platform.processor() or platform.machine()}, numpy {np.__version__}")
    for points, spacing in (noisy_torus(2000, 0.3), noisy_ellipse(2000, 0.3)):
        measure_balls(points, 2 * spacing)  # compile or load
    print("cloud       points  radius  seconds  points/s  of k-d tree")
    for size in sizes:
        for name, make in (("torus", noisy_torus), ("ellipse", noisy_ellipse)):
            points, spacing = make(size, 0.3)
            reference = seconds(partial(yardstick, points))
            for multiple in (2.0, 3.0):
                taken = seconds(partial(measure_balls, points, multiple * spacing))
                print(
                    f"{name:8} {size:9d} {multiple:6.0f}s {taken:8.3f} {size / taken:9.0f} "
                    f"{taken / reference:12.2f}"
                )


if __name__ == "__main__":
    main([int(argument) for argument in sys.argv[1:]] or [100_000, 1_000_000])
