"""`pcsmooth experiments`."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from cli.clouds import DATA, save_text, sphere
from cli.commands import pcsmooth as command
from cli.commands import succeeds
from experiments.galleries import made_up, read_page
from pcsmooth.errors import InvalidInputError
from pcsmooth_experiments import catalogue

pytestmark = pytest.mark.slow

REPORT = DATA / "report"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An own folder, where there is no data."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def stand_ins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three quick experiments in place of the thesis', of which one fails."""
    failing = made_up("two", failure=InvalidInputError("it has no points"))
    monkeypatch.setattr(catalogue, "EXPERIMENTS", (made_up("one"), failing, made_up("three")))


def test_list() -> None:
    finished = succeeds("experiments", "--list")
    assert finished.stderr == ""
    lines = finished.stdout.decode().splitlines()
    assert [line.split()[0] for line in lines] == [e.name for e in catalogue.EXPERIMENTS]
    columns = set()
    for line, experiment in zip(lines, catalogue.EXPERIMENTS, strict=True):
        assert experiment.place in line
        assert line.endswith(experiment.title)
        columns.add(line.index(experiment.title))
    assert len(columns) == 1


def test_list_of_some() -> None:
    lines = succeeds("experiments", "noise", "corners", "--list").stdout.decode().splitlines()
    assert [line.split()[0] for line in lines] == ["corners", "noise"]


def test_two_of_the_report_s(folder: Path) -> None:
    finished = succeeds(
        "experiments", "energy-decrease", "segment", "--out", "new/gallery", "--data", REPORT
    )
    assert finished.stdout == b""
    first, second, last = finished.stderr.splitlines()
    assert first.startswith("segment: agrees in part. CV of the gaps")  # in the thesis' order
    assert second.startswith("energy-decrease: agrees. Area falls to")
    assert last == "wrote new/gallery/index.html"
    sections = read_page(folder / "new" / "gallery").by_anchor
    assert list(sections) == ["segment", "energy-decrease"]
    assert sections["segment"].paragraphs[2] in first
    assert (folder / "new" / "gallery" / "energy-log.csv").is_file()


def test_quiet() -> None:
    finished = succeeds("experiments", "segment", "--out", "g", "--data", REPORT, "-q")
    assert (finished.stdout, finished.stderr) == (b"", "")
    assert Path("g/index.html").is_file()


def test_data_is_looked_for_where_the_project_has_it(folder: Path) -> None:
    shutil.copytree(REPORT, folder / "data" / "report")
    succeeds("experiments", "segment", "--out", "g")
    assert Path("g/segment.png").is_file()


@pytest.mark.usefixtures("stand_ins")
def test_a_gallery_is_replaced_only_when_told_to(folder: Path) -> None:
    Path("g").mkdir()
    Path("g/index.html").write_text("precious")
    Path("g/one.png").write_text("precious too")
    Path("g/other.txt").write_text("not ours")
    finished = command("experiments", "one", "--out", "g", "--data", ".")
    assert finished.status == 1
    assert finished.stderr == (
        "Error: g/index.html: exists already; pass --overwrite to replace the gallery\n"
    )
    assert Path("g/index.html").read_text() == "precious"
    assert Path("g/one.png").read_text() == "precious too"
    succeeds("experiments", "one", "--out", "g", "--data", ".", "--overwrite")
    assert list(read_page(folder / "g").by_anchor) == ["one"]
    assert Path("g/one.png").read_bytes().startswith(b"\x89PNG")
    assert Path("g/other.txt").read_text() == "not ours"


@pytest.mark.usefixtures("stand_ins")
def test_a_folder_without_a_page_may_be_there() -> None:
    Path("g").mkdir()
    succeeds("experiments", "three", "--out", "g", "--data", ".")


