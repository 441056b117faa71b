from __future__ import annotations

import contextlib
import datetime
import io
import re
import struct
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest

from formats.damaged_las import BAD
from formats.las_files import (
    EXTRA_TYPES,
    GOOD,
    KINDS,
    LAZ,
    OLD,
    N,
    changed,
    dimension,
    facts,
    opaque_las,
    opened,
    random_las,
    saved,
)
from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats import (
    check_cloud,
    lost_in,
    output_format,
    read_cloud,
    stored_positions,
    write_cloud,
)
from pcsmooth.formats.las.positions import LasLayout

PACKED = pytest.mark.parametrize("packed", [False, True], ids=["las", "laz"])
EVERY_KIND = pytest.mark.parametrize(("version", "point_format"), KINDS)


def read(data: bytes, **options: Any) -> PointCloud:
    return read_cloud(io.BytesIO(data), **options)


def written(cloud: PointCloud, format: str = "las") -> bytes:
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format=format)
    return buffer.getvalue()


def points_of(data: bytes) -> bytes:
    """All points of an uncompressed file as bytes."""
    las = opened(data)
    return bytes(las.points.array.tobytes())


@PACKED
@EVERY_KIND
def test_dimensions_are_those_of_laspy(version: str, point_format: int, packed: bool) -> None:
    las = random_las(version, point_format)
    cloud = read(saved(las, packed=packed))
    np.testing.assert_array_equal(cloud.points, np.asarray(las.xyz))
    assert cloud.position_type == np.float64
    standard = [name for name in las.point_format.standard_dimension_names if name not in "XYZ"]
    assert sorted(list(cloud.columns)[: len(standard)]) == sorted(standard)
    for name in (*standard, *(f"extra {code}" for code in EXTRA_TYPES), "amplitude"):
        np.testing.assert_array_equal(cloud.columns[name], dimension(las, name))
    for code in EXTRA_TYPES:
        assert cloud.columns[f"extra {code}"].dtype == code
    for name, count in (("pair", 2), ("triple", 3), ("both", 2)):
        for item in range(count):
            expected = dimension(las, name)[:, item]
            np.testing.assert_array_equal(cloud.columns[f"{name}_{item}"], expected)
    assert "blob" not in cloud.columns
    assert cloud.columns["amplitude"].std() > 0.0
    assert output_format(None, cloud) == ("laz" if packed else "las")


@EVERY_KIND
def test_what_is_not_changed_is_kept(version: str, point_format: int) -> None:
    data = saved(random_las(version, point_format))
    assert facts(written(read(data))) == facts(data)


@EVERY_KIND
def test_laz_holds_the_same_as_las(version: str, point_format: int) -> None:
    data = saved(random_las(version, point_format))
    packed = written(read(data), "laz")
    assert packed[104] == point_format | 0x80
    assert facts(packed) == facts(data)
    assert len(opened(packed).evlrs or []) == (version >= "1.4")
    assert facts(written(read(packed), "las")) == facts(data)


def test_records_that_laspy_would_reword_are_kept() -> None:
    las = random_las("1.4", 6)
    table = b"".join(bytes([code]) + b"low_vegetation ".ljust(15, b".") for code in range(3))
    contents = [b'PROJCS["none"]', table, b"\1\0\1\0\0\0\2\0" + bytes(range(9))]
    keys = [("LASF_Projection", 2112), ("LASF_Spec", 0), ("LASF_Projection", 34735)]
    named = [(*key, "\x7f" * 31, content) for key, content in zip(keys, contents, strict=True)]
    for record in named:
        far = ("far away", 5, "last", bytes(record[3][:2]))
        for records, each in ((las.header.vlrs, record), (las.evlrs, record), (las.evlrs, far)):
            records.append(laspy.VLR(*each))
    data = saved(las)
    layouts = [read(each).layout for each in (data, written(read(data)))]
    before, after = (
        [
            (record.user_id, record.record_id, record.description, record.record_data)
            for record in (*layout.records, *layout.extended)
        ]
        for layout in layouts
        if isinstance(layout, LasLayout)
    )
    assert before == after
    assert [record for record in after if record in named] == named * 2


def test_names_in_the_header_that_are_not_ascii() -> None:
    data = bytearray(saved(random_las("1.2", 3, extras=False)))
    data[58:90] = bytes(range(0xC0, 0xE0))
    data[90:94] = bytes(4)  # no date
    start = struct.unpack_from("<H", data, 94)[0]
    data[start + 22 : start + 54] = b"y\xff".ljust(32, b"z")
    again = written(read(bytes(data)))
    assert again[58:90] == data[58:90]
    layout = read(again).layout
    assert isinstance(layout, LasLayout)
    assert "y" + "z" * 30 in [record.description for record in layout.records]


