"""Kernels as plain Python do what compiled ones do, and touch nothing beside their arrays."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from kernels import small_runs

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("group", small_runs.RUNS)
def test_without_compilation(group: str, tmp_path: Path) -> None:
    target = tmp_path / "results"
    subprocess.run(
        [sys.executable, "-W", "ignore", small_runs.__file__, group, str(target)],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        check=True,
    )
    compiled = small_runs.results_of(group)
    plain = pickle.loads(target.read_bytes())
    assert set(plain) == set(compiled)
    for name, expected in compiled.items():
        size = np.abs(expected[np.isfinite(expected)]).max(initial=1e-300)
        np.testing.assert_allclose(plain[name], expected, rtol=0.0, atol=1e-9 * size, err_msg=name)
