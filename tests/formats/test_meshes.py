from __future__ import annotations

import io
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from formats.peers import opened_by_pymeshlab
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


def read(data: bytes, format: str, **options: Any) -> PointCloud:
    return read_cloud(io.BytesIO(data), format=format, **options)


def written(cloud: PointCloud, format: str) -> bytes:
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format=format)
    return buffer.getvalue()


def faces(data: bytes, format: str) -> Any:
    return trimesh.load_mesh(io.BytesIO(data), file_type=format, process=False)


CUBE = trimesh.creation.box()
POINTS = np.array([[0.0, 0.5, 1.0], [1.0, 0.25, -2.5], [1e-3, 7.0, 0.1], [9.0, 9.0, 9.0]])

OBJ = b"""# made by h\xe4nd
mtllib a.mtl
o thing
v 0.0 0.5 1.0
v 1.0 0.25 -2.5
  v 0.001 7.0 0.1
v 9.0 9.0 9.0
vt 0 0
vt 1 0
vn 0 0 1

usemtl red
g side
s off
f 1/1/1 2/2/1 3/1/1 4/2/1
f 3 1 2
l 1 2
"""

OFF = b"""OFF
# by hand

4 2 0
0.0 0.5 1.0
1.0 0.25 -2.5
# in between
0.001 7.0 0.1

9.0 9.0 9.0
4 0 1 2 3
3 2 0 1 255 0 0
"""


class TestLines:
    """OBJ and OFF, whose lines come back."""

    FILES = pytest.mark.parametrize(("format", "data"), [("obj", OBJ), ("off", OFF)])

    @FILES
    def test_row_is_vertex_in_the_order_of_the_file(self, format: str, data: bytes) -> None:
        cloud = read(data, format)
        np.testing.assert_array_equal(cloud.points, POINTS)
        assert cloud.columns == {}
        assert cloud.position_type == np.float64
        assert output_format(None, cloud) == format

    @FILES
    def test_every_other_line_is_kept(self, format: str, data: bytes) -> None:
        assert written(read(data, format), format) == data
        windows = data.replace(b"\n", b"\r\n")
        assert written(read(windows, format), format) == windows
        assert written(read(data[:-1], format), format) == data[:-1]

    @FILES
    def test_positions_are_written_with_all_digits(self, format: str, data: bytes) -> None:
        cloud = read(data, format)
        moved = replace(cloud, points=cloud.points / 3)
        changed = written(moved, format)
        np.testing.assert_array_equal(read(changed, format).points, cloud.points / 3)
        lines = zip(data.split(b"\n"), changed.split(b"\n"), strict=True)
        assert sum(before != after for before, after in lines) == 4
        single = replace(moved, position_type=np.dtype("f4"))
        again = read(written(single, format), format).points
        np.testing.assert_array_equal(again.astype("f4"), (cloud.points / 3).astype("f4"))
        assert b" 0.33333334\n" in written(single, format)

    @FILES
    def test_dimension(self, format: str, data: bytes) -> None:
        cloud = read(data, format, dim=2)
        np.testing.assert_array_equal(cloud.points, POINTS[:, :2])
        np.testing.assert_array_equal(cloud.columns["z"], POINTS[:, 2])
        assert written(cloud, format) == data
        assert lost_in(cloud, format) == []
        flat = PointCloud(POINTS[:, :2])
        assert not read(written(flat, format), format).points[:, 2].any()

    @FILES
    def test_a_new_file_when_rows_were_cut(self, format: str, data: bytes) -> None:
        cloud = read(data, format)
        part = replace(cloud, points=cloud.points[1:])
        again = read(written(part, format), format)
        np.testing.assert_array_equal(again.points, POINTS[1:])
        assert b"f " not in written(part, format)
        assert lost_in(part, format) == [
            f"faces and all but the vertices of the {format.upper()} file"
        ]

    @FILES
    def test_what_is_lost(self, format: str, data: bytes) -> None:
        cloud = read(data, format)
        assert lost_in(cloud, format) == []
        other = "off" if format == "obj" else "obj"
        words = f"faces and all but the vertices of the {format.upper()} file"
        for target in ("ply", "las", "pcd", "xyz", "stl", other):
            assert lost_in(cloud, target) == [words]
        marked = PointCloud(
            np.zeros((1, 3)), {"k1": np.ones(1)}, comments=("c",), fixed_marks=np.ones(1, bool)
        )
        assert lost_in(marked, format) == [
            "column 'k1'", "the comments", "the marks of fixed points",
        ]  # fmt: skip
        plain = read(written(PointCloud(POINTS), format), format)
        assert lost_in(plain, "obj") == []

    @FILES
    def test_words_in_place_of_numbers(self, format: str, data: bytes) -> None:
        line = data[: data.index(b"1.0 0.25 -2.5")].count(b"\n") + 1
        for wrong, found in ((b"1.0 0.25", "1.0 0.25"), (b"1.0 a 3", "1.0 a 3"), (b"1,0 2 3", ".")):
            bad = data.replace(b"1.0 0.25 -2.5", wrong)
            message = rf"<stdin>: line {line}: '{found}.*' is not three coordinates; correct the"
            with pytest.raises(CloudFileError, match=message):
                read(bad, format)

    @FILES
    def test_faces_are_those_of_trimesh(self, format: str, data: bytes) -> None:
        source = CUBE.export(file_type=format)
        source = source.encode() if isinstance(source, str) else source
        cloud = read(source, format)
        np.testing.assert_array_equal(cloud.points, CUBE.vertices)
        after = faces(written(replace(cloud, points=cloud.points * 2), format), format)
        np.testing.assert_array_equal(after.vertices, CUBE.vertices * 2)
        np.testing.assert_array_equal(after.faces, CUBE.faces)

    @pytest.mark.parametrize("format", ["obj", "off"])
    def test_pymeshlab_opens_them(self, tmp_path: Path, format: str) -> None:
        path = tmp_path / f"a.{format}"
        CUBE.export(path)
        colors = {name: np.arange(8, dtype="u1") * 30 for name in ("red", "green", "blue")}
        cloud = read_cloud(path)
        write_cloud(replace(cloud, points=cloud.points * 3, columns=colors), path)
        opened = opened_by_pymeshlab(path)
        np.testing.assert_array_equal(opened["points"], CUBE.vertices * 3)
        np.testing.assert_array_equal(opened["faces"], CUBE.faces)
        shades = np.stack([*colors.values(), np.full(8, 255)], axis=1) / 255
        np.testing.assert_allclose(opened["colors"], shades, atol=0.5 / 255)


