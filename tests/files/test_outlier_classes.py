"""Outliers by the noise classes of LAS, whole and in tiles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest

import pcsmooth
from cli.commands import pcsmooth as run
from cli.commands import succeeds

HIGH, LOW, HELD = [30, 700], [500], 900


def sheet() -> Any:
    """Give a noisy sheet; two points are far above, one is far below, and one above is fixed."""
    rng = np.random.default_rng(4)
    points = rng.random((1200, 3)) * [1.0, 1.0, 0.0]
    points[:, 2] = 0.003 * rng.normal(size=1200)
    points[[*HIGH, *LOW, HELD], 2] = [0.4, 0.6, -0.5, 0.5]
    return points


def saved(path: Path, point_format: int) -> Path:
    header = laspy.LasHeader(version="1.4", point_format=point_format)
    header.scales = np.full(3, 1e-5)
    header.add_extra_dim(laspy.ExtraBytesParams("held", "u1"))
    las = laspy.LasData(header)
    las.xyz = sheet()
    las.classification = np.arange(1200) % 5
    las.held = np.arange(1200) == HELD
    las.write(str(path))
    return path


@pytest.mark.parametrize(
    ("point_format", "suffix"), [(1, "las"), (3, "laz"), (6, "laz"), (7, "las")]
)
@pytest.mark.parametrize("tile", ["off", "400"])
def test_classes(tmp_path: Path, point_format: int, suffix: str, tile: str) -> None:
    source = saved(tmp_path / f"in.{suffix}", point_format)
    target = tmp_path / f"out.{suffix}"
    done = succeeds("denoise", source, "-o", target, "--outliers", "class", "--fixed", "held",
                    "--tile", tile, "--json")  # fmt: skip
    expected = np.arange(1200) % 5
    expected[HIGH], expected[LOW] = 18, 7
    las = laspy.read(target)
    assert np.array_equal(las.classification, expected)
    assert las.header.point_format.id == point_format
    assert "outlier" not in list(las.point_format.dimension_names)
    facts = done.json
    assert (facts["outliers"], facts["class_7"], facts["class_18"], facts["removed"]) == (
        4,
        1,
        2,
        0,
    )
    assert facts["outliers_as"] == "class"
    assert (
        "4 outliers, 1 of them fixed: 1 to class 7, 2 above the surface to class 18" in done.stderr
    )
    if tile != "off":
        whole = tmp_path / f"whole.{suffix}"
        succeeds("denoise", source, "-o", whole, "--outliers", "class", "--fixed", "held")
        assert whole.read_bytes() == target.read_bytes()


@pytest.mark.parametrize("tile", ["off", "400"])
@pytest.mark.parametrize("classes", [None, "1", "2.0"])
def test_clouds_that_are_no_las(tmp_path: Path, classes: str | None, tile: str) -> None:
    source, target = tmp_path / "in.csv", tmp_path / "out.las"
    names = "x,y,z" + ("" if classes is None else ",classification")
    rows = [
        ",".join(map(str, [*point, *([classes] if classes else [])])) for point in sheet().tolist()
    ]
    source.write_text("\n".join([names, *rows]) + "\n")
    succeeds("denoise", source, "-o", target, "--outliers", "class", "--tile", tile)
    found = np.array(laspy.read(target).classification)
    expected = np.full(1200, 0 if classes is None else int(float(classes)))
    expected[[*HIGH, HELD]], expected[LOW] = 18, 7
    assert found.tolist() == expected.tolist()


@pytest.mark.parametrize("word", ["ground", "2.5", "300", "nan"])
def test_what_is_no_class(tmp_path: Path, word: str) -> None:
    source = tmp_path / "in.csv"
    rows = [",".join(map(str, [*point, 2])) for point in sheet().tolist()]
    rows[10] = rows[10][:-1] + word
    source.write_text("\n".join(["x,y,z,classification", *rows]) + "\n")
    done = run("denoise", source, "-o", tmp_path / "out.las", "--outliers", "class")
    assert done.status == 1
    assert f"{source}: its column 'classification' is not of whole numbers from 0" in done.stderr
    assert not (tmp_path / "out.las").exists()


def test_a_run_without_outliers_changes_no_class(tmp_path: Path) -> None:
    x, y = np.meshgrid(np.arange(12.0), np.arange(12.0))
    flat = pcsmooth.PointCloud(np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1))
    pcsmooth.write_cloud(flat, tmp_path / "in.las")
    done = succeeds("denoise", tmp_path / "in.las", "-o", tmp_path / "a.las", "--outliers", "class")
    assert "0 outliers: 0 to class 7, 0 above the surface to class 18" in done.stderr
    assert not np.array(laspy.read(tmp_path / "a.las").classification).any()


@pytest.mark.parametrize("name", ["out.ply", "out.csv", "out.obj"])
def test_other_formats_have_no_classes(tmp_path: Path, name: str) -> None:
    source = saved(tmp_path / "in.las", 6)
    done = run("denoise", source, "-o", tmp_path / name, "--outliers", "class")
    assert done.status == 1
    assert "--outliers class is for LAS and LAZ" in done.stderr
    assert "pass --outliers mark" in done.stderr
    assert not (tmp_path / name).exists()


def test_flows_find_no_outliers(tmp_path: Path) -> None:
    source = saved(tmp_path / "in.las", 6)
    done = run(
        "denoise", source, "-o", tmp_path / "o.las", "--outliers", "class", "--scheme", "euler"
    )
    assert "leave out --outliers class" in done.stderr


@pytest.mark.parametrize(
    ("name", "options", "marked"),
    [
        ("out.ply", (), True), ("out.csv", (), True), ("out.pcd", (), True), ("out.las", (), True),
        ("out.ply", ("--dialect", "meshlab"), False), ("out.obj", (), False),
        ("out.xyz", (), False), ("out.off", (), False),
        ("out.obj", ("--outliers", "remove"), None),
        ("out.obj", ("--scheme", "euler", "--iterations", "1"), None),
    ],
)  # fmt: skip
def test_that_outliers_are_not_marked_is_said_before_the_run(
    tmp_path: Path, name: str, options: tuple[str, ...], marked: bool | None
) -> None:
    source = tmp_path / "in.ply"
    pcsmooth.write_cloud(pcsmooth.PointCloud(sheet()), source)
    done = succeeds("denoise", source, "-o", tmp_path / name, "--json", *options)
    warned = "this file gets no column for outliers" in done.stderr
    assert warned == (marked is False)
    assert done.json["outliers_marked"] == bool(marked)
    if warned:
        assert done.stderr.index("no column for outliers") < done.stderr.index("points in 3D")
        assert "4 outliers left where they are (not marked in the file)" in done.stderr
    elif marked:
        assert any("outlier" in each for each in pcsmooth.read_cloud(tmp_path / name).columns)


def test_a_column_outlier_of_another_program_marks_nothing(tmp_path: Path) -> None:
    cloud = pcsmooth.PointCloud(sheet(), {"scalar_outlier": np.zeros(1200)})
    pcsmooth.write_cloud(cloud, tmp_path / "in.ply")
    done = succeeds("denoise", tmp_path / "in.ply", "-o", tmp_path / "out.ply", "--json")
    assert done.json["outliers_marked"] is False
