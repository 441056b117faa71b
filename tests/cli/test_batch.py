"""Many files in one command."""

from __future__ import annotations

import json
import os
import shutil
import signal
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest

from cli.clouds import circle, load_ply, positions, save_ply, save_text, sphere, vertices
from cli.commands import Finished, pcsmooth, process, succeeds
from pcsmooth import InvalidInputError, read_cloud
from pcsmooth.cli.batch import run_batch
from pcsmooth.cli.file_task import FileTask
from pcsmooth.cli.options import Files
from pcsmooth.cli.sources import Job, Source, find_sources, plan_jobs
from pcsmooth.errors import PcsmoothError

COMMANDS = ["denoise", "curvature"]

#: What to do about results of one name.
APART = "run them apart, or name the folder above both and give --recursive"


@pytest.fixture
def scans(tmp_path: Path) -> Path:
    """Five clouds in three formats, and two files that are none."""
    folder = tmp_path / "scans"
    folder.mkdir()
    for seed in range(3):
        save_ply(folder / f"s{seed}.ply", vertices(sphere(80 + seed, seed=seed), "f8"))
    save_text(folder / "c.xy", circle())
    save_text(folder / "t.csv", sphere(70), ",")
    (folder / "broken.ply").write_bytes((folder / "s0.ply").read_bytes()[:300])
    (folder / "words.xyz").write_text("this is no cloud\n")
    (folder / "notes.md").write_text("not looked at\n")
    return folder


def records(finished: Finished) -> list[dict[str, Any]]:
    return [json.loads(line) for line in finished.stdout.splitlines()]


@pytest.mark.usefixtures("quick_workers")
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("jobs", [1, 2])
def test_failures_do_not_stop_the_others(
    tmp_path: Path, scans: Path, command: str, jobs: int
) -> None:
    out = tmp_path / "new" / "out"
    finished = pcsmooth(
        command, scans, "--output-dir", out, "--suffix", "_x", "--json", "--jobs", jobs
    )
    assert finished.status == 1
    names = ["broken.ply", "c.xy", "s0.ply", "s1.ply", "s2.ply", "t.csv", "words.xyz"]
    told = records(finished)
    assert [Path(record["input"]).name for record in told] == names
    assert ["error" in record for record in told] == [name[0] in "bw" for name in names]
    assert told[0]["error"].startswith(f"{scans / 'broken.ply'}: the header promises 80 ")
    assert sorted(path.name for path in out.iterdir()) == [
        ".pcsmooth-batch.jsonl", "c_x.xy", "s0_x.ply", "s1_x.ply", "s2_x.ply", "t_x.csv"
    ]  # fmt: skip
    lines = finished.stderr.splitlines()
    assert lines[-1] == "Error: 2 of 7 files failed"
    assert lines[-4].startswith("7 files: 5 done, 0 skipped, 2 failed, in ")
    assert lines[-3] == f"  {told[0]['error']}"
    assert lines[0] == f"[1/7] Error: {told[0]['error']}"
    assert f"[3/7] {scans / 's0.ply'} -> {out / 's0_x.ply'}: 80 points, " in finished.stderr


@pytest.mark.slow
@pytest.mark.usefixtures("quick_workers")
@pytest.mark.parametrize("command", COMMANDS)
def test_results_are_those_of_single_runs(tmp_path: Path, scans: Path, command: str) -> None:
    names = ["s0.ply", "s1.ply", "c.xy"]
    alone = [
        succeeds(command, scans / name, "-o", tmp_path / f"alone_{name}", "--json").json
        for name in names
    ]
    told = records(
        succeeds(
            command, *(scans / name for name in names), "--output-dir", tmp_path / "out", "--json",
            "--jobs", 2,
        )
    )  # fmt: skip
    for name, one, many in zip(names, alone, told, strict=True):
        batched = tmp_path / "out" / name
        assert batched.read_bytes() == (tmp_path / f"alone_{name}").read_bytes()
        for key in ("output", "seconds"):
            one.pop(key), many.pop(key)
        assert many == one


