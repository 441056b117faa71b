"""Ctrl-C at any moment: soon, with exit status 130 and nothing left behind."""

from __future__ import annotations

import contextlib
import io
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil
import pytest

from cli.clouds import save_ply, save_text, sphere, vertices
from cli.commands import pcsmooth, start
from cli.forks import Running
from pcsmooth.cli import main
from pcsmooth.cli.interrupts import Interrupts

#: More work than any test waits for.
ENDLESS = ["--iterations", "1000000", "-v"]

#: Seconds in which all must be over, on a busy machine.
SOON = 10.0

#: In a call that neither returns to Python soon nor holds the GIL, with a folder to be put away.
STUCK = """
import contextlib, hashlib, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)
from pcsmooth.cleanup import temporary_folder
from pcsmooth.cli.interrupts import Interrupts, end_when_told
if sys.argv[2] == "worker":
    end_when_told()
    watched = contextlib.nullcontext()
else:
    watched = Interrupts().end_promptly()
with watched, temporary_folder("work-", sys.argv[1]) as folder:
    open(f"{folder}/file", "w").close()
    with contextlib.suppress(KeyboardInterrupt):  # if it comes before that has begun
        print("ready", flush=True)
        hashlib.pbkdf2_hmac("sha256", b"", b"", 1_000_000_000)
    hashlib.pbkdf2_hmac("sha256", b"", b"", 1_000_000_000)
"""


