"""`pcsmooth denoise --report`: the page, and what is checked before the work."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import pcsmooth
import pcsmooth.files.denoise_file
from cli.clouds import circle, save_ply, save_text, sphere, vertices
from cli.commands import pcsmooth as command
from cli.commands import succeeds
from cli.test_errors import check_line, fail_in_flow, snapshot
from plots.pages import read_page, unrendered

GOOD = ["denoise", "good.ply", "-o", "out.ply"]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An own folder with clouds and files that exist."""
    monkeypatch.chdir(tmp_path)
    save_ply(Path("good.ply"), vertices(sphere(), "f8"))
    save_text(Path("good.xy"), circle())
    save_text(Path("good.html"), sphere())
    Path("old.html").write_bytes(b"precious")
    Path("p.toml").write_bytes(b"")
    Path("folder.html").mkdir()
    return tmp_path


@pytest.fixture
def _unrendered() -> Iterator[None]:
    with unrendered():
        yield


@pytest.mark.usefixtures("_unrendered")
@pytest.mark.parametrize("name", ["good.ply", "good.xy"])
def test_the_page_says_what_the_summary_says(name: str) -> None:
    output = f"out.{name[5:]}"
    summary = succeeds(
        "denoise", name, "-o", output, "--report", "report.html", "--json"
    ).json  # fmt: skip
    page = read_page(Path("report.html").read_text())
    facts = page.facts
    assert page.links == page.scripts == []
    assert len(page.pictures) == 3
    assert facts["input"] == [name]
    assert facts["output"] == [output]
    assert facts["points"] == [f"{summary['points']} in {summary['dimension']}D"]
    assert facts["scheme"] == ["filter"]
    assert facts["mean spacing"] == [f"{summary['spacing']:.6g}"]
    assert facts["noise"][0].startswith(f"{summary['noise']:.4g}, ")
    assert facts["neighbourhoods"] == [f"{summary['filter_support']:.0f} points"]
    marked = "column outlier" if output == "out.ply" else "not marked in the file"
    said = f"{summary['outliers']} outliers left where they are ({marked})"
    assert facts["outliers"] == [said]
    assert facts["normals from"] == [f"{summary['normal_support']:.0f} points"]
    assert facts["curvature from"] == [f"{summary['curvature_support']:.0f} points"]
    assert float(facts["mean"][0]) == pytest.approx(summary["mean_displacement"], rel=1e-5)
    assert float(facts["max"][0]) == pytest.approx(summary["max_displacement"], rel=1e-5)


@pytest.mark.usefixtures("_unrendered")
def test_a_flow_has_a_curve_of_its_energies() -> None:
    options = ["--energy", "area", "--iterations", "3", "--energy-log", "log.csv"]
    succeeds(*GOOD, *options, "--report", "report.html")
    page = read_page(Path("report.html").read_text())
    log = np.genfromtxt("log.csv", delimiter=",", names=True)
    assert len(page.pictures) == 4
    assert page.facts["iterations"] == ["3"]
    for name in ("volume", "area"):
        before, after, _ = page.facts[name]
        assert (float(before), float(after)) == pytest.approx((log[name][0], log[name][-1]))


@pytest.mark.usefixtures("_unrendered")
def test_polyhedra_and_rows_that_take_no_part() -> None:
    points = np.vstack([sphere(), [[np.nan, 0.0, 0.0]]])
    held = np.zeros(151, "u1")
    held[:4] = 1
    save_ply(Path("good.ply"), vertices(points, "f8", held=held))
    succeeds(
        *GOOD, "--polyhedron", "cube", "--union", "naive", "--iterations", "1", "--fixed", "held",
        "--report", "report.html",
    )  # fmt: skip
    facts = read_page(Path("report.html").read_text()).facts
    assert facts["polyhedron"] == ["cube"]
    assert facts["union"] == ["naive"]
    assert facts["points"] == ["151 in 3D, 1 not finite (passed through), 4 fixed"]


@pytest.mark.usefixtures("_unrendered")  # pictures: see the test of the page
def test_same_bytes_and_the_same_cloud() -> None:
    succeeds(*GOOD)
    alone = Path("out.ply").read_bytes()
    for name in ("a.html", "b.html"):
        succeeds(*GOOD, "--report", name, "--overwrite")
    assert Path("a.html").read_bytes() == Path("b.html").read_bytes()
    assert Path("out.ply").read_bytes() == alone


