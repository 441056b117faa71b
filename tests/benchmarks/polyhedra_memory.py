"""Print how many bytes one evaluation of a union of cubes needs beyond its points.

Run in a process of its own, because a process's peak never falls.
Usage: python polyhedra_memory.py POINTS.npy RADIUS UNION
"""

import sys
from typing import get_args

import numpy as np
from clouds import noisy_torus
from measuring import peak_bytes, resident_bytes

from pcsmooth import load_presets, measure_polyhedra
from pcsmooth.energies.protocol import UnionName
from pcsmooth.kernels.threads import thread_limit


def main(path: str, radius: float, union: UnionName) -> None:
    """Load kernels and points, then evaluate once."""
    cube = load_presets()["cube"]
    small, spacing = noisy_torus(2000, 0.3)
    with thread_limit(2):
        measure_polyhedra(small, 2 * spacing, cube, union)
        points = np.load(path)
        before = resident_bytes()
        measure_polyhedra(points, radius, cube, union)
    print(peak_bytes() - before)


if __name__ == "__main__":
    [chosen] = [name for name in get_args(UnionName) if name == sys.argv[3]]
    main(sys.argv[1], float(sys.argv[2]), chosen)
