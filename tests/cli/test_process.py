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
from cli.commands import Finished, interrupt, start, succeeds

#: More work than any test waits for.
ENDLESS = ["--iterations", "1000000"]

COMPILING = "compiling for this machine (first run only): "


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """A cloud that takes a while."""
    return save_ply(tmp_path / "scan.ply", vertices(sphere(8000), "f4"))


@contextlib.contextmanager
def running(*arguments: object, stderr: int = subprocess.PIPE) -> Iterator[subprocess.Popen[bytes]]:
    """A process that does not outlive the test."""
    child = start(*arguments, stderr=stderr)
    try:
        yield child
    finally:
        child.kill()
        child.communicate()


def read_line(child: subprocess.Popen[bytes]) -> str:
    assert child.stderr is not None
    return child.stderr.readline().decode()


class TestInterrupt:
    @pytest.mark.parametrize("log", [[], ["--energy-log", "log.csv"]], ids=["cloud", "log"])
    def test_while_computing(
        self, scan: Path, log: list[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(scan.parent)
        before = scan.read_bytes()
        with running("denoise", scan, "-o", "out.ply", "-v", *ENDLESS, *log) as child:
            while not re.match(r" +1  volume ", line := read_line(child)):
                assert line, "ended early"
            assert interrupt(child) == 130
            assert child.stderr is not None
            rest = child.stderr.read().decode()
        assert "Traceback" not in rest
        assert rest.splitlines()[-1] == "Error: interrupted"
        assert os.listdir(scan.parent) == ["scan.ply"]
        assert scan.read_bytes() == before

    def test_while_replacing_the_input(self, scan: Path) -> None:
        before = scan.read_bytes()
        with running("denoise", scan, "-o", scan, "--overwrite", "-v", *ENDLESS) as child:
            assert "volume" in read_line(child)
            assert interrupt(child) == 130
        assert os.listdir(scan.parent) == ["scan.ply"]
        assert scan.read_bytes() == before


class TestReaderThatLeaves:
    @pytest.mark.parametrize(
        "arguments",
        [["denoise", "-q", "-o", "-"], ["curvature", "-q", "-o", "-"], ["info"]],
        ids=["denoise", "curvature", "info"],
    )
    def test_early(self, tmp_path: Path, arguments: list[str]) -> None:
        name, *options = arguments
        save_ply(tmp_path / "scan.ply", vertices(sphere(6000), "f8"))
        read_end, write_end = os.pipe()
        os.close(read_end)
        try:
            done = subprocess.run(
                [sys.executable, "-m", "pcsmooth", name, "scan.ply", *options],
                cwd=tmp_path,
                stdout=write_end,
                stderr=subprocess.PIPE,
                timeout=120,
            )
        finally:
            os.close(write_end)
        assert done.stderr == b""
        assert done.returncode == 1

    def test_after_a_few_bytes(self, tmp_path: Path) -> None:
        save_ply(tmp_path / "scan.ply", vertices(sphere(6000), "f8"))
        done = subprocess.run(
            ["bash", "-c", f"'{sys.executable}' -m pcsmooth denoise scan.ply -q -o - | head -c 10"],
            cwd=tmp_path,
            capture_output=True,
            timeout=120,
        )
        assert done.stdout == b"ply\nformat"
        assert done.stderr == b""


def seen_on_terminal(
    child: subprocess.Popen[bytes], terminal: int, pattern: str, seconds: float
) -> str:
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
    BAR = r"\| \d+/1000001 \[\d\d:\d\d<.+stage.*\]"

    def test_a_terminal_gets_a_bar_with_rate_and_time_left(
        self, scan: Path, terminal: tuple[int, int], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(scan.parent)
        ours, theirs = terminal
        with running("denoise", scan.name, "-o", "-", *ENDLESS, stderr=theirs) as child:
            seen = seen_on_terminal(child, ours, self.BAR, 20)
            assert interrupt(child) == 130
        assert re.search(r"\rscan\.ply: .*" + self.BAR, seen)

    def test_quiet_shows_no_bar(self, scan: Path, terminal: tuple[int, int]) -> None:
        ours, theirs = terminal
        log = ["-o", scan.with_name("out.ply"), "-q", *ENDLESS]
        with running("denoise", scan, *log, stderr=theirs) as child:
            assert seen_on_terminal(child, ours, ".", 2.5) == ""

    def test_a_pipe_gets_no_bar(self, scan: Path) -> None:
        with running("denoise", scan, "-o", "-", "-v", *ENDLESS) as child:
            lines = [read_line(child)]
            end = time.monotonic() + 1.5  # the bar would come after one second
            while time.monotonic() < end:
                lines.append(read_line(child))
        assert len(lines) > 2
        assert all(re.fullmatch(r" +\d+  volume .*\n", line) for line in lines)

    @pytest.mark.parametrize("name", ["denoise", "curvature"])
    def test_binary_data_are_not_written_to_a_terminal(
        self, tmp_path: Path, terminal: tuple[int, int], name: str
    ) -> None:
        cloud = save_ply(tmp_path / "scan.ply", vertices(sphere(), "f4"))
        done = subprocess.run(
            [sys.executable, "-m", "pcsmooth", name, str(cloud), "-o", "-", "-q"],
            stdout=terminal[1],
            stderr=subprocess.PIPE,
            timeout=120,
        )
        assert done.returncode == 1
        assert done.stderr.startswith(b"Error: <stdout>: is a terminal; ")
        assert not select.select([terminal[0]], [], [], 0)[0]


def test_the_first_run_says_that_it_compiles_and_the_second_does_not(tmp_path: Path) -> None:
    cloud = save_text(tmp_path / "curve.xy", circle())
    environment = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def run(output: str) -> Finished:
        child = start("denoise", cloud, "-o", tmp_path / output, env=environment)
        stdout, stderr = child.communicate(timeout=300)
        return Finished(child.returncode, stdout, stderr.decode())

    first, second = run("first.xy"), run("second.xy")
    shutil.rmtree(tmp_path / "cache")
    assert (first.status, second.status) == (0, 0)
    # Before it, which columns are coordinates.
    assert re.fullmatch(
        re.escape(COMPILING) + r"\d of \d+ kernels \.\.\.", first.stderr.splitlines()[1]
    )
    assert COMPILING not in second.stderr
    assert (tmp_path / "first.xy").read_bytes() == (tmp_path / "second.xy").read_bytes()


@pytest.mark.parametrize("name", ["denoise", "curvature"])
def test_both_commands_say_when_they_compile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    @contextlib.contextmanager
    def compiling(announce: Callable[[int, int], None]) -> Iterator[None]:
        announce(3, 24)
        announce(4, 24)  # too soon after that
        yield

    cloud = save_text(tmp_path / "curve.xy", circle())
    monkeypatch.setattr(pcsmooth.kernels.ahead, "compiling_ahead", compiling)
    told = succeeds(name, cloud, "-o", "-").stderr.splitlines()
    assert [line for line in told if "compiling" in line] == [f"{COMPILING}3 of 24 kernels ..."]
    assert succeeds(name, cloud, "-o", "-", "-q").stderr == ""
