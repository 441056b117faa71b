"""PLY files that other programs write and read, though the format's description knows them not."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats import open_chunks, read_cloud, write_chunks, write_cloud

COLORS = "uchar red, uchar green, uchar blue"
XYZ = "float x, float y, float z"


def ascii_ply(properties: str, count: int, rows: str, more: str = "") -> bytes:
    lines = "".join(f"property {prop}\n" for prop in properties.split(", "))
    header = f"ply\nformat ascii 1.0\nelement vertex {count}\n{lines}{more}end_header\n"
    return (header + rows).encode()


def read(data: bytes) -> PointCloud:
    return read_cloud(io.BytesIO(data), format="ply")


def written(cloud: PointCloud) -> bytes:
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format="ply")
    return buffer.getvalue()


def in_chunks(data: bytes, folder: Path, rows: int) -> list[PointCloud]:
    path = folder / "cloud.ply"
    path.write_bytes(data)
    with open_chunks(path) as chunks:
        return list(chunks.read(rows))


class TestRowsOverSeveralLines:
    """A camera's position on one line, its color on the next."""

    COUNT = 3000
    DATA = ascii_ply(
        f"{XYZ}, {COLORS}",
        COUNT,
        "".join(f"{i}.5 {i} -{i} \n\n{i % 256} 1 \n 2\n" for i in range(COUNT)) + "3 0 1 2\n",
        "element face 1\nproperty list uchar int vertex_indices\n",
    )

    def test_become_one(self) -> None:
        cloud = read(self.DATA)
        numbers = np.arange(self.COUNT)
        np.testing.assert_array_equal(cloud.points, np.c_[numbers + 0.5, numbers, -numbers])
        np.testing.assert_array_equal(cloud.columns["red"], (numbers % 256).astype(np.uint8))
        assert set(cloud.columns["green"]) == {1}
        assert set(cloud.columns["blue"]) == {2}
        after = written(cloud)
        assert after.endswith(b"\n2999.5 2999.0 -2999.0 183 1 2\n3 0 1 2\n")
        assert written(read(after)) == after

    @pytest.mark.parametrize("rows", [1, 7, 1000])
    def test_become_one_in_chunks_too(self, rows: int, tmp_path: Path) -> None:
        whole = read(self.DATA)
        parts = in_chunks(self.DATA, tmp_path, rows)
        np.testing.assert_array_equal(np.concatenate([p.points for p in parts]), whole.points)
        for name, column in whole.columns.items():
            np.testing.assert_array_equal(np.concatenate([p.columns[name] for p in parts]), column)

    def test_of_other_elements_are_kept(self) -> None:
        more = "element camera 2\nproperty float a\nproperty float b\n"
        cloud = read(ascii_ply(XYZ, 1, "1 2 3\n4\n5\n6\n7\n", more))
        assert written(cloud).endswith(b"1.0 2.0 3.0\n4 5\n6 7\n")

    def test_with_too_many_values(self) -> None:
        data = ascii_ply(XYZ, 2, "1 2\n3\n4 5\n6 7\n")
        with pytest.raises(CloudFileError, match="row 1: 4 values, expected 3"):
            read(data)

    def test_that_are_not_all_there(self) -> None:
        data = ascii_ply(XYZ, 3, "1.0 2.0\n3.0\n4 5\n6\n7 8\n")
        with pytest.raises(CloudFileError, match="promises 3 vertex rows, but 2 follow"):
            read(data)


class TestHeader:
    def test_blank_lines(self) -> None:
        data = ascii_ply(XYZ, 1, "1 2 3\n")
        cloud = read(data.replace(b"\n", b"\n \n\n", 4))
        assert cloud.points.tolist() == [[1, 2, 3]]
        assert written(cloud) == written(read(data))

    @pytest.mark.parametrize("name", ["cloud.ply", "cloud.txt"])
    def test_byte_order_mark(self, name: str, tmp_path: Path) -> None:
        path = tmp_path / name
        path.write_bytes(b"\xef\xbb\xbf" + ascii_ply(XYZ, 1, "1 2 3\n"))
        cloud = read_cloud(path)
        assert cloud.points.tolist() == [[1, 2, 3]]
        assert written(cloud).startswith(b"ply\nformat ascii 1.0\nelement")

    def test_names_with_blanks(self) -> None:
        properties = (
            f"float x, float y, float Roughness (0.1), list uchar int two  words, {XYZ[-7:]}"
        )
        data = ascii_ply(properties, 1, "1.0 2.0 0.5 1 7 3.0\n")
        cloud = read(data)
        assert list(cloud.columns) == ["Roughness (0.1)", "two  words"]
        assert cloud.columns["Roughness (0.1)"].tolist() == [0.5]
        assert written(cloud) == data

    def test_new_names_get_none(self) -> None:
        cloud = PointCloud(np.zeros((1, 3)), {"two words": np.ones(1, np.float32)})
        assert b"property float two_words\n" in written(cloud)

    @pytest.mark.parametrize(
        ("line", "message"),
        [
            ("element my vertex 1", "'element my vertex 1', expected .element {name} {count}"),
            ("property flot w", "'property flot w', field type 'flot' not in"),
            ("property list uchar int", "'property list uchar int', expected"),
            ("elephant", "'elephant', expected one of"),
        ],
    )
    def test_wrong_line_is_shown(self, line: str, message: str) -> None:
        data = ascii_ply(XYZ, 1, "1 2 3\n").replace(b"\nend_h", f"\n\n{line}\nend_h".encode())
        with pytest.raises(CloudFileError, match=message):
            read(data)

    @pytest.mark.parametrize("count", ["ten", "-1", "1_0"])
    def test_wrong_count_is_shown(self, count: str) -> None:
        data = ascii_ply(XYZ, 1, "1 2 3\n").replace(b"vertex 1", f"vertex {count}".encode())
        with pytest.raises(CloudFileError, match=f"an element has {count} rows"):
            read(data)


