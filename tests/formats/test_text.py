from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats import read_cloud, write_cloud

REPORT = Path(__file__).parents[2] / "data" / "report"


def read(text: str | bytes, format: str = "txt", **options: Any) -> PointCloud:
    data = text.encode() if isinstance(text, str) else text
    return read_cloud(io.BytesIO(data), format=format, **options)


def written(cloud: PointCloud, format: str) -> str:
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format=format)
    return buffer.getvalue().decode()


def with_new(cloud: PointCloud, **columns: Any) -> PointCloud:
    return replace(cloud, columns=cloud.columns | columns)


TWO_POINTS = [[1, 2, 3], [-4.5, 5e-3, 6]]


@pytest.mark.parametrize(
    ("text", "other_columns"),
    [
        ("1 2 3\n-4.5 5e-3 6\n", []),
        ("1 2 3\n-4.5 5e-3 6", []),
        ("  1   2\t3  \n\n-4.5 5e-3 6 \n\n\n", []),
        ("1 2 3\r\n-4.5 5e-3 6\r\n", []),
        ("1 2 3\r-4.5 5e-3 6\r", []),
        ("\ufeff1 2 3\n-4.5 5e-3 6\n", []),
        ("1,2,3\n-4.5,5e-3,6\n", []),
        ("1, 2, 3\n-4.5, 5e-3, 6\n", []),
        ("1;2;3\n-4.5;5e-3;6\n", []),
        ("1\t2\t3\n-4.5\t5e-3\t6\n", []),
        ('"1","2","3"\n"-4.5","5e-3","6"\n', []),
        ("2\n1 2 3\n-4.5 5e-3 6\n", []),
        ("# scan\n// by hand\n1 2 3\n# half\n-4.5 5e-3 6\n", []),
        ("x y z\n1 2 3\n-4.5 5e-3 6\n", []),
        ("2\n1 2 3 8\n-4.5 5e-3 6 9\n", ["column_4"]),
        ("1,2,3,a;b\n-4.5,5e-3,6,c\n", ["column_4"]),
        ('1,2,3,"a,b"\n-4.5,5e-3,6,"c"\n', ["column_4"]),
        ("1 2 3 a,b\n-4.5 5e-3 6 c\n", ["column_4"]),
        ("1\t2\t3\ta b\n-4.5\t5e-3\t6\t\n", ["column_4"]),
        ("x,y,z,intensity\n1,2,3,7\n-4.5,5e-3,6,8\n", ["intensity"]),
        ('"X","Y","Z","I t"\n1,2,3,7\n-4.5,5e-3,6,8\n', ["I t"]),
        ("id;Z;y;X\n7;3;2;1\nb;6;5e-3;-4.5\n", ["id"]),
        ("//X Y Z R G B sf Nx Ny Nz\n1 2 3 4 5 6 7 0 0 1\n-4.5 5e-3 6 4 5 6 7 0 1 0\n",
         ["R", "G", "B", "sf", "nx", "ny", "nz"]),
        ("//X,Y,Z,R\n2\n1,2,3,4\n-4.5,5e-3,6,5\n", ["R"]),
        ("# made on Monday\n# x y z nx ny nz\n1 2 3 0 0 1\n-4.5 5e-3 6 0 0 1\n",
         ["nx", "ny", "nz"]),
        ("# x, y, z, i\n1 2 3 9\n-4.5 5e-3 6 9\n", ["i"]),
        ("Easting,Northing,Height,Code\n1,2,3,7\n-4.5,5e-3,6,8\n", ["Code"]),
        ("x,y,z,,a,a\n1,2,3,4,5,6\n-4.5,5e-3,6,4,5,6\n", ["column_4", "a", "column_6"]),
        ("1 2 3 0.6 0 0.8\n-4.5 5e-3 6 0 0 0\n", ["nx", "ny", "nz"]),
        ("1 2 3 nan 0 0\n-4.5 5e-3 6 0 1 0\n", ["nx", "ny", "nz"]),
        ("1 2 3 0.6 0 0.9\n-4.5 5e-3 6 0 0 1\n", ["column_4", "column_5", "column_6"]),
        ("1 2 3 0 0 0\n-4.5 5e-3 6 0 0 0\n", ["column_4", "column_5", "column_6"]),
        ("1 2 3 a 0 1\n-4.5 5e-3 6 0 0 1\n", ["column_4", "column_5", "column_6"]),
    ],
)  # fmt: skip
def test_dialects(text: str, other_columns: list[str]) -> None:
    cloud = read(text)
    assert cloud.points.tolist() == TWO_POINTS
    assert list(cloud.columns) == other_columns
    assert cloud.points.flags.c_contiguous


