"""Numbers without measure, in options and in files: one line that says what to do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cli.clouds import save_ply, save_text, sphere, vertices
from cli.commands import pcsmooth, succeeds


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    return save_ply(tmp_path / "scan.ply", vertices(sphere()))


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("--tile", "9" * 30, "is neither a number of points, nor auto, nor off"),
        ("--tile", "9" * 5000, "is neither a number of points, nor auto, nor off"),
        ("--support", "9" * 5000, "is neither a number of points, 3 or more, nor auto"),
        ("--threads", "9" * 5000, "is not a valid integer range"),
        ("--step", "9" * 5000, "is neither a positive number nor auto"),
    ],
)
def test_digits_without_end(scan: Path, option: str, value: str, message: str) -> None:
    finished = pcsmooth("denoise", scan, "-o", scan.with_name("out.ply"), option, value)
    assert finished.status == 2
    assert message in finished.stderr
    assert finished.stderr.count("\n") == 1


def test_a_tile_larger_than_any_cloud(scan: Path) -> None:
    finished = succeeds(
        "denoise", scan, "-o", scan.with_name("out.ply"), "--tile", "9" * 18, "--json"
    )
    assert finished.json["tiles"] == 1


def test_a_column_of_endless_number(tmp_path: Path) -> None:
    table = save_text(tmp_path / "table.txt", np.c_[sphere(), np.ones(len(sphere()))])
    finished = pcsmooth("denoise", table, "-o", tmp_path / "out.txt", "--fixed", "9" * 5000)
    assert finished.status == 1
    assert "to fix points by; choose one of" in finished.stderr


@pytest.mark.parametrize("option", ["--radius", "--noise", "--max-move"])
@pytest.mark.parametrize("value", ["1e-300", "1e300", "1e300x"])
def test_lengths_that_cannot_be_measured(scan: Path, option: str, value: str) -> None:
    finished = pcsmooth("denoise", scan, "-o", scan.with_name("out.ply"), option, value)
    name = option[2:].replace("-", "_")
    assert finished.status == 1
    assert finished.stderr.startswith(f"Error: {scan}: {name} '{value}' is ")
    assert finished.stderr.endswith(" for this cloud; give a length from 1e-103 to 1e+100\n")
    assert finished.stderr.count("\n") == 1


@pytest.mark.parametrize("scheme", ["euler", "implicit"])
@pytest.mark.parametrize("step", ["1e-300", "1e300"])
def test_steps_that_cannot_be_measured(scan: Path, scheme: str, step: str) -> None:
    for tile in ("off", "60"):
        finished = pcsmooth(
            "denoise", scan, "-o", scan.with_name("out.ply"), "--scheme", scheme, "--step", step,
            "--tile", tile,
        )  # fmt: skip
        assert finished.status == 1
        assert finished.stderr.startswith(f"Error: {scan}: step is 1e")
        assert finished.stderr.endswith(
            "and steps on this cloud go from 1e-103 to 1e+100; choose one of these\n"
        )


@pytest.mark.parametrize("exponent", [-140, -110, 110, 120, 149])
@pytest.mark.parametrize("command", ["denoise", "curvature", "info"])
def test_clouds_that_cannot_be_measured(tmp_path: Path, command: str, exponent: int) -> None:
    scan = save_ply(tmp_path / "scan.ply", vertices(sphere() * 10.0**exponent, "f8"))
    output = [] if command == "info" else ["-o", tmp_path / "out.ply"]
    for more in [[], ["--tile", "60"]] if command == "denoise" else [[]]:
        finished = pcsmooth(command, scan, *output, *more)
        assert finished.status == 1
        assert finished.stderr.startswith(f"Error: {scan}: lengths of ")
        assert finished.stderr.endswith(
            " are not between 1e-103 and 1e+100; give the cloud in another unit\n"
        )


@pytest.mark.parametrize("exponent", [-99, 99])
@pytest.mark.parametrize("command", ["denoise", "curvature", "info"])
def test_largest_and_smallest_clouds(tmp_path: Path, command: str, exponent: int) -> None:
    scan = save_ply(tmp_path / "scan.ply", vertices(sphere() * 10.0**exponent, "f8"))
    output = [] if command == "info" else ["-o", tmp_path / "out.ply"]
    spacing = "mean_spacing" if command == "info" else "spacing"
    finished = succeeds(command, scan, *output, "--json")
    one = save_ply(tmp_path / "one.ply", vertices(sphere(), "f8"))
    expected = succeeds(command, one, *output, *["--overwrite"][: len(output)], "--json")
    assert finished.json[spacing] / 10.0**exponent == pytest.approx(expected.json[spacing])