def test_a_file_of_the_first_version() -> None:
    las = random_las("1.1", 0)
    data = changed(saved(las), 25, "B", 0)
    after = opened(written(read(data)))
    assert str(after.header.version) == "1.1"
    assert after.points.array.tobytes() == las.points.array.tobytes()


def test_points_that_only_readers_of_old_versions_see() -> None:
    data = changed(changed(GOOD, 247, "<Q", 0), 107, "<I", N)
    np.testing.assert_array_equal(read(data).points, read(GOOD).points)


def test_bytes_between_records_and_points_are_kept() -> None:
    data = saved(random_las("1.1", 0))
    (start,) = struct.unpack_from("<I", data, 96)
    gap = data[:96] + struct.pack("<I", start + 2) + data[100:start] + b"\xdd\xcc" + data[start:]
    assert facts(written(read(gap))) == facts(gap)


def test_bytes_that_are_not_described_are_kept() -> None:
    las = random_las("1.2", 1, extras=False)
    plain = saved(las)
    (start,) = struct.unpack_from("<I", plain, 96)
    rng = np.random.default_rng(1)
    rows = np.frombuffer(plain[start:], np.uint8).reshape(N, 28)
    extra = rng.integers(0, 256, (N, 300), np.uint8)
    data = plain[:105] + struct.pack("<H", 328) + plain[107:start]
    data += np.hstack([rows, extra]).tobytes()
    cloud = read(data)
    np.testing.assert_array_equal(cloud.points, np.asarray(las.xyz))
    assert facts(written(cloud)) == facts(data)
    more = replace(cloud, columns={**cloud.columns, "k1": np.arange(N, dtype="f4")})
    for format in ("las", "laz"):
        after = opened(written(more, format))
        assert after.points.array.dtype.itemsize == 332
        new = np.arange(N, dtype="<f4")[:, None].view(np.uint8)
        np.testing.assert_array_equal(
            after.points.array.view(np.uint8).reshape(N, 332), np.hstack([rows, new, extra])
        )
        np.testing.assert_array_equal(after["k1"], np.arange(N))


@pytest.mark.parametrize("n_bytes", [4, 8, 16, 24, 31, 255])
@pytest.mark.parametrize("name", [b"blob", b"bl\xf6b"])
def test_bytes_of_no_type_are_kept(n_bytes: int, name: bytes) -> None:
    data, described = opaque_las(n_bytes, name)
    cloud = read(data)
    assert [name for name in cloud.columns if name in ("before", "after")] == ["before", "after"]
    assert "blob" not in cloud.columns
    np.testing.assert_array_equal(cloud.columns["after"], np.arange(N))
    (start,) = struct.unpack_from("<I", data, 96)
    for packed in (cloud, read(written(cloud, "laz"))):
        after = written(packed)
        assert described in after
        (begin,) = struct.unpack_from("<I", after, 96)
        rows = N * (36 + n_bytes)
        assert after[begin : begin + rows] == data[start : start + rows]
    more = written(replace(cloud, columns={**cloud.columns, "k1": np.ones(N, "f4")}))
    again = read(more)
    assert list(again.columns)[-3:] == ["before", "after", "k1"]
    np.testing.assert_array_equal(again.columns["after"], np.arange(N))


def test_a_name_that_is_not_utf8() -> None:
    data = GOOD.replace(b"extra u1", b"extra \xe91")
    cloud = read(data)
    np.testing.assert_array_equal(cloud.columns["extra \ufffd1"], read(GOOD).columns["extra u1"])
    assert b"extra \xe91".ljust(32, b"\0") in written(cloud)


def calendar(year: int) -> type[datetime.date]:
    """Dates, of which today is in a year."""

    class Date(datetime.date):
        @classmethod
        def today(cls) -> Date:
            return cls(year, 2, 3)

    return Date


