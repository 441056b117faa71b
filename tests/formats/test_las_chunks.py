"""LAS and LAZ read and written piece by piece: the same as all at once, in bounded memory."""

from __future__ import annotations

import io
import os
import struct
import tracemalloc
from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from formats.chunked import Change, Dim, check, estimated, part_of, pieces, saved, unchanged
from formats.damaged_las import BAD
from formats.las_files import GOOD, KINDS, LAZ, OLD, N, opaque_las, opened, random_las
from formats.las_files import saved as as_bytes
from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats import (
    check_cloud,
    open_chunks,
    read_cloud,
    stored_positions,
    write_chunks,
    write_cloud,
    write_template,
)
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.las.positions import LasLayout

BOTH = pytest.mark.parametrize("suffix", ["las", "laz"])


def with_bytes_that_are_not_described(n: int = N) -> bytes:
    data = as_bytes(random_las("1.2", 1, n, extras=False))
    (start,) = struct.unpack_from("<I", data, 96)
    rows = np.frombuffer(data[start:], np.uint8).reshape(n, 28)
    extra = np.random.default_rng(1).integers(0, 256, (n, 30), np.uint8)
    header = data[:105] + struct.pack("<H", 58) + data[107:start]
    return header + np.hstack([rows, extra]).tobytes()


@cache
def many(n: int) -> bytes:
    """A packed file of several chunks."""
    rng = np.random.default_rng(5)
    buffer = io.BytesIO()
    columns = {"gps_time": rng.random(n), "intensity": rng.integers(0, 99, n, np.uint16)}
    write_cloud(PointCloud(rng.random((n, 3)), columns), buffer, format="laz")
    return buffer.getvalue()


VARIANTS = {
    **{
        f"{version} format {number}{' packed' * packed}": as_bytes(
            random_las(version, number), packed=packed
        )
        for version, number in KINDS
        for packed in (False, True)
    },
    "opaque": opaque_las(24)[0],
    "opaque, not UTF-8": opaque_las(24, b"bl\xf6b")[0],
    "not described": with_bytes_that_are_not_described(),
    "none": as_bytes(random_las("1.4", 7, 0)),
    "none, not described": with_bytes_that_are_not_described(0),
    "none, packed": as_bytes(random_las("1.2", 3, 0), packed=True),
}  # fmt: skip


def moved(cloud: PointCloud) -> PointCloud:
    """Move some of the points, drop a column and add others, row by row."""
    step = 0.0149 * (cloud.points[:, :1] > 500_000.0)
    return replace(
        cloud,
        points=cloud.points + step,
        columns={
            **dict(list(cloud.columns.items())[1:]),
            "quality": cloud.points.sum(axis=1).astype(np.float32),
            "marked": cloud.points[:, 0] > 1,
            "nx": cloud.points[:, 0] / 3,
        },
        comments=(*cloud.comments, "modified"),
    )


# How points lie in pieces and in space is no matter of their kind.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("variant", "rows", "dim"),
    [
        *((variant, 7, "auto") for variant in VARIANTS),
        *(
            (variant, rows, dim)
            for variant in ("1.2 format 3", "1.4 format 7 packed", "opaque", "not described")
            for rows, dim in ((1, "auto"), (7, 2), (10**15, "auto"))
        ),
    ],
)
def test_same_as_all_at_once(tmp_path: Path, variant: str, rows: int, dim: Dim) -> None:
    las, laz = (saved(tmp_path, VARIANTS[variant], suffix) for suffix in ("las", "laz"))
    check(las, rows, dim, moved)
    check(laz, rows, dim, unchanged)
    check(laz, rows, dim, partial(estimated, naming="las"))


@pytest.mark.parametrize("variant", VARIANTS)
def test_layouts_of_chunks(tmp_path: Path, variant: str) -> None:
    path = saved(tmp_path, VARIANTS[variant], "las")
    whole = read_cloud(path).layout
    assert isinstance(whole, LasLayout)
    with open_chunks(path) as chunks:
        first = 0
        for chunk in chunks.read(7):
            layout = chunk.layout
            assert isinstance(layout, LasLayout)
            rows = slice(first, first + len(chunk))
            np.testing.assert_array_equal(layout.integers, whole.integers[rows])
            for mine, theirs in zip(layout.extras, whole.extras, strict=True):
                assert (mine.raw is None) == (theirs.raw is None)
                if mine.raw is not None and theirs.raw is not None:
                    np.testing.assert_array_equal(mine.raw, theirs.raw[rows])
            assert layout.first == first
            first += len(chunk)
    assert first == len(whole.integers)


