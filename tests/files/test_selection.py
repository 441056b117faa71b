"""Points selected by a box, alone and with an expression."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pcsmooth
from cli.commands import pcsmooth as run
from cli.commands import succeeds
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.files.selection import Selection
from pcsmooth.files.where import Where

CLOUD = pcsmooth.PointCloud(
    np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [1.0, 2.0, 3.1], [0.5, np.nan, 1.0]])
)


@pytest.mark.parametrize(
    ("selection", "rows"),
    [
        (Selection(box=(0, 0, 1, 2)), [0, 1, 2]),
        (Selection(box=(0, 0, 0, 1, 2, 3)), [0, 1]),
        (Selection(box=(0.1, 0, 1, 2)), [1, 2]),
        (Selection(Where("z > 0"), (0, 0, 0, 1, 2, 3)), [1]),
        (Selection(Where("z > 0")), [1, 2, 3]),
        (Selection(box=(-np.inf, -np.inf, np.inf, np.inf)), [0, 1, 2]),
    ],
)
def test_rows_that_are_selected(selection: Selection, rows: list[int]) -> None:
    assert np.flatnonzero(selection.selected(CLOUD, "f")).tolist() == rows


@pytest.mark.parametrize("box", [(), (0, 0, 1), (1, 0, 0, 1), (0, 0, 1, np.nan), (0,) * 8])
def test_no_box(box: tuple[float, ...]) -> None:
    with pytest.raises(InvalidInputError, match="a box is XMIN,YMIN,XMAX,YMAX or"):
        Selection(box=box)


def test_a_box_with_z_for_points_without() -> None:
    plane = pcsmooth.PointCloud(np.zeros((3, 2)))
    with pytest.raises(CloudFileError, match="its points have no z for the box"):
        Selection(box=(0, 0, 0, 1, 1, 1)).selected(plane, "f")


@pytest.mark.parametrize("value", ["a,b", "1,2,3", "1,1,0,0"])
def test_what_is_no_box_is_an_error_of_usage(value: str) -> None:
    done = run("denoise", "none.xyz", "-o", "out.xyz", "--box", value)
    assert done.status == 2
    assert "Invalid value for '--box'" in done.stderr


@pytest.mark.parametrize("tile", ["off", "100"])
def test_points_outside_stay(tmp_path: Path, tile: Any) -> None:
    points = np.round(np.random.default_rng(1).normal(0, 1, (300, 2)) * [10, 0.05], 6)
    pcsmooth.write_cloud(pcsmooth.PointCloud(points), tmp_path / "in.ply")
    done = succeeds("denoise", tmp_path / "in.ply", "-o", tmp_path / "out.ply",
                    "--box=-5,-1,5,1", "--where", "x > 0", "--tile", tile,
                    "--dim", "2")  # fmt: skip
    outside = (points[:, 0] <= 0) | (points[:, 0] > 5) | (abs(points[:, 1]) > 1)
    assert f"{outside.sum()} fixed" in done.stderr
    cloud = pcsmooth.read_cloud(tmp_path / "out.ply", dim=2)
    assert np.array_equal(cloud.points[outside], points[outside])
    assert (cloud.points != points).any()
    assert " where=x%20>%200 box=-5,-1,5,1" in cloud.comments[0]


def test_an_empty_box_is_said(tmp_path: Path) -> None:
    pcsmooth.write_cloud(CLOUD, tmp_path / "in.ply")
    said: list[str] = []
    pcsmooth.denoise_file(
        tmp_path / "in.ply",
        tmp_path / "out.ply",
        selection=Selection(box=(8, 8, 9, 9)),
        say=said.append,
    )
    assert any("no point is selected by the box 8,8,9,9" in each for each in said)


def test_words_that_are_not_known() -> None:
    with pytest.raises(InvalidInputError, match="others is 'go'; it must be act or ignore"):
        Selection(others="go")  # type: ignore[arg-type]


@pytest.mark.parametrize("others", ["act", "ignore"])
def test_arrays_and_clouds_in_memory(tmp_path: Path, others: Any) -> None:
    points = np.random.default_rng(1).normal(0, 1, (300, 3)) * [1, 1, 0.02]
    cloud = pcsmooth.PointCloud(points, {"left": (points[:, 0] < 0).astype(np.uint8)})
    (tmp_path / "area").write_text("POLYGON ((-9 -9, 9 -9, -9 9, -9 -9))")
    selection = Selection("left", None, tmp_path / "area", others)
    chosen = selection.selected(cloud, "")
    assert 80 < chosen.sum() < 140
    result = pcsmooth.denoise(cloud, selection=selection)
    assert (result.points[~chosen] == points[~chosen]).all()
    assert (result.points[chosen] != points[chosen]).any(axis=1).sum() > 50
    assert " where=left polygon=area" in result.provenance
    held = pcsmooth.denoise(cloud, fixed=~chosen)
    assert np.array_equal(held.points, result.points) == (others == "act")
    few = pcsmooth.denoise(points, fixed=chosen, selection=Selection(box=(0, -9, 9, 9)))
    assert (few.points[chosen | (points[:, 0] < 0)] == points[chosen | (points[:, 0] < 0)]).all()

    estimate = pcsmooth.estimate_curvature(cloud, selection=selection)
    assert not estimate.normals[~chosen].any()
    assert estimate.has_normal[chosen].all()
    alone = pcsmooth.estimate_curvature(points if others == "act" else points[chosen])
    expected = alone.normals[chosen] if others == "act" else alone.normals
    np.testing.assert_array_equal(estimate.normals[chosen], expected)


def test_no_point_in_memory_is_selected() -> None:
    with pytest.raises(CloudFileError, match="the cloud: no point is selected by 'x > 9'"):
        pcsmooth.denoise(CLOUD, selection=Selection("x > 9", others="ignore"))


@pytest.mark.parametrize(
    ("area", "scale", "said"),
    [
        ("((7 46, 8 46, 8 47, 7 46))", 1e6, "the points x -1000000 to 1000000, y -1000000 to "
         "1000000; if these are degrees, project it like the points"),
        ("((7 46, 8 46, 8 47, 7 46))", 1.0, "y 46 to 47, the points x -1 to 1, y -1 to 1"),
        ("((7e6 46, 8e6 46, 8e6 47, 7e6 46))", 1e5, "y 46 to 47, the points x -100000 to 100000, "
         "y -100000 to 100000"),
        ("EMPTY", 1.0, "area, which is empty"),
    ],
)  # fmt: skip
def test_where_a_polygon_is_that_selects_nothing(
    tmp_path: Path, area: str, scale: float, said: str
) -> None:
    (tmp_path / "area").write_text(f"POLYGON {area}")
    selection = Selection(polygon=tmp_path / "area")
    box = scale * np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]])
    assert selection.missed_in_words(box, 0).endswith(said)
    assert selection.missed_in_words(None, 0).endswith(f"the polygon {tmp_path / 'area'}")


def test_noise_classes_may_be_why_nothing_is_selected() -> None:
    selection = Selection(where="classification == 7")
    assert selection.missed_in_words(None, 0) == ("no point is selected by 'classification == 7'")
    assert selection.missed_in_words(None, 1) == (
        "no point is selected by 'classification == 7' (1 point of a noise class or withheld left "
        "out; --keep-noise-class takes them in)"
    )