class TestWhatAFileSaysOfItsMaking:
    DAYS = [(0, 0), (1, 2020), (366, 2020), (366, 2021), (0, 2026), (65535, 0), (7, 65535)]  # noqa: RUF012

    @PACKED
    @pytest.mark.parametrize(("day", "year"), DAYS)
    def test_it_stays(self, day: int, year: int, packed: bool) -> None:
        for kind in (("1.1", 0), ("1.2", 3), ("1.4", 6)):
            data = bytearray(saved(random_las(*kind), packed=packed))
            data[4:6] = b"\7\1"
            data[8:24] = bytes(range(0x90, 0xA0))
            data[26:58] = b"a\0\xffb".ljust(32, b"c")
            data[58:90] = b"\xe9".rjust(32, b"s")
            struct.pack_into("<HH", data, 90, day, year)
            after = written(read(bytes(data)), "laz" if packed else "las")
            assert after[:94] == data[:94]

    @pytest.mark.parametrize("format", ["las", "laz"])
    def test_new_files_have_no_date(self, format: str) -> None:
        data = written(PointCloud(np.eye(3)), format)
        assert data[4:24] == b"\0\0" + b"\x10\0" + bytes(16)
        assert data[26:94] == 2 * b"pcsmooth".ljust(32, b"\0") + bytes(4)
        assert written(read(data), format) == data

    @pytest.mark.parametrize("format", ["las", "laz"])
    def test_files_do_not_depend_on_the_day(
        self, monkeypatch: pytest.MonkeyPatch, format: str
    ) -> None:
        undated = changed(GOOD, 90, "<HH", 0, 0)
        files = []
        for year in (2001, 2002):
            monkeypatch.setattr("laspy.header.date", calendar(year))
            assert laspy.LasHeader().creation_date.year == year
            clouds = (PointCloud(np.eye(3)), read(undated), read(GOOD))
            files.append([written(cloud, format) for cloud in clouds])
        assert files[0] == files[1]


def test_a_description_that_is_cut_short_is_left_out() -> None:
    data = OLD.replace(b"by hand".ljust(16, b"\0") + b"\x63", b"LASF_Spec".ljust(16, b"\0") + b"\4")
    assert read(data).columns.keys() == read(OLD).columns.keys()
    assert facts(written(read(data)))["points"] == facts(OLD)["points"]


@PACKED
def test_only_points_that_moved_get_other_integers(packed: bool) -> None:
    las = random_las("1.4", 7)
    las.header.offsets = np.array([0.1, 0.3, 1 / 3])
    las.points.offsets = las.header.offsets
    for name in "XYZ":
        las.points.array[name] %= 10_000_000
    cloud = read(saved(las))
    points = cloud.points.copy()
    points[[3, 8]] += [0.0149, -0.02, 0.0051]
    after = opened(written(replace(cloud, points=points), "laz" if packed else "las"))
    before = np.stack([las.X, las.Y, las.Z], axis=1)
    now = np.stack([after.X, after.Y, after.Z], axis=1)
    assert np.flatnonzero((now != before).any(axis=1)).tolist() == [3, 8]
    np.testing.assert_array_equal(now[[3, 8]] - before[[3, 8]], [[1, -20, 3]] * 2)
    expected = np.rint((points - las.header.offsets) / las.header.scales)
    np.testing.assert_array_equal(now, expected)
    np.testing.assert_allclose(after.header.maxs, np.asarray(after.xyz).max(axis=0), rtol=1e-15)
    np.testing.assert_allclose(after.header.mins, np.asarray(after.xyz).min(axis=0), rtol=1e-15)
    for name in ("intensity", "return_number", "overlap", "red", "gps_time", "blob"):
        np.testing.assert_array_equal(dimension(after, name), dimension(las, name))


def test_positions_that_are_stored() -> None:
    cloud = read(saved(random_las("1.2", 0)))
    moved = replace(cloud, points=cloud.points + 0.00123)
    moved = replace(moved, points=np.clip(moved.points, -1e6, 4.5e6))
    stored = stored_positions(moved, "laz", "a.laz")
    np.testing.assert_array_equal(stored.points, read(written(moved)).points)
    assert stored.kind == "LAS positions in steps of 0.01 0.001 0.002"
    assert stored.note == ""
    assert 0.0 < np.abs(stored.points - moved.points)[:, 0].max() <= 0.00501


def test_points_beyond_the_integers() -> None:
    cloud = read(saved(random_las("1.2", 0)))
    points = cloud.points.copy()
    points[7, 1] = 1e8
    message = (
        r"a\.las: point 8 is beyond the integers of 32 bits in steps of \[0\.01, 0\.001, 0\.002\] "
        r"from \[500000\.0, 4000000\.0, -10\.0\]; write \.ply instead"
    )
    far = replace(cloud, points=points)
    with pytest.raises(CloudFileError, match=message):
        stored_positions(far, "las", "a.las")
    with pytest.raises(CloudFileError, match="point 8 is beyond the integers"):
        written(far)


def test_the_last_integer_is_not_beyond() -> None:
    las = random_las("1.2", 0)
    las.points.array["X"][:2] = [-(2**31), 2**31 - 1]
    cloud = read(saved(las))
    moved = replace(cloud, points=cloud.points + [0.0, 0.0, 0.002] * (np.arange(N) < 2)[:, None])
    after = opened(written(moved))
    assert after.X[:2].tolist() == [-(2**31), 2**31 - 1]
    assert (after.Z - las.Z)[:3].tolist() == [1, 1, 0]


