from __future__ import annotations

import io
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import plyfile
import pytest
import trimesh

from formats.ply_files import (
    ENCODINGS,
    FACES,
    SCALARS,
    TRIANGLE,
    XYZ,
    as_bytes,
    ascii_ply,
    binary,
    rich_ply,
)
from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats import read_cloud, write_cloud, written_position_type


def read(data: bytes, **options: Any) -> PointCloud:
    return read_cloud(io.BytesIO(data), format="ply", **options)


def written(cloud: PointCloud) -> bytes:
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format="ply")
    return buffer.getvalue()


def opened(data: bytes) -> plyfile.PlyData:
    return plyfile.PlyData.read(io.BytesIO(data), mmap=False)


def assert_same(actual: plyfile.PlyData, expected: plyfile.PlyData) -> None:
    assert (actual.text, actual.byte_order) == (expected.text, expected.byte_order)
    assert actual.comments == expected.comments
    assert actual.obj_info == expected.obj_info
    assert [e.name for e in actual] == [e.name for e in expected]
    for mine, theirs in zip(actual, expected, strict=True):
        assert mine.header == theirs.header
        for prop in theirs.properties:
            for a, b in zip(mine[prop.name], theirs[prop.name], strict=True):
                np.testing.assert_array_equal(a, b)


@pytest.mark.filterwarnings("ignore:loadtxt")  # plyfile, on a list without items
@pytest.mark.parametrize(("text", "byte_order"), ENCODINGS)
def test_everything_comes_back(text: bool, byte_order: str) -> None:
    ply = rich_ply(text, byte_order)
    result = written(read(as_bytes(ply)))
    assert_same(opened(result), ply)
    if not text:
        assert result == as_bytes(ply)


@pytest.mark.parametrize(("text", "byte_order"), ENCODINGS)
def test_cloud_in_memory(text: bool, byte_order: str) -> None:
    ply = rich_ply(text, byte_order)
    cloud = read(as_bytes(ply))
    vertex = ply["vertex"].data
    expected = np.stack([vertex[axis].astype("f8") for axis in "xyz"], axis=1)
    np.testing.assert_array_equal(cloud.points, expected)
    assert list(cloud.columns) == ["red", *(f"s_{code}" for code in SCALARS), "hits"]
    for code in SCALARS:
        assert cloud.columns[f"s_{code}"].dtype == np.dtype(code)
        np.testing.assert_array_equal(cloud.columns[f"s_{code}"], vertex[f"s_{code}"])
    assert cloud.columns["hits"][3].tolist() == [0, 1, 2]
    assert cloud.position_type == np.float32
    assert cloud.comments == ("made by hand", "unit metre")


@pytest.mark.parametrize("code", SCALARS)
@pytest.mark.parametrize(("text", "byte_order"), ENCODINGS)
def test_every_position_type_is_read(code: str, text: bool, byte_order: str) -> None:
    table = np.array([(1, 2, 3), (4, 5, 6)], [(axis, code) for axis in "xyz"])
    ply = plyfile.PlyData(
        [plyfile.PlyElement.describe(table, "vertex")], text=text, byte_order=byte_order
    )
    cloud = read(as_bytes(ply))
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.position_type == np.dtype(code)
    expected = code if code[0] == "f" else "f8"
    assert written_position_type(cloud) == np.dtype(expected)
    assert opened(written(cloud))["vertex"].ply_property("x").val_dtype == expected


def test_both_type_vocabularies() -> None:
    data = ascii_ply("float32 x, float64 y, int16 z, uint8 a", "1 2 3 4\n")
    cloud = read(data)
    assert cloud.points.tolist() == [[1, 2, 3]]
    assert cloud.columns["a"].dtype == np.uint8


def test_extremes_survive_ascii() -> None:
    points = np.array([[0.1, 1 / 3, 1e-320], [np.nan, np.inf, -0.0], [5e6 + 0.001, 1e300, -1.0]])
    base = read(ascii_ply("double x, double y, double z", "0 0 0\n0 0 0\n0 0 0\n"))
    again = read(written(replace(base, points=points)))
    np.testing.assert_array_equal(again.points, points)
    assert np.signbit(again.points[1, 2])


def test_position_type_is_obeyed() -> None:
    cloud = read(ascii_ply(XYZ, "0.1 0.2 0.3\n"))
    double = opened(written(replace(cloud, position_type=np.dtype(np.float64))))
    assert double["vertex"].ply_property("y").val_dtype == "f8"