@pytest.mark.parametrize("rows", [999, 50_000, 77_777])
def test_several_chunks_of_a_packed_file(tmp_path: Path, rows: int) -> None:
    path = saved(tmp_path, many(101_000), "laz")
    with open_chunks(path) as chunks:
        write_chunks(tmp_path / "out.laz", chunks.template, chunks.count, chunks.read(rows))
        parts = []
        for one, other in zip(chunks.read(rows), chunks.read(rows, columns=False), strict=True):
            np.testing.assert_array_equal(one.points, other.points)
            parts.append(one.points)
    assert (tmp_path / "out.laz").read_bytes() == path.read_bytes()
    np.testing.assert_array_equal(np.concatenate(parts), read_cloud(path).points)


def test_blocks_smaller_than_a_chunk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pcsmooth.formats.las.reader._AT_A_TIME", 300)
    for suffix, data in (("las", GOOD), ("laz", LAZ)):
        check(saved(tmp_path, data, suffix), 11, "auto", moved)


# ------------------------------------------------------------------ from files of other formats


def other_clouds() -> dict[str, PointCloud]:
    rng = np.random.default_rng(4)
    points = rng.normal(size=(N, 3)) * [300.0, 20.0, 1.0] + [5e5, 0.0, -3.0]
    flat = points.copy()
    flat[:, 2] = np.where(np.arange(N) % 3, 0.0, -0.0)
    colors = dict(
        zip(("red", "green", "blue"), rng.integers(0, 256, (3, N), np.uint8), strict=True)
    )
    return {
        "plain": PointCloud(points),
        "flat": PointCloud(flat),
        "one place": PointCloud(np.tile(points[:1], (N, 1))),
        "plane": PointCloud(points[:, :2]),
        "plane with heights": PointCloud(points[:, :2], {"z": points[:, 2]}),
        "columns": PointCloud(
            points, {**colors, "k1": rng.random(N), "classification": np.arange(N) % 9},
            comments=("one", "two"), fixed_marks=np.arange(N) % 2 == 0,
        ),
        "empty": PointCloud(np.empty((0, 3))),
    }  # fmt: skip


@BOTH
@pytest.mark.parametrize(
    ("name", "rows"), [*((name, 7) for name in other_clouds()), ("columns", 1), ("columns", 1000)]
)
def test_a_cloud_from_elsewhere(tmp_path: Path, name: str, rows: int, suffix: str) -> None:
    cloud = other_clouds()[name]
    whole, target = tmp_path / f"whole.{suffix}", tmp_path / f"chunks.{suffix}"
    write_cloud(cloud, whole)
    template = write_template(target, part_of(cloud, slice(0)), pieces(cloud, rows))
    write_chunks(target, template, len(cloud), pieces(cloud, rows))
    assert target.read_bytes() == whole.read_bytes()
    write_chunks(target, cloud, len(cloud), pieces(cloud, rows))  # the whole cloud has its steps
    assert target.read_bytes() == whole.read_bytes()
    expected = stored_positions(cloud, suffix, "a")
    found = [
        stored_positions(replace(piece, layout=template.layout), suffix, "a")
        for piece in pieces(cloud, rows)
    ]
    if found:
        np.testing.assert_array_equal(np.concatenate([f.points for f in found]), expected.points)
        assert {(f.kind, f.note) for f in found} == {(expected.kind, expected.note)}


def test_template_of_what_needs_none(tmp_path: Path) -> None:
    class Fail:
        def __iter__(self) -> Iterator[PointCloud]:
            raise AssertionError

    cloud = PointCloud(np.eye(3))
    assert write_template("a.ply", cloud, Fail()) is cloud
    with open_chunks(saved(tmp_path, GOOD, "las")) as chunks:
        assert write_template("a.laz", chunks.template, Fail()) is chunks.template
    with pytest.raises(CloudFileError, match="its suffix names no known format"):
        write_template("a.what", cloud, Fail())


def test_the_template_wants_all_its_columns(tmp_path: Path) -> None:
    cloud = PointCloud(np.eye(3), {"word": np.array(["1", "2", "3"])})
    with pytest.raises(InvalidInputError, match="a chunk has no column 'word' of the template"):
        write_template(tmp_path / "a.laz", cloud, [PointCloud(np.eye(3))])


def test_ply_becomes_las(tmp_path: Path) -> None:
    cloud = other_clouds()["columns"]
    path = tmp_path / "in.ply"
    write_cloud(cloud, path)
    whole = tmp_path / "whole.laz"
    write_cloud(read_cloud(path), whole)
    with open_chunks(path) as chunks:
        template = write_template("out.laz", chunks.template, chunks.read(7))
        write_chunks(tmp_path / "out.laz", template, chunks.count, chunks.read(7))
    assert (tmp_path / "out.laz").read_bytes() == whole.read_bytes()
    with open_chunks(whole) as chunks:
        write_chunks(tmp_path / "back.ply", chunks.template, chunks.count, chunks.read(7))
    write_cloud(read_cloud(whole), tmp_path / "whole.ply")
    assert (tmp_path / "back.ply").read_bytes() == (tmp_path / "whole.ply").read_bytes()


