"""The table at the end of a batch."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from cli.clouds import save_ply, save_text, sphere, vertices
from cli.commands import Finished, pcsmooth
from pcsmooth.cli.batch_table import count_column, number_column, table_lines

COLUMNS = (count_column("points", "n"), number_column("noise", "s"))
SUMMARIES: list[dict[str, Any] | str] = [
    {"n": 12345, "s": 0.00123456},
    "failed",
    {"n": None, "s": None},
    {"n": 3, "s": float("nan")},
]
NAMES = ["a.ply", "folder/with/long/name.ply", "b\n.ply", "c.ply"]


def lines(width: int | None, warnings: tuple[int, ...] = (0, 0, 0, 0)) -> list[str]:
    return list(table_lines(NAMES, COLUMNS, SUMMARIES, [1.0, 0.0, 22.5, 0.1], warnings, width))


def test_columns_are_aligned() -> None:
    assert lines(None) == [
        "file                       points    noise  seconds",
        "a.ply                       12345  0.00123     1.00",
        "folder/with/long/name.ply  failed",
        "b\\n.ply                         -        -    22.50",
        "c.ply                           3        -     0.10",
    ]


def test_a_number_that_is_too_large_is_unknown() -> None:
    assert number_column("noise", "s").cell({"s": 10**400}) == "-"


def test_names_make_room() -> None:
    assert lines(40)[2] == "folder...e.ply  failed"
    assert all(len(line) <= 40 for line in lines(40))
    assert [len(line.split("  ")[0]) for line in lines(10)] == [4, 5, 12, 7, 5]
    assert lines(80) == lines(None)


def test_warnings_have_a_column_if_there_are_any() -> None:
    found = lines(None, (0, 1, 2, 0))
    assert found[0].endswith("  seconds  warnings")
    assert found[2].split()[1:] == ["failed", "1"]
    assert found[3].endswith("22.50         2")
    assert len(found[2]) == len(found[3])
    assert found[1] == lines(None)[1]


@pytest.fixture
def scans(tmp_path: Path) -> Path:
    folder = tmp_path / "scans"
    folder.mkdir()
    save_ply(folder / "far.ply", vertices(sphere() + 4e5, "f8"))
    save_text(folder / "near.xyz", sphere(70))
    (folder / "broken.xyz").write_text("x\n")
    return folder


def table_of(finished: Finished) -> list[str]:
    """The lines between the two that are empty."""
    return finished.stderr.split("\n\n")[1].splitlines()


@pytest.mark.parametrize(
    ("command", "titles"),
    [
        ("denoise", "points noise noise left moved outliers seconds warnings"),
        ("curvature", "points support median |H| without normal seconds warnings"),
        ("convert", "points format rounding seconds warnings"),
    ],
)
def test_what_commands_say(tmp_path: Path, scans: Path, command: str, titles: str) -> None:
    out = tmp_path / "out"
    finished = pcsmooth(command, scans, "--output-dir", out, "--float", "--json")
    head, *rows = table_of(finished)
    assert re.sub(r" +", " ", head) == f"file {titles}"
    assert [Path(row.split()[0]).name for row in rows] == ["broken.xyz", "far.ply", "near.xyz"]
    assert rows[0].split()[1] == "failed"
    assert rows[1].split()[-1] == "1"
    assert rows[2].split()[1] == "70"
    again = pcsmooth(command, scans, "--output-dir", out, "--float", "--skip-existing")
    assert "\n\n" not in again.stderr
    assert "2 skipped" in again.stderr
    assert pcsmooth(command, scans, "--output-dir", out, "-q").stderr.count("\n") == 4


def test_undo(tmp_path: Path, scans: Path) -> None:
    (scans / "broken.xyz").unlink()
    options = ("--write-displacement", "--suffix", ".ply")
    assert pcsmooth("denoise", scans, "--output-dir", tmp_path / "a", *options).status == 0
    head, *rows = table_of(pcsmooth("undo", tmp_path / "a", "--output-dir", tmp_path / "b"))
    assert head.split() == ["file", "points", "brought", "back", "seconds"]
    assert [row.split()[1] for row in rows] == ["150", "70"]