@pytest.mark.parametrize("format", ["las", "laz"])
def test_points_that_are_not_finite(format: str) -> None:
    points = np.zeros((4, 3))
    points[2, 1] = np.nan
    message = "point 3 is not finite, and LAS holds integers; write .ply instead, or remove the"
    for call in (
        lambda: check_cloud(PointCloud(points), format, "a"),
        lambda: stored_positions(PointCloud(points), format, "a"),
        lambda: written(PointCloud(points), format),
    ):
        with pytest.raises(CloudFileError, match=message):
            call()
    check_cloud(PointCloud(np.zeros((4, 3))), format, "a")


class TestColumns:
    def test_new_ones_become_extra_dimensions(self) -> None:
        las = random_las("1.3", 3)
        cloud = read(saved(las))
        columns = {"nx": np.linspace(-1, 1, N, dtype="f4"), "k1": np.arange(N, dtype="f8")}
        columns |= {"flag": np.arange(N) % 2 == 0, "ring": np.arange(N, dtype="i8")}
        after = opened(written(replace(cloud, columns={**cloud.columns, **columns})))
        before = list(las.point_format.extra_dimension_names)
        names = list(after.point_format.extra_dimension_names)
        assert names == [*before, "NormalX", "k1", "flag", "ring"]
        assert after.NormalX.dtype == np.float32
        np.testing.assert_array_equal(after.NormalX, columns["nx"])
        np.testing.assert_array_equal(after.k1, np.arange(N))
        np.testing.assert_array_equal(after.flag, columns["flag"])
        np.testing.assert_array_equal(after.ring, np.arange(N))
        for name in before:
            np.testing.assert_array_equal(dimension(after, name), dimension(las, name))
        again = read(written(replace(cloud, columns={**cloud.columns, **columns})))
        np.testing.assert_array_equal(again.columns["nx"], columns["nx"])

    @pytest.mark.parametrize("spelled", ["NormalX", "nx"])
    def test_normals_keep_their_name_and_type(self, spelled: str) -> None:
        las = random_las("1.2", 0, extras=False)
        las.add_extra_dim(laspy.ExtraBytesParams(spelled, "f8"))
        cloud = read(saved(las))
        new = np.full(N, 0.1, "f4")
        after = opened(written(replace(cloud, columns={**cloud.columns, "nx": new})))
        assert list(after.point_format.extra_dimension_names) == [spelled]
        assert after[spelled].dtype == np.float64
        np.testing.assert_array_equal(after[spelled], new.astype("f8"))

    def test_scaled_ones_that_changed(self) -> None:
        las = random_las("1.2", 0)
        cloud = read(saved(las))
        values = cloud.columns["amplitude"].copy()
        values[4] = 12.344
        after = opened(written(replace(cloud, columns={**cloud.columns, "amplitude": values})))
        raw = after.points.array["amplitude"]
        expected = las.points.array["amplitude"].copy()
        expected[4] = 734
        np.testing.assert_array_equal(raw, expected)

    def test_scaled_ones_that_are_no_numbers_stay(self) -> None:
        data = saved(random_las("1.2", 0))
        place = data.index(b"amplitude") - 4 + 136
        nans = changed(data, place, "<d", np.nan)
        cloud = read(nans)
        assert np.isnan(cloud.columns["amplitude"]).all()
        (start,) = struct.unpack_from("<I", data, 96)
        assert written(cloud).endswith(data[start:])
        assert list(read(written(cloud)).columns) == list(cloud.columns)

    def test_scaled_ones_that_do_not_fit_any_more(self) -> None:
        cloud = read(saved(random_las("1.2", 0)))
        values = np.linspace(0, 1e6, N)
        again = read(written(replace(cloud, columns={**cloud.columns, "amplitude": values})))
        np.testing.assert_array_equal(again.columns["amplitude"], values)
        assert list(again.columns)[-1] == "amplitude"

    def test_whole_ones_that_do_not_fit_any_more(self) -> None:
        cloud = read(saved(random_las("1.2", 0)))
        columns = {"extra u1": np.arange(N) * 100, "extra i2": np.full(N, 0.5)}
        again = read(written(replace(cloud, columns={**cloud.columns, **columns})))
        for name, values in columns.items():
            np.testing.assert_array_equal(again.columns[name], values)

    def test_dimensions_that_are_missing_are_left_out(self) -> None:
        cloud = read(saved(random_las("1.2", 3)))
        columns = {name: values for name, values in cloud.columns.items() if name != "triple_1"}
        del columns["intensity"]
        after = opened(written(replace(cloud, columns=columns)))
        assert not after.intensity.any()
        names = list(after.point_format.extra_dimension_names)
        assert "triple" not in names
        assert names[-2:] == ["triple_0", "triple_2"]

    def test_standard_dimensions_take_what_fits(self) -> None:
        columns: dict[str, Any] = {
            "intensity": np.arange(4, dtype="i8") * 20_000,
            "classification": np.array([2, 200, 3, 4], "u1"),
            "return_number": np.array([1, 2, 3, 15]),
            "scanner_channel": np.array([0, 1, 2, 4]),  # 2 bits
            "gps_time": np.array([0.5, 1.5, 2.5, 3.5], "f4"),
            "user_data": np.array(["1", "2", "3", "255"]),
            "point_source_id": np.array([0.5, 1, 2, 3]),
        }
        after = opened(written(PointCloud(np.eye(4, 3), columns)))
        for name in ("intensity", "classification", "return_number", "gps_time"):
            np.testing.assert_array_equal(dimension(after, name), columns[name])
        assert dimension(after, "user_data").tolist() == [1, 2, 3, 255]
        assert dimension(after, "number_of_returns").tolist() == [1] * 4
        assert after.header.number_of_points_by_return.tolist() == [1, 1, 1, *[0] * 11, 1]
        extras = ["scanner_channel_value", "point_source_id_value"]
        assert list(after.point_format.extra_dimension_names) == extras
        np.testing.assert_array_equal(after.scanner_channel_value, [0, 1, 2, 4])
        np.testing.assert_array_equal(after.point_source_id_value, [0.5, 1, 2, 3])

    def test_names_of_laspy_for_other_things(self) -> None:
        columns = {name: np.arange(3) for name in ("X", "bit_fields", "classification_flags", "0")}
        after = opened(written(PointCloud(np.eye(3), columns)))
        names = ["X_value", "bit_fields_value", "classification_flags_value", "0"]
        assert list(after.point_format.extra_dimension_names) == names
        assert [dimension(after, name).tolist() for name in names] == [[0, 1, 2]] * 4

    def test_what_is_said_of_extra_dimensions_is_kept(self) -> None:
        las = random_las("1.4", 6, extras=False)
        las.add_extra_dim(laspy.ExtraBytesParams("d", "f4", "words", no_data=np.array([-1.0])))
        data = saved(las)
        after = written(read(data))
        assert facts(after) == facts(data)
        assert facts(after)["extras"][-1][1:] == (b"words", 9, None, None, [-1.0])
        described = [
            opened(each).vlrs.get("ExtraBytesVlr")[0].extra_bytes_structs[0]
            for each in (data, after)
        ]
        assert [extra.options for extra in described] == [7, 1]

    def test_long_names_are_cut(self) -> None:
        name = "a very long name of a scalar field"
        after = opened(written(PointCloud(np.eye(3), {name: np.arange(3)})))
        assert list(after.point_format.extra_dimension_names) == [name[:32]]
        twice = {name + "1": np.arange(3), name + "2": np.arange(3)}
        message = "two dimensions would be called 'a very long name of a scalar fie'; rename"
        with pytest.raises(CloudFileError, match=message):
            written(PointCloud(np.eye(3), twice))

    def test_names_that_are_there_already(self) -> None:
        las = random_las("1.2", 0, extras=False)
        data = saved(las)
        for name in (b"intensity", b"x", b"NormalX", b"nx", b""):
            las = random_las("1.2", 0, extras=False)
            las.add_extra_dim(laspy.ExtraBytesParams("q" * 9, "f4"))
            las["q" * 9] = np.arange(N)
            data = saved(las).replace(b"q" * 9, name.ljust(9, b"\0"))
            cloud = read(data)
            assert len(set(cloud.columns)) == len(las.point_format.dimensions) - 3
            np.testing.assert_array_equal(list(cloud.columns.values())[-1], np.arange(N))
            again = read(written(cloud))
            assert list(again.columns) == list(cloud.columns)
            np.testing.assert_array_equal(list(again.columns.values())[-1], np.arange(N))
            assert name.ljust(9, b"\0") in written(cloud)

    def test_words(self) -> None:
        cloud = PointCloud(np.eye(2, 3), {"tree": np.array(["oak", "elm"])})
        with pytest.raises(CloudFileError, match=r"column 'tree' holds words .* LAS cannot hold"):
            written(cloud)

    def test_marks_of_fixed_points(self) -> None:
        marks = np.array([True, False])
        after = opened(written(PointCloud(np.eye(2, 3), fixed_marks=marks)))
        np.testing.assert_array_equal(after.fixed, [1, 0])


