"""What readers find amiss is said by every command, once for each file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cli.clouds import save_ply, sphere, vertices
from cli.commands import Finished, succeeds
from pcsmooth import PointCloud
from pcsmooth.formats import CloudChunks, open_chunks, read_cloud

AMISS = ("row 3 is odd", "row 7 is odd")


@pytest.fixture(autouse=True)
def _readers_that_warn(monkeypatch: pytest.MonkeyPatch) -> None:
    def read(*arguments: Any, **options: Any) -> PointCloud:
        return replace(read_cloud(*arguments, **options), warnings=AMISS)

    def opened(*arguments: Any) -> CloudChunks:
        chunks = open_chunks(*arguments)
        chunks.template = replace(chunks.template, warnings=AMISS)
        return chunks

    monkeypatch.setattr("pcsmooth.files.opening.read_cloud", read)
    monkeypatch.setattr("pcsmooth.files.opening.open_chunks", opened)


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    return save_ply(tmp_path / "scan.ply", vertices(sphere(), "f8"))


def said(finished: Finished, name: object) -> list[str]:
    lines = finished.stderr.splitlines()
    found = [line for line in lines if "warning:" in line]
    assert found == [f"{name}: warning: {warning}" for warning in AMISS] * (len(found) // 2)
    return found


@pytest.mark.parametrize("command", ["denoise", "curvature", "convert"])
def test_by_commands_that_write(tmp_path: Path, scan: Path, command: str) -> None:
    target = tmp_path / "out.ply"
    assert len(said(succeeds(command, scan, "-o", target), scan)) == 2
    assert succeeds(command, scan, "-o", target, "-q", "--overwrite").stderr == ""


def test_by_info(scan: Path) -> None:
    finished = succeeds("info", scan, "--json")
    assert len(said(finished, scan)) == 2
    assert finished.json["warnings"] == list(AMISS)


def test_of_stdin(scan: Path) -> None:
    assert len(said(succeeds("info", "-", stdin=scan.read_bytes()), "<stdin>")) == 2


def test_by_plot(tmp_path: Path, scan: Path) -> None:
    arguments = ("plot", scan, scan, "-o", tmp_path / "a.png")
    assert len(said(succeeds(*arguments), scan)) == 4


def test_in_tiles(tmp_path: Path, scan: Path) -> None:
    options = ("--scheme", "euler", "--iterations", "1", "--tile", "100")
    finished = succeeds("denoise", scan, "-o", tmp_path / "a.ply", *options)
    assert len(said(finished, scan)) == 2
    assert "tiles" in finished.stderr


@pytest.mark.parametrize("more", [(), ("-v",)])
def test_in_a_batch(tmp_path: Path, scan: Path, more: tuple[str, ...]) -> None:
    out = ("--output-dir", tmp_path / "out", "--overwrite")
    assert len(said(succeeds("denoise", scan.parent, *out, *more), scan)) == 2
    assert succeeds("denoise", scan.parent, *out, "-q").stderr == ""