class TestObj:
    COLORED = b"v 0 0 0 0.10 0.2 0.3\nv 1 0 0 1 1 1\np 1 2\n"

    def test_colors_are_columns_as_they_are_spelled(self) -> None:
        cloud = read(self.COLORED, "obj")
        assert {name: values.tolist() for name, values in cloud.columns.items()} == {
            "red": ["0.10", "1"], "green": ["0.2", "1"], "blue": ["0.3", "1"],
        }  # fmt: skip
        changed = written(replace(cloud, points=cloud.points + 0.5), "obj")
        assert changed == b"v 0.5 0.5 0.5 0.10 0.2 0.3\nv 1.5 0.5 0.5 1 1 1\np 1 2\n"
        assert lost_in(cloud, "obj") == []

    @pytest.mark.parametrize(
        ("code", "expected"), [("u1", "1.0 0.2 0.0"), ("u2", "0.003892 0.000779 0.0")]
    )
    def test_new_colors_are_shares(self, code: str, expected: str) -> None:
        colors = {
            name: np.full(2, value, code)
            for name, value in (("red", 255), ("green", 51), ("blue", 0))
        }
        cloud = replace(read(self.COLORED, "obj"), columns=colors)
        assert written(cloud, "obj").startswith(f"v 0.0 0.0 0.0 {expected}\n".encode())
        new = written(PointCloud(np.eye(2, 3), colors), "obj")
        assert new == f"v 1.0 0.0 0.0 {expected}\nv 0.0 1.0 0.0 {expected}\n".encode()

    def test_colors_of_words_in_another_format(self) -> None:
        text = read_cloud(io.BytesIO(b"x,y,z,red,green,blue\n1,2,3,255,0,51\n"), format="csv")
        assert written(text, "obj") == b"v 1.0 2.0 3.0 1.0 0.0 0.2\n"
        bad = replace(text, columns={**text.columns, "red": np.array(["much"])})
        message = r"column 'red' holds words .*, which OBJ cannot hold"
        with pytest.raises(CloudFileError, match=message):
            written(bad, "obj")

    def test_new_colors_that_are_shares_already(self) -> None:
        colors = {name: np.array([0.5, 0.25], "f4") for name in ("red", "green", "blue")}
        assert written(PointCloud(np.eye(2, 3), colors), "obj").startswith(
            b"v 1.0 0.0 0.0 0.5 0.5 0.5\nv 0.0 1.0 0.0 0.25 "
        )

    def test_a_fourth_coordinate(self) -> None:
        data = b"v 1.0 2.0 3.0 0.5\n"
        cloud = read(data, "obj")
        assert cloud.columns["w"].tolist() == ["0.5"]
        assert written(cloud, "obj") == data

    def test_lines_that_are_not_alike(self) -> None:
        data = b"v 1.0 2.0 3.0 0.1 0.2 0.3\nv 4.0 5.0 6.0\nv 7.0 8.0 9.0 1 2 3 4 5\n"
        cloud = read(data, "obj")
        assert cloud.columns == {}
        assert written(cloud, "obj") == data

    def test_normals_of_vertices(self) -> None:
        data = b"v 0.0 0.0 0.0\nvn 0 0 1\nv 1.0 0.0 0.0\nvn 0 1 0\r\n"
        data += b"f 1//1 2//2 1//1\nf 2/7/2 1/1/1 1/1/1"
        cloud = read(data, "obj")
        assert [cloud.columns[name].tolist() for name in ("nx", "ny", "nz")] == [
            ["0", "0"], ["0", "1"], ["1", "0"],
        ]  # fmt: skip
        assert written(cloud, "obj") == data
        assert lost_in(cloud, "obj") == []
        normals = {name: np.array([0.5, -1], "f4") for name in ("nx", "ny", "nz")}
        changed = written(replace(cloud, columns=normals), "obj")
        assert b"\nvn 0.5 0.5 0.5\n" in changed
        assert b"\nvn -1.0 -1.0 -1.0\r\n" in changed
        assert written(replace(cloud, columns={}), "obj") == data

    @pytest.mark.parametrize(
        "faces",
        [b"f 1//1 2//1 2//2", b"f 1 2 2", b"vn 0 0 1", b"f 1/1 2/2 1/1"],
        ids=["shared", "none named", "more normals", "none but textures"],
    )
    def test_normals_that_are_not_of_vertices_stay(self, faces: bytes) -> None:
        data = b"v 0.0 0.0 0.0\nvn 0 0 1\nv 1.0 0.0 0.0\nvn 0 1 0\n" + faces
        cloud = read(data, "obj")
        assert cloud.columns == {}
        assert written(cloud, "obj") == data

    def test_normals_of_two_numbers_stay(self) -> None:
        data = b"v 0.0 0.0 0.0\nvn 0 1"
        assert read(data, "obj").columns == {}
        assert written(read(data, "obj"), "obj") == data