# --------------------------------------------------------------------------- what a header says


@pytest.mark.parametrize("rows", [1, 7, 1000])
def test_extremes_in_the_header(tmp_path: Path, rows: int) -> None:
    las = random_las("1.5", 7)
    las.points.array["gps_time"][::3] = np.nan
    las.points.array["gps_time"][1] = -np.inf
    data = bytearray(as_bytes(las))
    struct.pack_into("<d", data, 139, -0.001)  # a scale
    path = saved(tmp_path, bytes(data), "las")
    check(path, rows, "auto", unchanged)
    header = opened((tmp_path / "chunks.las").read_bytes()).header
    points, times = read_cloud(path).points, las.points.array["gps_time"]
    np.testing.assert_array_equal(header.mins, points.min(axis=0))
    np.testing.assert_array_equal(header.maxs, points.max(axis=0))
    assert (header.min_gps_time, header.max_gps_time) == (-np.inf, np.nanmax(times))


def test_times_that_are_no_numbers(tmp_path: Path) -> None:
    las = random_las("1.5", 7)
    las.points.array["gps_time"] = np.nan
    check(saved(tmp_path, as_bytes(las), "las"), 7, "auto", unchanged)


# ------------------------------------------------------------------------------ what goes wrong


@pytest.mark.parametrize(("data", "message"), BAD.values(), ids=BAD)
def test_bad_files(tmp_path: Path, data: bytes, message: str) -> None:
    path = saved(tmp_path, data, "las")
    with pytest.raises(CloudFileError, match=message if data[:3] != b"ply" else "PLY") as expected:
        read_cloud(path)
    with pytest.raises(CloudFileError) as caught, open_chunks(path) as chunks:
        list(chunks.read(7))
    assert str(caught.value) == str(expected.value)


@BOTH
def test_any_damage_is_seen_in_both_ways(tmp_path: Path, suffix: str) -> None:
    rng = np.random.default_rng(6)
    data = GOOD if suffix == "las" else LAZ
    for _ in range(100):
        damaged = bytearray(data)
        for place in rng.integers(4, int(rng.choice([400, len(data)])), 2):
            damaged[place] = rng.integers(0, 256)
        path = saved(
            tmp_path, bytes(damaged[: rng.integers(len(data) // 2, 2 * len(data))]), suffix
        )
        results = []
        for read in (read_all, read_in_chunks):
            try:
                results.append(read(path).tobytes())
            except CloudFileError as error:
                results.append(
                    bytes("failed" if "LazrsError" in str(error) else str(error), "utf8")
                )
        assert results[0] == results[1]


def read_all(path: Path) -> Any:
    return read_cloud(path).points


def read_in_chunks(path: Path) -> Any:
    with open_chunks(path) as chunks:
        parts = [chunks.template, *chunks.read(1000)]
        return np.concatenate([part.points for part in parts])


@pytest.mark.parametrize("columns", [True, False])
def test_compressed_points_that_are_damaged(tmp_path: Path, columns: bool) -> None:
    data = as_bytes(random_las("1.2", 0, 2000, extras=False), packed=True)
    path = saved(tmp_path, data, "laz")
    times = path.stat()
    with open_chunks(path) as chunks:
        with open(path, "r+b") as file:
            file.seek(struct.unpack_from("<I", data, 96)[0])
            file.write(struct.pack("<q", 5))  # where the list of chunks is
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))  # or it would be a changed file
        with pytest.raises(CloudFileError, match=r"in\.laz: cannot be read as LAS .*; get the"):
            list(chunks.read(7, columns))


@pytest.mark.parametrize(
    "error", [CloudFileError("a", "broken disk", "mend it"), KeyboardInterrupt()]
)
@pytest.mark.parametrize("opening", [True, False])
def test_disk_that_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, opening: bool
) -> None:
    """lazrs would say that something went wrong, but not what."""
    read = ByteSource.read
    failing = opening

    def fail(source: ByteSource, start: int, size: int) -> bytes:
        if failing and size > 2000:
            raise error
        return read(source, start, size)

    def read_all() -> None:
        nonlocal failing
        with open_chunks(path) as chunks:
            failing = True
            list(chunks.read(7))

    path = saved(tmp_path, LAZ, "laz")
    monkeypatch.setattr(ByteSource, "read", fail)
    with pytest.raises(type(error)) as caught:
        read_all()
    assert caught.value is error