class TestWholeNumbers:
    def test_with_a_point(self) -> None:
        rows = "1 2 3 255.0 0.0 1e1\n1 2 3 7 8 9\n"
        cloud = read(ascii_ply(f"{XYZ}, {COLORS}", 2, rows))
        colors = np.stack([cloud.columns[name] for name in ("red", "green", "blue")], axis=1)
        assert colors.dtype == np.uint8
        assert colors.tolist() == [[255, 0, 10], [7, 8, 9]]
        assert written(cloud).endswith(b"1.0 2.0 3.0 255 0 10\n1.0 2.0 3.0 7 8 9\n")

    @pytest.mark.parametrize("kind", ["char", "uchar", "short", "ushort", "int", "uint"])
    def test_at_the_ends_of_a_type(self, kind: str) -> None:
        code = {"c": "i1", "s": "i2", "i": "i4"}[kind.removeprefix("u")[0]]
        limits = np.iinfo(code.replace("i", "u") if kind[0] == "u" else code)
        data = ascii_ply(f"{XYZ}, {kind} n", 2, f"0 0 0 {limits.max}.0\n0 0 0 {limits.min}.0\n")
        assert read(data).columns["n"].tolist() == [limits.max, limits.min]
        with pytest.raises(CloudFileError, match=f"row 0: n is '{limits.max + 1}.0', not a number"):
            read(data.replace(str(limits.max).encode(), str(limits.max + 1).encode()))

    @pytest.mark.parametrize(
        "word", ["1.5", "256", "-1", "-0.5", "nan", "inf", "1e99", "1_0", "red"]
    )
    def test_others_are_shown(self, word: str) -> None:
        data = ascii_ply(f"{XYZ}, {COLORS}", 2, f"1 2 3 4 5 6\n1 2 3 255.0 {word} 1\n")
        with pytest.raises(
            CloudFileError, match=f"row 1: green is '{word}', not a number of type u"
        ):
            read(data)


class TestNumbersThatAreNotFinite:
    WORDS = ("-nan(ind)", "1.#QNAN", "-1.#IND", "1.#INF", "-1.#INF", "nan(snan)", "NaN", "-inf")

    def data(self) -> bytes:
        rows = "".join(
            f"{word} {row}.0 {row}.0 {self.WORDS[-row]}\n" for row, word in enumerate(self.WORDS)
        )
        count = 2 * len(self.WORDS)
        return ascii_ply(f"{XYZ}, double w", count, rows + rows)

    def test_are_read_and_spelled_as_they_were(self) -> None:
        data = self.data()
        cloud = read(data)
        x = [np.nan, np.nan, np.nan, np.inf, -np.inf, np.nan, np.nan, -np.inf]
        np.testing.assert_array_equal(cloud.points[:, 0], x + x)
        np.testing.assert_array_equal(cloud.columns["w"][1:4], [-np.inf, np.nan, np.nan])
        assert written(cloud) == data

    @pytest.mark.parametrize("rows", [1, 5, 1000])
    def test_in_chunks(self, rows: int, tmp_path: Path) -> None:
        source, target = tmp_path / "a.ply", tmp_path / "b.ply"
        source.write_bytes(self.data())
        with open_chunks(source) as chunks:
            write_chunks(target, chunks.template, chunks.count, chunks.read(rows))
        assert target.read_bytes() == self.data()

    @pytest.mark.parametrize("row", ["1 2 3 -inf\x1c", "1\x1c2 3 -Inf"])
    def test_next_to_a_control_character_that_parts_words(self, row: str) -> None:
        cloud = read(ascii_ply(f"{XYZ}, float w", 2, f"1 2 3 -Inf\n{row}\n"))
        again = read(written(cloud))
        assert cloud.columns["w"].tolist() == again.columns["w"].tolist() == [-np.inf, -np.inf]
        np.testing.assert_array_equal(again.points, [[1, 2, 3], [1, 2, 3]])

    def test_that_became_others_are_not_spelled_as_before(self) -> None:
        cloud = read(ascii_ply(f"{XYZ}, float w", 2, "1.#INF 1 2 NaN\n1.#IND 1 2 NaN\n"))
        points = cloud.points.copy()
        points[:, 0] = [np.nan, 5.0]
        new = replace(cloud, points=points, columns={"w": np.array([0.5, np.nan])})
        assert written(new).endswith(b"\nnan 1.0 2.0 0.5\n5.0 1.0 2.0 NaN\n")
        fewer = replace(cloud, points=cloud.points[:1], columns={"w": np.array([np.nan])})
        assert written(fewer).endswith(b"header\n1.#INF 1.0 2.0 NaN\n")

    def test_beside_lists_are_refused_by_name(self) -> None:
        with pytest.raises(CloudFileError, match="row 0: property 'x': malformed"):
            read(ascii_ply(f"{XYZ}, list uchar int near", 1, "1.#IND 1 2 0\n"))
