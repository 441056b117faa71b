"""Files that change while they are read, though their size stays."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cli.clouds import save_ply, save_text, sphere, vertices
from pcsmooth import CloudFileError, read_cloud
from pcsmooth.formats import open_chunks, registry
from pcsmooth.formats.cloud_file import CloudFile
from pcsmooth.formats.unchanged import Unchanged

CHANGED = "it has changed while it was read; run again when nothing writes it"


def rewrite(path: Path) -> None:
    """Change a byte in place, some time later."""
    before = path.stat().st_mtime_ns
    with open(path, "r+b") as file:
        file.write(b"P")
    os.utime(path, ns=(before, before + 1_000_000_000))


def rename(path: Path) -> None:
    """Put another file in its place that has the same size and time."""
    state = path.stat()
    other = path.with_name("other")
    other.write_bytes(path.read_bytes())
    os.utime(other, ns=(state.st_atime_ns, state.st_mtime_ns))
    other.replace(path)


def grow(path: Path) -> None:
    """Add a byte, and hide it."""
    state = path.stat()
    with open(path, "ab") as file:
        file.write(b"\n")
    os.utime(path, ns=(state.st_atime_ns, state.st_mtime_ns))


Change = Callable[[Path], None]
CHANGES: list[Change] = [rewrite, rename, grow, Path.unlink]


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    return save_ply(tmp_path / "scan.ply", vertices(sphere(50), "f8"))


@pytest.mark.parametrize("change", CHANGES)
def test_known_by_its_name(scan: Path, change: Change) -> None:
    unchanged = Unchanged(str(scan))
    unchanged.check()
    change(scan)
    with pytest.raises(CloudFileError, match=CHANGED):
        unchanged.check()


@pytest.mark.parametrize("change", CHANGES)
def test_open_it_may_lose_its_name(scan: Path, change: Change) -> None:
    with open(scan, "rb") as file:
        unchanged = Unchanged(str(scan), file)
        change(scan)
        if change in (rewrite, grow):
            with pytest.raises(CloudFileError, match=CHANGED):
                unchanged.check()
        else:
            unchanged.check()


def test_nothing_to_be_known_by(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    unchanged = Unchanged(str(tmp_path / "pipe"))
    os.utime(tmp_path / "pipe", ns=(0, 0))
    unchanged.check()
    Unchanged("memory", io.BytesIO()).check()


def test_missing(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        Unchanged(str(tmp_path / "none"))


@pytest.mark.parametrize("change", CHANGES)
def test_whole_clouds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: Change) -> None:
    """Some libraries open the file themselves, after its bytes were read."""
    scan = save_text(tmp_path / "scan.xyz", sphere(50))
    parse = registry.open_source

    def change_and_parse(*arguments: Any, **options: Any) -> CloudFile:
        change(scan)
        return parse(*arguments, **options)

    monkeypatch.setattr(registry, "open_source", change_and_parse)
    with pytest.raises(CloudFileError, match=rf"scan\.xyz: {CHANGED}"):
        read_cloud(scan)


@pytest.mark.parametrize("change", [rewrite, grow])
def test_pieces(scan: Path, change: Change) -> None:
    with open_chunks(scan) as chunks:
        assert sum(map(len, chunks.read(7))) == 50
        change(scan)
        with pytest.raises(CloudFileError, match=CHANGED):
            list(chunks.read(7))


@pytest.mark.parametrize("change", [rewrite, grow])
def test_between_two_pieces(scan: Path, change: Change) -> None:
    with open_chunks(scan) as chunks:
        pieces = chunks.read(7)
        first = next(pieces).points
        np.testing.assert_array_equal(first, read_cloud(scan).points[:7])
        change(scan)
        with pytest.raises(CloudFileError, match=CHANGED):
            list(pieces)