def test_new_columns_follow_and_old_ones_stay() -> None:
    cloud = read(ascii_ply(f"{XYZ}, float nx, uchar red", "1 2 3 0 9\n"))
    columns = {
        "quality": np.array([0.5], np.float32),
        "nx": np.array([1.0]),
        "red": np.array([300], np.int16),
    }
    vertex = opened(written(replace(cloud, columns=columns)))["vertex"]
    assert vertex.data.dtype.names == ("x", "y", "z", "nx", "red", "quality")
    assert vertex.ply_property("nx").val_dtype == "f4"  # floating: the file's type
    assert vertex.ply_property("red").val_dtype == "i2"  # whole: the new type
    assert vertex.data[0].tolist() == (1, 2, 3, 1, 300, 0.5)


def test_list_that_outgrows_its_length_type() -> None:
    cloud = read(ascii_ply(f"{XYZ}, list uchar ushort near", "1 2 3 2 7 8\n"))
    longer = np.empty(1, object)
    longer[0] = np.arange(256)
    again = read(written(replace(cloud, columns={"near": longer})))
    np.testing.assert_array_equal(again.columns["near"][0], np.arange(256))


def test_new_list_column() -> None:
    cloud = read(ascii_ply(XYZ, "1 2 3\n4 5 6\n"))
    lists = np.empty(2, object)
    lists[:] = [np.arange(300), np.arange(1)]
    again = read(written(replace(cloud, columns={"near": lists})))
    assert [len(row) for row in again.columns["near"]] == [300, 1]


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (np.array([True, False]), "u1"),
        (np.array([1, 2**31 - 1]), "i4"),
        (np.array([1, 2**31]), "f8"),
        (np.array([1, 2], np.float16), "f4"),
        (np.array(["7", "-8"]), "i4"),
        (np.array(["7", "99999999999"]), "f8"),
        (np.array(["7.5", "nan"]), "f8"),
        (np.array(['"7"', ""]), "f8"),
    ],
)
def test_types_of_new_columns(values: np.ndarray[Any, Any], expected: str) -> None:
    cloud = PointCloud(np.zeros((2, 3)), {"new": values})
    vertex = opened(written(cloud))["vertex"]
    assert vertex.ply_property("new").val_dtype == expected


def test_words_and_complex_numbers_do_not_fit() -> None:
    cloud = PointCloud(np.zeros((2, 3)), {"kind": np.array(["tree", "1"])})
    with pytest.raises(CloudFileError, match=r"column 'kind' holds words .*'tree'.*write \.csv"):
        written(cloud)
    with pytest.raises(CloudFileError, match="column 'kind' has type complex128"):
        written(PointCloud(np.zeros((1, 3)), {"kind": np.array([1j])}))


def test_names_that_clash() -> None:
    one = np.ones(1)
    with pytest.raises(CloudFileError, match="two columns would be called 'a_b'"):
        written(PointCloud(np.zeros((1, 3)), {"a b": one, "a_b": one}))


def test_cloud_from_elsewhere_is_little_endian_with_three_coordinates() -> None:
    marks = np.array([True, False])
    cloud = PointCloud(
        np.array([[1.0, 2.0], [3.0, 4.0]]),
        {"Scalar field": np.array(["1", "2"])},
        fixed_marks=marks,
    )
    ply = opened(written(cloud))
    assert (ply.text, ply.byte_order) == (False, "<")
    assert ply["vertex"].data.dtype.names == ("x", "y", "z", "Scalar_field", "fixed")
    assert ply["vertex"].ply_property("z").val_dtype == "f8"
    assert ply["vertex"].data.tolist() == [(1, 2, 0, 1, 1), (3, 4, 0, 2, 0)]


def test_flat_cloud_from_text_keeps_its_own_z() -> None:
    cloud = read_cloud(io.BytesIO(b"x,y,z\n1,2,3\n"), format="csv", dim=2)
    vertex = opened(written(cloud))["vertex"]
    assert vertex.data.dtype.names == ("x", "y", "z")
    assert vertex.data.tolist() == [(1, 2, 3)]


def test_trimesh_reads_what_we_write(tmp_path: Path) -> None:
    points = np.random.default_rng(0).normal(size=(50, 3))
    write_cloud(PointCloud(points, {"quality": np.arange(50.0)}), tmp_path / "cloud.ply")
    loaded: Any = trimesh.load(tmp_path / "cloud.ply")
    np.testing.assert_array_equal(loaded.vertices, points)


@pytest.mark.parametrize("dim", ["auto", 2])
def test_flat_file_stays_flat(dim: Any) -> None:
    data = ascii_ply("double x, double y", "1 2\n3 4\n")
    cloud = read(data, dim=dim)
    assert cloud.points.tolist() == [[1, 2], [3, 4]]
    assert opened(written(cloud))["vertex"].data.dtype.names == ("x", "y")


def test_dim_2_keeps_z_as_a_column() -> None:
    data = ascii_ply("float z, float x, float y", "9.5 1 2\n")
    cloud = read(data, dim=2)
    assert cloud.points.tolist() == [[1, 2]]
    assert cloud.columns["z"].tolist() == [9.5]
    assert opened(written(cloud))["vertex"].data[0].tolist() == (9.5, 1, 2)


