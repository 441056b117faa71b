"""`--report` with `--output-dir`: a page for each file, and one on all of them."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

import pytest

from cli.clouds import circle, save_ply, save_text, sphere, vertices
from cli.commands import pcsmooth, succeeds
from plots.pages import Page, read_page, unrendered

COMMAND = ["denoise", "in", "--output-dir", "out", "--recursive", "--report", "pages"]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with clouds of hostile names, far away, in the plane, and broken."""
    monkeypatch.chdir(tmp_path)
    Path("in/deep").mkdir(parents=True)
    save_ply(Path("in/deep/a%20 b#?.ply"), vertices(sphere(), "f8"))
    save_text(Path("in/c.xy"), circle())
    save_ply(Path("in/far.ply"), vertices(sphere() + 4e5, "f8"))
    Path("in/<b>.xyz").write_text("x\n")
    return tmp_path


@pytest.fixture(autouse=True)
def _unrendered() -> Iterator[None]:
    with unrendered():
        yield


def index() -> Page:
    return read_page(Path("pages/index.html").read_text())


@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.usefixtures("quick_workers")
def test_pages_and_index(jobs: int) -> None:
    finished = pcsmooth(*COMMAND, "--float", "--json", "--jobs", jobs)
    assert finished.status == 1
    summaries = [json.loads(line) for line in finished.stdout.splitlines()]
    page = index()
    head, *rows = page.rows[:5]
    assert head == [
        "", "file", "outcome", "points", "noise", "noise left", "moved", "outliers", "seconds",
        "warnings",
    ]  # fmt: skip
    assert [row[1:3] for row in rows] == [
        ["in/<b>.xyz", "failed"], ["in/c.xy", "done"], ["in/far.ply", "done"],
        ["in/deep/a%20 b#?.ply", "done"],
    ]  # fmt: skip
    assert rows[3][3:5] == ["150", f"{summaries[3]['noise']:.3g}"]
    assert [row[-1] for row in rows] == ["", "", "1", ""]
    assert page.rows[5] == [summaries[0]["error"]]
    assert page.rows[6][0].startswith("in/far.ply: ")
    assert len(page.rows) == 7
    names = [unquote(link) for link in page.links]
    assert sorted(set(names)) == [
        "c.xy.html", "c.xy.png", "deep/a%20 b#?.ply.html", "deep/a%20 b#?.ply.png",
        "far.ply.html", "far.ply.png",
    ]  # fmt: skip
    assert all(Path("pages", name).stat().st_size > 0 for name in names)
    own = read_page(Path("pages/deep/a%20 b#?.ply.html").read_text())
    assert own.facts["output"] == ["out/deep/a%20 b#?.ply"]


def test_what_is_skipped_keeps_its_numbers_and_pages() -> None:
    Path("in/<b>.xyz").unlink()
    succeeds(*COMMAND)
    before = index()
    succeeds(*COMMAND, "--skip-existing")
    after = index()
    assert after.links == before.links
    assert [row[2] for row in after.rows[1:4]] == ["skipped"] * 3
    assert [row[3:8] for row in after.rows[:4]] == [row[3:8] for row in before.rows[:4]]
    Path("out/c.xy").unlink()  # the page that is left is made anew
    succeeds(*COMMAND, "--skip-existing")
    assert [row[2] for row in index().rows[1:4]] == ["done", "skipped", "skipped"]


@pytest.mark.skipif(sys.platform != "linux", reason="names are Unicode elsewhere")
def test_a_name_that_is_no_text() -> None:
    os.rename("in/c.xy", b"in/\xe9.xy")
    succeeds("denoise", "in/\udce9.xy", *COMMAND[2:])
    assert sorted(set(index().links)) == ["%E9.xy.html", "%E9.xy.png"]


def test_results_without_pages_are_made_anew_with_them() -> None:
    Path("in/<b>.xyz").unlink()
    succeeds(*COMMAND[:-2])
    succeeds(*COMMAND[:-2], "--skip-existing")
    assert not Path("pages").exists()
    succeeds(*COMMAND, "--skip-existing")
    assert [row[2] for row in index().rows[1:4]] == ["done"] * 3
    Path("pages/far.ply.png").unlink()
    succeeds(*COMMAND, "--skip-existing")
    assert [row[2] for row in index().rows[1:4]] == ["skipped", "done", "skipped"]


def test_pages_of_others_are_kept() -> None:
    Path("pages").mkdir()
    Path("pages/c.xy.html").write_text("mine")
    finished = pcsmooth(*COMMAND)
    assert "pages/c.xy.html: exists already; pass --overwrite" in finished.stderr
    assert Path("pages/c.xy.html").read_text() == "mine"
    assert not Path("out/c.xy").exists()
    Path("pages/c.xy.html").rename("pages/c.xy.png")
    finished = pcsmooth(*COMMAND)
    assert "pages/c.xy.png: exists already; pass --overwrite" in finished.stderr
    assert not Path("out/c.xy").exists()
    Path("pages/index.html").write_text("mine")
    refused = pcsmooth(*COMMAND)
    assert refused.status == 1
    assert refused.stderr.startswith("Error: pages/index.html: exists already and is no report; ")
    assert Path("pages/index.html").read_text() == "mine"
    pcsmooth(*COMMAND, "--overwrite")
    assert len(index().rows) > 4
    assert read_page(Path("pages/c.xy.html").read_text()).facts


def test_what_is_checked_before_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    Path("pages").write_text("")
    refused = pcsmooth(*COMMAND)
    assert refused.stderr == "Error: pages: is no folder; name a folder for the pages\n"
    Path("pages").unlink()
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    refused = pcsmooth(*COMMAND)
    assert refused.stderr.startswith("Error: pictures need matplotlib, which is not installed; ")
    assert not Path("out").exists()
    assert not Path("pages").exists()


def test_a_batch_that_is_broken_off_has_an_index(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_arguments: object, **_options: object) -> None:
        raise KeyboardInterrupt

    succeeds(*COMMAND[:1], "in/c.xy", *COMMAND[2:])
    monkeypatch.setattr("pcsmooth.files.denoise_file.denoise_input", interrupt)
    finished = pcsmooth(*COMMAND, "--skip-existing")
    assert finished.status == 130
    assert [row[1:3] for row in index().rows[1:5]] == [
        ["in/<b>.xyz", "failed"], ["in/c.xy", "skipped"], ["in/far.ply", "not done"],
        ["in/deep/a%20 b#?.ply", "not done"],
    ]  # fmt: skip


def test_an_index_that_cannot_be_written_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_arguments: object) -> None:
        raise OSError(28, os.strerror(28))

    Path("in/<b>.xyz").unlink()
    monkeypatch.setattr("pcsmooth.plots.batch_page.batch_page", full)
    finished = pcsmooth(*COMMAND)
    assert finished.status == 1
    assert "Error: pages/index.html: No space left on device; check the disk" in finished.stderr
    assert "3 files: 3 done" in finished.stderr

    def interrupt(*_arguments: object, **_options: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("pcsmooth.files.denoise_file.denoise_input", interrupt)
    broken = pcsmooth(*COMMAND, "--overwrite")
    assert broken.status == 130
    assert "warning: pages/index.html: No space left on device" in broken.stderr
