"""Which columns of text files are the coordinates: every command says it, and can be told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cli.clouds import Points, save_ply, sphere, vertices
from cli.commands import Finished, pcsmooth, succeeds
from pcsmooth import read_cloud
from pcsmooth.formats import coordinate_columns
from pcsmooth.neighbors.local_spacing import local_spacings

WRITING = ("denoise", "curvature", "convert")


def survey(path: Path, header: str = "PointID,Easting,Northing,Elevation") -> Points:
    """Write a sphere whose points have a running number."""
    points = sphere()
    rows = [",".join(map(repr, [n + 1, *point])) for n, point in enumerate(points.tolist())]
    path.write_text("\n".join([*([header] if header else []), *rows]) + "\n")
    return points


def said(finished: Finished) -> list[str]:
    return [line for line in finished.stderr.splitlines() if "coordinates:" in line]


@pytest.mark.parametrize("command", WRITING)
def test_named_columns_are_taken_and_said(tmp_path: Path, command: str) -> None:
    source, target = tmp_path / "a.csv", tmp_path / "b.csv"
    points = survey(source)
    finished = succeeds(command, source, "-o", target, "--json")
    assert said(finished) == [f"{source}: coordinates: Easting, Northing, Elevation"]
    assert finished.json["coordinates"] == ["Easting", "Northing", "Elevation"]
    cloud = read_cloud(target)
    assert cloud.columns["PointID"].tolist() == [str(n + 1) for n in range(len(points))]
    assert coordinate_columns(cloud) == ["Easting", "Northing", "Elevation"]
    assert np.any(cloud.points != points) == (command == "denoise")
    assert np.median(np.linalg.norm(cloud.points, axis=1)) == pytest.approx(1.0, abs=0.01)
    assert succeeds(command, source, "-o", target, "-q", "--overwrite").stderr == ""


def test_info_says_the_columns(tmp_path: Path) -> None:
    survey(tmp_path / "a.csv")
    finished = succeeds("info", tmp_path / "a.csv")
    assert said(finished) == [f"{tmp_path / 'a.csv'}: coordinates: Easting, Northing, Elevation"]
    assert "Easting; Northing; Elevation\n" in finished.stdout.decode()


@pytest.mark.parametrize("command", ["denoise", "curvature"])
@pytest.mark.parametrize(
    ("suffix", "column"),
    [("ply", "scalar_spacing"), ("csv", "spacing"), ("las", "spacing"), ("pcd", "spacing")],
)
def test_the_local_spacing_as_a_column(
    tmp_path: Path, command: str, suffix: str, column: str
) -> None:
    points = np.vstack([sphere(300), 0.01 * sphere(200) + [3.0, 0.0, 0.0], [[np.nan, 0.0, 0.0]]])
    points = points[:-1] if suffix == "las" else points
    source, target = save_ply(tmp_path / "a.ply", vertices(points, "f8")), tmp_path / f"b.{suffix}"
    succeeds(command, source, "-o", target, "--columns-extra", "spacing", "--double")
    cloud = read_cloud(target)
    finite = np.isfinite(cloud.points).all(axis=1)
    found = cloud.columns[column].astype(np.float64)
    # Positions of LAS are rounded to steps.
    np.testing.assert_allclose(
        found[finite], local_spacings(cloud.points[finite]), rtol=0.01 if suffix == "las" else 1e-6
    )
    assert found[finite].max() > 30 * found[finite].min()
    assert np.all(found[~finite] == 0.0)
    assert np.count_nonzero(~finite) == (suffix != "las")
    again = tmp_path / f"c.{suffix}"
    finished = succeeds(command, target, "-o", again)
    assert column not in read_cloud(again).columns
    assert f"columns of an earlier run are left out: {column}" in finished.stderr


def test_the_local_spacing_needs_the_whole_cloud(tmp_path: Path) -> None:
    source = save_ply(tmp_path / "a.ply", vertices(sphere(), "f8"))
    for command in ("denoise", "curvature"):
        refused = pcsmooth(
            command, source, "-o", tmp_path / "b.ply", "--columns-extra", "spacing", "--tile", "50"
        )
        assert refused.status == 1
        assert f"{source}: the column spacing needs the whole cloud; leave it out" in refused.stderr


@pytest.mark.parametrize(
    ("suffix", "column"),
    [("ply", "scalar_sigma"), ("csv", "sigma"), ("las", "sigma"), ("pcd", "sigma")],
)
def test_the_noise_as_a_column(tmp_path: Path, suffix: str, column: str) -> None:
    source, target = save_ply(tmp_path / "a.ply", vertices(sphere(300), "f8")), f"b.{suffix}"
    succeeds(
        "denoise", source, "-o", tmp_path / target, "--noise", "0.01", "--columns-extra", "sigma"
    )
    found = read_cloud(tmp_path / target).columns[column].astype(np.float64)
    np.testing.assert_allclose(found, 0.01, rtol=1e-6)
    again = tmp_path / f"c.{suffix}"
    succeeds("curvature", tmp_path / target, "-o", again)
    assert column in read_cloud(again).columns  # still that of the input of the filter


@pytest.mark.parametrize(
    ("command", "options", "by"),
    [
        ("denoise", ["--scheme", "euler"], "the scheme euler"),
        ("curvature", [], "a run that moves no point"),
    ],
)
def test_only_the_filter_finds_the_noise(
    tmp_path: Path, command: str, options: list[str], by: str
) -> None:
    source = save_ply(tmp_path / "a.ply", vertices(sphere(), "f8"))
    refused = pcsmooth(
        command, source, "-o", tmp_path / "b.ply", *options, "--columns-extra", "sigma"
    )
    assert refused.status == 2
    assert f"{by} does not look for it: leave it out" in refused.stderr


@pytest.mark.parametrize("column", ["spacing", "sigma", "sigma_after"])
def test_columns_that_are_asked_for_are_not_lost_in_silence(tmp_path: Path, column: str) -> None:
    source = save_ply(tmp_path / "a.ply", vertices(sphere(300), "f8"))
    finished = succeeds("denoise", source, "-o", tmp_path / "b.xyz", "--columns-extra", column)
    assert f"warning: xyz files cannot hold column '{column}'" in finished.stderr


@pytest.mark.parametrize("command", WRITING)
def test_a_running_number_needs_a_choice(tmp_path: Path, command: str) -> None:
    source, target = tmp_path / "a.xyz", tmp_path / "b.xyz"
    points = survey(source, header="")
    refused = pcsmooth(command, source, "-o", target)
    assert refused.status == 1
    assert refused.stderr.startswith(f"Error: {source}: its rows begin with a running number")
    assert "--columns 2,3,4" in refused.stderr
    assert not target.exists()
    finished = succeeds(command, source, "-o", target, "--columns", "2,3,4", "--json")
    assert said(finished) == [f"{source}: coordinates: columns 2, 3, 4"]
    assert finished.json["coordinates"] == ["2", "3", "4"]
    cloud = read_cloud(target, columns=[2, 3, 4])
    assert cloud.columns["column_1"].tolist() == [str(n + 1) for n in range(len(points))]
    assert np.median(np.linalg.norm(cloud.points, axis=1)) == pytest.approx(1.0, abs=0.01)


def test_info_and_plot_take_the_choice_too(tmp_path: Path) -> None:
    source = tmp_path / "a.csv"
    points = survey(source, header="id,a,b,c")
    for command in (("info", source), ("plot", source, source, "-o", tmp_path / "a.png")):
        refused = pcsmooth(*command)
        assert refused.status == 1
        assert "names no coordinates (id, a, b, c); " in refused.stderr
        finished = succeeds(*command, "--columns", "a, b, c")
        assert said(finished)[0] == f"{source}: coordinates: a, b, c"
    facts = succeeds("info", source, "--columns", "a,b", "--json").json
    assert facts["dimension"] == 2
    assert facts["maximum"] == points[:, :2].max(axis=0).tolist()


def test_degrees_are_warned_about(tmp_path: Path) -> None:
    survey(tmp_path / "a.csv", header="id,lon,lat,height")
    finished = succeeds("convert", tmp_path / "a.csv", "-o", tmp_path / "b.ply")
    assert "a.csv: warning: its coordinates lon and lat are degrees" in finished.stderr


def test_a_batch_says_the_columns_of_text_files(tmp_path: Path) -> None:
    folder = tmp_path / "scans"
    folder.mkdir()
    survey(folder / "a.csv")
    save_ply(folder / "b.ply", vertices(sphere(), "f8"))
    finished = succeeds("denoise", folder, "--output-dir", tmp_path / "out")
    assert said(finished) == [f"{folder / 'a.csv'}: coordinates: Easting, Northing, Elevation"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--columns", "2"], "'2' does not name two or three columns, such as 2,3,4"),
        (["--columns", "1,2,3,4"], "does not name two or three columns"),
        (["--columns", "1,,3"], "does not name two or three columns"),
        (["--columns", "1,2", "--dim", "3"], "--columns names 2 coordinates, --dim wants 3"),
    ],
)
def test_a_choice_that_makes_no_point(tmp_path: Path, options: list[str], message: str) -> None:
    survey(tmp_path / "a.csv")
    finished = pcsmooth("info", tmp_path / "a.csv", *options)
    assert finished.status == 2
    assert message in finished.stderr


@pytest.mark.slow
def test_a_choice_is_for_the_text_among_several(tmp_path: Path) -> None:
    text, other = tmp_path / "a.csv", tmp_path / "b.ply"
    points = survey(text, header="id,a,b,c")
    save_ply(other, vertices(points, "f8"))
    choice = ["--columns", "a,b,c"]
    picture = tmp_path / "a.png"
    plot = succeeds("plot", text, other, "-o", picture, "--color-by", "distance", *choice)
    assert said(plot) == [f"{text}: coordinates: a, b, c"]
    assert picture.exists()
    succeeds("convert", other, text, "--output-dir", tmp_path / "out", *choice)
    for name in ("a.csv", "b.ply"):
        columns = ["a", "b", "c"] if name == "a.csv" else None
        again = read_cloud(tmp_path / "out" / name, columns=columns)
        np.testing.assert_array_equal(again.points, points)
    refused = pcsmooth("plot", other, other, "-o", picture, "--overwrite", *choice)
    assert refused.status == 1
    assert "in text files only" in refused.stderr
    third = save_ply(tmp_path / "c.ply", vertices(points, "f8"))
    refused = pcsmooth("convert", third, other, "--output-dir", tmp_path / "none", *choice)
    assert "2 of 2 files failed" in refused.stderr
    assert "in text files only" in refused.stderr


def test_a_choice_before_what_cannot_be_looked_at(tmp_path: Path) -> None:
    other = save_ply(tmp_path / "b.ply", vertices(sphere(), "f8"))
    (tmp_path / "closed.csv").symlink_to("closed.csv")
    mixed = ["convert", other, tmp_path / "none.csv", tmp_path / "closed.csv"]
    finished = pcsmooth(*mixed, "--output-dir", tmp_path / "out", "--columns", "1,2,3")
    assert finished.status == 1
    assert "2 of 3 files failed" in finished.stderr
    assert [path.name for path in (tmp_path / "out").glob("[!.]*")] == ["b.ply"]


@pytest.mark.parametrize("tile", [[], ["--tile", "100"]])
def test_other_formats_leave_no_choice(tmp_path: Path, tile: list[str]) -> None:
    source = save_ply(tmp_path / "a.ply", vertices(sphere(), "f8"))
    options = ["--scheme", "euler", *tile, "--columns", "x,y,z"]
    finished = pcsmooth("denoise", source, "-o", tmp_path / "b.ply", *options)
    assert finished.status == 1
    assert finished.stderr.count("\n") == 1
    assert "text files" in finished.stderr
    assert not (tmp_path / "b.ply").exists()


def test_marks_in_other_encodings_are_shown(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b"x,y,z,hold\n1,2,3,1\n4,5,6,M\xfcl0\n")
    refused = pcsmooth("denoise", tmp_path / "a.csv", "-o", tmp_path / "b.csv", "--fixed", "hold")
    assert refused.status == 1
    assert "column 'hold' of point 2 is 'Mül0', neither a number nor 'fixed'" in refused.stderr


def test_marks_of_fixed_points_may_be_missing(tmp_path: Path) -> None:
    points = sphere()
    marks = ["1", "NULL", *["0"] * (len(points) - 2)]
    rows = [f"{x!r},{y!r},{z!r},{mark}" for (x, y, z), mark in zip(points.tolist(), marks,
                                                                   strict=True)]  # fmt: skip
    (tmp_path / "a.csv").write_text("\n".join(["x,y,z,hold", *rows]) + "\n")
    options = ["--fixed", "hold", "--json"]
    done = succeeds("denoise", tmp_path / "a.csv", "-o", tmp_path / "b.csv", *options).json
    assert done["fixed"] == 1