class TestInterrupts:
    @pytest.mark.parametrize(
        ("number", "handler"),
        [
            (signal.SIGINT, signal.default_int_handler),
            (signal.SIGTERM, signal.SIG_DFL),
            (signal.SIGHUP, signal.SIG_DFL),
        ],
    )
    def test_an_interrupt_is_raised_and_noted(
        self, number: signal.Signals, handler: signal.Handlers
    ) -> None:
        interrupts = Interrupts()
        before = signal.signal(number, handler)
        try:
            with pytest.raises(KeyboardInterrupt), interrupts.end_promptly():
                signal.raise_signal(number)
            assert interrupts.signal is number
            assert signal.getsignal(number) is handler
        finally:
            signal.signal(number, before)

    def test_a_second_one_does_not_disturb_the_end(self) -> None:
        interrupts = Interrupts()
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        done = []

        @contextlib.contextmanager
        def put_away() -> Iterator[None]:
            try:
                yield
            finally:
                signal.raise_signal(signal.SIGINT)
                done.append(True)

        try:
            with pytest.raises(KeyboardInterrupt), interrupts.end_promptly(), put_away():
                signal.raise_signal(signal.SIGINT)
        finally:
            signal.signal(signal.SIGINT, before)
        assert done == [True]

    @pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
    @pytest.mark.parametrize("handler", [signal.SIG_IGN, lambda _number, _frame: None])
    def test_others_handlers_are_left_alone(
        self, number: signal.Signals, handler: signal.Handlers
    ) -> None:
        before = signal.signal(number, handler)
        try:
            with Interrupts().end_promptly():
                assert signal.getsignal(number) is handler
                signal.raise_signal(number)
        finally:
            signal.signal(number, before)

    def test_in_another_thread_it_does_nothing(self) -> None:
        entered = []

        def enter() -> None:
            with Interrupts().end_promptly():
                entered.append(True)

        thread = threading.Thread(target=enter)
        thread.start()
        thread.join()
        assert entered == [True]

    @pytest.mark.parametrize(
        ("role", "number", "words", "status"),
        [
            ("main", signal.SIGINT, "Error: interrupted\n", 130),
            ("main", signal.SIGTERM, "Error: terminated\n", 143),
            ("main", signal.SIGHUP, "Error: hung up\n", 129),
            ("worker", signal.SIGTERM, "", 143),
        ],
    )
    def test_compiled_code_does_not_keep_it_waiting(
        self, tmp_path: Path, role: str, number: int, words: str, status: int
    ) -> None:
        command = [sys.executable, "-c", STUCK, str(tmp_path), role]
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as child:
            assert child.stdout is not None
            assert child.stdout.readline() == "ready\n"
            assert len(os.listdir(tmp_path)) == 1
            child.send_signal(number)
            try:
                _, stderr = child.communicate(timeout=SOON)
            finally:
                child.kill()
        assert child.returncode == status
        assert stderr == words
        assert os.listdir(tmp_path) == []

    def test_what_a_library_makes_of_it_is_an_interrupt(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def fail(**_options: object) -> None:
            try:
                signal.raise_signal(signal.SIGINT)
            except KeyboardInterrupt as error:
                raise RuntimeError("from a library") from error

        codes: list[int] = []
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        monkeypatch.setattr(main, "main", fail)
        monkeypatch.setattr(os, "_exit", codes.append)
        try:
            finished = pcsmooth()
        finally:
            signal.signal(signal.SIGINT, before)
        assert finished.stderr == "Error: interrupted\n"
        assert codes == [130]

    def test_another_error_is_itself(self, monkeypatch: pytest.MonkeyPatch) -> None:
        def fail(**_options: object) -> None:
            raise RuntimeError("a bug")

        monkeypatch.setattr(main, "main", fail)
        monkeypatch.setattr(sys, "stdout", io.StringIO())  # not one of pytest's to wrap
        with pytest.raises(RuntimeError, match="a bug"):
            main.run()


#: How a command ends that is sent a signal.
ENDINGS = {
    signal.SIGINT: (130, "Error: interrupted"),
    signal.SIGTERM: (143, "Error: terminated"),
    signal.SIGHUP: (129, "Error: hung up"),
}


def lines_until(child: Running, line: str) -> list[bytes]:
    """What a command says on stderr up to a line that matches."""
    assert child.stderr is not None
    lines: list[bytes] = []
    while not (lines and re.match(line, lines[-1].decode())):
        lines.append(child.stderr.readline())
        assert lines[-1], lines
    return lines


def ended_by_signal(
    folder: Path,
    *arguments: object,
    moment: Callable[[Running], list[bytes]],
    after: float = 0.0,
    number: signal.Signals = signal.SIGINT,
) -> list[str]:
    """Lines of a command that is sent a signal a while after a moment, which is waited for.

    All processes of a terminal get Ctrl-C, and SIGHUP when it is closed.
    """
    before = sorted(folder.iterdir())
    with start(*arguments, own_group=True) as child:
        assert child.stderr is not None
        lines = moment(child)
        time.sleep(after)
        if number is signal.SIGTERM:
            child.send_signal(number)
        else:
            os.killpg(child.pid, number)
        lines += child.stderr.read().splitlines()
        status, last_words = ENDINGS[number]
        assert child.wait(timeout=SOON) == status
    told = [each.decode().rstrip() for each in lines if each.strip()]
    assert not [each for each in told if "Traceback" in each or "resource_tracker" in each]
    assert told[-1] == last_words
    assert sorted(folder.iterdir()) == before
    wait_for_the_others(child.pid)
    return told


def wait_for_the_others(group: int) -> None:
    """Wait for all processes of a group to end."""
    ends = time.monotonic() + SOON
    while at_work(group):
        assert time.monotonic() < ends
        time.sleep(0.05)


def at_work(group: int) -> list[psutil.Process]:
    """Processes of a group that have not ended."""
    found = []
    for each in psutil.process_iter():
        with contextlib.suppress(psutil.NoSuchProcess, ProcessLookupError):
            if os.getpgid(each.pid) == group and each.status() != psutil.STATUS_ZOMBIE:
                found.append(each)
    return found


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return save_ply(tmp_path_factory.mktemp("scan") / "scan.ply", vertices(sphere(3000), "f4"))


TILES: list[object] = ["--tile", 1000]

WAYS = {
    "alone": [],
    "tiles": TILES,
    "worker": [*TILES, "--workers", 1],
    "workers": [*TILES, "--workers", 2],
}

#: How the work is shared, a signal, and seconds after the first step. All signals and moments for
#: one process; the others end their work in the same way, and their workers whatever came.
MOMENTS = [
    ("alone", signal.SIGINT, 0.0),
    ("alone", signal.SIGINT, 0.2),
    ("alone", signal.SIGINT, 0.5),
    ("alone", signal.SIGTERM, 0.2),
    ("alone", signal.SIGHUP, 0.1),
    ("tiles", signal.SIGINT, 0.2),
    ("tiles", signal.SIGTERM, 0.0),
    ("workers", signal.SIGINT, 0.2),
    ("worker", signal.SIGTERM, 0.2),
]


@pytest.mark.slow
@pytest.mark.parametrize(("way", "number", "after"), MOMENTS)
def test_a_flow(scan: Path, way: str, number: signal.Signals, after: float) -> None:
    output = scan.parent / "out.ply"
    command = ["denoise", scan, "-o", output, *ENDLESS, *WAYS[way]]
    ended_by_signal(scan.parent, *command, moment=first_step, after=after, number=number)


def first_step(child: Running) -> list[bytes]:
    return lines_until(child, r" +\d+  volume ")


@pytest.mark.parametrize("way", ["alone", "tiles", "worker"])
def test_nothing_outlives_a_run_that_is_killed(tmp_path: Path, scan: Path, way: str) -> None:
    output = tmp_path / "out.ply"
    killed("denoise", scan, "-o", output, *ENDLESS, *WAYS[way], moment=first_step)
    assert not output.exists()


def killed(*arguments: object, moment: Callable[[Running], list[bytes]]) -> None:
    """Kill a command at a moment, and wait for its processes to end."""
    with start(*arguments, own_group=True) as child:
        moment(child)
        child.kill()
    wait_for_the_others(child.pid)


@pytest.fixture(scope="module")
def text(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file that takes a second to read even where that is fast, and another one to write."""
    lines = save_text(tmp_path_factory.mktemp("text") / "scan.xyz", sphere(8000))
    lines.write_bytes(lines.read_bytes() * 100)
    return lines


@pytest.mark.parametrize("after", [0.1, 0.5])
def test_reading_text(text: Path, after: float) -> None:
    command = ["convert", text, "-o", text.with_name("out.csv")]
    ended_by_signal(text.parent, *command, moment=lambda _child: [], after=after)


def test_writing_text(text: Path) -> None:
    def begun(child: Running) -> list[bytes]:
        while not list(text.parent.glob(".pcsmooth-*.tmp")):
            assert child.poll() is None
            time.sleep(0.01)
        return []

    command = ["convert", text, "-o", text.with_name("out.csv")]
    ended_by_signal(text.parent, *command, moment=begun)


class TestBatch:
    """One file fails at once, one is there, one is done soon, and the others take for ever."""

    @pytest.mark.parametrize(
        ("jobs", "number"), [(1, signal.SIGTERM), (2, signal.SIGINT), (2, signal.SIGHUP)]
    )
    def test_what_was_done_is_summed_up(
        self, tmp_path: Path, jobs: int, number: signal.Signals
    ) -> None:
        out = tmp_path / "out"
        out.mkdir()
        (out / "b.ply").write_text("there")
        (tmp_path / "a.ply").write_text("ply\n")
        save_ply(tmp_path / "b.ply", vertices(sphere(50), "f4"))
        # Far apart, they rest, and --stop takes notice.
        save_ply(tmp_path / "c.ply", vertices(1000.0 * sphere(50), "f4"))
        for name in ("d.ply", "e.ply", "f.ply"):
            save_ply(tmp_path / name, vertices(sphere(3000), "f4"))
        told = ended_by_signal(
            tmp_path, "denoise", tmp_path, "--output-dir", out, "--skip-existing", "--jobs", jobs,
            "--radius", 0.1, "--stop", 1e-12, *ENDLESS[:2], number=number,
            moment=lambda child: lines_until(child, r"\[3/6\] "), after=0.3,
        )  # fmt: skip
        assert sorted(os.listdir(out)) == [".pcsmooth-batch.jsonl", "b.ply", "c.ply"]
        assert told[-3].startswith("6 files: 1 done, 1 skipped, 1 failed, 3 not done, in ")
        assert told[-2].startswith(f"  {tmp_path / 'a.ply'}: ")

    @pytest.mark.slow
    def test_nothing_outlives_one_that_is_killed(self, tmp_path: Path) -> None:
        for name in ("a.ply", "b.ply", "c.ply"):
            save_ply(tmp_path / name, vertices(sphere(3000 if name != "a.ply" else 50), "f4"))
        killed(
            "denoise", tmp_path, "--output-dir", tmp_path / "out", "--jobs", 2,
            "--radius", 0.1, "--scheme", "euler", *ENDLESS[:2], "--stop", 0.01,
            moment=lambda child: lines_until(child, r"\[1/3\] "),
        )  # fmt: skip
