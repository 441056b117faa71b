"""What is left of killed processes, and what only seems to be."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pcsmooth import temporaries
from pcsmooth.temporaries import (
    folder_prefix,
    process_mark,
    remove_abandoned,
    temporary_name,
)

#: Prints a name for a file and one for a folder, and waits.
NAMING = """
import sys, time
from pcsmooth.temporaries import folder_prefix, temporary_name
print(temporary_name(), f"{folder_prefix('tiles')}a1b2_c3d", flush=True)
time.sleep(600)
"""


def start() -> tuple[subprocess.Popen[str], list[str]]:
    child = subprocess.Popen([sys.executable, "-c", NAMING], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    return child, child.stdout.readline().split()


def make(folder: Path, names: list[str]) -> None:
    for name in names:
        if "-tiles-" in name:
            (folder / name / "inner").mkdir(parents=True)
            (folder / name / "inner" / "tile").write_bytes(b"half")
        else:
            (folder / name).write_bytes(b"half")


@pytest.fixture
def left(tmp_path: Path) -> list[str]:
    """Names of a process that is gone, in the folder."""
    child, names = start()
    with child:
        child.kill()
    make(tmp_path, names)
    return sorted(names)


def test_what_a_killed_process_left_is_removed(tmp_path: Path, left: list[str]) -> None:
    (tmp_path / "scan.ply").write_bytes(b"whole")
    assert remove_abandoned(tmp_path) == left
    assert os.listdir(tmp_path) == ["scan.ply"]
    assert remove_abandoned(tmp_path) == []


def test_a_living_process_keeps_its_own(tmp_path: Path) -> None:
    child, names = start()
    own = [temporary_name(), f"{folder_prefix('tiles')}abcdefgh"]
    with child:
        try:
            make(tmp_path, [*names, *own])
            assert remove_abandoned(tmp_path) == []
        finally:
            child.kill()
    assert remove_abandoned(tmp_path) == sorted(names)
    assert sorted(os.listdir(tmp_path)) == sorted(own)


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="nobody says when it started")
class TestWhereTheSystemSaysWhenAProcessStarted:
    def test_another_process_with_the_number(self, tmp_path: Path) -> None:
        host, number, start = process_mark().split("-")
        earlier = f".pcsmooth-{host}-{number}-{int(start) - 1}-00ff.tmp"
        make(tmp_path, [earlier])
        assert remove_abandoned(tmp_path) == [earlier]

    def test_a_process_that_nobody_has_waited_for(self, tmp_path: Path) -> None:
        child, names = start()
        make(tmp_path, names)
        with child:
            child.send_signal(signal.SIGKILL)
            deadline = time.monotonic() + 30.0
            while os.listdir(tmp_path):
                remove_abandoned(tmp_path)
                assert time.monotonic() < deadline


def test_where_nobody_says_when_a_process_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, left: list[str]
) -> None:
    monkeypatch.setattr(temporaries, "_start_of", lambda _process: None)
    name = temporary_name()
    assert name.split("-")[3] == "0"
    make(tmp_path, [name])
    assert remove_abandoned(tmp_path) == left
    assert os.listdir(tmp_path) == [name]


def test_a_process_of_another_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, left: list[str]
) -> None:
    def refuse(_process: int, _signal: int) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "kill", refuse)
    assert remove_abandoned(tmp_path) == []


def test_numbers_of_another_host_mean_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, left: list[str]
) -> None:
    monkeypatch.setattr(temporaries, "_host", lambda: "00000000")
    assert remove_abandoned(tmp_path) == []


@pytest.mark.parametrize(
    "name",
    [
        ".pcsmooth-0123456789abcdef.tmp",
        ".pcsmooth-HOST-99999999999999999999-0-.tmp",
        "pcsmooth-HOST-99999999999999999999-0-00ff.tmp",
        ".pcsmooth-HOST-99999999999999999999-0-00ff.tmp.ply",
        ".pcsmooth-HOST--1-0-00ff.tmp",
    ],
)
def test_other_names_are_left_alone(tmp_path: Path, name: str) -> None:
    host = process_mark().split("-")[0]
    make(tmp_path, [name.replace("HOST", host)])
    assert remove_abandoned(tmp_path) == []


def test_a_number_beyond_all(tmp_path: Path) -> None:
    name = f".pcsmooth-{process_mark().split('-')[0]}-99999999999999999999-0-00ff.tmp"
    make(tmp_path, [name])
    assert remove_abandoned(tmp_path) == [name]


def test_a_link_of_that_name_is_not_followed(tmp_path: Path, left: list[str]) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "scan.ply").write_bytes(b"whole")
    folder = next(name for name in left if "-tiles-" in name)
    shutil.rmtree(tmp_path / folder)
    (tmp_path / folder).symlink_to("data")
    assert folder not in remove_abandoned(tmp_path)
    assert (tmp_path / "data" / "scan.ply").read_bytes() == b"whole"


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    assert remove_abandoned(tmp_path / "none") == []