def test_axes_in_capitals_are_kept() -> None:
    cloud = read(ascii_ply("float X, float Y, float Z", "1 2 3\n"))
    assert cloud.points.tolist() == [[1, 2, 3]]
    assert opened(written(cloud))["vertex"].data.dtype.names == ("X", "Y", "Z")


def test_lower_case_axes_come_first() -> None:
    cloud = read(ascii_ply("float X, float x, float y, float z", "9 1 2 3\n"))
    assert cloud.points.tolist() == [[1, 2, 3]]
    assert list(cloud.columns) == ["X"]


def test_crlf_blank_lines_and_no_last_newline() -> None:
    data = ascii_ply(XYZ, "1 2 3\n\n4 5 6", count=2).replace(b"\n", b"\r\n")
    assert read(data).points.tolist() == [[1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize("note", ["façade".encode(), "façade".encode("latin-1")])
def test_comment_that_is_not_ascii(note: bytes) -> None:
    data = ascii_ply(XYZ, "1 2 3\n").replace(b"1.0\n", b"1.0\ncomment " + note + b"\n")
    cloud = read(data)
    assert cloud.comments == (r"fa\xe7ade",)
    assert opened(written(cloud)).comments == [r"fa\xe7ade"]


def test_comment_cannot_break_the_header() -> None:
    cloud = PointCloud(np.zeros((1, 3)), comments=("one\nend_header", "été", ""))
    assert opened(written(cloud)).comments == ["one", "end_header", r"\xe9t\xe9", ""]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is empty"),
        (b"solid cube\n", "not a PLY file"),
        (b"plyers\n1 2 3\n", "not a PLY file"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\n", "no 'end_header'"),
        (b"ply\nformat braille 1.0\nend_header\n", "damaged .*braille"),
        (ascii_ply("float x, float y, float y", "1 2 3\n"), "damaged .*same name"),
        (ascii_ply("quad x, float y", "1 2\n"), "damaged .*quad"),
        (ascii_ply(XYZ, "", count=-4), "damaged .*-4 rows"),
        (b"ply\nformat ascii 1.0\nelement vertex many\nend_header\n", "damaged"),
        (b"ply\nformat ascii 1.0\nelement face 0\nend_header\n", "no vertex element"),
        (ascii_ply("float y, float z", "1 2\n"), "no number 'x'"),
        (ascii_ply("float x, float z", "1 2\n"), "no number 'y'"),
        (ascii_ply("list uchar float x, float y", "1 2 3\n"), "no number 'x'"),
        (ascii_ply(XYZ, "1 2 3\n4 5 6\n", 3), "promises 3 vertex rows.* 18 bytes, but 12"),
        (ascii_ply(XYZ, "1.25 2.5 3.75\n4 5 6\n", 3), "promises 3 vertex rows, but 2 follow"),
        (ascii_ply(XYZ, "1 2 3\n4 five 6\n"), "row 1: y is 'five', not a number"),
        (ascii_ply(XYZ, "1 2 3\n4 5.0\n"), "row 1: 2 values, expected 3"),
        (ascii_ply(XYZ, "1 2 3\n4 5 6 7\n"), "row 1: 4 values, expected 3"),
        (
            ascii_ply(f"{XYZ}, uchar red", "1 2 3 256\n"),
            "row 0: red is '256', not a number of type uint8",
        ),
        (binary(10, bytes(100)), "at least 120 bytes, but 100 bytes follow"),
        (binary(1, bytes(12) + TRIANGLE, tail=FACES), "face .*the data end in row 1"),
        (binary(1, bytes(12) + TRIANGLE + b"\x09" + bytes(6), tail=FACES), "32 bytes are missing"),
        (
            binary(1, bytes(12) + b"\xff" + bytes(12), f"{XYZ}, list char uchar near"),
            "vertex row 0 has a list of -1 items",
        ),
    ],
)
def test_damaged_file(data: bytes, message: str) -> None:
    with pytest.raises(CloudFileError, match=message) as caught:
        read(data)
    assert str(caught.value).startswith("<stdin>: ")


def test_dim_3_needs_z() -> None:
    with pytest.raises(CloudFileError, match="no number 'z'"):
        read(ascii_ply("float x, float y", "1 2\n"), dim=3)


@pytest.mark.parametrize("encoding", [b"ascii", b"binary_little_endian"])
@pytest.mark.parametrize("properties", [XYZ, f"{XYZ}, list uchar int near"])
def test_absurd_count_is_refused_at_once(encoding: bytes, properties: str) -> None:
    data = ascii_ply(properties, "1 2 3 0\n", count=10**12).replace(b"ascii", encoding)
    start = time.perf_counter()
    with pytest.raises(CloudFileError, match="promises 1000000000000 vertex rows"):
        read(data)
    assert time.perf_counter() - start < 1.0
