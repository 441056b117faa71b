"""Processes that need the same kernel."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pcsmooth.kernels import claims

HOLDER = """
import sys, time
from pathlib import Path
from pcsmooth.kernels import claims
claims.folder_of = lambda family: Path(sys.argv[1])
with claims.claimed("grid", "a.b") as is_ours:
    print(is_ours, flush=True)
    time.sleep(float(sys.argv[2]))
"""

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no locks of this kind there")


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(claims, "folder_of", lambda _family: tmp_path)


def hold(folder: Path, seconds: float) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDER, folder, str(seconds)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "True\n"
    return process


@pytest.fixture
def holder(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A process that holds a claim for a minute."""
    with hold(tmp_path, 60.0) as process:
        yield process
        process.kill()


@pytest.mark.usefixtures("holder")
def test_one_who_does_not_wait_is_told() -> None:
    with claims.claimed("grid", "a.b", wait=False) as is_ours:
        assert not is_ours
    with claims.claimed("grid", "a.c", wait=False) as is_ours:
        assert is_ours
    assert claims.is_claimed("grid", "a.b")
    assert not claims.is_claimed("grid", "a.c")


@pytest.mark.slow
def test_one_who_waits_goes_ahead_when_the_other_has_ended(tmp_path: Path) -> None:
    with hold(tmp_path, 0.4):
        started = time.monotonic()
        with claims.claimed("grid", "a.b") as is_ours:
            assert is_ours
            assert time.monotonic() - started > 0.1


def test_a_killed_process_claims_nothing(holder: subprocess.Popen[str]) -> None:
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    with claims.claimed("grid", "a.b", wait=False) as is_ours:
        assert is_ours


@pytest.mark.usefixtures("holder")
def test_nobody_waits_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(claims, "_PATIENCE", 0.1)
    with claims.claimed("grid", "a.b") as is_ours:
        assert is_ours


def test_where_nothing_can_be_locked_all_go_ahead(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_file: int, _how: int) -> None:
        raise OSError("no locks")

    monkeypatch.setattr("fcntl.flock", fail)
    with claims.claimed("grid", "a.b", wait=False) as is_ours:
        assert is_ours
    monkeypatch.setattr(claims, "folder_of", lambda _family: tmp_path / "nowhere")
    with claims.claimed("grid", "a.b", wait=False) as is_ours:
        assert is_ours