class TestColors:
    COLORS = {  # noqa: RUF012
        "red": np.linspace(0, 255, N).astype("u1"),
        "green": np.full(N, 255, "u1"),
        "blue": np.zeros(N, "u1"),
    }

    @pytest.mark.parametrize(
        ("version", "before", "after", "minor"),
        [
            ("1.1", 0, 2, 2),
            ("1.2", 0, 2, 2),
            ("1.3", 1, 3, 3),
            ("1.4", 6, 7, 4),
            ("1.2", 2, 2, 2),
            ("1.2", 3, 3, 2),
            ("1.4", 8, 8, 4),
        ],
    )
    def test_bytes_become_16_bits_and_the_format_has_them(
        self, version: str, before: int, after: int, minor: int
    ) -> None:
        las = random_las(version, before)
        cloud = read(saved(las))
        changed = opened(written(replace(cloud, columns={**cloud.columns, **self.COLORS}), "laz"))
        assert changed.point_format.id == after
        assert changed.header.version.minor == minor
        for name, values in self.COLORS.items():
            np.testing.assert_array_equal(dimension(changed, name), values.astype("u2") * 257)
        assert dimension(changed, "green").max() == 65535
        for name in las.point_format.dimension_names:
            if name not in self.COLORS:
                np.testing.assert_array_equal(dimension(changed, name), dimension(las, name))

    def test_of_16_bits_stay(self) -> None:
        columns = {name: np.arange(N, dtype="u2") * 1000 for name in self.COLORS}
        after = opened(written(PointCloud(np.random.default_rng(1).normal(size=(N, 3)), columns)))
        assert after.point_format.id == 7
        np.testing.assert_array_equal(after.red, columns["red"])

    def test_that_are_not_all_there_are_no_colors(self) -> None:
        after = opened(written(PointCloud(np.eye(3), {"red": np.arange(3, dtype="u1")})))
        assert after.point_format.id == 6
        assert list(after.point_format.extra_dimension_names) == ["red"]


