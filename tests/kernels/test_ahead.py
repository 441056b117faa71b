"""Kernels that other processes compile, and `pcsmooth warmup`."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba
import pytest

from cli.commands import pcsmooth, succeeds
from pcsmooth.kernels import ahead, cache
from pcsmooth.kernels.ahead import USUAL, compiling_ahead, missing, missing_of_all, warm_up
from pcsmooth.kernels.compiled import KERNELS

FEW = ("grid/grid.gather_points", "grid/radix_sort._count_digits", "grid/radix_sort._move_pairs")


def warm(folder: Path, *arguments: str) -> str:
    """What `pcsmooth warmup` says, in a process that compiles little."""
    program = (
        "import sys; from pcsmooth.kernels import ahead; "
        f"ahead.USUAL = {FEW!r}; sys.argv[1:] = {['warmup', *arguments]!r}; "
        "from pcsmooth.cli.main import run\n"
        "if __name__ == '__main__': run()"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder)}
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout == ""
    return done.stderr


@pytest.mark.slow
def test_warmup_compiles_once(tmp_path: Path) -> None:
    folder = tmp_path / "cache"
    first, second = warm(folder), warm(folder)
    assert "compiled 3 kernels in " in first
    assert f"kept in {folder}/pcsmooth" in first
    assert second == "nothing to do: all of them have been compiled\n"
    kept = {path.name.split("-")[0] for path in folder.rglob("*.nbc")}
    assert kept == {name.split("/")[1] for name in FEW}


def test_warmup_fails_where_nothing_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cache, "why_not_kept", lambda: "/nowhere: Permission denied")
    monkeypatch.setattr(ahead, "missing", list)
    finished = pcsmooth("warmup")
    assert finished.status == 1
    assert finished.stderr == (
        "Error: nothing would be kept: /nowhere: Permission denied; set NUMBA_CACHE_DIR to a "
        "folder that you alone may write\n"
    )


def test_warmup_says_nothing_if_told_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ahead, "missing", lambda _names: [])
    assert succeeds("warmup", "-q").stderr == ""


def test_all_kernels_are_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[str, int] = {}

    def is_kept(family: str, name: str, count: int = 1) -> bool:
        asked[f"{family}/{name}"] = count
        return False

    monkeypatch.setattr(ahead, "is_kept", is_kept)
    assert missing(USUAL) == list(USUAL)
    assert asked == dict.fromkeys(USUAL, 1)
    everything = missing_of_all()
    assert everything[: len(USUAL)] == list(USUAL)
    assert sorted(everything) == sorted(map("/".join, KERNELS))
    assert asked == {"/".join(key): len(each.signatures) for key, each in KERNELS.items()}


@pytest.mark.slow
def test_helpers_share_the_work_and_their_end_is_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pcsmooth.machine.cores", lambda: 2)
    program = (
        "from pcsmooth.kernels.ahead import warm_up\n"
        f"if __name__ == '__main__': warm_up({FEW!r}, lambda: print('done'))"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout == "done\n" * 3
    assert done.stderr == ""
    assert len(list(tmp_path.rglob("*.nbc"))) == 3


def test_little_work_is_done_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ahead, "spawning", None)  # would be called
    done: list[None] = []
    warm_up(FEW[:2], lambda: done.append(None))
    assert len(done) == 2


def test_a_helper_that_cannot_be_started_is_done_without(monkeypatch: pytest.MonkeyPatch) -> None:
    class Helper:
        def __init__(self, **_options: object) -> None:
            pass

        def start(self) -> None:
            raise BlockingIOError("no more processes")

    monkeypatch.setattr("pcsmooth.machine.cores", lambda: 2)
    monkeypatch.setattr(ahead, "spawning", lambda: SimpleNamespace(Process=Helper))
    assert ahead._start_helpers(FEW) == []


def test_helpers_say_nothing_of_what_they_cannot_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[str] = []

    def fail(name: str) -> SimpleNamespace:
        def make_ready(**_options: bool) -> None:
            tried.append(name)
            raise MemoryError

        return SimpleNamespace(family="", name="", signatures=[()], make_ready=make_ready)

    monkeypatch.setattr(ahead, "when_parent_ends", lambda _act: None)
    monkeypatch.setattr(ahead, "is_kept", lambda *_: False)
    monkeypatch.setattr(ahead, "_kernel", fail)
    ahead._help(FEW, False)
    assert tried == [*reversed(FEW)]


def test_helpers_end_with_what_they_help(monkeypatch: pytest.MonkeyPatch) -> None:
    class Helper:
        def __init__(self) -> None:
            self.state = "at work"

        def terminate(self) -> None:
            self.state = "ended"

    helper = Helper()
    monkeypatch.setattr(ahead, "_start_helpers", lambda names: [helper])
    told: list[tuple[int, int]] = []
    with compiling_ahead(lambda compiled, count: told.append((compiled, count))):
        assert helper.state == "at work"
    assert helper.state == "ended"


def test_it_is_said_how_much_has_been_compiled(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(ahead, "_start_helpers", lambda names: [])
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    kernel = ahead._kernel("grid/grid.gather_points")
    monkeypatch.setattr("pcsmooth.kernels.compiled.is_kept", lambda *_: False)
    monkeypatch.setattr(ahead, "missing", lambda _names: ["a", "b"])
    told: list[tuple[int, int]] = []
    with compiling_ahead(lambda *counts: told.append(counts)):
        kernel.make_ready()
    kernel.make_ready()
    assert told == [(len(USUAL) - 2, len(USUAL))]


def test_others_are_compiled_while_one_is_awaited(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []

    def kernel(name: str) -> SimpleNamespace:
        family, own = name.split("/")
        return SimpleNamespace(
            family=family, name=own, make_ready=lambda *, wait: made.append(f"{name} {wait}")
        )

    kernels = {name: kernel(name) for name in ("a/kept", "a/awaited", "a/theirs", "a/b", "a/late")}
    monkeypatch.setattr(ahead, "_kernel", kernels.__getitem__)
    monkeypatch.setattr(ahead, "is_kept", lambda _family, name: name == "kept")

    def is_claimed(_family: str, name: str) -> bool:
        return name == "theirs" or (name == "awaited" and len(made) < 1)

    monkeypatch.setattr(ahead, "is_claimed", is_claimed)
    awaited: Any = kernels["a/awaited"]
    ahead._compile_meanwhile(awaited, list(kernels))
    assert made == ["a/b False"]  # then the other process had ended
    ahead._compile_meanwhile(awaited, list(kernels))
    assert made == ["a/b False"]


def test_the_longest_is_the_first_that_others_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def kernel(name: str) -> SimpleNamespace:
        asked.append(name)
        return SimpleNamespace(family="f", name="n", signatures=[1])

    monkeypatch.setattr(ahead, "_kernel", kernel)
    monkeypatch.setattr(ahead, "is_kept", lambda *_place: True)
    monkeypatch.setattr(ahead, "when_parent_ends", lambda _act: None)
    ahead._help(USUAL, for_all=False)
    assert asked[0] == ahead._LONGEST
    assert asked[1:] == [name for name in reversed(USUAL) if name != ahead._LONGEST]