def test_skip_existing_redoes_only_what_is_missing(tmp_path: Path, scans: Path) -> None:
    out = tmp_path / "out"
    options = ("--output-dir", out, "--skip-existing")
    assert pcsmooth("denoise", scans, *options).status == 1
    before = {path.name: path.stat().st_mtime_ns for path in out.glob("[!.]*")}
    assert len(before) == 5
    shutil.copy(scans / "s0.ply", scans / "broken.ply")
    again = pcsmooth("denoise", scans, *options, "--json")
    assert again.status == 1
    told = records(again)
    assert [("skipped" in record, "error" in record) for record in told] == [
        (False, False), *[(True, False)] * 5, (False, True)
    ]  # fmt: skip
    after = {path.name: path.stat().st_mtime_ns for path in out.glob("[!.]*")}
    assert {name: after[name] for name in before} == before
    assert after.keys() - before.keys() == {"broken.ply"}
    assert f"{scans / 's0.ply'}: skipped, {out / 's0.ply'} is there and up to date" in again.stderr
    assert "7 files: 1 done, 5 skipped, 1 failed" in again.stderr


def test_existing_results_fail_one_by_one(tmp_path: Path, scans: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "s0.ply").write_text("mine")
    refused = pcsmooth("curvature", scans / "s0.ply", scans / "s1.ply", "--output-dir", out)
    assert refused.status == 1
    assert "s0.ply: exists already; pass --overwrite to replace it" in refused.stderr
    assert (out / "s0.ply").read_text() == "mine"
    assert (out / "s1.ply").exists()
    succeeds("curvature", scans / "s0.ply", "--output-dir", out, "--overwrite")
    assert "nx" in load_ply(out / "s0.ply")["vertex"].data.dtype.names


@pytest.mark.parametrize("suffix", ["/../../x", "_x/y.ply"])
def test_suffix_leads_to_no_other_folder(tmp_path: Path, scans: Path, suffix: str) -> None:
    out = tmp_path / "new" / "out"
    refused = pcsmooth("denoise", scans / "c.xy", "--output-dir", out, "--suffix", suffix)
    assert refused.status == 2
    assert f"{suffix!r} is not part of a name; --output-dir names a folder" in refused.stderr
    assert not (tmp_path / "new").exists()


def test_suffix_can_choose_the_format(tmp_path: Path, scans: Path) -> None:
    succeeds("denoise", scans / "c.xy", "--output-dir", tmp_path, "--suffix", "_s.ply")
    assert np.isfinite(positions(tmp_path / "c_s.ply")).all()
    assert len(read_cloud(tmp_path / "c_s.ply")) == 60


def test_quiet_tells_failures_alone(tmp_path: Path, scans: Path) -> None:
    quiet = pcsmooth("denoise", scans, "--output-dir", tmp_path / "out", "-q")
    assert len(quiet.stderr.splitlines()) == 3
    assert quiet.stderr.count("Error: ") == 3


def test_verbose_tells_everything(tmp_path: Path, scans: Path) -> None:
    told = succeeds("denoise", scans / "s0.ply", scans / "s1.ply", "--output-dir", tmp_path, "-v")
    assert f"{scans / 's1.ply'}: 81 points in 3D" in told.stderr
    assert told.stderr.count("points moved") == 2


def test_warnings_are_told_with_the_file(tmp_path: Path) -> None:
    far = save_ply(tmp_path / "far.ply", vertices(sphere() + 4e5, "f8"))
    told = succeeds(
        "denoise", far, far.with_name("./far.ply"), "--output-dir", tmp_path / "out", "--float"
    ).stderr
    assert told.count("warning:") == 1
    assert f"{far}: warning: " in told


@pytest.mark.usefixtures("quick_workers")
def test_info_of_many(scans: Path) -> None:
    told = pcsmooth("info", scans, "--json", "--jobs", 2)
    assert told.status == 1
    files = records(told)
    assert [Path(facts["file"]).name for facts in files][1:4] == ["c.xy", "s0.ply", "s1.ply"]
    assert files[1]["points"] == 60
    assert files[0].keys() == {"file", "error"}
    alone = succeeds("info", scans / "s1.ply", "--json").json
    assert files[3] == alone
    words = succeeds("info", scans / "s0.ply", scans / "c.xy").stdout.decode()
    assert words.count("mean spacing") == 2


# --- which files, and where to