class TestOff:
    @pytest.mark.parametrize(
        ("title", "more", "names"),
        [
            (b"OFF", b"", []),
            (b"NOFF", b" 0 0 1", ["nx", "ny", "nz"]),
            (b"COFF", b" 255 0 9", ["red", "green", "blue"]),
            (b"COFF", b" 0.5 0 0.25 1", ["red", "green", "blue", "alpha"]),
            (b"CNOFF", b" 0 1 0 255 0 9", ["nx", "ny", "nz", "red", "green", "blue"]),
            (b"STOFF", b" 0.5 0.5", []),
            (b"OFF 2 1 0", b"", []),
            (b"OFF # counts follow", b"", []),
        ],
    )
    def test_kinds(self, title: bytes, more: bytes, names: list[str]) -> None:
        counts = b"" if b"2" in title else b"2 1 0\n"
        rows = b"1.0 2.0 3.0" + more + b"\n4.0 5.0 6.0" + more
        data = title + b"\n" + counts + rows + b"\n3 0 1 0\n"
        cloud = read(data, "off")
        assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
        assert list(cloud.columns) == names
        assert written(cloud, "off") == data

    def test_new_normals_and_colors(self) -> None:
        data = b"CNOFF\n1 0 0\n1.0 2.0 3.0 0 0 1 9 8 7\n"
        columns: dict[str, Any] = {name: np.array([0.5], "f4") for name in ("nx", "ny", "nz")}
        columns |= {name: np.array([65535], "u2") for name in ("red", "green", "blue")}
        cloud = replace(read(data, "off"), columns=columns)
        assert written(cloud, "off") == b"CNOFF\n1 0 0\n1.0 2.0 3.0 0.5 0.5 0.5 255 255 255\n"

    def test_colors_change_the_title(self) -> None:
        colors = {name: np.array([1, 2, 3, 4], "u1") for name in ("red", "green", "blue")}
        cloud = replace(read(OFF, "off"), columns=colors)
        changed = written(cloud, "off")
        assert changed.startswith(b"COFF\n# by hand\n\n4 2 0\n0.0 0.5 1.0 1 1 1\n")
        normals = b"NOFF\n1 0 0\n1.0 2.0 3.0 0 0 1\n"
        with_normals = read(normals, "off")
        one = {name: np.array([9], "u1") for name in colors}
        more = replace(with_normals, columns={**with_normals.columns, **one})
        assert written(more, "off") == normals
        assert lost_in(more, "off") == ["column 'red'", "column 'green'", "column 'blue'"]
        again = read(changed, "off")
        assert again.columns["blue"].tolist() == ["1", "2", "3", "4"]
        assert written(PointCloud(POINTS, colors), "off").startswith(b"COFF\n4 0 0\n0.0 0.5 1.0 1 ")

    @pytest.mark.parametrize(
        ("data", "message"),
        [
            (b"", "not an OFF file: its first word is not 'OFF'"),
            (b"3 1 0\n", "not an OFF file"),
            (b"OFF BINARY\n\0\0\0\1", "of a kind of OFF that is not known, OFF BINARY; export it"),
            (b"4OFF\n1 0 0\n1 2 3 4\n", "of a kind of OFF that is not known, 4OFF"),
            (b"nOFF\n5\n1 0 0\n", "of a kind of OFF that is not known, nOFF"),
            (b"OFF\n", "its header does not say how many vertices it has; export it again"),
            (b"OFF\n# c\nmany\n", "does not say how many vertices"),
            (OFF[:45], "promises 4 vertices, but 2 lines follow; get the whole file"),
            (b"OFF 1000000000000 0 0\n1 2 3\n", "1000000000000 vertices, but 1 lines"),
        ],
    )
    def test_bad_files(self, data: bytes, message: str) -> None:
        with pytest.raises(CloudFileError, match=message):
            read(data, "off")