class TestNewFiles:
    @PACKED
    @pytest.mark.parametrize(
        ("scale", "center"),
        [(1.0, 0.0), (1e-3, 0.0), (1e4, 5e6), (50.0, 4.5e6), (1e-7, 1.0), (1e12, 0.0)],
    )
    def test_steps_are_far_below_the_spacing(
        self, scale: float, center: float, packed: bool
    ) -> None:
        points = center + scale * np.random.default_rng(1).random((2000, 3))
        cloud = PointCloud(points)
        data = written(cloud, "laz" if packed else "las")
        las = opened(data)
        assert las.header.version.minor == 4
        step = las.header.scales[0]
        assert np.all(las.header.scales == step)
        assert np.log10(step) == pytest.approx(np.round(np.log10(step)), abs=1e-9)
        spacing = scale * np.sqrt(3 / 2000)
        assert 1e-5 * spacing < step <= 1.0001e-4 * spacing
        rounding = np.abs(read(data).points - points).max()
        assert 0.0 < rounding <= 0.5001 * step + 1e-15 * abs(center)
        np.testing.assert_array_equal(np.asarray(las.xyz), read(data).points)
        note = stored_positions(cloud, "las", "a.las").note
        assert note == f"LAS positions are written in steps of {step:.9g}"

    @pytest.mark.parametrize(
        "points",
        [
            np.zeros((1, 3)),
            np.full((5, 3), 7.25),
            np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 4e9]]),
            np.array([[0.0, 0.0, 0.0], [1e15, 1e15, 1e15], [1.0, 1.0, 1.0]]),
            np.linspace(0, 1, 30).reshape(-1, 1) * [1.0, 0.0, 0.0],
            np.array([[4.5e15, 1.0, 0.0]]),
        ],
        ids=["origin", "one place", "line", "far apart", "axis", "one point far away"],
    )
    def test_few_points(self, points: Any) -> None:
        again = read(written(PointCloud(points)))
        extent = np.ptp(points, axis=0).max()
        close = max(1e-4 * extent / len(points), extent / 1e9, np.abs(points).max() * 1e-14)
        np.testing.assert_allclose(again.points, points, rtol=0.0, atol=close)

    @pytest.mark.parametrize("far", [1e160, -1e308])
    def test_no_data_does_not_widen_the_steps(self, far: float) -> None:
        points = np.random.default_rng(1).random((9, 3))
        points[4, 2] = far
        with pytest.raises(CloudFileError, match=r"point 5 is beyond .* in steps of \[1e-05, 1e-"):
            written(PointCloud(points))

    def test_no_points(self) -> None:
        for format in ("las", "laz"):
            data = written(PointCloud(np.empty((0, 3)), {"k1": np.empty(0, "f4")}), format)
            assert len(read(data)) == 0
            assert list(read(data).columns)[-1] == "k1"
            assert len(opened(data).points) == 0

    def test_a_plane_cloud_has_no_height(self) -> None:
        cloud = PointCloud(np.random.default_rng(1).random((9, 2)))
        again = read(written(cloud))
        np.testing.assert_allclose(again.points[:, :2], cloud.points, atol=1e-4)
        assert not again.points[:, 2].any()

    def test_comments(self) -> None:
        comments = ("first line", "ünïcode\nsecond part")
        data = written(PointCloud(np.eye(3), comments=comments), "laz")
        cloud = read(data)
        assert cloud.comments == ("first line", "ünïcode second part")
        (record,) = [vlr for vlr in opened(data).vlrs if vlr.user_id == "pcsmooth"]
        assert record.record_data.decode() == "first line\nünïcode second part"
        assert written(cloud, "laz") == data
        assert lost_in(cloud, "las") == []

    def test_too_many_comments(self) -> None:
        cloud = PointCloud(np.eye(3), comments=("x" * 1000,) * 70)
        message = "its comments take 70069 bytes to describe, LAS has room for 65535; write .ply"
        with pytest.raises(CloudFileError, match=message):
            written(cloud)

    def test_too_many_columns(self) -> None:
        columns = {f"c{rank}": np.zeros(1, "u1") for rank in range(342)}
        with pytest.raises(CloudFileError, match="its extra dimensions take 65664 bytes"):
            written(PointCloud(np.zeros((1, 3)), columns))


