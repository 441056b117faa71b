"""The run over damaged files: a small part of it, and that it would find what it looks for."""

from __future__ import annotations

import subprocess
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fuzz_trial
import numpy as np
import pytest
from fuzz_seeds import SEEDS
from fuzz_trial import Trial, Verdict, judged, trial

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError

pytestmark = pytest.mark.slow

GOOD = Trial(b"1 2 3\n4 5 6\n", "xyz", sniffed=False, dim="auto")


def test_every_seed_is_accepted() -> None:
    kinds = Counter(
        judged(Trial(data, format, sniffed=False, dim="auto"))
        for format, seeds in SEEDS.items()
        for data in seeds
    )
    assert kinds.keys() == {Verdict("cloud"), Verdict("error")}
    assert kinds[Verdict("cloud")] > 8 * kinds[Verdict("error")]


def test_damaged_files() -> None:
    kinds = [judged(trial(2026, index)) for index in range(2500)]
    assert [verdict for verdict in kinds if verdict.failed] == []
    assert kinds.count(Verdict("cloud")) > 300


def test_inputs_are_the_same_for_the_same_seed() -> None:
    assert [trial(1, index) for index in range(50)] == [trial(1, index) for index in range(50)]
    assert len({trial(1, index).data for index in range(50)}) > 40
    assert trial(2, 3) != trial(1, 3)


def raising(error: Exception) -> Callable[..., PointCloud]:
    def fail(*_args: object, **_options: object) -> PointCloud:
        raise error

    return fail


def warning(*_args: object, **_options: object) -> PointCloud:
    warnings.warn("overflow", RuntimeWarning, stacklevel=2)
    return PointCloud(np.zeros((1, 3)))


def spinning(*_args: object, **_options: object) -> PointCloud:
    end = time.monotonic() + 30
    while time.monotonic() < end:
        pass
    return PointCloud(np.zeros((1, 3)))


def greedy(*_args: object, **_options: object) -> PointCloud:
    return PointCloud(np.zeros((1 << 22, 3)))


class Random:
    """A reader that never reads the same."""

    def __init__(self) -> None:
        self._rng = np.random.default_rng(0)

    def __call__(self, *_args: object, **_options: object) -> PointCloud:
        return PointCloud(self._rng.normal(size=(2, 3)))


@pytest.mark.parametrize(
    ("reader", "kind"),
    [
        (raising(ZeroDivisionError("oops")), "ZeroDivisionError in "),
        (raising(CloudFileError("a", "x" * 9999, "y")), "changed: an error that is no line"),
        (warning, "RuntimeWarning in "),
        (spinning, "more than 0.2 s in "),
        (greedy, "memory in "),
        (Random(), "changed: points"),
    ],
    ids=["exception", "message", "warning", "time", "memory", "points"],
)
def test_what_a_reader_may_not_do(
    monkeypatch: pytest.MonkeyPatch, reader: Callable[..., Any], kind: str
) -> None:
    assert judged(GOOD) == Verdict("cloud")
    monkeypatch.setattr(fuzz_trial, "CPU_SECONDS", 0.2)
    monkeypatch.setattr(fuzz_trial, "read_cloud", reader)
    verdict = judged(GOOD)
    assert verdict.failed
    assert verdict.kind.startswith(kind)
    monkeypatch.undo()
    assert judged(GOOD) == Verdict("cloud")


def test_the_command(tmp_path: Path) -> None:
    script = Path(fuzz_trial.__file__).with_name("fuzz_readers.py")
    done = subprocess.run(
        [sys.executable, str(script), "--inputs", "200", "--seed", "5", "--out", str(tmp_path)],
        capture_output=True,
        timeout=120,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"200 inputs, seed 5, " in done.stdout
    assert b"| all | 200 | " in done.stdout
    assert list(tmp_path.iterdir()) == []
