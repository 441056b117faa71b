from __future__ import annotations

import io
import struct
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from formats.chunked import check, modified, unchanged
from formats.peers import opened_by_open3d, written_by_open3d
from formats.test_lzf import pack_lzf
from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats import lost_in, open_chunks, read_cloud, stored_positions, write_cloud

N = 12

#: A field: its name and values, (n,) or (n, count).
Field = tuple[str, npt.NDArray[Any]]

TITLE = "# .PCD v0.7 - Point Cloud Data file format\n"
ORIGIN = "0 0 0 1 0 0 0"


def read(data: bytes, **options: Any) -> PointCloud:
    return read_cloud(io.BytesIO(data), format="pcd", **options)


def written(cloud: PointCloud) -> bytes:
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format="pcd")
    return buffer.getvalue()


def items(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return values[:, None] if values.ndim == 1 else values


def pcd(
    fields: Sequence[Field],
    encoding: str = "binary",
    shape: tuple[int, int] | None = None,
    viewpoint: str = ORIGIN,
    comments: Sequence[str] = (),
    head: str | None = None,
) -> bytes:
    """Compose a PCD file by the description of the format."""
    n = len(fields[0][1])
    width, height = shape or (n, 1)
    columns = [items(values) for _, values in fields]
    if head is None:
        head = TITLE + "".join(f"# {line}\n" for line in comments)
        head += "VERSION 0.7\nFIELDS " + " ".join(name for name, _ in fields)
        head += "\nSIZE " + " ".join(str(column.dtype.itemsize) for column in columns)
        head += "\nTYPE " + " ".join(column.dtype.kind.upper() for column in columns)
        head += "\nCOUNT " + " ".join(str(column.shape[1]) for column in columns)
        head += f"\nWIDTH {width}\nHEIGHT {height}\nVIEWPOINT {viewpoint}\nPOINTS {n}\n"
        head += f"DATA {encoding}\n"
    if encoding == "ascii":
        rows = [[str(value) for column in columns for value in column[row]] for row in range(n)]
        return head.encode() + "".join(" ".join(row) + "\n" for row in rows).encode()
    if encoding == "binary":
        body = b"".join(column[row].tobytes() for row in range(n) for column in columns)
        return head.encode() + body
    plain = b"".join(column.tobytes() for column in columns)
    packed = pack_lzf(plain)
    return head.encode() + struct.pack("<II", len(packed), len(plain)) + packed


def xyz(n: int = N, code: str = "f4") -> list[Field]:
    points = np.random.default_rng(3).normal(size=(n, 3)).astype(code)
    return [(name, points[:, axis]) for axis, name in enumerate("xyz")]


def rich() -> list[Field]:
    """Every type, a field of several items, and packed colors, of which some are NaN as floats."""
    rng = np.random.default_rng(4)
    fields = xyz()
    for code in ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"):
        info = np.iinfo(code)
        fields.append((code, rng.integers(info.min, info.max, N, code, endpoint=True)))
    fields += [(code, rng.normal(size=N).astype(code)) for code in ("f4", "f8")]
    fields.append(("histogram", rng.normal(size=(N, 5)).astype("f4")))
    return fields


PACKED = np.random.default_rng(5).integers(0, 2**32, N, "u4")
PACKED[0] = 0xFFFFFFFF

ENCODINGS = ("ascii", "binary", "binary_compressed")


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_every_type_is_read(encoding: str) -> None:
    fields = rich()
    cloud = read(pcd(fields, encoding))
    assert cloud.position_type == np.float32
    expected = np.stack([values for _, values in fields[:3]], axis=1)
    np.testing.assert_array_equal(cloud.points, expected.astype("f8"))
    assert list(cloud.columns) == [
        *(name for name, _ in fields[3:-1]),
        *(f"histogram_{item}" for item in range(5)),
    ]
    for name, values in fields[3:-1]:
        assert cloud.columns[name].dtype == values.dtype
        np.testing.assert_array_equal(cloud.columns[name], values)
    for item in range(5):
        np.testing.assert_array_equal(cloud.columns[f"histogram_{item}"], fields[-1][1][:, item])


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
@pytest.mark.parametrize("code", ["f4", "f8"])
def test_what_is_not_changed_is_written_bit_for_bit(encoding: str, code: str) -> None:
    fields = [*rich()[3:6], *xyz(code=code), *rich()[6:]]
    data = pcd(fields, encoding, (4, 3), "0.5 -1 2 0.5 0.5 0.5 0.5", ["by hand", ""])
    cloud = read(data)
    assert cloud.comments == ("by hand", "")
    assert written(cloud) == data


def test_what_is_not_finite_stays_as_it_is_spelled() -> None:
    head = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z _ i\n"
        "SIZE 4 4 4 4 4\nTYPE F F F F F\nCOUNT 1 1 1 1 2\nWIDTH 3\nHEIGHT 1\n"
        "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n"
    )
    rows = [
        "-nan(ind) 0.5 1.#INF NaN 1.0 -nan",
        "1.0 2.0 3.0 4.0 5.0 6.0",
        "nan inf 1e99 1.0 NA 2.0",
    ]
    cloud = read((head + "\n".join(rows) + "\n").encode())
    np.testing.assert_array_equal(cloud.points[2], [np.nan, np.inf, np.inf])
    assert written(cloud).decode() == head + "\n".join(rows) + "\n"
    moved = replace(cloud, points=np.ones((3, 3)))
    assert written(moved).decode().splitlines()[-3:] == [
        "1.0 1.0 1.0 NaN 1.0 -nan", "1.0 1.0 1.0 4.0 5.0 6.0", "1.0 1.0 1.0 1.0 NA 2.0"
    ]  # fmt: skip
    fewer = replace(
        cloud, points=cloud.points[:2], columns={n: c[:2] for n, c in cloud.columns.items()}
    )
    assert written(fewer).decode().splitlines()[-2:] == [
        "nan 0.5 inf 1.0 nan",
        "1.0 2.0 3.0 5.0 6.0",
    ]
    more = replace(cloud, columns={**cloud.columns, "k": np.ones(3)})
    assert written(more).decode().splitlines()[-3:] == [f"{row} 1.0" for row in rows]