@pytest.mark.parametrize(
    ("text", "format", "dim", "expected"),
    [
        ("1 2\n", "txt", "auto", [[1, 2]]),
        ("1 2 3\n", "xy", "auto", [[1, 2]]),
        ("1 2 3\n", "xy", 3, [[1, 2, 3]]),
        ("1 2 3\n", "xyz", 2, [[1, 2]]),
        ("x,y,i\n1,2,3\n", "csv", "auto", [[1, 2]]),
        ("x,y,z\n1,2,3\n", "csv", 2, [[1, 2]]),
        ("1 2 3 4\n", "xyz", "auto", [[1, 2, 3]]),
    ],
)
def test_dimension(text: str, format: str, dim: Any, expected: list[list[float]]) -> None:
    assert read(text, format, dim=dim).points.tolist() == expected


def test_normals_are_found_behind_the_positions_or_at_the_end() -> None:
    assert list(read("1 2 0 1\n", "xy").columns) == ["nx", "ny"]
    assert list(read("1 2 7 0.6 0.8\n", "xy").columns) == ["column_3", "nx", "ny"]
    assert list(read("1 2 3 0 0 1 9\n").columns) == ["nx", "ny", "nz", "column_7"]
    assert list(read("1 2 3 9 0 0 1\n").columns) == ["column_4", "nx", "ny", "nz"]
    assert list(read("1 2 7 0.6 0.9\n", "xy").columns) == ["column_3", "column_4", "column_5"]


def test_2d_keeps_z() -> None:
    assert read("X,Y,Z\n1,2,3\n", "csv", dim=2).columns["z"].tolist() == ["3"]


def test_columns_keep_their_spelling() -> None:
    cloud = read("x y z id t\n1 2 3 00012345678901234567890 1.50\n")
    assert cloud.columns["id"].tolist() == ["00012345678901234567890"]
    assert cloud.columns["t"].tolist() == ["1.50"]


def test_nan_and_inf_are_positions() -> None:
    np.testing.assert_array_equal(
        read("nan inf -INF\n1 2 3\n").points, [[np.nan, np.inf, -np.inf], [1, 2, 3]]
    )


@pytest.mark.parametrize(("format", "dimension"), [("txt", 3), ("xyz", 3), ("xy", 2)])
@pytest.mark.parametrize("text", ["", "\n\n", "# nothing\n", "0\n"])
def test_no_rows(text: str, format: str, dimension: int) -> None:
    cloud = read(text, format)
    assert cloud.points.shape == (0, dimension)
    assert read(written(cloud, format), format).points.shape == (0, dimension)


def test_header_without_rows() -> None:
    cloud = read("x,y,i\n", "csv")
    assert cloud.points.shape == (0, 2)
    assert written(cloud, "csv") == "x,y,i\n"


@pytest.mark.parametrize(
    ("text", "points", "marks", "columns"),
    [
        ("1 2 fixed\n3 4\n", [[1, 2], [3, 4]], [True, False], []),
        ("1 2\n3 4 FIXED\n", [[1, 2], [3, 4]], [False, True], []),
        ("1,2,3,Fixed\n4,5,6\n", [[1, 2, 3], [4, 5, 6]], [True, False], []),
        ("1 2 fixed\n3 4 fixed\n", [[1, 2], [3, 4]], [True, True], []),
        ("x,y,state\n1,2,fixed\n3,4,free\n", [[1, 2], [3, 4]], None, ["state"]),
        ("x,y,state\n1,2,fixed,fixed\n3,4,a\n", [[1, 2], [3, 4]], [True, False], ["state"]),
        ("# x y i\n1 2 9 fixed\n3 4 9\n", [[1, 2], [3, 4]], [True, False], ["i"]),
        ("1 2 3 fixed\n4 5 6 free\n", [[1, 2, 3], [4, 5, 6]], None, ["column_4"]),
    ],
)
def test_fixed_word(
    text: str, points: list[list[float]], marks: list[bool] | None, columns: list[str]
) -> None:
    cloud = read(text)
    assert cloud.points.tolist() == points
    assert (None if cloud.fixed_marks is None else cloud.fixed_marks.tolist()) == marks
    assert list(cloud.columns) == columns