@pytest.mark.parametrize("dim", [2, 3])
def test_dimension(dim: Any) -> None:
    las = random_las("1.2", 1)
    data = saved(las)
    cloud = read(data, dim=dim)
    assert cloud.points.shape == (N, dim)
    assert ("z" in cloud.columns) == (dim == 2)
    assert facts(written(cloud)) == facts(data)
    if dim == 2:
        np.testing.assert_array_equal(cloud.columns["z"], las.z)


def test_heights_in_words() -> None:
    text = read_cloud(io.BytesIO(b"x,y,z\n1,2,3.5\n4,5,6\n"), format="csv", dim=2)
    assert text.columns["z"].tolist() == ["3.5", "6"]
    np.testing.assert_allclose(
        read(written(text)).points, np.array([[1, 2, 3.5], [4, 5, 6]]), atol=1e-3
    )
    words = replace(text, columns={"z": np.array(["high", "6"])})
    with pytest.raises(CloudFileError, match="point 1 is not finite, and LAS holds integers"):
        check_cloud(words, "las", "a")


def test_rows_that_were_cut_are_placed_anew() -> None:
    las = random_las("1.4", 6)
    cloud = read(saved(las))
    part = replace(
        cloud,
        points=cloud.points[5:9],
        columns={name: values[5:9] for name, values in cloud.columns.items()},
    )
    after = opened(written(part))
    np.testing.assert_array_equal(after.X, las.X[5:9])
    np.testing.assert_array_equal(after.return_number, np.array(las.return_number)[5:9])
    assert "blob" not in after.point_format.dimension_names
    assert [vlr.user_id for vlr in after.vlrs if vlr.user_id == "by hand"] == ["by hand"]


def test_what_is_lost() -> None:
    for extras in (False, True):
        cloud = read(saved(random_las("1.4", 6, extras=extras)))
        assert lost_in(cloud, "las") == lost_in(cloud, "laz") == []
        assert lost_in(cloud, "pcd") == ["3 LAS records (such as the coordinate system)"]
    lists = np.empty(1, object)
    lists[0] = [1]
    other = PointCloud(np.zeros((1, 3)), {"near": lists})
    assert lost_in(other, "laz") == ["lists 'near'"]
    assert len(read(written(other))) == 1


def test_an_index_of_the_file_is_left_out() -> None:
    las = random_las("1.4", 6)
    las.vlrs.insert(0, laspy.VLR("copc", 1, "info", bytes(160)))
    las.evlrs.append(laspy.VLR("copc", 1000, "hierarchy", bytes(32)))
    cloud = read(saved(las, packed=True))
    assert lost_in(cloud, "laz") == ["the COPC index"]
    after = opened(written(cloud, "laz"))
    assert "copc" not in [vlr.user_id for vlr in [*after.vlrs, *after.evlrs]]
    assert [vlr.user_id for vlr in after.evlrs] == ["far away"]


# ----------------------------------------------------------------------------- damaged files


@pytest.mark.parametrize(("data", "message"), BAD.values(), ids=BAD)
def test_bad_files(data: bytes, message: str) -> None:
    with pytest.raises(CloudFileError, match=message) as caught:
        read(data, format="las")
    assert str(caught.value).startswith("<stdin>: ")
    assert "; " in str(caught.value)