def test_compressed_is_not_read_piece_by_piece(tmp_path: Path) -> None:
    path = tmp_path / "a.pcd"
    path.write_bytes(pcd(xyz(), "binary_compressed"))
    message = "a.pcd: it is one compressed stream, which cannot be read piece by piece; convert it"
    with pytest.raises(CloudFileError, match=message):
        open_chunks(path)


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_everything_in_pieces(tmp_path: Path, encoding: str) -> None:
    """Packed colors, padding, fields of several items, and whatever else a point may have."""
    path = tmp_path / "in.pcd"
    more: list[Field] = [("rgb", PACKED), ("_", np.arange(4 * N, dtype="u1").reshape(N, 4))]
    path.write_bytes(pcd([*rich(), *more], encoding))
    for rows in (1, 7, N):
        check(path, rows, "auto", unchanged)
        check(path, rows, 2, modified)


def test_compressed_becomes_binary() -> None:
    fields = [*rich(), ("rgb", PACKED.view("f4"))]
    assert written(read(pcd(fields, "binary_compressed"))) == pcd(fields)


def test_packed_colors_are_kept_bit_for_bit() -> None:
    for name, code in (("rgb", "f4"), ("rgb", "u4"), ("rgba", "u4")):
        data = pcd([*xyz(), (name, PACKED.view(code)), ("ring", np.arange(N, dtype="u2"))])
        cloud = read(data)
        for column, shift in (("red", 16), ("green", 8), ("blue", 0)):
            np.testing.assert_array_equal(cloud.columns[column], (PACKED >> shift) & 255)
            assert cloud.columns[column].dtype == np.uint8
        assert ("alpha" in cloud.columns) == (name == "rgba")
        assert written(cloud) == data