@pytest.mark.usefixtures("_unrendered")
def test_a_cloud_that_goes_to_stdout() -> None:
    finished = succeeds("denoise", "good.ply", "-o", "-", "--report", "report.html")
    assert finished.stdout.startswith(b"ply\n")
    assert read_page(Path("report.html").read_text()).facts["output"] == ["-"]


#: Arguments, what the line says; status 2.
USAGE: dict[str, tuple[list[str], str]] = {
    "stdout": ([*GOOD, "--report", "-"], "--report needs the name of a file"),
    "over the input": (
        ["denoise", "good.html", "-o", "o.ply", "--report", "good.html", "--overwrite"],
        "--report names a file that is already read or written",
    ),
    "over the output": ([*GOOD, "--report", "./out.ply"], "--report names a file"),
    "over the log": (
        [*GOOD, "--report", "r.html", "--energy-log", "r.html"],
        "--report names a file",
    ),
    "log over the presets": (
        [
            *GOOD,
            "--polyhedron",
            "cube",
            "--presets",
            "p.toml",
            "--energy-log",
            "p.toml",
            "--overwrite",
        ],
        "--energy-log names a file",
    ),
    "log over the input": (
        [*GOOD, "--energy-log", "good.ply", "--overwrite"],
        "--energy-log names a file",
    ),
}

#: The file, what the line says; status 1.
REFUSALS: dict[str, tuple[str, str]] = {
    "exists": ("old.html", "exists.*--overwrite"),
    "folder": ("folder.html", "is a folder"),
    "no folder": ("none/r.html", "there is no folder"),
    "suffix": ("report.pdf", r"suffix '\.pdf'.*use \.html"),
}


@pytest.mark.parametrize(("arguments", "cause"), USAGE.values(), ids=USAGE)
def test_usage(folder: Path, arguments: list[str], cause: str) -> None:
    before = snapshot(folder)
    check_line(command(*arguments), 2, cause)
    assert snapshot(folder) == before


@pytest.mark.parametrize(("name", "cause"), REFUSALS.values(), ids=REFUSALS)
def test_targets_are_checked_before_the_work(
    folder: Path, monkeypatch: pytest.MonkeyPatch, name: str, cause: str
) -> None:
    worked = fail_in_flow(AssertionError("worked"))
    monkeypatch.setattr(pcsmooth.files.denoise_file, "denoise_input", worked)
    before = snapshot(folder)
    finished = command(*GOOD, "--report", name)
    check_line(finished, 1, cause)
    assert finished.stderr.startswith(f"Error: {name}: ")
    assert snapshot(folder) == before


def test_a_missing_library_is_named_before_the_work(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = snapshot(folder)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    finished = command(*GOOD, "--report", "r.html")
    check_line(finished, 1, r"matplotlib.*; pip install 'pcsmooth\[plot\]'")
    assert snapshot(folder) == before
    succeeds(*GOOD)


@pytest.mark.slow
@pytest.mark.usefixtures("_unrendered")
def test_a_write_that_is_cut_off_leaves_the_old_page(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = os.replace

    def fail(source: str, target: str) -> None:
        if target.endswith(".html"):
            raise OSError(28, "No space left on device")
        replace(source, target)

    monkeypatch.setattr(os, "replace", fail)
    finished = command(*GOOD, "--report", "old.html", "--overwrite", "-q")
    check_line(finished, 1, "^Error: old.html: No space left")
    assert Path("old.html").read_bytes() == b"precious"
    assert not list(folder.glob(".pcsmooth-*"))


@pytest.mark.parametrize("option", ["--report", "--energy-log"])
def test_links_in_a_circle(option: str) -> None:
    Path("one.html").symlink_to("two.html")
    Path("two.html").symlink_to("one.html")
    finished = command(*GOOD, option, "one.html", "--overwrite")
    assert finished.status == 1
    assert finished.stderr == (
        "Error: one.html: Too many levels of symbolic links; check the disk and try again\n"
    )


def test_a_log_over_another_name_of_the_input() -> None:
    os.link("good.ply", "log.csv")
    finished = command(*GOOD, "--energy-log", "log.csv", "--overwrite")
    assert finished.status == 2
    assert "--energy-log names a file that is already read or written" in finished.stderr