def test_sources(scans: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(scans.parent)
    inner = scans / "inner"
    inner.mkdir()
    save_text(inner / "deep.xyz", sphere(5))
    assert paths("scans/s2.ply", "scans", "missing.ply") == [
        "scans/s2.ply", "scans/broken.ply", "scans/c.xy", "scans/s0.ply", "scans/s1.ply",
        "scans/t.csv", "scans/words.xyz", "missing.ply",
    ]  # fmt: skip
    assert paths("scans/s*.ply", "scans/**/*.xyz", "no*thing") == [
        "scans/s0.ply", "scans/s1.ply", "scans/s2.ply", "scans/inner/deep.xyz",
        "scans/words.xyz", "no*thing",
    ]  # fmt: skip
    (scans / "a[1].ply").write_bytes((scans / "s0.ply").read_bytes())
    assert paths("scans/a[1].ply") == ["scans/a[1].ply"]


def paths(*names: str) -> list[str]:
    found = find_sources(names)
    assert not any(source.folder for source in found)
    return [source.path for source in found]


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Clouds of the same names in folders and sub-folders, and what is to be left out."""
    monkeypatch.chdir(tmp_path)
    for folder in ("t", "t/a", "t/a/deep", "t/b", "t/.hidden", "t/out/a", "elsewhere"):
        Path(folder).mkdir(parents=True, exist_ok=True)
        save_text(Path(folder, "x.xyz"), sphere(60))
    Path("t/a/round").symlink_to("../..")
    Path("t/linked").symlink_to("../elsewhere")
    return tmp_path


@pytest.mark.usefixtures("tree")
def test_sub_folders_are_searched_and_mirrored() -> None:
    found = [Source("t/x.xyz"), Source("t/a/x.xyz", "a"), Source("t/a/deep/x.xyz", "a/deep"),
             Source("t/b/x.xyz", "b")]  # fmt: skip
    assert find_sources(("t",), recursive=True, output="t/out") == found
    inside = Source("t/out/a/x.xyz", "out/a")
    assert find_sources(("t/",), recursive=True) == [*found, inside]
    assert find_sources(("t/**/x.*",), recursive=True)[:3] == [found[2], found[1], found[3]]
    assert find_sources(("t/?/x.*", "t/a"), recursive=True) == [found[1], found[3], Source(
        "t/a/deep/x.xyz", "deep")]  # fmt: skip
    assert find_sources(("*/b/x.xyz",), recursive=True) == [Source("t/b/x.xyz", "t/b")]


@pytest.mark.usefixtures("tree")
def test_results_of_equal_names_lie_in_folders_of_their_own() -> None:
    options = ("--output-dir", "t/out", "--overwrite", "--suffix", "_s", "--recursive")
    told = records(succeeds("convert", "t", *options, "--json"))
    assert [record["output"] for record in told] == [
        "t/out/x_s.xyz", "t/out/a/x_s.xyz", "t/out/a/deep/x_s.xyz", "t/out/b/x_s.xyz"
    ]  # fmt: skip
    again = pcsmooth("convert", "t", *options, "--json")  # the results are no inputs
    assert records(again) == [record | {"seconds": mock.ANY} for record in told]
    flat = pcsmooth("convert", "t/**/*.xyz", "--output-dir", "new")
    assert flat.status == 2
    assert f"x.xyz would both become new/x.xyz; {APART}" in flat.stderr
    assert not Path("new").exists()
    assert len(records(succeeds("info", "t/a", "--recursive", "--json"))) == 2
    assert pcsmooth("convert", "t/a/deep", "--output-dir", "n", "--recursive").status == 0
    assert pcsmooth("convert", "t/x.xyz", "-o", "n/y.xyz", "--recursive").status == 2


@pytest.mark.usefixtures("tree")
def test_a_tree_without_clouds_or_closed_to_reading(monkeypatch: pytest.MonkeyPatch) -> None:
    Path("empty/deep").mkdir(parents=True)
    failed = pcsmooth("convert", "empty", "--output-dir", "new", "--recursive")
    assert failed.stderr == (
        "Error: empty: the folder holds no file of a known format; name another folder\n"
    )

    def closed(folder: str) -> Any:
        raise PermissionError(13, "Permission denied", folder)

    monkeypatch.setattr(os, "scandir", closed)
    refused = pcsmooth("convert", "t", "--output-dir", "new", "--recursive")
    assert refused.status == 1
    assert refused.stderr.startswith("Error: t: ")
    assert "ermission" in refused.stderr


def test_jobs() -> None:
    jobs = plan_jobs([Source("a/x.ply"), Source("b/y.XYZ", "b/c")], "out", "_s")
    assert jobs == [Job("a/x.ply", "out/x_s.ply"), Job("b/y.XYZ", "out/b/c/y_s.XYZ")]
    one = [Source("a/x.xyz")]
    assert plan_jobs(one, "out", ".ply") == [Job("a/x.xyz", "out/x.ply")]
    assert plan_jobs(one, "out", "_v1.5") == [Job("a/x.xyz", "out/x_v1.5.xyz")]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["a.ply"], "give -o OUTPUT, or --output-dir DIR for many files"),
        (["a.ply", "b.ply", "-o", "c.ply"], "-o is for one input; give --output-dir DIR"),
        (["a.ply", "-o", "c.ply", "--output-dir", "d"], "-o and --output-dir exclude each other"),
        (["a.ply", "-o", "c.ply", "--suffix", "_s"], "--suffix needs --output-dir"),
        (["a.ply", "-o", "c.ply", "--skip-existing"], "--skip-existing needs --output-dir"),
        (["a.ply", "-o", "c.ply", "--jobs", "2"], "--jobs needs --output-dir"),
        (["-", "a.ply", "--output-dir", "d"], "- (stdin) is one cloud"),
        (["a/x.ply", "b/x.ply", "--output-dir", "d"], "a/x.ply and b/x.ply would both become d/x"),
        (["-", "-o", "-", "--json"], "--json and -o - both want stdout"),
    ],
)
@pytest.mark.parametrize("command", COMMANDS)
def test_usage(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
    arguments: list[str],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    refused = pcsmooth(command, *arguments)
    assert refused.status == 2
    assert f"Error: {message}" in refused.stderr
    assert list(tmp_path.iterdir()) == []


class TestResultsThatAreInputs:
    """Refused before any file is read or written, whatever leads to them."""

    @pytest.fixture(autouse=True)
    def folder(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
        monkeypatch.chdir(tmp_path)
        Path("e").mkdir()
        save_text(Path("e/a.xyz"), sphere(60))
        save_text(Path("e/a_s.xyz"), sphere(70))
        return tmp_path

    def check(self, *arguments: str, message: str) -> None:
        before = {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}
        for command in (*COMMANDS, "convert"):
            for jobs in ("1", "2"):
                refused = pcsmooth(command, *arguments, "--jobs", jobs)
                assert (refused.status, refused.stdout) == (2, b"")
                assert refused.stderr == f"Error: {message}; see pcsmooth {command} --help\n"
        after = {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}
        assert after == before

    MESSAGE = (
        "e/a.xyz would become {}, which is one of the inputs; choose another --output-dir or "
        "--suffix"
    )

    @pytest.mark.parametrize("option", ["--overwrite", "--skip-existing", "--quiet"])
    def test_by_the_suffix(self, option: str) -> None:
        target = self.MESSAGE.format("e/a_s.xyz")
        self.check("e", "--output-dir", "e", "--suffix", "_s", option, message=target)

    def test_by_the_folder(self) -> None:
        target = self.MESSAGE.format("e/a.xyz")
        self.check("e", "--output-dir", "e", "--overwrite", message=target)

    def test_folders_that_are_links(self) -> None:
        Path("link").symlink_to("e")
        target = self.MESSAGE.format("link/a_s.xyz")
        options = ("--output-dir", "link", "--suffix", "_s", "--overwrite")
        self.check("e", *options, message=target)

    @pytest.mark.parametrize("kind", ["link", "symlink"])
    def test_links(self, kind: str) -> None:
        Path("out").mkdir()
        getattr(os, kind)(os.path.abspath("e/a_s.xyz"), "out/a.xyz")
        target = self.MESSAGE.format("out/a.xyz")
        self.check("e", "--output-dir", "out", "--overwrite", message=target)

    def test_inputs_that_are_links(self) -> None:
        Path("in").mkdir()
        Path("in/b.xyz").symlink_to("../out/a.xyz")
        Path("out").mkdir()
        Path("e/a_s.xyz").rename("out/a.xyz")
        target = self.MESSAGE.format("out/a.xyz")
        self.check("e", "in", "--output-dir", "out", "--overwrite", message=target)

    def test_two_results_in_one_file(self) -> None:
        Path("out").mkdir()
        Path("out/a.xyz").symlink_to("a_s.xyz")
        message = f"e/a.xyz and e/a_s.xyz would both become out/a_s.xyz; {APART}"
        self.check("e", "--output-dir", "out", message=message)

    def test_a_single_file_may_take_its_own_place(self) -> None:
        before = len(read_cloud("e/a.xyz"))
        succeeds("convert", "e/a.xyz", "-o", "e/a.xyz", "--overwrite")
        assert len(read_cloud("e/a.xyz")) == before


@pytest.mark.parametrize(
    ("option", "name", "told"),
    [
        ("--energy-log", "e.csv", "--energy-log is for one input, not for --output-dir"),
        ("--report", "r.html", "--report names a folder for many pages, with --output-dir"),
    ],
)
def test_files_beside_one_cloud(tmp_path: Path, option: str, name: str, told: str) -> None:
    refused = pcsmooth("denoise", "a.ply", "--output-dir", tmp_path, option, tmp_path / name)
    assert refused.status == 2
    assert told in refused.stderr


def test_a_folder_without_clouds(tmp_path: Path) -> None:
    failed = pcsmooth("curvature", tmp_path, "--output-dir", tmp_path / "out")
    assert failed.status == 1
    assert failed.stderr == (
        f"Error: {tmp_path}: the folder holds no file of a known format; name another folder, or "
        "give --recursive\n"
    )


def test_a_file_where_the_folder_should_be(tmp_path: Path, scans: Path) -> None:
    (tmp_path / "out").write_text("")
    failed = pcsmooth("denoise", scans / "s0.ply", "--output-dir", tmp_path / "out")
    assert failed.status == 1
    assert failed.stderr.count("Error") == 2
    assert "Traceback" not in failed.stderr


# --- what may happen to one of many


def work(source: str, target: str | None, **options: Any) -> dict[str, Any]:
    """Do what the name of the file says."""
    name = Path(source).name
    if name == "dies":
        os.kill(os.getpid(), signal.SIGKILL)
    if name == "memory":
        raise MemoryError
    if name == "invalid":
        raise InvalidInputError("it is\nso; do not")
    if name == "bug":
        raise KeyError("oops")
    return {"input": source, "output": target, "points": 1}


def run(capsys: pytest.CaptureFixture[str], names: list[str], processes: int) -> tuple[Any, str]:
    jobs = [Job(name, None) for name in names]
    with pytest.raises(PcsmoothError, match=r"^\d+ of \d+ files failed$"):
        run_batch(FileTask(work, Files(("x",)), {}, as_json=True), jobs, processes)
    told = capsys.readouterr()
    return [json.loads(line) for line in told.out.splitlines()], told.err


@pytest.mark.usefixtures("quick_workers")
@pytest.mark.parametrize("processes", [1, 2])
def test_every_failure_has_one_line(capsys: pytest.CaptureFixture[str], processes: int) -> None:
    told, said = run(capsys, ["memory", "invalid", "bug", "fine"], processes)
    assert [record.get("error") for record in told] == [
        "memory: not enough memory; run it alone",
        "invalid: it is so; do not",
        "bug: KeyError: 'oops'; please report this",
        None,
    ]
    assert "4 files: 1 done, 0 skipped, 3 failed" in said


@pytest.mark.slow
@pytest.mark.usefixtures("quick_workers")
def test_a_process_that_is_killed_takes_no_other_with_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    names = ["a", "dies", "b", "c", "dies", "d", "e", "f", "dies", "g", "h"]
    told, said = run(capsys, names, 2)
    assert ["error" in record for record in told] == [name == "dies" for name in names]
    assert told[1]["error"].startswith("dies: its process was killed, perhaps for lack of memory;")
    assert "warning: a process was killed, perhaps for lack of memory; done in one of its" in said


@pytest.mark.slow
def test_as_a_process(tmp_path: Path, scans: Path) -> None:
    """Workers are started from the program's own entry; of any command."""
    done = process("convert", scans / "s*.ply", "--output-dir", tmp_path / "out", "--jobs", 2)
    assert done.status == 0, done.stderr
    assert len(list((tmp_path / "out").glob("[!.]*"))) == 3