def test_new_colors_are_packed_and_the_fourth_byte_stays() -> None:
    cloud = read(pcd([*xyz(), ("rgb", PACKED.view("f4"))]))
    red = 255 - cloud.columns["red"]
    new = replace(cloud, columns={**cloud.columns, "red": red})
    again = read(written(new))
    np.testing.assert_array_equal(again.columns["red"], red)
    kept = np.frombuffer(written(new)[-16 * N :], [("xyz", "f4", 3), ("rgb", "u4")])["rgb"]
    np.testing.assert_array_equal(kept & 0xFF00FFFF, PACKED & 0xFF00FFFF)


def test_colors_that_are_no_bytes_are_fields() -> None:
    cloud = read(pcd([*xyz(), ("rgb", PACKED.view("f4"))]))
    colors = {name: np.arange(N, dtype="u2") * 1000 for name in cloud.columns}
    again = read(written(replace(cloud, columns=colors)))
    assert list(again.columns) == ["red", "green", "blue"]
    np.testing.assert_array_equal(again.columns["green"], colors["green"])


def test_colors_beside_fields_of_their_names_stay_packed() -> None:
    data = pcd([*xyz(), ("rgb", PACKED.view("f4")), ("red", np.arange(N, dtype="u1"))])
    cloud = read(data)
    assert list(cloud.columns) == ["rgb", "red"]
    assert written(cloud) == data


def test_padding_is_kept() -> None:
    rng = np.random.default_rng(6)
    gaps = [rng.integers(0, 255, (N, count), "u1") for count in (4, 3)]
    fields = [*xyz(), ("_", gaps[0]), ("ring", np.arange(N, dtype="u1")), ("_", gaps[1])]
    data = pcd(fields)
    cloud = read(data)
    assert list(cloud.columns) == ["ring"]
    assert written(cloud) == data


def test_rows_without_positions_pass_through() -> None:
    fields = xyz()
    for _, values in fields:
        values[[2, 5]] = np.nan
    fields[0][1][7] = np.inf
    data = pcd(fields, shape=(6, 2))
    cloud = read(data)
    assert np.flatnonzero(np.isnan(cloud.points).any(axis=1)).tolist() == [2, 5]
    assert written(cloud) == data
    assert written(read(pcd(fields, "ascii"))) == pcd(fields, "ascii")


def test_a_signalling_nan_is_no_warning() -> None:
    fields = xyz()
    fields[0][1].view("u4")[3] = 0x7FA00000
    assert np.isnan(read(pcd(fields)).points[3, 0])


def test_normals_have_their_usual_names() -> None:
    normals = np.random.default_rng(7).normal(size=(N, 3)).astype("f4")
    fields = [(f"normal_{axis}", normals[:, rank]) for rank, axis in enumerate("xyz")]
    data = pcd([*fields[:1], *xyz(), *fields[1:]])
    cloud = read(data)
    assert list(cloud.columns) == ["nx", "ny", "nz"]
    np.testing.assert_array_equal(cloud.columns["ny"], normals[:, 1])
    assert written(cloud) == data
    new = PointCloud(np.zeros((N, 3)), cloud.columns)
    assert b"\nFIELDS x y z normal_x normal_y normal_z\n" in written(new)


def test_names_that_are_there_twice() -> None:
    column = np.arange(N, dtype="f4")
    fields = [*xyz(), ("x", column), ("normal_x", column + 1), ("nx", column + 2)]
    fields += [("a_0", column + 3), ("a", np.stack([column + 4, column + 5], axis=1))]
    cloud = read(pcd(fields))
    assert list(cloud.columns) == ["x_2", "normal_x", "nx", "a_0", "a_0_2", "a_1"]
    assert [column[0] for column in cloud.columns.values()] == [0, 1, 2, 3, 4, 5]
    assert written(cloud) == pcd(fields)