@pytest.mark.parametrize("path", sorted(REPORT.glob("*.xy")), ids=lambda path: path.stem)
def test_inputs_of_the_report(path: Path) -> None:
    cloud = read_cloud(path)
    words = [line.split() for line in path.read_text().splitlines() if line.strip()]
    assert cloud.points.tolist() == [[float(x), float(y)] for x, y, *_ in words]
    again = read(written(cloud, "xy"), "xy")
    np.testing.assert_array_equal(again.points, cloud.points)


def test_fixed_points_of_the_report() -> None:
    cloud = read_cloud(REPORT / "line_fixed.xy")
    assert cloud.fixed_marks is not None
    assert np.flatnonzero(cloud.fixed_marks).tolist() == [0, len(cloud) - 1]
    assert written(cloud, "xy") == (REPORT / "line_fixed.xy").read_text()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3\n4 5\n", "line 2 has 2 columns, expected 3"),
        ("1 2 3\n\n# note\n4 5 6 7\n", "line 4 has 4 columns, expected 3"),
        ("1 2 3 4\n1\n", "line 2 has 1 column, expected 4"),
        ("1 2\n3 4 5 6\n", "line 2 has 4 columns, expected 2"),
        ("x,y,z\n1,2\n", "line 2 has 2 columns, expected 3"),
        ("1 2 3\n\n4 abc 6\n", "line 3: 'abc' is not a number; correct or remove"),
        ("1 2 3\n4 1_0 6\n", "line 2: '1_0' is not a number"),
        ("1 2 3 4\n4 1_0 6 7\n", "line 2: '1_0' is not a number"),
        ("1,5;2,5;3,5\n4;5.5;6\n", "line 2: '5.5' is not a number; write all decimals"),
        ("x,y,z\n1,2,3\nabc,5,6\n", "line 3: 'abc' is not a number; correct or remove"),
        ("1 2 3\n4 a,b 6\n", "line 2: 'a,b' is not a number; correct or remove"),
        ("1,5 2,5 3.5\n", "line 1: '3.5' is not a number; write all decimals alike"),
        ("12.5\n13.5\n", "its rows have 1 column, a point needs at least 2"),
        ("5\n6\n", "its rows have 1 column"),
        (b"1 2 3\n\xff\xfe\x80\1", "not a point cloud"),
        (b"LASF\0\0\1\2", "not a point cloud"),
        ("1 2 3".encode("utf-16"), "UTF-16 text; save it as UTF-8"),
    ],
)
def test_what_cannot_be_read(text: str | bytes, message: str) -> None:
    with pytest.raises(CloudFileError, match=message):
        read(text)


def test_line_number_beyond_the_first_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pcsmooth.formats.text.values.ROWS_AT_A_TIME", 2)
    good = "# c\n" + "1 2 3 a\n" * 5
    assert len(read(good)) == 5
    assert read(good).columns["column_4"].tolist() == ["a"] * 5
    with pytest.raises(CloudFileError, match="line 7: 'oops' is not a number"):
        read(good + "1 oops 3 a\n")
    with pytest.raises(CloudFileError, match="line 7 has 2 columns"):
        read(good + "1 2\n")
    marks = read(good + "1 2 3 a fixed\n").fixed_marks
    assert marks is not None
    assert np.flatnonzero(marks).tolist() == [5]


@pytest.mark.parametrize("text", ["1 2\n", "x,y\n1,2\n", "x,y,i\n1,2,3\n"])
def test_dim_3_needs_three(text: str) -> None:
    with pytest.raises(CloudFileError, match="have 2 coordinates, not 3; read it as a 2D cloud"):
        read(text, dim=3)


