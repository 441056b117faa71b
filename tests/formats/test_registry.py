from __future__ import annotations

import io
import os
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pcsmooth.cli.options import WRITTEN_SUFFIXES
from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats import (
    FORMATS,
    WRITTEN_FORMATS,
    check_cloud,
    format_of,
    is_text,
    lost_in,
    naming_of,
    output_format,
    read_cloud,
    stored_positions,
    write_cloud,
)

POINTS = np.random.default_rng(3).normal(size=(20, 3))

PTX = b"1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3\n4 5 6\n"
MESH = b"""ply
format ascii 1.0
comment by hand
element vertex 1
property float x
property float y
property float z
property uchar red
property list uchar int near
element face 1
property list uchar int vertex_indices
end_header
1 2 3 255 2 7 8
3 0 0 0
"""


def test_help_names_every_suffix() -> None:
    assert WRITTEN_SUFFIXES.split() == [f".{name}" for name in WRITTEN_FORMATS]


def test_what_a_terminal_may_show() -> None:
    assert [name for name in FORMATS if is_text(name)] == ["xyz", "xy", "txt", "asc", "csv", "pts"]


@pytest.mark.parametrize("data", [MESH, b"1 2 3\n"])
def test_pipe(data: bytes) -> None:
    reading, writing = os.pipe()

    def feed() -> None:
        with open(writing, "wb") as file:
            file.write(data)

    with open(reading, "rb") as pipe:
        thread = threading.Thread(target=feed)
        thread.start()
        cloud = read_cloud(pipe)
        thread.join()
    assert cloud.points.tolist() == [[1, 2, 3]]


@pytest.mark.parametrize(
    ("path", "head", "expected"),
    [
        ("a.xyz", b"ply\n", "ply"),
        ("a", b"ply\r\n", "ply"),
        (None, b"ply\n", "ply"),
        ("a.ply", b"1 2 3", "ply"),
        ("a.dat", b"1 2 3", "txt"),
        (None, b"plywood 1", "txt"),
        ("a.ply.csv", b"", "csv"),
        ("a.xyz", b"LASF" + bytes(200), "las"),
        ("a.las", b"LASF" + bytes(100) + b"\x86" + bytes(99), "laz"),
        (None, b"LASF", "las"),
        (None, b"# .PCD v.7 - Point Cloud Data file format\n", "pcd"),
        (None, b"# by hand\n\nVERSION .7\nFIELDS", "pcd"),
        (None, b"# VERSION 0.7\n1 2 3\n", "txt"),
        (None, b"ASTM-E57\1\0", "e57"),
        (None, PTX, "ptx"),
        ("a.xyz", PTX.replace(b"\n", b"\r\n\r\n"), "ptx"),
        (None, PTX.replace(b"2\n", b"2.5\n"), "txt"),
        (None, b"OFF\n3 1 0\n", "off"),
        (None, b"# c\n\nCOFF 3 1 0\n", "off"),
        (None, b"OFFSET 1\n", "txt"),
        (None, b"solid cube\n facet normal 0 0 1\n", "stl"),
        ("a.txt", b"solid ground\n", "txt"),
        ("a.stl", bytes(100), "stl"),
        ("A.OBJ", b"v 0 0 0\n", "obj"),
    ],
)
def test_format_of(path: str | None, head: bytes, expected: str) -> None:
    assert format_of(path, head) == expected


def test_content_wins_over_suffix(tmp_path: Path) -> None:
    (tmp_path / "a.xyz").write_bytes(MESH)
    assert read_cloud(tmp_path / "a.xyz").points.tolist() == [[1, 2, 3]]


def test_output_format() -> None:
    text = read_cloud(io.BytesIO(b"1 2 3\n"), format="xyz")
    assert output_format(None, text) == "xyz"
    assert output_format(None, PointCloud(POINTS)) == "ply"
    assert output_format(None) == "ply"
    assert output_format("a.csv", text) == "csv"
    assert output_format("a.dat", text, "pts") == "pts"
    assert output_format(None, read_cloud(io.BytesIO(MESH))) == "ply"
    off = read_cloud(io.BytesIO(b"OFF\n1 0 0\n1 2 3\n"))
    assert output_format(None, off) == "off"
    with pytest.raises(CloudFileError, match=r"a\.dat: its suffix .*; use one of \.ply, \.xyz"):
        output_format("a.dat")


def test_unknown_names() -> None:
    cloud = PointCloud(POINTS)
    for call in (
        lambda: read_cloud(io.BytesIO(), format="gltf"),
        lambda: write_cloud(cloud, io.BytesIO(), format="gltf"),
        lambda: lost_in(cloud, "gltf"),
        lambda: naming_of("gltf"),
        lambda: check_cloud(cloud, "gltf", "a"),
        lambda: stored_positions(cloud, "gltf", "a"),
    ):
        with pytest.raises(InvalidInputError, match=r"format must be one of ply, .* not 'gltf'"):
            call()
    wrong: Any = 4
    with pytest.raises(InvalidInputError, match="dim must be 'auto', 2 or 3, not 4"):
        read_cloud(io.BytesIO(), dim=wrong)