def test_new_columns_come_last_and_missing_ones_are_left_out() -> None:
    cloud = read(pcd(rich()))
    columns = {name: values for name, values in cloud.columns.items() if name != "histogram_3"}
    del columns["i4"]
    new = replace(cloud, columns={**columns, "k1": np.ones(N, "f4"), "flag": np.ones(N, bool)})
    again = read(written(new))
    assert [*again.columns][-6:] == [
        "histogram_0", "histogram_1", "histogram_2", "histogram_4", "k1", "flag",
    ]  # fmt: skip
    assert "i4" not in again.columns
    for name, values in new.columns.items():
        np.testing.assert_array_equal(again.columns[name], values)


def test_floats_keep_their_type_and_moved_points_theirs() -> None:
    cloud = read(pcd([*xyz(), ("f4", np.zeros(N, "f4")), ("u2", np.zeros(N, "u2"))]))
    columns = {"f4": np.full(N, 0.1), "u2": np.full(N, 0.5)}
    moved = replace(cloud, points=cloud.points + 0.1, columns=columns)
    again = read(written(moved))
    assert again.position_type == np.float32
    np.testing.assert_array_equal(again.points, (cloud.points + 0.1).astype("f4"))
    assert [values.dtype for values in again.columns.values()] == ["f4", "f8"]


@pytest.mark.parametrize("dim", [2, 3, "auto"])
def test_dimension(dim: Any) -> None:
    cloud = read(pcd(xyz()), dim=dim)
    assert cloud.dimension == (2 if dim == 2 else 3)
    assert list(cloud.columns) == (["z"] if dim == 2 else [])
    assert written(cloud) == pcd(xyz())
    flat = xyz()[:2]
    if dim == 3:
        with pytest.raises(CloudFileError, match="it has no field 'z'; read it as a 2D cloud"):
            read(pcd(flat), dim=dim)
    else:
        assert read(pcd(flat), dim=dim).dimension == 2
        assert written(read(pcd(flat), dim=dim)) == pcd(flat)


def test_rows_that_were_cut_lose_the_organisation() -> None:
    data = pcd([*xyz(), ("_", np.zeros(N, "u1")), ("rgb", PACKED)], shape=(4, 3))
    cloud = read(data)
    part = replace(
        cloud,
        points=cloud.points[:5],
        columns={name: values[:5] for name, values in cloud.columns.items()},
    )
    head = written(part).split(b"DATA")[0]
    assert b"\nWIDTH 5\nHEIGHT 1\n" in head
    assert b"\nFIELDS x y z rgb\n" in head
    np.testing.assert_array_equal(read(written(part)).points, part.points)


def test_a_new_file() -> None:
    points = np.random.default_rng(8).normal(size=(5, 3)) + 5e5
    colors = {name: np.arange(5, dtype="u1") * 50 for name in ("red", "green", "blue")}
    columns = {
        "intensity": np.linspace(0, 1, 5, dtype="f4"),
        **colors,
        "class": np.array(["1", "2", "3", "4", "5"]),
        "mixed": np.array(["1", "", "2.5", "nan", "-1"]),
    }
    cloud = PointCloud(points, columns, comments=("from elsewhere\nin two lines",),
                       fixed_marks=np.array([True, False, False, False, True]))  # fmt: skip
    again = read(written(cloud))
    np.testing.assert_array_equal(again.points, points)
    assert again.comments == ("from elsewhere", "in two lines")
    assert list(again.columns) == [
        "red", "green", "blue", "intensity", "class", "mixed", "fixed",
    ]  # fmt: skip
    for name, values in colors.items():
        np.testing.assert_array_equal(again.columns[name], values)
    assert again.columns["class"].dtype == np.int64
    np.testing.assert_array_equal(again.columns["class"], [1, 2, 3, 4, 5])
    np.testing.assert_array_equal(again.columns["mixed"], [1, np.nan, 2.5, np.nan, -1])
    np.testing.assert_array_equal(again.columns["fixed"], [1, 0, 0, 0, 1])
    assert written(again) == written(again)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_no_points(encoding: str) -> None:
    fields = [(name, values[:0]) for name, values in rich()]
    cloud = read(pcd(fields, encoding))
    assert len(cloud) == 0
    assert len(cloud.columns) == 15
    assert written(cloud) == pcd(fields, "ascii" if encoding == "ascii" else "binary")


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_one_point(encoding: str) -> None:
    fields = [(name, values[:1]) for name, values in rich()]
    np.testing.assert_array_equal(
        read(pcd(fields, encoding)).points[0], [values[0] for _, values in fields[:3]]
    )