@pytest.mark.parametrize(
    ("text", "format"),
    [
        ("1.0 2.0\n3.5 4.0\n", "xy"),
        ("1.0 2.0 3.0 255 word\n3.5 4.0 1e-07 0 other\n", "xyz"),
        ("1.0 2.0 3.0 255\n3.5 4.0 1e-07 0\n", "xyz"),
        ("1.0\t2.0\t3.0\n", "xyz"),
        ("# note\n//again\n1.0 2.0 3.0\n", "xyz"),
        ("2\n1.0 2.0 3.0 7\n3.5 4.0 1.0 8\n", "pts"),
        ("1\n1.0 2.0 3.0\n", "xyz"),
        ("x y z i\n1.0 2.0 3.0 7\n", "xyz"),
        ('"X","Y","Z","I t"\n1.0,2.0,3.0,"a,b"\n', "csv"),
        ("id;z;y;x\n007;3.0;2.0;1.0\n", "csv"),
        ("//X Y Z R\n1\n1.0 2.0 3.0 7\n", "txt"),
        ("# x y z i\n1.0 2.0 3.0 7\n", "asc"),
        ("x\ty\tz\ti\n1.0\t2.0\t3.0\t\n", "txt"),
        ("//X Y Z i\n1.0 2.0 3.0 7 fixed\n2.0 2.0 3.0 8\n", "txt"),
        ("x,y,i\n1.0,2.0,7,fixed\n1.0,2.0,8\n", "csv"),
        ("Easting,Northing,Height,Code\n1.0,2.0,3.0,7\n", "csv"),
    ],
)
def test_same_kind_comes_back_unchanged(text: str, format: str) -> None:
    assert written(read(text, format), format) == text


def test_positions_are_as_short_as_their_type_allows() -> None:
    points = np.array([[0.1, 1 / 3, 1e22], [np.nan, -np.inf, -0.0]])
    cloud = PointCloud(points)
    assert written(cloud, "xyz") == "0.1 0.3333333333333333 1e+22\nnan -inf -0.0\n"
    single = replace(cloud, position_type=np.dtype(np.float32))
    assert written(single, "xyz") == "0.1 0.33333334 1e+22\nnan -inf -0.0\n"
    whole = replace(cloud, position_type=np.dtype(np.int16))
    assert written(whole, "xyz") == written(cloud, "xyz")


def test_numeric_columns_are_spelled_in_their_own_type() -> None:
    columns: dict[str, Any] = {
        "f": np.array([0.1], np.float32),
        "i": np.array([2**63 - 1]),
        "b": np.array([True]),
    }
    text = written(PointCloud(np.zeros((1, 3)), columns), "csv")
    assert text == "x,y,z,f,i,b\n0.0,0.0,0.0,0.1,9223372036854775807,1\n"


NORMALS = {name: np.array([0.0]) for name in ("nx", "ny", "nz")}


@pytest.mark.parametrize(
    ("text", "source", "target", "expected"),
    [
        ("1 2 3\n", "xyz", "xyz", "1.0 2.0 3.0 0.0 0.0 0.0\n"),
        ("1 2 3 9\n", "xyz", "xyz", "1.0 2.0 3.0 9 0.0 0.0 0.0\n"),
        ("1 2 3 0 0 1\n", "xyz", "xyz", "1.0 2.0 3.0 0.0 0.0 0.0\n"),
        ("1 2 3\n", "xyz", "pts", "1\n1.0 2.0 3.0 0.0 0.0 0.0\n"),
        ("# c\n1,2,3,9\n", "csv", "xyz", "1.0 2.0 3.0 9 0.0 0.0 0.0\n"),
        ("id,z,y,x\n9,3,2,1\n", "csv", "xyz", "1.0 2.0 3.0 9 0.0 0.0 0.0\n"),
        ("x y z i\n1 2 3 9\n", "xyz", "xyz", "x y z i Nx Ny Nz\n1.0 2.0 3.0 9 0.0 0.0 0.0\n"),
        ("1 2 3\n", "xyz", "csv", "x,y,z,nx,ny,nz,h\n1.0,2.0,3.0,0.0,0.0,0.0,0.5\n"),
        ("1 2 3 9\n", "xyz", "txt",
         "//X Y Z column_4 Nx Ny Nz h\n1.0 2.0 3.0 9 0.0 0.0 0.0 0.5\n"),
        ("x,y,z,i t\n1,2,3,9\n", "csv", "asc",
         "//X,Y,Z,i t,Nx,Ny,Nz,h\n1.0,2.0,3.0,9,0.0,0.0,0.0,0.5\n"),
        ("X,Y,Z,I\n1,2,3,9\n", "csv", "csv",
         "X,Y,Z,I,nx,ny,nz,h\n1.0,2.0,3.0,9,0.0,0.0,0.0,0.5\n"),
        ("# x y z Nx Ny Nz\n1 2 3 1 0 0\n", "txt", "txt",
         "# x y z Nx Ny Nz h\n1.0 2.0 3.0 0.0 0.0 0.0 0.5\n"),
    ],
)  # fmt: skip
def test_new_columns(text: str, source: str, target: str, expected: str) -> None:
    cloud = with_new(read(text, source), **NORMALS, h=np.array([0.5]))
    assert written(cloud, target) == expected


