"""What every reader and writer must do, whatever the format; `format_kinds` has them all."""

from __future__ import annotations

import io
import os
import resource
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import pytest

from formats.chunked import (
    Change,
    check,
    check_reading,
    estimated,
    joined,
    modified,
    part_of,
    pieces,
    saved,
    unchanged,
)
from formats.format_kinds import COLORS, COMMENTS, FLOAT, KINDS, MARKS, Kind, intensities
from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats import (
    FORMATS,
    WRITTEN_FORMATS,
    WRITTEN_IN_PIECES,
    format_of,
    lost_in,
    naming_of,
    open_chunks,
    output_format,
    read_cloud,
    stored_positions,
    write_chunks,
    write_cloud,
    write_template,
)


def each(kinds: list[Kind]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("kind", kinds, ids=str)


every_kind = each(KINDS)
every_written_kind = each([kind for kind in KINDS if kind.is_written])
every_new_kind = each([kind for kind in KINDS if kind.keeps is not None])
every_kind_in_pieces = each([kind for kind in KINDS if kind.in_pieces])
every_kind_written_in_pieces = each([kind for kind in KINDS if kind.in_pieces and kind.is_written])


@pytest.fixture(autouse=True)
def _library(request: pytest.FixtureRequest) -> None:
    if "kind" in request.fixturenames and request.getfixturevalue("kind").library:
        pytest.importorskip(request.getfixturevalue("kind").library)


@pytest.fixture
def path(tmp_path: Path, kind: Kind) -> Path:
    """An example."""
    return saved(tmp_path, kind.example(kind.points), kind.format)


@pytest.fixture
def long_path(tmp_path: Path, kind: Kind) -> Path:
    """An example that is written in several parts."""
    return saved(tmp_path, kind.example(kind.many_points), kind.format)


@pytest.fixture
def _left_as_it_was(path: Path) -> Iterator[None]:
    """Neither the file of the test changes, nor is there another one in the end."""
    data = path.read_bytes()
    yield
    assert os.listdir(path.parent) == [path.name]
    assert path.read_bytes() == data


def written(cloud: PointCloud, format: str) -> bytes:
    stream = io.BytesIO()
    write_cloud(cloud, stream, format=format)
    return stream.getvalue()


def numbers(column: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """A column, which text formats have in words."""
    return column.astype(np.float64)


def test_every_format_is_tried() -> None:
    assert {kind.format for kind in KINDS} == set(FORMATS)
    assert {kind.format for kind in KINDS if kind.keeps is not None} == {*WRITTEN_FORMATS} - {"stl"}
    in_pieces = {kind.format for kind in KINDS if kind.in_pieces and kind.is_written}
    assert in_pieces == set(WRITTEN_IN_PIECES)
    for kind in KINDS:
        assert (kind.keeps is not None) <= kind.is_written


# --- reading


@every_kind
def test_rows_are_those_of_the_file(path: Path, kind: Kind) -> None:
    data = path.read_bytes()
    shouting = path.rename(path.with_name(path.name.upper()))
    for cloud in (read_cloud(shouting), read_cloud(io.BytesIO(data), format=kind.format)):
        np.testing.assert_array_equal(cloud.points, kind.points)
        assert cloud.points.dtype == np.float64
        assert cloud.points.flags.c_contiguous
        assert cloud.dimension == kind.dimension
        if kind.column:
            found = numbers(cloud.columns[kind.column])
            np.testing.assert_array_equal(found, intensities(len(cloud)))
        assert {len(column) for column in cloud.columns.values()} <= {len(cloud)}
        assert cloud.warnings == ()
    assert format_of(str(shouting), data) == kind.format


@every_kind
def test_few_points(tmp_path: Path, kind: Kind) -> None:
    for count in (0, kind.corners):
        cloud = read_cloud(saved(tmp_path, kind.example(kind.points[:count]), kind.format))
        np.testing.assert_array_equal(cloud.points, kind.points[:count])
        if kind.is_written:
            again = read_cloud(io.BytesIO(written(cloud, kind.format)), format=kind.format)
            np.testing.assert_array_equal(again.points, kind.points[:count])
            assert list(again.columns) == list(cloud.columns)


@every_kind
def test_a_cloud_in_space_may_be_read_as_a_plane_one(path: Path, kind: Kind) -> None:
    cloud = read_cloud(path, dim=2)
    np.testing.assert_array_equal(cloud.points, kind.points[:, :2])
    if kind.height:
        np.testing.assert_array_equal(numbers(cloud.columns[kind.height]), kind.points[:, 2])
    if kind.is_written:
        again = read_cloud(io.BytesIO(written(cloud, kind.format)), format=kind.format)
        np.testing.assert_array_equal(again.points, kind.points)


@every_kind
def test_a_file_without_a_byte(tmp_path: Path, kind: Kind) -> None:
    path = saved(tmp_path, b"", kind.format)
    if not kind.empty:
        assert read_cloud(path).points.shape == (0, kind.dimension)
        return
    with pytest.raises(CloudFileError, match=kind.empty) as caught:
        read_cloud(path)
    assert caught.value.path == str(path)
    assert caught.value.remedy


@every_kind
def test_a_file_that_is_cut(path: Path, kind: Kind) -> None:
    """It is a cloud that begins as the whole one, or an error that names it."""
    data = path.read_bytes()
    ends = {*np.linspace(0, len(data), 24, endpoint=False, dtype=int).tolist()}
    for end in sorted(ends | set(range(len(data) - 8, len(data)))):
        path.write_bytes(data[:end])
        found = outcome(read_cloud, path)
        if isinstance(found, np.ndarray):
            assert len(found) <= len(kind.points)
            if len(found) > 1:  # the last row may be cut, which sets the columns if it is alone
                np.testing.assert_array_equal(found[:-1], kind.points[: len(found) - 1])
        if kind.in_pieces:
            np.testing.assert_equal(outcome(read_in_pieces, path), found)


def outcome(read: Callable[[Path], PointCloud], path: Path) -> npt.NDArray[np.float64] | str:
    """Read a file: its points, or what is said of it."""
    try:
        return read(path).points
    except CloudFileError as caught:
        error = caught
    assert error.path == str(path)
    assert str(error) == f"{path}: {error.cause}; {error.remedy}"
    assert error.cause.isprintable()
    assert error.remedy.isprintable()
    return str(error)


def read_in_pieces(path: Path) -> PointCloud:
    with open_chunks(path) as chunks:
        return joined(chunks.read(5), chunks.template)


# --- writing


@every_written_kind
@pytest.mark.parametrize("code", ["as it was", "f4", "f8"])
def test_what_is_written_is_read_again(path: Path, kind: Kind, code: str) -> None:
    cloud = read_cloud(path)
    assert lost_in(cloud, kind.format) == []
    own = cloud.position_type if code == "as it was" else np.dtype(code)
    moved = replace(cloud, points=cloud.points / 3, position_type=own)
    write_cloud(moved, path)
    assert path.read_bytes() == written(moved, kind.format)
    again = read_cloud(path)
    stored = stored_positions(moved, kind.format, "a").points
    # Of a float, text has no more digits than tell it from others.
    np.testing.assert_array_equal(again.points.astype(own), stored.astype(own))
    rounding = max(kind.rounding, FLOAT if code == "f4" else 0.0)
    np.testing.assert_allclose(stored, moved.points, rtol=0.0, atol=rounding)
    assert list(again.columns) == list(cloud.columns)
    for name, column in cloud.columns.items():
        assert again.columns[name].dtype == column.dtype
        np.testing.assert_array_equal(again.columns[name], column)
    assert again.comments == cloud.comments
    assert again.position_type == cloud.position_type or code != "as it was"
    assert written(again, kind.format) == path.read_bytes()


def new_cloud(kind: Kind) -> PointCloud:
    """A cloud that is not from a file, with one of each that a cloud may have."""
    n = len(kind.points)
    rng = np.random.default_rng(5)
    normals = rng.normal(size=kind.points.shape)
    normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
    lists = np.empty(n, object)
    lists[:] = [np.arange(row % 3) for row in range(n)]
    columns: dict[str, npt.NDArray[Any]] = {
        f"n{axis}": values for axis, values in zip("xyz", normals.T, strict=False)
    }
    shades = np.linspace(0, 255, n).astype("u1")
    columns |= {name: rng.permutation(shades) for name in sorted(COLORS)}
    columns |= {"k1": rng.normal(size=n), "near": lists}
    return PointCloud(kind.points, columns, comments=("new",), fixed_marks=np.arange(n) % 3 == 0)


@every_new_kind
def test_of_a_new_cloud_all_comes_back_but_what_is_said_to_be_lost(
    tmp_path: Path, kind: Kind
) -> None:
    cloud, path = new_cloud(kind), tmp_path / f"A.{kind.format.upper()}"
    write_cloud(cloud, path)
    assert path.read_bytes() == written(cloud, kind.format)
    again = read_cloud(path)
    stored = stored_positions(cloud, kind.format, "a").points
    np.testing.assert_array_equal(again.points, stored)
    np.testing.assert_allclose(stored, cloud.points, rtol=0.0, atol=kind.new_rounding)

    kept = {name for name in cloud.columns if name in again.columns}
    for name in kept - COLORS - {"near"}:
        np.testing.assert_array_equal(numbers(again.columns[name]), cloud.columns[name])
    for name in kept & COLORS:  # which may be bytes, of 16 bits or shares
        found = numbers(again.columns[name])
        np.testing.assert_allclose(255 * found / found.max(), cloud.columns[name], atol=1e-3)
    for name in kept & {"near"}:
        for mine, theirs in zip(again.columns[name], cloud.columns[name], strict=True):
            np.testing.assert_array_equal(mine, theirs)
    if again.comments:
        assert again.comments == cloud.comments
        kept.add(COMMENTS)
    marks = again.columns.get("fixed") if again.fixed_marks is None else again.fixed_marks
    if marks is not None:
        np.testing.assert_array_equal(marks, cloud.fixed_marks)
        kept.add(MARKS)

    assert frozenset(kept) == kind.keeps
    lost = [
        phrase.split("'")[1] if "'" in phrase else phrase  # of a column its name
        for phrase in lost_in(cloud, kind.format)
    ]
    assert sorted(lost) == sorted({*cloud.columns, COMMENTS, MARKS} - kept)


@every_new_kind
@pytest.mark.parametrize("count", [0, 1])
def test_new_clouds_of_few_points(kind: Kind, count: int) -> None:
    once = written(PointCloud(kind.points[:count]), kind.format)
    again = read_cloud(io.BytesIO(once), format=kind.format)
    np.testing.assert_allclose(again.points, kind.points[:count], rtol=0.0, atol=kind.new_rounding)
    assert again.dimension == kind.dimension
    assert written(again, kind.format) == once


@every_written_kind
@pytest.mark.parametrize("code", [np.int8, np.uint64, np.float16, np.float32, np.longdouble])
def test_points_of_other_types_are_written(path: Path, kind: Kind, code: type) -> None:
    whole: Any = np.arange(kind.points.size).reshape(kind.points.shape).astype(code)
    cloud = PointCloud(whole) if kind.keeps is not None else replace(read_cloud(path), points=whole)
    write_cloud(cloud, path)
    again = read_cloud(path)
    np.testing.assert_array_equal(again.points, whole.astype(np.float64))
    stored = stored_positions(cloud, kind.format, "a").points
    np.testing.assert_array_equal(again.points, stored)


@every_written_kind
def test_points_that_are_not_finite_keep_their_rows_or_are_refused(path: Path, kind: Kind) -> None:
    cloud = read_cloud(path)
    points = cloud.points.copy()
    points[3] = np.nan
    points[7, 1] = -np.inf
    odd = replace(cloud, points=points)
    if kind.only_finite:
        data = path.read_bytes()
        with pytest.raises(CloudFileError, match="point 4 is not finite") as caught:
            write_cloud(odd, path)
        assert caught.value.path == str(path)
        assert os.listdir(path.parent) == [path.name]
        assert path.read_bytes() == data
        return
    write_cloud(odd, path)
    np.testing.assert_array_equal(read_cloud(path).points, points)


@every_written_kind
def test_output_may_be_the_input(path: Path, kind: Kind) -> None:
    for cloud in (read_cloud(path), replace(read_cloud(path), points=kind.points / 3)):
        expected = written(cloud, kind.format)
        write_cloud(cloud, path)
        assert path.read_bytes() == expected
    assert os.listdir(path.parent) == [path.name]


@contextmanager
def room_for(size: int) -> Iterator[None]:
    """Have the system refuse the bytes of a file after so many."""
    before, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (before, most))


def write_in_pieces(cloud: PointCloud, path: Path) -> None:
    write_chunks(path, cloud, len(cloud), pieces(cloud, 100))


@pytest.mark.parametrize(
    ("kind", "write"),
    [
        pytest.param(kind, write, id=f"{kind}{' in pieces' * (write is write_in_pieces)}")
        for kind in KINDS
        for write in (write_cloud, write_in_pieces)
        if kind.is_written and (kind.in_pieces or write is write_cloud)
    ],
)
@pytest.mark.parametrize("missing", [0.5, 1])
def test_a_disk_that_is_full(
    long_path: Path, kind: Kind, write: Callable[[PointCloud, Path], None], missing: float
) -> None:
    data = long_path.read_bytes()
    cloud = replace(read_cloud(long_path), points=kind.many_points / 3, columns={})
    size = len(written(cloud, kind.format))
    with (
        room_for(size - int(missing if missing >= 1 else missing * size)),
        pytest.raises(CloudFileError, match="File too large; check the disk") as caught,
    ):
        write(cloud, long_path)
    assert caught.value.path == str(long_path)
    assert os.listdir(long_path.parent) == [long_path.name]
    assert long_path.read_bytes() == data
    with room_for(size):
        write(cloud, long_path)


@each([kind for kind in KINDS if not kind.is_written])
def test_a_format_that_can_only_be_read(tmp_path: Path, kind: Kind) -> None:
    cloud, name = PointCloud(kind.points), f"a.{kind.format}"
    message = rf"\.{kind.format} can be read but not written; use one of \.ply, "
    with pytest.raises(CloudFileError, match=f"^{name}: {message}"):
        output_format(name)
    with pytest.raises(CloudFileError, match=message):
        write_cloud(cloud, tmp_path / name)
    with pytest.raises(CloudFileError, match=message):
        write_chunks(tmp_path / name, cloud, len(cloud), [cloud])
    with pytest.raises(CloudFileError, match=f"^<stdout>: {message}"):
        write_cloud(cloud, io.BytesIO(), format=kind.format)
    assert os.listdir(tmp_path) == []


# --- piece by piece


@each([kind for kind in KINDS if not kind.in_pieces])
def test_a_format_that_is_read_and_written_at_once_only(path: Path, kind: Kind) -> None:
    cause = "it is a mesh, which cannot be read piece by piece"
    with pytest.raises(CloudFileError, match=f"{cause}; convert it to PLY first$") as caught:
        open_chunks(path)
    assert caught.value.path == str(path)
    if kind.is_written:
        cloud = PointCloud(kind.points)
        target = path.with_name(f"out.{kind.format}")
        cause = f"{kind.format} files cannot be written piece by piece"
        with pytest.raises(CloudFileError, match=f"{cause}; write .ply instead$") as caught:
            write_chunks(target, cloud, len(cloud), [cloud])
        assert caught.value.path == str(target)
        assert os.listdir(path.parent) == [path.name]


@every_kind_in_pieces
@pytest.mark.parametrize("dim", ["auto", 2])
@pytest.mark.parametrize("rows", [1, 7, 10**15])
def test_pieces_are_read_as_all_at_once(
    path: Path, kind: Kind, rows: int, dim: Literal["auto", 2]
) -> None:
    check_reading(path, rows, dim)


@every_kind_in_pieces
def test_pieces_of_no_points(tmp_path: Path, kind: Kind) -> None:
    check_reading(saved(tmp_path, kind.example(kind.points[:0]), kind.format), 7, "auto")


CHANGES: dict[str, Callable[[Kind], Change]] = {
    "as it is": lambda _kind: unchanged,
    "modified": lambda _kind: modified,
    "with estimates": lambda kind: partial(estimated, naming=naming_of(kind.format)),
}


@every_kind_written_in_pieces
@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize(("rows", "dim"), [(1, 2), (7, "auto"), (10**15, "auto")])
def test_pieces_are_the_same_as_all_at_once(
    path: Path, kind: Kind, change: str, rows: int, dim: Literal["auto", 2]
) -> None:
    check(path, rows, dim, CHANGES[change](kind))


@every_kind_written_in_pieces
@pytest.mark.parametrize(("rows", "dimension"), [(1, 3), (5, 2), (1000, 3)])
def test_pieces_of_a_new_cloud(tmp_path: Path, kind: Kind, rows: int, dimension: int) -> None:
    cloud, path = new_cloud(kind), tmp_path / f"a.{kind.format}"
    cloud = replace(cloud, points=cloud.points[:, :dimension])
    del cloud.columns["near"]
    none = part_of(cloud, slice(0))
    for template in (write_template(path, none, pieces(cloud, rows)), cloud):
        write_chunks(path, template, len(cloud), [none, *pieces(cloud, rows), none])
        assert path.read_bytes() == written(cloud, kind.format)


@every_kind_written_in_pieces
def test_pieces_of_the_file_that_is_written(path: Path, kind: Kind) -> None:
    expected = written(modified(read_cloud(path)), kind.format)
    with open_chunks(path) as chunks:
        write_chunks(path, modified(chunks.template), chunks.count, map(modified, chunks.read(5)))
        assert path.read_bytes() == expected
        assert sum(map(len, chunks.read(5))) == len(kind.points)  # still the old one
    assert os.listdir(path.parent) == [path.name]


@every_kind_written_in_pieces
def test_pieces_through_a_pipe(path: Path, kind: Kind) -> None:
    expected = written(read_cloud(path), kind.format)
    pipe = path.with_name(f"pipe.{kind.format}")
    os.mkfifo(pipe)
    got: list[bytes] = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    reader.start()
    with open_chunks(path) as chunks:
        write_chunks(pipe, chunks.template, chunks.count, chunks.read(5))
    reader.join()
    assert got == [expected]


@every_kind_in_pieces
def test_two_readings_at_the_same_time(long_path: Path, kind: Kind) -> None:
    with open_chunks(long_path) as chunks:
        rows = iter(kind.many_points)
        for one, other in zip(chunks.read(700), chunks.read(700, columns=False), strict=True):
            np.testing.assert_array_equal(one.points, other.points)
            np.testing.assert_array_equal(one.points, [next(rows) for _ in one.points])
    with pytest.raises((ValueError, CloudFileError), match="closed file"):
        next(chunks.read(1))


@every_kind_in_pieces
@pytest.mark.parametrize("rows", [0, -1])
def test_pieces_without_points(path: Path, kind: Kind, rows: int) -> None:
    with (
        open_chunks(path) as chunks,
        pytest.raises(InvalidInputError, match="1 point or more"),
    ):
        chunks.read(rows)


@every_kind_in_pieces
@pytest.mark.parametrize("missing", [9, 0.5])
def test_a_file_that_shrinks_meanwhile(long_path: Path, kind: Kind, missing: float) -> None:
    size = long_path.stat().st_size
    with open_chunks(long_path) as chunks:
        os.truncate(long_path, size - int(missing if missing >= 1 else missing * size))
        with pytest.raises(CloudFileError, match="has changed while it was read") as caught:
            list(chunks.read(700))
    assert caught.value.path == str(long_path)


@every_kind_written_in_pieces
@pytest.mark.parametrize("target", ["in", "out"])
@pytest.mark.usefixtures("_left_as_it_was")
class TestPiecesThatDoNotFit:
    """Everything stays as it was."""

    def check(
        self,
        path: Path,
        target: str,
        message: str,
        change: Change = unchanged,
        count: int = 12,
        template: Change = unchanged,
        error: type[BaseException] = InvalidInputError,
    ) -> None:
        with open_chunks(path) as chunks, pytest.raises(error, match=message):
            write_chunks(
                path.with_name(f"{target}{path.suffix}"),
                template(chunks.template),
                count,
                map(change, chunks.read(5)),
            )

    def test_number_of_points(self, path: Path, kind: Kind, target: str) -> None:
        self.check(path, target, "hold 2 fewer than the promised 14 points", count=14)
        self.check(path, target, "hold more than the promised 11 points", count=11)
        self.check(path, target, "cannot have -1 points", count=-1)

    def test_columns(self, path: Path, kind: Kind, target: str) -> None:
        for change in (modified, lambda cloud: replace(cloud, columns={})):
            d = kind.dimension
            self.check(path, target, f"a chunk in {d}D has .*; the file in {d}D has ", change)

    def test_length_of_a_column(self, path: Path, kind: Kind, target: str) -> None:
        def longer(cloud: PointCloud) -> PointCloud:
            return replace(cloud, columns={**cloud.columns, "more": np.zeros(9, np.uint8)})

        self.check(path, target, "column 'more' has 9 rows, the cloud has 5", longer)
        self.check(path, target, "has 9 rows, the cloud has 0", template=longer)

    def test_dimension(self, path: Path, kind: Kind, target: str) -> None:
        def flat(cloud: PointCloud) -> PointCloud:
            return replace(cloud, points=cloud.points[:, :2])

        if kind.dimension == 3:
            self.check(path, target, "a chunk in 2D has .*; the file in 3D", flat)

    @pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
    def test_interruption(
        self, path: Path, kind: Kind, target: str, error: type[BaseException]
    ) -> None:
        seen = 0

        def interrupted(cloud: PointCloud) -> PointCloud:
            nonlocal seen
            seen += len(cloud)
            if seen > 5:
                raise error("of the chunks")
            return cloud

        self.check(path, target, "^of the chunks$", interrupted, error=error)