HEAD = "VERSION {}\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\n"


@pytest.mark.parametrize("version", [".7", "0.7", ".6", "0.5"])
def test_versions_and_what_may_be_left_out(version: str) -> None:
    data = f"# .PCD v{version}\r\n{HEAD.format(version)}DATA ascii\n1 2 3\n\n4 5 6".encode()
    cloud = read(data)
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.comments == ()


PLAIN = HEAD.format(".7")

BAD = {
    "empty": (b"", "not a PCD file: it has no line VERSION; check the file"),
    "something else": (b"ply\nformat", "not a PCD file"),
    "cut in the header": (PLAIN.encode(), "no DATA line; the file is cut short"),
    "unknown version": (
        (HEAD.format("0.8") + "DATA ascii\n1 2 3\n4 5 6\n").encode(),
        r"the PCD header is damaged \(version 0\.8 is not known\)",
    ),
    "unknown data": ((PLAIN + "DATA zip\n").encode(), "DATA zip is not known"),
    "no fields": (b"VERSION .7\nSIZE 4\nTYPE F\nWIDTH 1\nDATA ascii\n1\n", "there is no FIELDS"),
    "no width": (b"VERSION .7\nFIELDS x y\nSIZE 4 4\nTYPE F F\nDATA ascii\n", "no WIDTH"),
    "negative": ((PLAIN + "HEIGHT -1\nDATA ascii\n").encode(), "HEIGHT -1 is not a number"),
    "count of points": (
        (PLAIN + "HEIGHT 1\nPOINTS 3\nDATA ascii\n").encode(),
        "WIDTH 2 times HEIGHT 1 is not POINTS 3",
    ),
    "viewpoint": ((PLAIN + "VIEWPOINT 0 0 0\nDATA ascii\n").encode(), "VIEWPOINT is not 7 numbers"),
    "viewpoint of words": (
        (PLAIN + "VIEWPOINT a b c d e f g\nDATA ascii\n").encode(),
        "could not convert",
    ),
    "sizes": (
        PLAIN.replace("4 4 4", "4 4").encode() + b"DATA ascii\n",
        "3 FIELDS have 2 entries of SIZE",
    ),
    "type": (PLAIN.replace("F F F", "F F D").encode() + b"DATA ascii\n", "TYPE D of SIZE 4"),
    "size": (PLAIN.replace("4 4 4", "4 4 2").encode() + b"DATA ascii\n", "TYPE F of SIZE 2"),
    "counts of nothing": (
        (PLAIN + "COUNT 1 0 0\nDATA ascii\n1\n2\n").encode(),
        "it has no field 'y'",
    ),
    "count of all": (
        (PLAIN + f"COUNT 1 1 {10**12}\nDATA ascii\n").encode(),
        "a point has more than 50000 items",
    ),
    "no position": (
        PLAIN.replace("x y z", "a y z").encode() + b"DATA ascii\n1 2 3\n4 5 6\n",
        "it has no field 'x'; export it with x and y",
    ),
    "fewer lines": ((PLAIN + "DATA ascii\n1 2 3 44444\n").encode(), "2 points, but 1 lines"),
    "more lines": ((PLAIN + "DATA ascii\n" + "1 2 3\n" * 3).encode(), "2 points, but 3 lines"),
    "word": ((PLAIN + "DATA ascii\n1 2 3\n4 five 6\n").encode(), "malformed PCD points .*'five'"),
    "ragged": ((PLAIN + "DATA ascii\n1 2 3\n4 5 6 7\n").encode(), "malformed PCD points"),
    "too large": (
        PLAIN.replace("F F F", "F F U").replace("4 4 4", "4 4 1").encode()
        + b"DATA ascii\n1 2 3\n4 5 256\n",
        "malformed PCD points",
    ),
    "cut": (pcd(xyz())[:-1], "12 points, which take at least 144 bytes, but 143 bytes follow"),
    "endless text": (
        PLAIN.replace("2", str(10**12)).encode() + b"DATA ascii\n1 2 3\n",
        "promises 1000000000000 points, which take at least 6000000000000 bytes, but 6 bytes",
    ),
    "endless": (PLAIN.replace("2", str(10**12)).encode() + b"DATA binary\n1", "but 1 bytes follow"),
    "endless compressed": (
        PLAIN.replace("2", str(10**12)).encode() + b"DATA binary_compressed\n1234",
        "but 4 compressed bytes follow",
    ),
    "compressed, cut": (
        pcd(xyz(), "binary_compressed")[:-1],
        "its compressed data are .* that stand for 144",
    ),
    "compressed, damaged": (
        PLAIN.replace("2", "1").encode() + b"DATA binary_compressed\n\3\0\0\0\14\0\0\0\xff\xff\xff",
        "the compressed data refer to what is before them; get the whole file again",
    ),
    "compressed, without sizes": (
        PLAIN.replace("2", "1").encode() + b"DATA binary_compressed\n12",
        "its compressed data are 0 bytes that stand for 0",
    ),
}  # fmt: skip


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_fields_of_nothing_are_left_out_and_said(encoding: str) -> None:
    padding, gap = np.empty((N, 0), "u1"), np.empty((N, 0), "f4")
    fields = xyz()
    data = pcd([fields[0], ("_", padding), *fields[1:], ("gap", gap)], encoding)
    cloud = read(data)
    assert cloud.warnings == tuple(
        f"field '{name}' has COUNT 0 and is left out" for name in ("_", "gap")
    )
    assert cloud.columns == {}
    np.testing.assert_array_equal(cloud.points, np.stack([v for _, v in fields], axis=1))
    after = written(cloud)
    assert b"FIELDS x y z\n" in after
    assert read(after).warnings == ()