class TestWritten:
    """What does not fit together leaves the folder as it was."""

    def check(
        self,
        folder: Path,
        error: type[BaseException],
        message: str,
        change: Change = unchanged,
        template: Change = unchanged,
    ) -> None:
        path = saved(folder, GOOD, "las")
        for name in ("in.las", "out.laz"):
            with open_chunks(path) as chunks:
                described, parts = template(chunks.template), map(change, chunks.read(7))
                with pytest.raises(error, match=message):
                    write_chunks(path.with_name(name), described, N, parts)
            assert os.listdir(folder) == ["in.las"]
            assert path.read_bytes() == GOOD

    def test_more_points_than_fit(self, tmp_path: Path) -> None:
        path = saved(tmp_path, OLD, "las")
        message = r"LAS 1\.2 has room for 4294967295 points, not 4294967296; write \.ply instead"
        with open_chunks(path) as chunks, pytest.raises(CloudFileError, match=message):
            write_chunks(path, chunks.template, 2**32, chunks.read(7))

    def test_points_that_cannot_be_held(self, tmp_path: Path) -> None:
        for value, words in ((np.nan, "not finite"), (1e9, "beyond the integers")):

            def change(cloud: PointCloud, value: float = value) -> PointCloud:
                points = cloud.points.copy()
                if isinstance(cloud.layout, LasLayout) and cloud.layout.first == 21:
                    points[3, 1] = value
                return replace(cloud, points=points)

            self.check(tmp_path, CloudFileError, f"point 25 is {words}", change)
            with open_chunks(saved(tmp_path, GOOD, "las")) as chunks:
                chunk = list(map(change, chunks.read(7)))[3]
                with pytest.raises(CloudFileError, match=rf"^a: point 25 is {words}"):
                    stored_positions(chunk, "las", "a")
        with (
            open_chunks(saved(tmp_path, GOOD, "las")) as chunks,
            pytest.raises(CloudFileError, match=r"^a: point 1 is not finite"),
        ):
            check_cloud(replace(next(chunks.read(1)), points=np.full((1, 3), np.inf)), "laz", "a")

    def test_values_that_do_not_fit(self, tmp_path: Path) -> None:
        def change(cloud: PointCloud) -> PointCloud:
            codes = np.full(len(cloud), 300)
            return replace(cloud, columns={**cloud.columns, "classification": codes})

        message = r"a chunk in 3D has .*classification_value \(1 int64\); the file in 3D has "
        self.check(tmp_path, InvalidInputError, message, change, template=change)

    def test_bytes_that_are_missing(self, tmp_path: Path) -> None:
        def other(cloud: PointCloud) -> PointCloud:
            return replace(cloud, layout=None)

        self.check(tmp_path, InvalidInputError, r"a chunk in 3D has ", other)

    def test_no_steps(self, tmp_path: Path) -> None:
        self.check(
            tmp_path,
            InvalidInputError,
            "need to know their steps before their points; make the template by write_template",
            template=lambda cloud: replace(cloud, layout=None),
        )

    def test_words(self, tmp_path: Path) -> None:
        def words(cloud: PointCloud) -> PointCloud:
            return replace(cloud, columns={"name": np.full(len(cloud), "tree")})

        self.check(tmp_path, CloudFileError, "column 'name' holds words", words, template=words)


@BOTH
def test_chunks_of_another_file(tmp_path: Path, suffix: str) -> None:
    """Steps are those of the template, whatever the chunks came in."""
    las = random_las("1.4", 7)
    las.header.offsets = np.array([500_001.0, 4_000_000.0, -10.0])
    las.points.offsets = las.header.offsets
    las.points.array["X"] //= 2
    other = saved(tmp_path, as_bytes(las), "las").rename(tmp_path / "other.las")
    template = read_cloud(saved(tmp_path, GOOD, "las"))
    whole, target = tmp_path / f"whole.{suffix}", tmp_path / f"out.{suffix}"
    with open_chunks(tmp_path / "in.las") as mine, open_chunks(other) as chunks:
        write_chunks(target, mine.template, N, chunks.read(7))
    again = read_cloud(other)
    assert isinstance(template.layout, LasLayout)
    assert isinstance(again.layout, LasLayout)
    write_cloud(replace(again, layout=replace(template.layout, extras=again.layout.extras)), whole)
    assert target.read_bytes() == whole.read_bytes()


@BOTH
def test_memory(tmp_path: Path, suffix: str) -> None:
    n, n_rows = 400_000, 10_000
    rng = np.random.default_rng(0)
    path = tmp_path / f"in.{suffix}"
    write_cloud(PointCloud(rng.random((n, 3)), {"gps_time": rng.random(n)}), path)
    size = path.stat().st_size
    before = path.read_bytes()
    tracemalloc.start()
    try:
        with open_chunks(path) as chunks:
            assert sum(map(len, chunks.read(n_rows, columns=False))) == n
            write_chunks(path, chunks.template, n, chunks.read(n_rows))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert path.read_bytes() == before
    assert peak < size / 2
