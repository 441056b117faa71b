"""The command line as a process: signals, terminals, pipes, and the first run on a machine."""

from __future__ import annotations

import contextlib
import os
import pty
import re
import select
import shutil
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import pcsmooth.kernels.ahead
from cli.clouds import circle, save_ply, save_text, sphere, vertices
from cli.commands import Finished, forked, interrupt, process, start, succeeds
from cli.forks import PIPE, Running
from pcsmooth.kernels.ahead import USUAL
from pcsmooth.kernels.cache import folder_of

#: More work than any test waits for.
ENDLESS = ["--iterations", "1000000"]

#: Kernels that take little time to compile, and so many that another process is asked to help.
FEW = ("grid/grid.gather_points", "grid/radix_sort._count_digits", "grid/radix_sort._move_pairs")

COMPILING = "compiling for this machine (first run only): "


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """A cloud that takes a while."""
    return save_ply(tmp_path / "scan.ply", vertices(sphere(3000), "f4"))


@contextlib.contextmanager
def running(*arguments: object, stderr: int = PIPE) -> Iterator[Running]:
    """A process that does not outlive the test."""
    with start(*arguments, stderr=stderr) as child:
        yield child
        child.kill()


def read_line(child: Running) -> str:
    assert child.stderr is not None
    return child.stderr.readline().decode()


def test_an_interrupt_while_the_input_is_to_be_replaced(scan: Path) -> None:
    before = scan.read_bytes()
    command = [
        "denoise",
        scan,
        "-o",
        scan,
        "--overwrite",
        "--energy-log",
        scan.with_name("log.csv"),
    ]
    with running(*command, "-v", *ENDLESS) as child:
        while not re.match(r" +1  volume ", line := read_line(child)):
            assert line, "ended early"
        assert interrupt(child) == 130
        assert child.stderr is not None
        rest = child.stderr.read().decode()
    assert "Traceback" not in rest
    assert rest.splitlines()[-1] == "Error: interrupted"
    assert os.listdir(scan.parent) == ["scan.ply"]
    assert scan.read_bytes() == before


