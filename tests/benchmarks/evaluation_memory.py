"""Print how many bytes one evaluation needs beyond its points.

Run in a process of its own, because a process's peak never falls.
Usage: python evaluation_memory.py POINTS.npy RADIUS
"""

import sys

import numpy as np
from clouds import noisy_torus
from measuring import peak_bytes, resident_bytes

from pcsmooth import measure_balls
from pcsmooth.kernels.threads import thread_limit


def main(path: str, radius: float) -> None:
    """Load kernels and points, then evaluate once."""
    small, spacing = noisy_torus(2000, 0.3)
    with thread_limit(2):
        measure_balls(small, 2 * spacing)
        points = np.load(path)
        before = resident_bytes()
        measure_balls(points, radius)
    print(peak_bytes() - before)


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