@pytest.mark.parametrize("format", ["obj", "off"])
@pytest.mark.parametrize("dim", [2, 3])
def test_what_is_not_finite_stays_as_it_is_spelled(format: str, dim: Any) -> None:
    rows = ["-nan(ind) 0.5 1.0", "1.#QNAN -1.#INF NULL", "nan inf 1e999", "1.0 2.0 N/A"]
    data = {
        "obj": "".join(f"v {row}\n" for row in rows).encode(),
        "off": ("OFF\n4 0 0\n" + "\n".join(rows) + "\n").encode(),
    }[format]
    cloud = read(data, format, dim=dim)
    assert not np.isfinite(cloud.points[:3]).all(axis=1).any()
    assert written(cloud, format) == data
    moved = written(replace(cloud, points=np.ones_like(cloud.points)), format)
    numbers = {
        3: [b"1.0 1.0 1.0"] * 4,
        2: [b"1.0 1.0 1.0", b"1.0 1.0 NULL", b"1.0 1.0 1e999", b"1.0 1.0 N/A"],
    }
    assert [line.removeprefix(b"v ") for line in moved.splitlines()[-4:]] == numbers[dim]


@pytest.mark.parametrize("word", [b"\0", b"1" * 33, b"0.5\0"])
def test_words_that_no_column_holds_stay_in_their_lines(word: bytes) -> None:
    for format, data in (
        ("obj", b"v 1.0 2.0 3.0 1 1 %b\nv 4.0 5.0 6.0 1 1 1\n" % word),
        ("off", b"COFF\n1 0 0\n1.0 2.0 3.0 1 1 %b\n" % word),
        ("obj", b"v 1.0 2.0 3.0\nvn 0 0 %b\n" % word),
    ):
        cloud = read(data, format)
        assert cloud.columns == {}
        assert written(cloud, format) == data


def test_only_plain_blanks_divide_words() -> None:
    data = "v 1.0 2.0 3.0 1\u20281 1\nv 4.0 5.0 6.0 1 1\n".encode()
    cloud = read(data, "obj")
    assert written(cloud, "obj") == data
    with pytest.raises(CloudFileError, match=r"line 1: '1 2\\xa03' is not three coordinates"):
        read("v 1 2\xa03\n".encode(), "obj")


