"""Time one way to denoise in a process of its own, apart from the input and the first call.

Prints wall and CPU seconds and the number of threads, as JSON.
Usage: python smoothing_time.py pcsmooth|cgal POINTS.npy
"""

import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np


def measure(work: Callable[[], object]) -> dict[str, float]:
    """Wall time, CPU time and threads of some work."""
    wall, cpu = time.perf_counter(), time.process_time()
    work()
    return {
        "seconds": time.perf_counter() - wall,
        "cpu_seconds": time.process_time() - cpu,
        "threads": len(os.listdir("/proc/self/task")) if Path("/proc/self/task").exists() else 0,
    }


def time_pcsmooth(points: Any) -> dict[str, float]:
    """Time the defaults, once the kernels are loaded."""
    from pcsmooth import denoise

    denoise(points[:: max(1, len(points) // 2000)])
    return measure(lambda: denoise(points))


def time_cgal(points: Any) -> dict[str, float]:
    """Time jets with k = 24 on a point set that CGAL has already."""
    from CGAL.CGAL_Point_set_processing_3 import jet_smooth_point_set
    from peers import cgal_cloud

    cloud = cgal_cloud(points)
    return measure(lambda: jet_smooth_point_set(cloud, 24))


if __name__ == "__main__":
    program = {"pcsmooth": time_pcsmooth, "cgal": time_cgal}[sys.argv[1]]
    print(json.dumps(program(np.load(sys.argv[2]))))