def test_words_for_numbers() -> None:
    fields = [*xyz(2), ("ring", np.array([7, 8], "u8"))]
    head, rows = pcd(fields, "ascii").split(b"ascii\n")
    head, rows = head + b"ascii\n", rows.replace(b" 7\n", b" 18446744073709551615\n")
    cloud = read(head + rows.replace(b" 8\n", b" 8.0\n"))
    assert cloud.columns["ring"].tolist() == [2**64 - 1, 8]
    with pytest.raises(CloudFileError, match=r"row 1: ring is '8\.5', not a number of type u"):
        read(head + rows.replace(b" 8\n", b" 8.5\n"))


def test_many_fields() -> None:
    names = ["x", "y", *["f"] * 8000, *(f"g{rank}" for rank in range(8000))]
    entries = {"FIELDS": names, "SIZE": "4" * 16_002, "TYPE": "F" * 16_002, "WIDTH": "0"}
    head = "".join(f"{entry} {' '.join(words)}\n" for entry, words in entries.items())
    data = f"VERSION .7\n{head}DATA ascii\n".encode()
    started = time.process_time()
    cloud = read(data)
    assert time.process_time() - started < 5.0
    assert len(cloud.columns) == 16_000
    assert list(cloud.columns)[:3] == ["f", "f_2", "f_3"]


def test_numbers_that_are_longer_than_any_file() -> None:
    for entry in ("WIDTH", "POINTS"):
        long = pcd(xyz()).replace(f"{entry} 12".encode(), f"{entry} {'9' * 5000}".encode())
        with pytest.raises(
            CloudFileError, match=rf"damaged \({entry} 9+ \.\.\.\); correct"
        ) as caught:
            read(long)
        assert len(str(caught.value)) < 300


@pytest.mark.parametrize(("data", "message"), BAD.values(), ids=BAD)
def test_bad_files(data: bytes, message: str) -> None:
    with pytest.raises(CloudFileError, match=message) as caught:
        read(data)
    assert str(caught.value).startswith("<stdin>: ")
    assert "; " in str(caught.value)


