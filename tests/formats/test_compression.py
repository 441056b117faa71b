"""Compressed files: read and written as what they hold, or refused in bounded memory."""

from __future__ import annotations

import gzip
import io
import sys
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from formats.chunked import assert_same, joined, saved
from formats.format_kinds import KINDS, Kind
from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError, PcsmoothError
from pcsmooth.formats import open_chunks, output_format, read_cloud, write_chunks, write_cloud

SUFFIXES = ("gz", "zst")
POINTS = np.random.default_rng(5).normal(size=(50, 3))


def zstandard() -> Any:
    return pytest.importorskip("zstandard")


def packed(data: bytes, suffix: str) -> bytes:
    if suffix == "gz":
        return gzip.compress(data)
    compressed: bytes = zstandard().ZstdCompressor().compress(data)
    return compressed


def unpacked(data: bytes, suffix: str) -> bytes:
    if suffix == "gz":
        return gzip.decompress(data)
    with zstandard().ZstdDecompressor().stream_reader(io.BytesIO(data)) as reader:
        whole: bytes = reader.read()
    return whole


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_read_as_what_it_holds(tmp_path: Path, kind: Kind, suffix: str) -> None:
    if kind.library:
        pytest.importorskip(kind.library)
    data = kind.example(kind.points)
    plain = read_cloud(saved(tmp_path, data, kind.format))
    path = saved(tmp_path, packed(data, suffix), f"{kind.format}.{suffix}")
    assert_same(read_cloud(path), plain)
    if kind.in_pieces:
        with open_chunks(path) as chunks:
            assert_same(joined(chunks.read(5), chunks.template), plain)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("format", ["ply", "xyz", "csv", "las", "laz", "pcd", "obj"])
def test_written_as_it_would_be(tmp_path: Path, format: str, suffix: str) -> None:
    zstandard()
    cloud = PointCloud(POINTS)
    plain, path = tmp_path / f"out.{format}", tmp_path / f"out.{format}.{suffix}"
    write_cloud(cloud, plain)
    write_cloud(cloud, path)
    assert unpacked(path.read_bytes(), suffix) == plain.read_bytes()
    again = tmp_path / f"other.{format}.{suffix}"
    write_cloud(cloud, again)
    assert again.read_bytes() == path.read_bytes()  # neither name nor time is in it


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_written_in_pieces(tmp_path: Path, suffix: str) -> None:
    zstandard()
    cloud = PointCloud(POINTS)
    path = tmp_path / f"out.ply.{suffix}"
    write_chunks(path, cloud, 50, [PointCloud(POINTS[:20]), PointCloud(POINTS[20:])])
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format="ply")
    assert unpacked(path.read_bytes(), suffix) == buffer.getvalue()


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_in_a_stream_or_under_another_name(tmp_path: Path, suffix: str) -> None:
    data = packed(b"1 2 3\n4 5 6\n", suffix)
    expected = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    assert read_cloud(io.BytesIO(data)).points.tolist() == expected
    assert read_cloud(saved(tmp_path, data, "xyz")).points.tolist() == expected
    plain = saved(tmp_path, b"1 2 3\n4 5 6\n", f"xyz.{suffix}")  # its name only says so
    assert read_cloud(plain).points.tolist() == expected


def test_several_members_are_one_file(tmp_path: Path) -> None:
    for suffix in SUFFIXES:
        data = packed(b"1 2 3\n", suffix) + packed(b"4 5 6\n", suffix)
        assert len(read_cloud(saved(tmp_path, data, f"xyz.{suffix}"))) == 2


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("left", [5, 60, -3])
def test_cut_short(tmp_path: Path, suffix: str, left: int) -> None:
    text = "\n".join(" ".join(map(str, row)) for row in POINTS).encode()
    path = saved(tmp_path, packed(text, suffix)[:left], f"xyz.{suffix}")
    for read in (read_cloud, open_chunks):
        with pytest.raises(CloudFileError, match=r"damaged or cut short.*copy or download"):
            read(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_damaged(tmp_path: Path, suffix: str) -> None:
    data = packed(b"1 2 3\n" * 9, suffix) + b"behind"
    path = saved(tmp_path, data, f"xyz.{suffix}")
    with pytest.raises(CloudFileError, match="damaged or cut short"):
        read_cloud(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_bombs_are_refused_in_bounded_memory(tmp_path: Path, suffix: str) -> None:
    zeros = bytes(1 << 27)
    data = packed(zeros, suffix)
    path = saved(tmp_path, data * 4, f"xyz.{suffix}")
    tracemalloc.start()
    try:
        with pytest.raises(CloudFileError, match=r"more than 200 times as large.*unpack it by"):
            open_chunks(path)
        assert tracemalloc.get_traced_memory()[1] < 1 << 26
    finally:
        tracemalloc.stop()


def test_needs_a_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = saved(tmp_path, packed(b"1 2 3\n", "zst"), "xyz.zst")
    monkeypatch.setitem(sys.modules, "zstandard", None)
    for act in (lambda: read_cloud(path), lambda: output_format("out.ply.zst")):
        with pytest.raises(PcsmoothError, match=r"\.zst files need zstandard.*pcsmooth\[zst\]"):
            act()


def test_plain_files_need_no_temporary_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_arguments: Any) -> Any:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pcsmooth.formats.chunks.TemporaryFile", full)
    with open_chunks(saved(tmp_path, b"1 2 3\n4 5 6\n", "xyz")) as chunks:
        assert chunks.count == 2
    with pytest.raises(CloudFileError, match=r"(?i)no space left"):
        open_chunks(saved(tmp_path, gzip.compress(b"1 2 3\n"), "xyz.gz"))
