from __future__ import annotations

import os
import pickle
import subprocess
import sys

import numpy as np
import pytest

import oracles
from pcsmooth.energies.balls import measure_balls
from pcsmooth.kernels.level import COMPILED_FOR

pytestmark = pytest.mark.slow

FUSING = {"x86-64-v3", "x86-64-v4"}

#: From pickled pairs of points and radius to their pickled unions.
PROGRAM = """
import pickle, sys
from pcsmooth.energies.balls import measure_balls
from pcsmooth.kernels.level import COMPILED_FOR
assert COMPILED_FOR == "generic"
unions = [measure_balls(points, radius) for points, radius in pickle.load(sys.stdin.buffer)]
pickle.dump(unions, sys.stdout.buffer)
"""


def test_measures_are_the_same_on_the_plainest_processor() -> None:
    """Without fused products, without registers of eight numbers or of four."""
    clouds = [
        (oracles.uniform_cloud(400, 3), 0.3),
        (oracles.uniform_cloud(400, 2), 0.15),
        (oracles.lattice(5, 5, 5), 0.9),  # rounding decides about corners
    ]
    environment = {**os.environ, "NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    command = [sys.executable, "-c", PROGRAM]
    done = subprocess.run(
        command, input=pickle.dumps(clouds), env=environment, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr.decode()
    differs = False
    for (points, radius), union in zip(clouds, pickle.loads(done.stdout), strict=True):
        here = measure_balls(points, radius)
        oracles.assert_same_measures(union, here, 1e-13)
        differs |= not np.array_equal(union.measures, here.measures)
    # Products are fused here, so that digits show whether other code has run there.
    assert differs or COMPILED_FOR not in FUSING