class Panic(BaseException):
    """What lazrs raises where it finds itself wrong."""

    __module__ = "pyo3_runtime"


def test_panics_are_failures_of_the_file(monkeypatch: pytest.MonkeyPatch) -> None:
    def panic(*_: object) -> None:
        raise Panic("called `Option::unwrap()` on a `None` value")

    monkeypatch.setattr("lazrs.read_chunk_table", panic)
    message = r"its 40 compressed points cannot be read \(called `Option::unwrap\(\)` on a"
    with pytest.raises(CloudFileError, match=message):
        read(LAZ)

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("lazrs.read_chunk_table", interrupt)
    with pytest.raises(KeyboardInterrupt):
        read(LAZ)


def test_points_that_are_too_long_to_be_packed() -> None:
    las = random_las("1.2", 3, 1, extras=False)
    long = changed(saved(las), 105, "<H", 34 + 5000) + bytes(5000)
    cloud = read(long)
    assert written(cloud) == long
    message = "points of 5034 bytes are too long for LAZ, 4096 at most; write .las instead"
    with pytest.raises(CloudFileError, match=re.escape(message)):
        written(cloud, "laz")
    las.add_extra_dims([laspy.ExtraBytesParams("b", np.dtype((np.uint8, (5000,))))])
    data = saved(las, packed=True)
    data = data.replace(b"LASF_Spec", b"LASF_None")  # of so many bytes laspy makes a wrong record
    with pytest.raises(CloudFileError, match=r"cannot be read .points of 5034 bytes are too long"):
        read(data)


def test_long_points_that_are_not_there() -> None:
    data = saved(random_las("1.2", 3, 0, extras=False))
    cloud = read(changed(data, 105, "<H", 65_000))
    for format in ("las", "laz"):
        assert opened(written(cloud, format)).point_format.size == 34


def test_the_good_files_are_good() -> None:
    for data in (GOOD, OLD, LAZ):
        assert len(read(data)) == N


@pytest.mark.slow
def test_chunk_sizes_are_checked() -> None:
    # Of two chunks, as many bytes as there are, and the second as long as the first.
    rng = np.random.default_rng(1)
    cloud = PointCloud(rng.random((60_000, 3)))
    data = written(cloud, "laz")
    np.testing.assert_allclose(read(data).points, cloud.points, atol=1e-4)
    (start,) = struct.unpack_from("<I", data, 96)
    (listed,) = struct.unpack_from("<q", data, start)
    for bit in range(8 * (len(data) - listed - 8)):
        flipped = bytearray(data)
        flipped[listed + 8 + bit // 8] ^= 1 << bit % 8
        with contextlib.suppress(CloudFileError):
            assert len(read(bytes(flipped))) == len(cloud)


def test_a_list_of_chunks_that_is_found_at_the_end() -> None:
    las = random_las("1.2", 3)
    data = saved(las, packed=True)
    (start,) = struct.unpack_from("<I", data, 96)
    (listed,) = struct.unpack_from("<q", data, start)
    streamed = changed(data, start, "<q", -1) + struct.pack("<q", listed)
    np.testing.assert_array_equal(read(streamed).points, np.asarray(las.xyz))


@pytest.mark.parametrize("data", [GOOD, OLD, LAZ], ids=["1.4", "1.2", "laz"])
def test_any_damage_ends_in_one_kind_of_error(data: bytes) -> None:
    rng = np.random.default_rng(2)
    failed = 0
    for _ in range(300):
        damaged = bytearray(data)
        reach = int(rng.choice([400, len(data)]))
        for place in rng.integers(0, reach, rng.integers(1, 4)):
            damaged[place] = rng.integers(0, 256)
        try:
            read(bytes(damaged[: rng.integers(1, 3 * len(data))]), format="las")
        except CloudFileError:
            failed += 1
    assert 20 < failed < 300


def test_laspy_is_loaded_for_las_alone(tmp_path: Path) -> None:
    (tmp_path / "a.xyz").write_text("0 0 0\n1 2 3\n")
    (tmp_path / "a.las").write_bytes(GOOD)
    code = """
import sys, pcsmooth
for path in sys.argv[1:]:
    pcsmooth.read_cloud(path)
    print("laspy" in sys.modules)
"""
    paths = [tmp_path / "a.xyz", tmp_path / "a.las"]
    done = subprocess.run([sys.executable, "-c", code, *paths], capture_output=True, text=True)
    assert done.stdout.split() == ["False", "True"]


def test_the_layout_says_its_format() -> None:
    layouts = [read(data).layout for data in (GOOD, LAZ)]
    assert [isinstance(layout, LasLayout) and layout.format for layout in layouts] == ["las", "laz"]