def test_messages_quote_little() -> None:
    with pytest.raises(CloudFileError, match="line 1: 'aaaa") as caught:
        read(b"v " + b"a" * 9999 + b" 2 3\n", "obj")
    assert len(str(caught.value)) < 300
    with pytest.raises(CloudFileError, match="kind of OFF that is not known") as caught:
        read(b"4OFF " + b"a" * 9999 + b"\n", "off")
    assert len(str(caught.value)) < 300


def test_blank_lines_before_the_first_word() -> None:
    assert output_format(None, read(b" \n" * 50_000 + b"#\n\nOFF 1 0 0\n1 2 3\n", "off")) == "off"
    with pytest.raises(CloudFileError, match="its first word is not 'OFF'"):
        read(b" \n" * 100_000 + b"1 0 0", "off")
    with pytest.raises(CloudFileError, match="does not say how many"):
        read(b"OFF " + b"9" * 5000 + b" 0 0\n1 2 3\n", "off")


_FACET = np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])


def binary_stl(mesh: Any, attributes: bool = True) -> bytes:
    """Binary STL by the description of the format, with attributes and a name."""
    facets = np.zeros(len(mesh.faces), _FACET)
    facets["n"], facets["v"] = mesh.face_normals, mesh.triangles
    facets["a"] = np.arange(len(mesh.faces)) * attributes
    return b"solid by hand".ljust(80, b" ") + struct.pack("<I", len(facets)) + facets.tobytes()


def text_stl(mesh: Any) -> bytes:
    lines = ["solid by hand"]
    for normal, triangle in zip(mesh.face_normals, mesh.triangles, strict=True):
        lines += [f"  facet normal {' '.join(map(repr, normal.tolist()))}", "    outer loop"]
        lines += [f"      vertex {' '.join(map(repr, corner))}" for corner in triangle.tolist()]
        lines += ["    endloop", "  endfacet"]
    return "\n".join([*lines, "endsolid by hand", ""]).encode()