class TestReaderThatLeaves:
    @pytest.mark.parametrize(
        "arguments",
        [["denoise", "-q", "-o", "-"], ["curvature", "-q", "-o", "-"], ["info"]],
        ids=["denoise", "curvature", "info"],
    )
    def test_early(self, scan: Path, arguments: list[str]) -> None:
        name, *options = arguments
        read_end, write_end = os.pipe()
        os.close(read_end)
        try:
            done = forked(name, scan, *options, stdout=write_end)
        finally:
            os.close(write_end)
        assert done.stderr == ""
        assert done.status == 1

    def test_after_a_few_bytes(self, scan: Path) -> None:
        with running("denoise", scan, "-q", "-o", "-") as child:
            assert child.stdout is not None
            assert child.stderr is not None
            assert os.read(child.stdout.fileno(), 10) == b"ply\nformat"
            child.stdout.close()
            assert child.stderr.read() == b""
            assert child.wait(timeout=60) == 1

    @pytest.mark.parametrize("moment", range(4))
    def test_without_a_buffer(self, tmp_path: Path, moment: int) -> None:
        """As PYTHONUNBUFFERED has it: what the pipe does not take must not be lost in silence."""
        scan = save_ply(tmp_path / "scan.ply", vertices(sphere(8000), "f8"))
        command = [sys.executable, "-u", "-m", "pcsmooth", "convert", str(scan), "-o", "-", "-q"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as child:
            assert child.stdout is not None
            assert child.stderr is not None
            assert os.read(child.stdout.fileno(), 10) == b"ply\nformat"
            time.sleep(0.02 * moment)  # the rest is being written
            child.stdout.close()
            assert child.wait(timeout=60) == 1
            assert child.stderr.read() == b""


def seen_on_terminal(child: Running, terminal: int, pattern: str, seconds: float) -> str:
    """What a process wrote on a terminal until it matches or the time is over."""
    seen = ""
    deadline = time.monotonic() + seconds
    while not re.search(pattern, seen) and (left := deadline - time.monotonic()) > 0:
        if select.select([terminal], [], [], left)[0]:
            seen += os.read(terminal, 4096).decode()
        assert child.poll() is None, seen
    return seen


@pytest.fixture
def terminal() -> Iterator[tuple[int, int]]:
    """Both ends of a pseudo-terminal: ours, the process's."""
    ends = pty.openpty()
    termios.tcsetwinsize(ends[1], (24, 120))
    yield ends
    for end in ends:
        os.close(end)


class TestProgress:
    BAR = r"\| \d+/1000010 \[\d\d:\d\d<.+stage.*\]"

    @pytest.mark.slow
    def test_a_terminal_gets_a_bar_with_rate_and_time_left(
        self, scan: Path, terminal: tuple[int, int], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(scan.parent)
        ours, theirs = terminal
        with running("denoise", scan.name, "-o", "-", *ENDLESS, stderr=theirs) as child:
            seen = seen_on_terminal(child, ours, self.BAR, 20)
            assert interrupt(child) == 130
        assert re.search(r"\rscan\.ply: .*" + self.BAR, seen)

    @pytest.mark.slow
    def test_quiet_shows_no_bar(self, scan: Path, terminal: tuple[int, int]) -> None:
        ours, theirs = terminal
        log = ["-o", scan.with_name("out.ply"), "-q", *ENDLESS]
        with running("denoise", scan, *log, stderr=theirs) as child:
            # The bar would come after one second.
            assert seen_on_terminal(child, ours, ".", 2.0) == ""

    @pytest.mark.slow
    def test_a_pipe_gets_no_bar(self, scan: Path) -> None:
        with running("denoise", scan, "-o", "-", "-v", *ENDLESS) as child:
            lines = [read_line(child)]
            end = time.monotonic() + 1.3  # the bar would come after one second
            while time.monotonic() < end:
                lines.append(read_line(child))
        assert len(lines) > 2
        assert all(re.fullmatch(r" +\d+  volume .*\n", line) for line in lines)

    @pytest.mark.parametrize("name", ["denoise", "curvature"])
    def test_binary_data_are_not_written_to_a_terminal(
        self, tmp_path: Path, terminal: tuple[int, int], name: str
    ) -> None:
        cloud = save_ply(tmp_path / "scan.ply", vertices(sphere(), "f4"))
        done = forked(name, cloud, "-o", "-", "-q", stdout=terminal[1])
        assert done.status == 1
        assert done.stderr.startswith("Error: <stdout>: is a terminal; ")
        assert not select.select([terminal[0]], [], [], 0)[0]


def cache_without(folder: Path, *names: str) -> Path:
    """Copy the cache of this machine but for a few kernels."""
    for family in {name.split("/")[0] for name in USUAL}:
        kept = folder_of(family)
        lacking = [f"{name.split('/')[1]}-*" for name in names]
        ignore = shutil.ignore_patterns(*lacking)
        shutil.copytree(kept, folder / "pcsmooth" / kept.name, ignore=ignore)
    return folder


@pytest.mark.slow
def test_a_run_says_that_it_compiles_and_the_second_does_not(tmp_path: Path) -> None:
    cloud = save_text(tmp_path / "curve.xy", circle())
    cache = cache_without(tmp_path / "cache", *FEW)

    def run(output: str) -> Finished:
        environment = {"NUMBA_CACHE_DIR": str(cache)}
        return process("denoise", cloud, "-o", tmp_path / output, env=environment)

    first, second = run("first.xy"), run("second.xy")
    assert (first.status, second.status) == (0, 0)
    # Before it, which columns are coordinates, and that none is for outliers.
    counts = re.fullmatch(
        re.escape(COMPILING) + r"(\d+) of (\d+) kernels \.\.\.", first.stderr.splitlines()[2]
    )
    assert counts is not None
    assert len(USUAL) - len(FEW) <= int(counts[1]) < int(counts[2]) == len(USUAL)
    assert COMPILING not in second.stderr
    assert (tmp_path / "first.xy").read_bytes() == (tmp_path / "second.xy").read_bytes()


@pytest.mark.parametrize("name", ["denoise", "curvature"])
def test_both_commands_say_when_they_compile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    @contextlib.contextmanager
    def compiling(announce: Callable[[int, int], None], *_union: object) -> Iterator[None]:
        announce(3, 24)
        announce(4, 24)  # too soon after that
        yield

    cloud = save_text(tmp_path / "curve.xy", circle())
    monkeypatch.setattr(pcsmooth.kernels.ahead, "compiling_ahead", compiling)
    told = succeeds(name, cloud, "-o", "-").stderr.splitlines()
    assert [line for line in told if "compiling" in line] == [f"{COMPILING}3 of 24 kernels ..."]
    assert succeeds(name, cloud, "-o", "-", "-q").stderr == ""