@pytest.mark.usefixtures("stand_ins")
def test_one_that_fails_fails_the_command_in_the_end(folder: Path) -> None:
    finished = command("experiments", "--out", "g", "--data", ".")
    assert (finished.status, finished.stdout) == (1, b"")
    assert finished.stderr.splitlines() == [
        "one: agrees. Nothing: as reported.",
        "two: failed. it has no points",
        "three: agrees. Nothing: as reported.",
        "wrote g/index.html",
        "Error: 1 of 3 experiments failed (two); g/index.html says why",
    ]
    assert list(read_page(folder / "g").by_anchor) == ["one", "two", "three"]
    quiet = command("experiments", "--out", "g", "--data", ".", "-q", "--overwrite")
    assert (quiet.status, quiet.stderr.count("\n")) == (1, 1)


#: Arguments, exit status, what the message must say.
FAULTS = {
    "unknown": (["nose", "--out", "g", "--data", "."], 2,
                "there is no experiment 'nose'; use one of gradients-2d, ellipse-curvature,"),
    "unknown in list": (["noise", "nose", "--list"], 2, "there is no experiment 'nose'"),
    "no out": (["noise"], 2, "--out DIR says where to write; --list shows what there is; see"),
    "no data": (["noise", "--out", "g"], 1,
                "data/report: there is no such folder; name the folder of the thesis' clouds"),
    "data is a file": (["noise", "--out", "g", "--data", "file"], 1, "file: there is no such fol"),
    "out is a file": (["noise", "--out", "file", "--data", "."], 1, "file: is not a folder; choo"),
    "out is below a file": (["noise", "--out", "file/g", "--data", "."], 1, "file/g: "),
}  # fmt: skip


@pytest.mark.parametrize(("arguments", "status", "message"), FAULTS.values(), ids=FAULTS)
def test_faults(folder: Path, arguments: list[str], status: int, message: str) -> None:
    Path("file").write_text("precious")
    finished = command("experiments", *arguments)
    assert (finished.status, finished.stdout) == (status, b"")
    assert finished.stderr.startswith("Error: ")
    assert finished.stderr.count("\n") == 1
    assert message in finished.stderr
    assert [path.name for path in folder.iterdir()] == ["file"]
    assert Path("file").read_text() == "precious"


def test_without_matplotlib_nothing_is_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    finished = command("experiments", "segment", "--out", "g", "--data", REPORT)
    assert finished.status == 1
    assert "pictures need matplotlib" in finished.stderr
    assert "pip install 'pcsmooth[plot]'" in finished.stderr
    assert not Path("g").exists()


@pytest.mark.parametrize("arguments", [["--list"], ["nose"], ["segment", "--out", "g"]], ids=str)
def test_without_the_experiments_the_command_says_so(
    arguments: list[str], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pcsmooth_experiments", None)
    finished = command("experiments", *arguments)
    assert (finished.status, finished.stdout) == (1, b"")
    assert finished.stderr == (
        "Error: the experiments need the package pcsmooth_experiments, which is not installed; "
        "install all of pcsmooth\n"
    )
    assert list(folder.iterdir()) == []


#: Runs a command line where there are no experiments.
WITHOUT_EXPERIMENTS = """\
import sys
sys.modules["pcsmooth_experiments"] = None
from pcsmooth.cli.main import run
run()
"""


@pytest.mark.parametrize(
    ("arguments", "status"),
    [(["--help"], 0), (["denoise", "a.xyz", "-o", "b.xyz"], 0), (["experiments", "--list"], 1)],
    ids=["help", "denoise", "experiments"],
)
def test_all_else_works_without_the_experiments(arguments: list[str], status: int) -> None:
    save_text(Path("a.xyz"), sphere(100))
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_EXPERIMENTS, *arguments], capture_output=True, timeout=300
    )
    assert done.returncode == status, done.stderr
    assert b"Traceback" not in done.stderr
    assert Path("b.xyz").is_file() == ("denoise" in arguments)


def test_clouds_that_are_not_there_are_named() -> None:
    finished = command("experiments", "segment", "--out", "g", "--data", ".")
    assert finished.status == 1
    first = finished.stderr.splitlines()[0]
    assert first.startswith("segment: failed. line_fixed.xy: it is not there; name the folder")