def test_system_errors_name_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(error: OSError) -> Any:
        def fail(*args: object, **options: object) -> None:
            raise error

        return fail

    cloud = PointCloud(POINTS)
    with pytest.raises(CloudFileError, match=r"none\.ply: no such file") as caught:
        read_cloud(tmp_path / "none.ply")
    assert isinstance(caught.value.__cause__, FileNotFoundError)
    with pytest.raises(CloudFileError, match="no such file or folder"):
        write_cloud(cloud, tmp_path / "none" / "a.ply")
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(CloudFileError, match="a folder stands where"):
        read_cloud(tmp_path / "folder.ply")
    with pytest.raises(CloudFileError, match="a folder stands where"):
        write_cloud(cloud, tmp_path / "folder.ply")
    monkeypatch.setattr("builtins.open", refuse(PermissionError(13, "Permission denied")))
    with pytest.raises(CloudFileError, match="permission denied"):
        read_cloud(tmp_path / "a.ply")
    monkeypatch.setattr("builtins.open", refuse(OSError(28, "No space left on device")))
    with pytest.raises(CloudFileError, match="No space left on device; check the disk"):
        write_cloud(cloud, tmp_path / "a.ply")


class Sparing(io.RawIOBase):
    """A stream without a buffer, which takes little at a time and, in the end, nothing."""

    def __init__(self, most: int) -> None:
        self.taken = b""
        self._most = most

    def writable(self) -> bool:
        return True

    def write(self, data: Any, /) -> int:
        part = bytes(data)[: min(100, self._most - len(self.taken))]
        if not part:
            raise OSError(28, "No space left on device")
        self.taken += part
        return len(part)


@pytest.mark.parametrize("name", ["ply", "xyz", "pcd", "las", "laz"])
def test_streams_that_take_little_at_a_time_get_all(name: str) -> None:
    cloud = PointCloud(np.random.default_rng(1).normal(size=(2000, 3)))
    whole, sparing = io.BytesIO(), Sparing(10**9)
    write_cloud(cloud, whole, format=name)
    write_cloud(cloud, sparing, format=name)  # type: ignore[arg-type]
    assert sparing.taken == whole.getvalue()
    assert not sparing.closed
    for most in (0, 5000):
        with pytest.raises(CloudFileError, match="No space left on device"):
            write_cloud(cloud, Sparing(most), format=name)  # type: ignore[arg-type]


def test_reader_of_a_pipe_may_leave() -> None:
    class Closed(io.BytesIO):
        def write(self, data: object) -> int:
            raise BrokenPipeError

    with pytest.raises(BrokenPipeError):
        write_cloud(PointCloud(POINTS), Closed())


@pytest.mark.parametrize("name", ["ply", "csv"])
def test_failed_write_leaves_the_old_file(tmp_path: Path, name: str) -> None:
    path = tmp_path / f"a.{name}"
    path.write_bytes(b"old")
    unwritable = PointCloud(POINTS, {"c": np.full(20, 1j if name == "ply" else "\ud800")})
    with pytest.raises((CloudFileError, UnicodeEncodeError)):
        write_cloud(unwritable, path)
    assert [entry.read_bytes() for entry in tmp_path.iterdir()] == [b"old"]


@pytest.mark.parametrize("kind", [complex, object, str])
def test_points_that_are_no_real_numbers_are_not_written(tmp_path: Path, kind: type) -> None:
    cloud = PointCloud(POINTS.astype(kind))
    with pytest.raises(InvalidInputError, match="points are not real numbers, but of type "):
        write_cloud(cloud, tmp_path / "a.ply")
    assert list(tmp_path.iterdir()) == []


def test_what_is_masked_is_not_written(tmp_path: Path) -> None:
    masked = np.ma.masked_less(POINTS, np.median(POINTS))
    for message, cloud in {
        "points are masked; fill them": PointCloud(masked),
        "column 'height' is masked; fill it": PointCloud(POINTS, {"height": masked[:, 0]}),
    }.items():
        with pytest.raises(InvalidInputError, match=message):
            write_cloud(cloud, tmp_path / "a.ply")
    assert list(tmp_path.iterdir()) == []


def test_columns_of_another_length() -> None:
    with pytest.raises(InvalidInputError, match="column 'short' has 3 rows, the cloud has 20"):
        write_cloud(PointCloud(POINTS, {"short": np.ones(3)}), io.BytesIO())


def test_lost_in() -> None:
    mesh = read_cloud(io.BytesIO(MESH))
    assert lost_in(mesh, "ply") == []
    assert lost_in(mesh, "csv") == ["element 'face' (1 row)", "lists 'near'", "the comments"]
    assert lost_in(mesh, "xyz") == [
        "element 'face' (1 row)",
        "column 'red'",
        "lists 'near'",
        "the comments",
    ]
    text = read_cloud(io.BytesIO(b"# c\nx,y,z,id\n1,2,3,12345678901234567890\n"), format="csv")
    assert lost_in(text, "csv") == []
    assert lost_in(text, "xyz") == ["the comments", "the column names"]
    assert lost_in(text, "ply") == ["digits of the long numbers in column 'id'"]
    for number, lost in ((2**53 + 1, ["digits of the long numbers in column 'id'"]), (2**53, [])):
        long = PointCloud(np.zeros((1, 3)), {"id": np.array([number])})
        assert lost_in(long, "ply") == lost
        assert lost_in(long, "las") == lost_in(long, "pcd") == []


def test_lost_is_what_is_not_written() -> None:
    mesh = read_cloud(io.BytesIO(MESH))
    buffer = io.BytesIO()
    write_cloud(mesh, buffer, format="csv")
    assert buffer.getvalue() == b"x,y,z,red\n1.0,2.0,3.0,255\n"
    buffer = io.BytesIO()
    write_cloud(mesh, buffer, format="xyz")
    assert buffer.getvalue() == b"1.0 2.0 3.0\n"
