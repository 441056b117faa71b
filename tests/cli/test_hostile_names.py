"""Batches of files with hostile names, and of things that are no files."""

from __future__ import annotations

import json
import os
import shutil
import time
from pathlib import Path

import pytest

from cli.clouds import save_ply, sphere, vertices
from cli.commands import pcsmooth, succeeds
from pcsmooth.cli.sources import Source, find_sources

NAMES = [
    "with space.ply",
    "née ☃.ply",
    "two\nlines.ply",
    "-dash.ply",
    "--overwrite.ply",
    "a[1].ply",
    "st*r.ply",
    "q?.ply",
    "\x1b[2Jescape.ply",
    "%s{0}.ply",
    "~.ply",
    "$HOME.ply",
    os.fsdecode(b"no utf-8 \xff.ply"),
]


@pytest.fixture
def scans(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of clouds with such names, in the current folder."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "scans"
    folder.mkdir()
    first = save_ply(folder / NAMES[0], vertices(sphere(80), "f8"))
    for name in NAMES[1:]:
        shutil.copy(first, folder / name)
    return folder


@pytest.fixture
def special(scans: Path) -> Path:
    """The same folder, with what is no cloud but is called like one."""
    (scans / "folder.ply").mkdir()
    os.mkfifo(scans / "pipe.ply")
    (scans / "loop.ply").symlink_to("loop.ply")
    (scans / "dangling.ply").symlink_to("gone.ply")
    (scans / "device.ply").symlink_to(os.devnull)
    (scans / ".hidden.ply").write_bytes(b"no cloud")
    (scans / ".pcsmooth-0123456789abcdef.tmp").write_bytes(b"half")
    for name in ("self", "again"):
        (scans / name).symlink_to(".")
    return scans


@pytest.mark.parametrize("given", ["folder", "pattern", "names"])
def test_every_name_is_worked_on(scans: Path, given: str) -> None:
    names = {
        "folder": ["scans"],
        "pattern": ["scans/*.ply"],
        "names": [f"scans/{name}" for name in NAMES],
    }[given]
    finished = succeeds("curvature", *names, "--output-dir", "out", "--json")
    assert sorted(path.name for path in Path("out").glob("[!.]*")) == sorted(NAMES)
    inputs = [json.loads(line)["input"] for line in finished.stdout.splitlines()]
    assert sorted(inputs) == sorted(f"scans/{name}" for name in NAMES)
    lines = finished.stderr.splitlines()
    table = len(NAMES) + 3  # a line each, titles, and two that are empty
    assert len(lines) == len(NAMES) + table + 1
    assert all(line.isprintable() for line in lines)


def test_failures_have_one_line_each(scans: Path) -> None:
    for name in NAMES:
        (scans / name).write_bytes(b"")
    finished = pcsmooth("curvature", "scans", "--output-dir", "out")
    assert finished.status == 1
    lines = finished.stderr.splitlines()
    assert len(lines) == 2 * len(NAMES) + 2
    assert all(line.isprintable() for line in lines)
    assert any(r"scans/two\nlines.ply: the file is empty" in line for line in lines)


@pytest.mark.parametrize("name", NAMES)
def test_info_and_errors_show_names_as_text(scans: Path, name: str) -> None:
    told = succeeds("info", f"scans/{name}")
    assert all(line.isprintable() for line in told.stdout.decode().splitlines())
    (scans / name).write_bytes(b"")
    refused = pcsmooth("info", f"scans/{name}")
    assert refused.status == 1
    assert refused.stderr.count("\n") == 1
    assert refused.stderr.strip().isprintable()


@pytest.mark.parametrize("given", ["scans", "scans/*.ply", "scans/**/*.ply", "scans/../scans/*"])
def test_only_files_are_found(special: Path, given: str) -> None:
    """A named pipe would be waited for, and links in a circle have no end."""
    started = time.monotonic()
    found = find_sources((given,))
    assert sorted(Path(source.path).name for source in found) == sorted(NAMES)
    assert time.monotonic() - started < 2


def test_hidden_files_are_found_where_they_are_asked_for(special: Path) -> None:
    assert find_sources(("scans/.h*.ply",)) == [Source("scans/.hidden.ply")]
    hidden = special / ".scans"
    hidden.mkdir()
    shutil.copy(special / NAMES[0], hidden / "a.ply")
    assert find_sources((str(hidden),)) == [Source(str(hidden / "a.ply"))]
    assert find_sources((f"{hidden}/*.ply",)) == [Source(str(hidden / "a.ply"))]


def test_what_is_named_fails_alone(special: Path) -> None:
    names = ["folder.ply", "loop.ply", "dangling.ply", "-dash.ply"]
    finished = pcsmooth(
        "curvature", *(f"scans/{name}" for name in names), "--output-dir", "out", "--json"
    )
    assert finished.status == 1
    told = [json.loads(line) for line in finished.stdout.splitlines()]
    assert ["error" in record for record in told] == [True, True, True, False]
    for record, cause in zip(
        told, ("a folder stands where", "Too many levels", "no such file"), strict=False
    ):
        assert cause in record["error"]


def test_pattern_that_is_none(special: Path) -> None:
    refused = pcsmooth("curvature", "scans/[.ply", "scans/*none.ply", "--output-dir", "out")
    assert refused.status == 1
    assert refused.stderr.count("no such file") == 4
    refused = pcsmooth("curvature", "scans/**.ply", "--output-dir", "out")
    assert refused.status in (1, 2)  # newer Pythons take it for a single *
    assert refused.stderr.splitlines()[-1].startswith("Error: ")


def test_folder_that_is_closed(special: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def closed(path: Path) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "iterdir", closed)  # root may list anything
    refused = pcsmooth("curvature", "scans", "--output-dir", "out")
    assert refused.status == 1
    assert refused.stderr.startswith("Error: scans: permission denied; ")
    assert refused.stderr.count("\n") == 1
