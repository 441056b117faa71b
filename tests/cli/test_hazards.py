"""What may go wrong around a run: it is killed, the disk is full, streams are closed."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import pytest

from cli.clouds import circle, save_ply, save_text, sphere, vertices
from cli.commands import Finished, forked, pcsmooth, succeeds
from cli.forks import CLOSED
from pcsmooth import read_cloud
from pcsmooth.cli.batch_record import NAME
from pcsmooth.temporaries import process_mark
from plots.pages import unrendered

#: Writes a cloud at each path in turn, and kills the process that does at the moment beside it.
_DYING = """
import io, os, signal, sys
import pcsmooth
from pcsmooth.formats import registry

def die():
    os.kill(os.getpid(), signal.SIGKILL)

def write_and_die(path, moment):
    write, replace = registry._write, os.replace

    def write_a_part(cloud, file, *names):
        whole = io.BytesIO()
        write(cloud, whole, *names)
        file.write(whole.getvalue()[: len(whole.getvalue()) * int(moment) // 100])
        file.flush()
        die()

    if moment == "before":
        os.replace = lambda *paths: die()
    elif moment == "after":
        os.replace = lambda *paths: (replace(*paths), die())
    else:
        registry._write = write_a_part
    pcsmooth.write_cloud(pcsmooth.read_cloud("new.ply"), path)

for path, moment in zip(sys.argv[1::2], sys.argv[2::2]):
    child = os.fork()
    if child == 0:
        write_and_die(path, moment)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""

#: For each line that it reads, starts a process that replaces a file by one cloud and the other,
#: for ever, and waits for its end.
_WRITING = """
import os, sys
import pcsmooth

clouds = [pcsmooth.read_cloud(name) for name in ("old.ply", "new.ply")]
while sys.stdin.readline():
    child = os.fork()
    if child == 0:
        break
    os.waitpid(child, 0)
    print("ended", flush=True)
else:
    sys.exit()
pcsmooth.write_cloud(clouds[0], "target.ply")
print(os.getpid(), flush=True)
while True:
    for cloud in clouds:
        pcsmooth.write_cloud(cloud, "target.ply")
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An own folder with clouds."""
    monkeypatch.chdir(tmp_path)
    save_ply(tmp_path / "old.ply", vertices(sphere(900), "f8"))
    save_ply(tmp_path / "new.ply", vertices(sphere(1200), "f8"))
    save_text(tmp_path / "curve.xy", circle())
    return tmp_path


def abandoned(prefix: str = ".pcsmooth-", suffix: str = ".tmp") -> str:
    """Name of what a process of this host made that is gone."""
    host = process_mark().split("-")[0]
    return f"{prefix}{host}-{1 << 40}-1-0123456789abcdef{suffix}"


def left_over(folder: Path) -> list[Path]:
    return sorted(folder.glob(".pcsmooth-*.tmp"))


def assert_last_words(done: Finished, beginning: str) -> None:
    """Check that nothing was said but which columns are coordinates, and then an error."""
    *before, last = done.stderr.splitlines()
    assert last.startswith(beginning)
    assert all(line.startswith("curve.xy: coordinates: ") for line in before)


@pytest.fixture
def _unrendered() -> Iterator[None]:
    with unrendered():
        yield


class TestKilled:
    def test_target_is_the_old_or_the_new_file(self, folder: Path) -> None:
        cases = list(product((True, False), ("0", "50", "100", "before", "after")))
        targets = [folder / f"{moment}-{existing}" / "target.ply" for existing, moment in cases]
        for (existing, _), target in zip(cases, targets, strict=True):
            target.parent.mkdir()
            if existing:
                shutil.copy("old.ply", target)
        words = [
            str(word)
            for (_, moment), target in zip(cases, targets, strict=True)
            for word in (target, moment)
        ]
        done = subprocess.run(
            [sys.executable, "-c", _DYING, *words], capture_output=True, timeout=120
        )
        assert done.stdout.split() == [b"%d" % -signal.SIGKILL] * len(cases)
        for (existing, moment), target in zip(cases, targets, strict=True):
            if moment == "after":
                assert target.read_bytes() == (folder / "new.ply").read_bytes()
                assert left_over(target.parent) == []
            else:
                assert target.exists() == existing
                assert not existing or target.read_bytes() == (folder / "old.ply").read_bytes()
                assert len(left_over(target.parent)) == 1

    @pytest.mark.slow
    def test_at_any_moment(self, folder: Path) -> None:
        whole = [(folder / name).read_bytes() for name in ("old.ply", "new.ply")]
        with subprocess.Popen(
            [sys.executable, "-c", _WRITING], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        ) as parent:
            assert parent.stdin is not None
            assert parent.stdout is not None
            for part in range(4):
                parent.stdin.write(b"\n")
                parent.stdin.flush()
                child = int(parent.stdout.readline())
                time.sleep(0.05 + 0.0137 * part)
                os.kill(child, signal.SIGKILL)
                assert parent.stdout.readline() == b"ended\n"
                assert (folder / "target.ply").read_bytes() in whole

    def test_what_is_left_over_disturbs_no_later_run(self, folder: Path) -> None:
        inputs = folder / "in"
        inputs.mkdir()
        shutil.copy("new.ply", inputs / "scan.ply")
        names = [".pcsmooth-0123456789abcdef.tmp", abandoned()]
        for place in (inputs, folder):
            for name in names:
                (place / name).write_bytes(b"half")
        told = succeeds("curvature", inputs, "--output-dir", folder, "--suffix", "_c")
        assert "1 files: 1 done" in told.stderr
        assert told.stderr.count("of runs that were killed") == 1
        assert len(read_cloud(folder / "scan_c.ply")) == 1200
        assert left_over(folder) == [folder / names[0]]  # nobody knows whose it is
        assert len(left_over(inputs)) == 2

    @pytest.mark.usefixtures("_unrendered")
    @pytest.mark.parametrize(
        "arguments",
        [
            ["convert", "curve.xy", "-o", "out/x.ply"],
            ["convert", "curve.xy", "-o", "link.ply"],
            ["curvature", "curve.xy", "old.ply", "--output-dir", "out"],
            ["denoise", "old.ply", "-o", "x.ply", "--scheme", "euler", "--tile", "200",
             "--iterations", "1", "--tile-folder", "out"],
            ["denoise", "curve.xy", "-o", "x.xy", "--scheme", "euler", "--iterations", "1",
             "--energy-log", "out/log.csv"],
            ["plot", "old.ply", "old.ply", "-o", "out/x.png"],
            ["presets", "cube", "-o", "out/x.ply"],
        ],
        ids=["output", "link", "batch", "tiles", "log", "plot", "presets"],
    )  # fmt: skip
    def test_the_next_run_in_the_folder_removes_it_and_says_so(
        self, folder: Path, arguments: list[str]
    ) -> None:
        out = folder / "out"
        out.mkdir()
        (folder / "link.ply").symlink_to("out/x.ply")
        (out / abandoned(".pcsmooth-tiles-", "")).mkdir()
        (out / abandoned()).write_bytes(b"half")
        told = succeeds(*arguments)
        said = "out: removed 2 temporary files and folders of runs that were killed\n"
        assert told.stderr.count(said) == 1
        assert {path.name for path in out.glob(".*")} <= {NAME}
        succeeds("convert", "curve.xy", "-o", "out/y.ply", "-q")
        (out / abandoned()).write_bytes(b"half")
        one = succeeds("convert", "curve.xy", "-o", "out/z.ply").stderr
        assert "out: removed 1 temporary file or folder of runs that were killed\n" in one


def shell(command: str) -> Finished:
    """Run a command line of bash where ``$pcsmooth`` is the program."""
    done = subprocess.run(
        ["bash", "-c", command],
        env={**os.environ, "pcsmooth": f"{sys.executable} -m pcsmooth"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=120,
    )
    return Finished(done.returncode, done.stdout, done.stderr.decode())


@pytest.fixture
def full() -> Iterator[int]:
    """A device that has no space left."""
    device = os.open("/dev/full", os.O_WRONLY)
    yield device
    os.close(device)


@pytest.fixture
def small_disk(folder: Path) -> Iterator[Path]:
    """A disk of 64 kB."""
    disk = folder / "disk"
    disk.mkdir()
    if os.geteuid() != 0 or shutil.which("mount") is None:
        pytest.skip("only root may mount")
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(disk)], capture_output=True
    )
    if mounted.returncode:
        pytest.skip("nothing can be mounted here")
    try:
        yield disk
    finally:
        subprocess.run(["umount", str(disk)], check=True)


class TestFullDisk:
    def check(self, finished: Finished, path: str, cause: str) -> None:
        assert finished.status == 1
        assert finished.stdout == b""
        assert finished.stderr == f"Error: {path}: {cause}; check the disk and try again\n"

    @pytest.mark.parametrize("existing", [True, False])
    @pytest.mark.parametrize("command", ["curvature", "denoise"])
    def test_too_small_for_the_cloud(
        self, folder: Path, small_disk: Path, command: str, existing: bool
    ) -> None:
        if existing:
            (small_disk / "out.ply").write_bytes(b"precious")
        done = forked(command, "new.ply", "-o", "disk/out.ply", "--overwrite", "-q")
        self.check(done, "disk/out.ply", "No space left on device")
        assert [path.read_bytes() for path in small_disk.iterdir()] == [b"precious"] * existing

    def test_limit_of_file_size(self, folder: Path) -> None:
        (folder / "out.ply").write_bytes(b"precious")
        before = sorted(folder.iterdir())
        done = forked("curvature", "new.ply", "-o", "out.ply", "--overwrite", "-q", limit=40_000)
        self.check(done, "out.ply", "File too large")
        assert (folder / "out.ply").read_bytes() == b"precious"
        assert sorted(folder.iterdir()) == before

    def test_batch_goes_on(self, folder: Path, small_disk: Path) -> None:
        done = forked("curvature", "new.ply", "curve.xy", "--output-dir", "disk")
        assert done.status == 1
        assert "[1/2] Error: disk/new.ply: No space left on device" in done.stderr
        assert {path.name for path in small_disk.iterdir()} <= {"curve.xy", NAME}
        assert (small_disk / "curve.xy").exists()

    def test_read_only_disk(self, folder: Path, small_disk: Path) -> None:
        subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
        done = forked("curvature", "new.ply", "-o", "disk/out.ply", "-q")
        assert done.status == 1
        assert done.stderr.startswith("Error: disk/out.ply: folder ")
        assert done.stderr.count("\n") == 1

    @pytest.mark.parametrize(
        "command",
        ["info curve.xy", "info curve.xy --json", "presets", "curvature curve.xy -qo -"],
    )
    def test_stdout(self, command: str, full: int) -> None:
        done = forked(*command.split(), stdout=full)
        assert done.status == 1
        assert_last_words(done, "Error: <stdout>: No space left on device; ")

    def test_stdout_in_a_shell(self) -> None:
        done = shell("$pcsmooth --help > /dev/full")
        assert done.status == 1
        assert_last_words(done, "Error: <stdout>: No space left on device; ")


class TestClosedStreams:
    @pytest.mark.parametrize("command", ["info -", "curvature - -o out.ply"])
    def test_stdin(self, folder: Path, command: str) -> None:
        done = forked(*command.split(), stdin=CLOSED)
        assert (done.status, done.stdout) == (1, b"")
        assert done.stderr == "Error: <stdin>: it is closed; redirect it\n"
        assert not (folder / "out.ply").exists()

    @pytest.mark.parametrize(
        "command", ["info curve.xy", "curvature curve.xy -qo -", "curvature new.ply -qo -"]
    )
    def test_stdout_that_is_needed(self, command: str) -> None:
        done = forked(*command.split(), stdout=CLOSED)
        assert done.status == 1
        assert_last_words(done, "Error: <stdout>: it is closed; redirect it")

    def test_none_is_needed_to_write_a_file(self, folder: Path) -> None:
        done = forked(
            "curvature", "new.ply", "-o", "one.ply", stdin=CLOSED, stdout=CLOSED, stderr=CLOSED
        )
        assert (done.status, done.stdout, done.stderr) == (0, b"", "")
        succeeds("curvature", "new.ply", "-o", "other.ply")
        assert (folder / "one.ply").read_bytes() == (folder / "other.ply").read_bytes()

    def test_none_is_needed_in_a_shell(self, folder: Path) -> None:
        done = shell("$pcsmooth convert new.ply -o one.ply <&- >&- 2>&-")
        assert (done.status, done.stdout, done.stderr) == (0, b"", "")
        assert (folder / "one.ply").read_bytes() == (folder / "new.ply").read_bytes()

    def test_stderr_that_is_full(self, full: int) -> None:
        assert forked("info", "missing.ply", stderr=full).status == 1


class TestOthersFiles:
    """What somebody else does in the folder meanwhile."""

    @pytest.mark.usefixtures("_unrendered")
    @pytest.mark.parametrize(
        "arguments",
        [
            ["convert", "new.ply", "-o", "out.ply"],
            ["denoise", "new.ply", "-o", "out.ply", "--scheme", "euler", "--tile", "600"],
            ["denoise", "curve.xy", "-o", "x.xy", "--scheme", "euler", "--energy-log", "out.csv"],
            ["denoise", "curve.xy", "-o", "x.xy", "--report", "out.html"],
            ["plot", "old.ply", "old.ply", "-o", "out.png"],
            ["presets", "cube", "-o", "out.stl"],
        ],
        ids=["whole", "tiles", "log", "report", "plot", "presets"],
    )
    def test_a_file_of_the_name_comes_to_be_there(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str]
    ) -> None:
        link = os.link

        def come_first(source: str, target: str) -> None:
            if Path(target).name.startswith("out."):
                Path(target).write_bytes(b"another's")
            link(source, target)

        monkeypatch.setattr(os, "link", come_first)
        finished = pcsmooth(*arguments)
        assert finished.status == 1
        name = next(word for word in arguments if word.startswith("out."))
        assert finished.stderr.splitlines()[-1] == (
            f"Error: {name}: exists already, perhaps since a moment ago; pass --overwrite to "
            "replace it"
        )
        assert Path(name).read_bytes() == b"another's"
        assert left_over(folder) == []
        monkeypatch.undo()
        monkeypatch.chdir(folder)
        Path("x.xy").unlink(missing_ok=True)
        succeeds(*arguments, "--overwrite")
        assert Path(name).read_bytes() != b"another's"

    @pytest.mark.skipif(os.geteuid() != 0, reason="only root may give files away")
    @pytest.mark.parametrize("batch", [True, False])
    def test_an_owner_that_cannot_be_kept_is_told(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch, batch: bool
    ) -> None:
        def refuse(*_arguments: int) -> None:
            raise PermissionError

        monkeypatch.setattr(os, "fchown", refuse)
        target = folder / "out" / "new.ply"
        target.parent.mkdir()
        target.write_bytes(b"old")
        os.chown(target, 1234, -1)
        where = ["--output-dir", "out"] if batch else ["-o", "out/new.ply"]
        told = succeeds("convert", "new.ply", *where, "--overwrite").stderr
        assert told.count("warning: out/new.ply: owner 1234 is not kept\n") == 1

    @pytest.mark.skipif(os.geteuid() != 0, reason="only root may give links away")
    def test_a_link_that_leads_astray_is_refused_at_once(self, folder: Path) -> None:
        shared = folder / "shared"
        shared.mkdir()
        shared.chmod(0o1777)
        (shared / "out.ply").symlink_to(folder / "old.ply")
        os.lchown(shared / "out.ply", 1234, 1234)
        before = (folder / "old.ply").read_bytes()
        refused = pcsmooth("convert", "new.ply", "-o", "shared/out.ply", "--overwrite")
        assert (refused.status, refused.stdout) == (1, b"")
        assert refused.stderr == (
            "Error: shared/out.ply: a link of somebody else, in a folder that all may write, leads "
            "elsewhere; name the file itself\n"
        )
        assert (folder / "old.ply").read_bytes() == before
