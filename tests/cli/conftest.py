"""Everything compiled before the first test, so that no message but the command's is seen."""

from __future__ import annotations

import pytest

import pcsmooth
from cli.clouds import circle, sphere


@pytest.fixture(scope="session", autouse=True)
def _compiled_kernels() -> None:
    for points in (circle(), sphere()):
        repeated = points[[0, *range(len(points))]]
        pcsmooth.denoise(repeated)
        pcsmooth.denoise(repeated, energy="area", iterations=1)
        pcsmooth.denoise(repeated, energy="volume", iterations=1)
        pcsmooth.estimate_curvature(repeated)
        pcsmooth.estimate_curvature(repeated, estimator="report", energy="area")
