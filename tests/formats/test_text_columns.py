"""Which columns of a text file become coordinates: by their names, by choice, or none."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats import coordinate_columns, read_cloud, write_cloud


def read(text: str, format: str = "csv", **options: Any) -> PointCloud:
    return read_cloud(io.BytesIO(text.encode()), format=format, **options)


def written(cloud: PointCloud, format: str) -> str:
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format=format)
    return buffer.getvalue().decode()


@pytest.mark.parametrize(
    ("text", "format", "others"),
    [
        ("PointID,Easting,Northing,Elevation\n1000,1.0,2.0,3.0\n", "csv", {"PointID": "1000"}),
        ("id,Hochwert,Rechtswert,Höhe\nA7,2.0,1.0,3.0\n", "csv", {"id": "A7"}),
        ('"Scalars_","Points:0","Points:1","Points:2"\n0,1.0,2.0,3.0\n', "csv", {"Scalars_": "0"}),
        ("//Easting Northing Elevation R G B\n1.0 2.0 3.0 4 5 6\n", "txt",
         {"R": "4", "G": "5", "B": "6"}),
        ("# t x_m y_m z_m\n0.5 1.0 2.0 3.0\n", "xyz", {"t": "0.5"}),
        ("!X Y Z\n1.0 2.0 3.0\n", "asc", {}),
        ("x [m] y [m] z [m] t\n1.0 2.0 3.0 4\n", "txt", {"t": "4"}),
        ("E;N;H;k;\n1.0;2.0;3.0;a;\n", "csv", {"k": "a"}),
        ("X,Y,Z,Normals:0,Normals:1,Normals:2\n1.0,2.0,3.0,0,0,1\n", "csv",
         {"nx": "0", "ny": "0", "nz": "1"}),
    ],
)  # fmt: skip
def test_named_columns_are_taken_and_the_file_comes_back(
    text: str, format: str, others: dict[str, str]
) -> None:
    cloud = read(text, format)
    assert cloud.points.tolist() == [[1, 2, 3]]
    assert {name: column.tolist() for name, column in cloud.columns.items()} == {
        name: [word] for name, word in others.items()
    }
    assert written(cloud, format) == text.replace(";\n", "\n")


def test_a_header_of_spaces_serves_rows_of_commas() -> None:
    assert read("//X Y Z i\n1,2,3,4\n").columns["i"].tolist() == ["4"]


def test_the_height_of_a_plane_cloud_is_its_z() -> None:
    cloud = read("Easting,Northing,Elevation,id\n1,2,3,4\n", dim=2)
    assert cloud.points.tolist() == [[1, 2]]
    assert list(cloud.columns) == ["z", "id"]


@pytest.mark.parametrize(
    ("text", "columns", "expected"),
    [
        ("1 10 20 30\n2 11 21 31\n3 12 22 32\n", [2, 3, 4], [10, 20, 30]),
        ("1 10 20 30\n2 11 21 31\n3 12 22 32\n", ["1", "2", "3"], [1, 10, 20]),
        ("1 10 20 30\n2 11 21 31\n3 12 22 32\n", [4, 2], [30, 10]),
        ("A,B,b,x\n1,2,3,4\n", ("B", "x", "a"), [2, 4, 1]),
        ("1,3,2\n7,8,9\n", ("3", "2", "1"), [2, 3, 1]),
        ("x,y,z,X_new,Y_new\n1,2,3,4,5\n", ("X_new", "Y_new", "z"), [4, 5, 3]),
    ],
)
def test_chosen_columns(text: str, columns: Any, expected: list[float]) -> None:
    cloud = read(text, "txt", columns=columns)
    assert cloud.points[0].tolist() == expected
    assert len(cloud.columns) == len(text.split("\n")[0].replace(",", " ").split()) - len(expected)
    again = read(written(cloud, "txt"), "txt", columns=columns)
    np.testing.assert_array_equal(again.points, cloud.points)


def test_normals_behind_chosen_columns_are_found() -> None:
    rows = "1 5 5 5 0 0 1\n2 6 6 6 0 1 0\n3 7 7 7 1 0 0\n"
    assert list(read(rows, "xyz", columns=[2, 3, 4]).columns) == ["column_1", "nx", "ny", "nz"]


@pytest.mark.parametrize(
    ("text", "columns", "message"),
    [
        ("a,b,c\n1,2,3\n", ["a", "b", "d"], r"no column 'd', .*; choose a, b, c, or a number from"),
        ("1 2 3\n", [1, 2, 4], "no column '4', or more than one; choose a number from 1 to 3"),
        ("1 2 3\n", [0, 1, 2], "no column '0'"),
        ("1 2 3\n", ["9" * 5000, 1, 2], "no column '9999"),
        ("a,A,c\n1,2,3\n", ["c", "C", "a"], "'c' is two coordinates at once; choose others"),
        ("a,a,c\n1,2,3\n", ["a", "c"], "no column 'a', or more than one"),
    ],
)
def test_columns_that_cannot_be_chosen(text: str, columns: Any, message: str) -> None:
    with pytest.raises(CloudFileError, match=message):
        read(text, columns=columns)


@pytest.mark.parametrize(
    ("columns", "dim", "message"),
    [
        ([1], "auto", "those of 2 or 3 coordinates, not 1"),
        ([1, 2, 3, 4], "auto", "not 4"),
        ([1, 2], 3, "those of 3 coordinates, not 2"),
    ],
)
def test_as_many_columns_as_coordinates(columns: list[int], dim: Any, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        read("1 2 3\n", columns=columns, dim=dim)


@pytest.mark.parametrize("text", ["", "# nothing\n", "\n\n"])
def test_columns_of_no_points(text: str) -> None:
    assert read(text, columns=[1, 2, 3]).points.shape == (0, 3)
    assert read(text, columns=["x", "y"]).points.shape == (0, 2)


def test_columns_are_chosen_in_text_alone() -> None:
    with pytest.raises(CloudFileError, match=r"ply files say which .* in text files only"):
        read_cloud(io.BytesIO(b"ply\n"), columns=[1, 2, 3])


@pytest.mark.parametrize("header", ["a,b,c,d", "x,b,c,d", "id,kind,value,note"])
def test_a_header_without_coordinates_is_asked_about(header: str) -> None:
    with pytest.raises(CloudFileError, match=rf"names no coordinates \({header[0]}.*--columns 1,2"):
        read(f"{header}\n1,2,3,4\n")


def test_two_columns_for_one_coordinate_are_asked_about() -> None:
    text = "x_m,x_ft,y_m,z_m\n1,2,3,4\n"
    with pytest.raises(CloudFileError, match=r"'x_m' and 'x_ft' may both be x; .*--columns"):
        read(text)
    assert read(text, columns=["x_m", "y_m", "z_m"]).points.tolist() == [[1, 3, 4]]
    heights = "x,y,height,elevation\n1,2,3,4\n"
    with pytest.raises(CloudFileError, match="may both be z"):
        read(heights)
    assert read(heights, dim=2).points.tolist() == [[1, 2]]


@pytest.mark.parametrize(
    "text",
    [
        "0 0.5 1.5 2.5\n1 0.7 1.5 2.5\n2 0.9 1.5 2.5\n",
        "1 5 5 5\n2 6 6 6\n3 7 7 7\n",
        "1,0.5,1.5,2.5,oak\n2,0.7,1.5,2.5,elm\n3,0.9,1.5,2.5,ash\n",
        "1000 0.5 1.5 2.5 7\n1002 0.7 1.5 2.5 7\n1007 0.9 1.5 2.5 7\n",
        "# survey\n4 0.5 1.5 2.5\n5 0.7 1.5 nan\n6 0.9 1.5 2.5\n",
        "1.0 0.5 1.5 2.5\n2.0 0.7 1.5 2.5\n3.0 0.9 1.5 2.5\n",
        "0.000e+00 5.0e-01 1.5 2.5\n1.000e+00 7.0e-01 1.5 2.5\n2.000e+00 9.0e-01 1.5 2.5\n",
        "1,0;0,5;1,5;2,5\n2,0;0,5;1,5;2,5\n3,0;0,5;1,5;2,5\n",
        '"1";"0,5";"1,5";"2,5"\n"2";"0,5";"1,5";"2,5"\n"3";"0,5";"1,5";"2,5"\n',
    ],
)
@pytest.mark.parametrize("format", ["txt", "xyz", "pts", "csv"])
def test_a_running_number_is_asked_about(text: str, format: str) -> None:
    with pytest.raises(CloudFileError, match=r"begin with a running number, .*--columns 2,3,4, or"):
        read(text, format)
    cloud = read(text, format, columns=[2, 3, 4])
    assert cloud.points[0].max() in (2.5, 5)
    assert len(cloud.columns["column_1"]) == 3


@pytest.mark.parametrize(
    "text",
    [
        "1 0.5 1.5\n2 0.7 1.5\n3 0.9 1.5\n",
        "1 0.5 1.5 7\n2 0.7 1.5 7\n",
        "1 0.5 1.5 7\n2 0.7 1.5 7\n3 0.9 1.5 7\n1 0.9 1.5 7\n",
        "1.0 5 1.0 7\n2.0 5 1.0 7\n3.0 5 1.0 7\n",
        "1.0 0.5 1.5 7\n2.0 0.7 1.5 7\n4.0 0.9 1.5 7\n",
        "1.0 0.5 1.5 7\n2.0 0.7 1.5 7\n3.0 0.9 1.5 7\n4.5 0.9 1.5 7\n",
        "-3.0 0.5 1.5 7\n-2.0 0.7 1.5 7\n-1.0 0.9 1.5 7\n",
        "10 5 5 5\n20 6 6 6\n30 7 7 7\n",
        "1 0.5 1.5 a\n2 0.7 1.5 b\n3 0.9 1.5 c\n",
        "3 0.5 1.5 7\n2 0.7 1.5 7\n1 0.9 1.5 7\n",
        "x y z i\n1 0.5 1.5 7\n2 0.7 1.5 7\n3 0.9 1.5 7\n",
    ],
)
def test_other_whole_numbers_are_coordinates(text: str) -> None:
    first = text.splitlines()[-3 if text[0] == "x" else 0]
    assert read(text, "txt").points[0].tolist() == [float(word) for word in first.split()[:3]]


@pytest.mark.parametrize(
    ("text", "columns"),
    [
        ("id,E,N,Z\n1,2,3,4\n", ["E", "N", "Z"]),
        ('"Y [m]";"X [m]";t\n1;2;3\n', ["X [m]", "Y [m]"]),
        ("1 2 3\n", ["1", "2", "3"]),
        ("1 2\n", ["1", "2"]),
    ],
)
def test_the_columns_can_be_told(text: str, columns: list[str]) -> None:
    assert coordinate_columns(read(text)) == columns


def test_running_numbers_of_numpy_are_asked_about() -> None:
    buffer = io.BytesIO()
    np.savetxt(
        buffer, np.column_stack([np.arange(500), np.random.default_rng(3).normal(size=(500, 3))])
    )
    with pytest.raises(CloudFileError, match="begin with a running number"):
        read(buffer.getvalue().decode(), "txt")
    grid = np.column_stack([np.arange(500), np.zeros((500, 3))])
    buffer = io.BytesIO()
    np.savetxt(buffer, grid)
    np.testing.assert_array_equal(read(buffer.getvalue().decode(), "txt").points, grid[:, :3])


def test_columns_that_are_not_chosen_keep_their_names() -> None:
    cloud = read("x,y,z,nx,e,n,h\n1,2,3,7,4,5,6\n", columns=["e", "n", "h"])
    assert list(cloud.columns) == ["x_1", "y_2", "z_3", "nx"]
    assert written(cloud, "csv") == "x,y,z,nx,e,n,h\n1,2,3,7,4.0,5.0,6.0\n"
    other = read(written(cloud, "txt"), "txt")
    assert other.points.tolist() == [[4, 5, 6]]
    assert list(other.columns) == list(cloud.columns)
    assert read("x,y,x_1,e,n\n1,2,3,4,5\n", columns=["e", "n"]).columns["x_1"].tolist() == ["1"]


@pytest.mark.parametrize(
    ("header", "unknown"),
    [
        ("x,y,q", "q"),
        ("E,N,id,H_local,w2", "H_local"),
        ("x,y,point_height,i", "point_height"),
        ("x,y,intensity,R", None),
        ("x,y,Reflectance,GpsTime", None),
        ("x,y,r,g,b,id,time", None),
        ("x,y,nx,ny,mean_curvature,confidence,displacement,outlier", None),
        ("x,y,z,q", None),
    ],
)
def test_a_height_of_unknown_name_is_warned_about(header: str, unknown: str | None) -> None:
    labels = header.split(",")
    text = header + "\n" + ",".join(["0.5"] * len(labels)) + "\n"
    cloud = read(text)
    if unknown is None:
        assert cloud.warnings == ()
        return
    (warning,) = cloud.warnings
    choice = ",".join([*labels[:2], unknown])
    assert warning == (
        f"its points are plane, as the header names no height; if {unknown} is that, "
        f"pass --columns {choice}, else --dim 2"
    )
    assert read(text, dim=2).warnings == ()
    assert read(text, "xy").warnings == ()
    assert read(text, columns=choice.split(",")).warnings == ()
    assert read(text.replace("0.5", "oak").replace("oak,oak", "1,2", 1)).warnings == ()


def test_other_formats_have_x_y_and_z() -> None:
    assert coordinate_columns(PointCloud(np.zeros((1, 2)))) == ["x", "y"]


def test_degrees_are_warned_about() -> None:
    cloud = read("lon,lat,height\n7.6,51.9,103.5\nnan,51.9,103.5\n")
    assert cloud.points[0].tolist() == [7.6, 51.9, 103.5]
    (warning,) = cloud.warnings
    assert warning.startswith("its coordinates lon and lat are degrees")
    assert warning.endswith("project them to metres first")
    assert read("lon,lat,height\n400000,5000000,103.5\n").warnings == ()
    assert read("x,y,height\n7.6,51.9,103.5\n").warnings == ()
    for columns, both in ((["lon", "lat", "h"], "lon and lat"), (["lat", "lon"], "lat and lon")):
        (warning,) = read("h,lon,lat\n1,120.5,51.9\n", columns=columns).warnings
        assert warning.startswith(f"its coordinates {both} are degrees")
    assert read("h,lon,lat\n1,7.6,51.9\n", columns=["h", "lat"]).warnings == ()
    assert read("1,7.6,51.9\n", columns=[2, 3]).warnings == ()