def test_what_cannot_be_written() -> None:
    points = np.zeros((2, 3))
    for columns, message in (
        ({"name": np.array(["oak", "elm"])}, "column 'name' holds words .*, which PCD cannot hold"),
        ({"c": np.ones(2, complex)}, "column 'c' has type complex128, which PCD cannot hold"),
        ({"a b": np.ones(2), "a_b": np.ones(2)}, "two columns would be called 'a_b'"),
    ):
        with pytest.raises(CloudFileError, match=message):
            written(PointCloud(points, columns))
    with pytest.raises(CloudFileError, match="float cannot hold such coordinates; pass --double"):
        stored_positions(PointCloud(points + 1e300, position_type=np.dtype("f4")), "pcd", "a.pcd")


def test_what_is_lost() -> None:
    lists = np.empty(1, object)
    lists[0] = [1, 2]
    cloud = PointCloud(np.zeros((1, 3)), {"near": lists, "id": np.array(["12345678901234567890"])})
    assert lost_in(cloud, "pcd") == ["lists 'near'", "digits of the long numbers in column 'id'"]
    assert b"FIELDS x y z id\n" in written(cloud)
    organised = read(pcd(xyz(), shape=(4, 3)))
    assert lost_in(organised, "pcd") == []
    assert lost_in(organised, "ply") == ["width, height and viewpoint of the PCD file"]
    assert lost_in(read(pcd(xyz(), viewpoint="1 0 0 1 0 0 0")), "las") == lost_in(organised, "ply")
    assert lost_in(read(pcd(xyz())), "ply") == []


@pytest.mark.parametrize("kinds", [[], ["ascii"], ["compressed"]], ids=str)
def test_files_of_open3d(tmp_path: Path, kinds: list[str]) -> None:
    path = tmp_path / "a.pcd"
    written_by_open3d(path, *kinds)
    cloud = read_cloud(path)
    before = opened_by_open3d(path)
    close = 1e-7 if kinds == ["ascii"] else 0.0  # Open3D does not round to the float it wrote
    np.testing.assert_allclose(cloud.points, before["points"], atol=close)
    assert len(cloud) == 500
    for rank, name in enumerate(("nx", "ny", "nz")):
        np.testing.assert_allclose(cloud.columns[name], before["normals"][:, rank], atol=close)
    for rank, name in enumerate(("red", "green", "blue")):
        shades = cloud.columns[name] / 255
        np.testing.assert_allclose(shades, before["colors"][:, rank], atol=1e-6)
    write_cloud(replace(cloud, points=cloud.points + 0.25), path)
    after = opened_by_open3d(path)
    np.testing.assert_allclose(after["points"], before["points"] + 0.25, atol=1e-6)
    np.testing.assert_allclose(after["normals"], before["normals"], atol=close)
    np.testing.assert_array_equal(after["colors"], before["colors"])
    assert len(after["colors"]) == 500


def test_open3d_opens_new_files(tmp_path: Path) -> None:
    points = np.random.default_rng(10).normal(size=(50, 3)).astype("f4")
    columns = {name: np.full(50, rank / 2, "f4") for rank, name in enumerate(("nx", "ny", "nz"))}
    columns |= {name: np.full(50, 51 * rank, "u1") for rank, name in enumerate(("red", "green"))}
    columns |= {"blue": np.full(50, 255, "u1"), "k1": np.arange(50, dtype="f4")}
    path = tmp_path / "a.pcd"
    write_cloud(PointCloud(points.astype("f8"), columns, position_type=np.dtype("f4")), path)
    opened = opened_by_open3d(path)
    np.testing.assert_array_equal(opened["points"], points)
    np.testing.assert_array_equal(opened["normals"][7], [0.0, 0.5, 1.0])
    np.testing.assert_allclose(opened["colors"][7], [0.0, 0.2, 1.0])
    np.testing.assert_array_equal(opened["k1"], columns["k1"])