@pytest.mark.parametrize("format", ["xyz", "pts"])
def test_flat_cloud_gets_what_viewers_expect(format: str) -> None:
    count = "1\n" if format == "pts" else ""
    cloud = read("1 2\n", "xy")
    assert written(cloud, format) == f"{count}1.0 2.0 0.0\n"
    normals = with_new(cloud, nx=np.array([0.6]), ny=np.array([0.8]))
    assert written(normals, format) == f"{count}1.0 2.0 0.0 0.6 0.8 0.0\n"
    assert written(normals, "xy") == "1.0 2.0 0.6 0.8\n"
    other = with_new(read("x,y,i\n1,2,9\n", "csv"))
    assert written(other, format) == f"{count}1.0 2.0 0.0 9\n"
    own = read("9 1 2 3\n", "xy", dim=2)
    assert written(own, "xy") == "9.0 1.0 2 3\n"
    kept = read("x,y,z\n1,2,3\n", "csv", dim=2)
    assert written(kept, format) == f"{count}1.0 2.0 3\n"


@pytest.mark.parametrize("format", ["txt", "asc", "csv"])
@pytest.mark.parametrize(
    "text", ["1 2 3 9\n4 5 6 8\n", "x,y\n1,2\n3,4\n", "y\tx\tz\ti\n1\t2\t3\t\n"]
)
def test_second_pass_changes_nothing(text: str, format: str) -> None:
    cloud = read(text)
    normals = {f"n{axis}": np.ones(len(cloud)) for axis in "xyz"[: cloud.dimension]}
    once = written(with_new(cloud, **normals, k=np.ones(len(cloud))), format)
    again = read(once, format)
    np.testing.assert_array_equal(again.points, cloud.points)
    assert list(again.columns) == [*cloud.columns, *normals, "k"]
    twice = with_new(again, **normals, k=np.ones(len(cloud)))
    assert written(twice, format) == once


def test_word_that_a_space_would_break() -> None:
    cloud = read("x,y,z,kind\n1,2,3,old oak\n", "csv")
    with pytest.raises(CloudFileError, match=r"column 'kind' holds 'old oak'.*write \.csv"):
        written(cloud, "xyz")


def test_word_with_the_delimiter_is_quoted() -> None:
    cloud = read('1 2 3 a,b 5"\n4 5 6 c "d"\n', "xyz")
    text = written(cloud, "csv")
    assert text == 'x,y,z,column_4,column_5\n1.0,2.0,3.0,"a,b","5"""\n4.0,5.0,6.0,c,"d"\n'
    assert read(text, "csv").columns["column_4"].tolist() == ['"a,b"', "c"]


def test_new_name_cannot_break_the_header() -> None:
    cloud = PointCloud(np.zeros((1, 3)), {"a b,c": np.ones(1)})
    assert written(cloud, "txt").startswith("//X Y Z a_b,c\n")
    assert written(cloud, "csv").startswith("x,y,z,a b_c\n")


def test_third_coordinate_does_not_fit_in_xy() -> None:
    with pytest.raises(CloudFileError, match=r"no third coordinate; write \.xyz"):
        written(read("1 2 3\n", "xyz"), "xy")
    assert written(read("1 2 3\n", "xy", dim=3), "xy") == "1.0 2.0 3.0\n"


def test_removed_comment_is_not_written() -> None:
    cloud = read("# keep\n# drop\n1 2 3\n", "xyz")
    assert cloud.comments == ("keep", "drop")
    assert written(replace(cloud, comments=("keep",)), "xyz") == "# keep\n1.0 2.0 3.0\n"
