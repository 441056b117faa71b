from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path

import oracles
from pcsmooth.energies.balls import measure_balls

#: From pickled pairs of points and radius to their pickled unions.
PROGRAM = """
import pickle, sys
from pcsmooth.energies.balls import measure_balls
from pcsmooth.kernels.grid.near_points import select_within_reach
unions = [measure_balls(points, radius) for points, radius in pickle.load(sys.stdin.buffer)]
for assembly in select_within_reach.inspect_asm().values():
    assert "ymm" not in assembly and "zmm" not in assembly, "compiled for this very processor"
pickle.dump(unions, sys.stdout.buffer)
"""


def test_measures_are_the_same_on_the_plainest_processor(tmp_path: Path) -> None:
    """Without fused products, without registers of eight numbers or of four."""
    clouds = [
        (oracles.uniform_cloud(400, 3), 0.3),
        (oracles.uniform_cloud(400, 2), 0.15),
        (oracles.lattice(5, 5, 5), 0.9),  # rounding decides about corners
    ]
    environment = {
        **os.environ,
        "NUMBA_CPU_NAME": "generic",
        "NUMBA_CPU_FEATURES": "",
        "NUMBA_CACHE_DIR": str(tmp_path),  # or it would run what was compiled for this processor
    }
    command = [sys.executable, "-c", PROGRAM]
    done = subprocess.run(
        command, input=pickle.dumps(clouds), env=environment, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr.decode()
    for (points, radius), union in zip(clouds, pickle.loads(done.stdout), strict=True):
        oracles.assert_same_measures(union, measure_balls(points, radius), 1e-13)