class TestStl:
    FILES = pytest.mark.parametrize(
        "data", [binary_stl(CUBE), text_stl(CUBE)], ids=["binary", "text"]
    )

    @FILES
    def test_rows_are_the_corners_of_the_triangles(self, data: bytes) -> None:
        cloud = read(data, "stl")
        np.testing.assert_array_equal(cloud.points, CUBE.triangles.reshape(-1, 3))
        assert len(cloud) == 36
        assert cloud.columns == {}
        assert written(cloud, "stl") == data
        assert lost_in(cloud, "stl") == []
        assert lost_in(cloud, "ply") == ["triangles of the STL file (12)"]

    @FILES
    def test_moved_corners_and_their_normals(self, data: bytes) -> None:
        cloud = read(data, "stl")
        points = cloud.points.copy()
        points[3:6] = np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.1]])
        points[9:12] = 0.5
        changed = written(replace(cloud, points=points), "stl")
        again = read(changed, "stl")
        np.testing.assert_allclose(again.points, points, rtol=1e-7)
        mesh = faces(changed, "stl")
        np.testing.assert_allclose(mesh.triangles.reshape(-1, 3), points, rtol=1e-7)
        if data.startswith(b"solid by hand "):
            table = np.frombuffer(changed, [("n", "<f4", 3), ("v", "<f4", 9), ("a", "<u2")], 12, 84)
            np.testing.assert_array_equal(table["a"], np.arange(12))
            normals = table["n"]
            assert changed[:84] == data[:84]
        else:
            rows = [line.split()[2:] for line in changed.split(b"\n") if b"facet n" in line]
            normals = np.array(rows, "f8")
        expected = np.where(np.arange(12)[:, None] == 3, 0.0, CUBE.face_normals)
        expected[1] = [1.0, 0.0, 0.0]
        np.testing.assert_allclose(normals, expected, atol=1e-7)
        moved = np.flatnonzero(np.abs(normals - CUBE.face_normals).max(axis=1) > 0.0)
        assert 3 in moved
        assert set(moved) <= {1, 3}

    def test_positions_that_are_stored(self) -> None:
        binary, text = (read(data, "stl") for data in (binary_stl(CUBE), text_stl(CUBE)))
        assert [str(cloud.position_type) for cloud in (binary, text)] == ["float32", "float64"]
        for cloud, rounds in ((binary, True), (text, False)):
            moved = replace(cloud, points=cloud.points / 3, position_type=np.dtype("f8"))
            stored = stored_positions(moved, "stl", "a.stl")
            np.testing.assert_array_equal(stored.points, read(written(moved, "stl"), "stl").points)
            assert np.any(stored.points != moved.points) == rounds
            assert stored.remedy == (
                ".ply with --double keeps them" if rounds else "--double keeps them"
            )

    def test_a_plane(self) -> None:
        data = binary_stl(CUBE)
        cloud = read(data, "stl", dim=2)
        assert cloud.points.shape == (36, 2)
        assert written(cloud, "stl") == data

    def test_what_follows_the_triangles_is_kept(self) -> None:
        data = binary_stl(CUBE) + b"more"
        assert written(read(data, "stl"), "stl") == data

    def test_a_signalling_nan_is_no_warning(self) -> None:
        data = bytearray(binary_stl(CUBE))
        struct.pack_into("<I", data, 84 + 12, 0x7FA00000)
        assert np.isnan(read(bytes(data), "stl").points[0, 0])

    def test_no_triangles(self) -> None:
        for data in (bytes(84), b"solid facets\nendsolid\n"):
            cloud = read(data, "stl")
            assert cloud.points.shape == (0, 3)
            assert written(cloud, "stl") == data

    def test_files_of_trimesh_in_both_kinds(self) -> None:
        for kind in ("stl", "stl_ascii"):
            data = CUBE.export(file_type=kind)
            data = data.encode() if isinstance(data, str) else data
            cloud = read(data, "stl")
            np.testing.assert_allclose(cloud.points, CUBE.triangles.reshape(-1, 3))

    @pytest.mark.parametrize(
        ("data", "message"),
        [
            (b"", "promises 0 triangles, which take 84 bytes, but the file has 0; get the whole"),
            (binary_stl(CUBE)[:-1], "promises 12 triangles, which take 684 bytes, .* has 683"),
            (b"x" * 80 + b"\xff" * 4, "promises 4294967295 triangles, which take 214748364834"),
            (text_stl(CUBE)[:-17], "its 12 triangles have 36 corners and the last line is not th"),
            (
                text_stl(CUBE).replace(b"      vertex", b"      corner", 1),
                "its 12 triangles have 35 corners and the last line is there; get the whole",
            ),
            (
                text_stl(CUBE).replace(b"vertex 0.5", b"vertex half", 1),
                r"line \d+: 'half .*' is not three coordinates",
            ),
        ],
    )
    def test_bad_files(self, data: bytes, message: str) -> None:
        with pytest.raises(CloudFileError, match=message):
            read(data, "stl")

    def test_points_that_are_no_triangles(self) -> None:
        cut = read(binary_stl(CUBE), "stl")
        for cloud in (PointCloud(POINTS), replace(cut, points=cut.points[3:])):
            for call in (check_cloud, stored_positions):
                message = "a: an .stl file holds triangles, which these points are not; write"
                with pytest.raises(CloudFileError, match=message):
                    call(cloud, "stl", "a")
            with pytest.raises(CloudFileError, match=r"write \.ply instead"):
                written(cloud, "stl")

    def test_columns_are_lost(self) -> None:
        cloud = read(binary_stl(CUBE), "stl", dim=2)
        more = replace(
            cloud, columns={**cloud.columns, "k1": np.zeros(36)}, comments=("c",),
            fixed_marks=np.ones(36, bool),
        )  # fmt: skip
        lost = ["column 'k1'", "the marks of fixed points", "the comments"]
        assert lost_in(more, "stl") == lost

    def test_corners_that_are_not_finite_or_huge(self) -> None:
        facets = np.frombuffer(binary_stl(CUBE)[84:], _FACET).copy()
        facets["v"][0, 0, 0] = np.nan
        facets["v"][1] = np.eye(3) * 3e38
        data = binary_stl(CUBE)[:84] + facets.tobytes()
        cloud = read(data, "stl")
        assert written(cloud, "stl") == data
        points = cloud.points.copy()
        points[[1, 3, 6]] = np.array([[np.inf, 0.0, 0.0], [2e38, 0.0, 0.0], [1.0, 2.0, 3.0]])
        after = np.frombuffer(written(replace(cloud, points=points), "stl")[84:], _FACET)
        assert not after["n"][0].any()
        lengths = np.linalg.norm(after["n"][1:3].astype("f8"), axis=1)
        np.testing.assert_allclose(lengths, 1.0, atol=1e-6)
        np.testing.assert_array_equal(after["n"][3:], facets["n"][3:])
