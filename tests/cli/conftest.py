"""Everything compiled before the first test, so that no message but the command's is seen."""

from __future__ import annotations

import multiprocessing
import os
import sys
from multiprocessing import forkserver
from unittest import mock

import pytest

import pcsmooth
from cli.clouds import circle, sphere
from pcsmooth.cli import batch_workers


@pytest.fixture(scope="session", autouse=True)
def _compiled_kernels() -> None:
    for points in (circle(), sphere()):
        repeated = points[[0, *range(len(points))]]
        pcsmooth.denoise(repeated)
        pcsmooth.denoise(repeated, energy="area", iterations=1)
        pcsmooth.denoise(repeated, energy="volume", iterations=1)
        pcsmooth.estimate_curvature(repeated)
        pcsmooth.estimate_curvature(repeated, estimator="gradient", energy="area")


@pytest.fixture(scope="session")
def _forkserver() -> None:
    multiprocessing.set_forkserver_preload(["cli.preloaded"])
    with mock.patch.dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)):
        forkserver.ensure_running()


@pytest.fixture
def quick_workers(_forkserver: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes at a batch that start at once, forked from one that has imported everything."""
    monkeypatch.setattr(
        batch_workers, "spawning", lambda: multiprocessing.get_context("forkserver")
    )
