"""`--where`, `--box`, `--polygon` and `--others` on the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cli.commands import pcsmooth, succeeds
from pcsmooth.cloud import PointCloud
from pcsmooth.formats import read_cloud, write_cloud


def test_no_expression_is_an_error_of_usage() -> None:
    run = pcsmooth("denoise", "none.xyz", "-o", "out.xyz", "--where", "f(x)")
    assert run.status == 2
    assert "Invalid value for '--where': 'f(x)' in 'f(x)' is neither a column" in run.stderr


def test_points_that_are_not_selected_stay(tmp_path: Path) -> None:
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    points = np.random.default_rng(1).normal(0, 1, (60, 2)) * [10, 0.05]
    np.savetxt(source, points, "%.6f", ",", header="x,y", comments="")
    run = succeeds("denoise", source, "-o", target, "--where", "x > 0")
    assert f"{(points[:, 0] <= 0).sum()} fixed" in run.stderr
    before, after = (np.loadtxt(p, delimiter=",", skiprows=1)[:, :2] for p in (source, target))
    assert np.array_equal(before[before[:, 0] <= 0], after[before[:, 0] <= 0])


def test_the_noise_that_is_left_is_that_of_points_that_may_move(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    source = tmp_path / "in.csv"
    points = np.c_[rng.uniform(0, 10, (2000, 2)), rng.normal(0, 0.1, 2000)]
    np.savetxt(source, points, "%.6f", ",", header="x,y,z", comments="")
    whole, part, none = (
        succeeds("denoise", source, "-o", tmp_path / f"{name}.csv", "--json", *options).json
        for name, options in (
            ("whole", ()), ("part", ("--box=0,0,2,2",)), ("none", ("--where", "z > 9")),
        )
    )  # fmt: skip
    assert part["fixed"] > 1800
    # Less is left where all move, as those that stay keep their noise beside the others.
    assert whole["noise_after"] < part["noise_after"] < 0.5 * whole["noise"]
    assert none["noise_after"] is None


def sheet(tmp_path: Path, suffix: str = "csv") -> tuple[Path, Any]:
    """Write a noisy sheet of 10 x 10 with a column of its halves; row 5 is NaN."""
    rng = np.random.default_rng(3)
    points = np.c_[rng.uniform(0, 10, (1500, 2)), rng.normal(0, 0.1, 1500)]
    points[5, 2] = np.nan
    half = (points[:, 0] > 5).astype(np.uint8)
    path = tmp_path / f"in.{suffix}"
    write_cloud(PointCloud(points, {"scan half": half}), path)
    return path, read_cloud(path).points


def triangle(tmp_path: Path, scale: float = 1.0) -> Path:
    """Write the polygon of points left of and below a diagonal."""
    ring = [[-1, -1], [9, -1], [-1, 9], [-1, -1]]
    path = tmp_path / "area.geojson"
    path.write_text(
        json.dumps(
            {"type": "Polygon", "coordinates": [scale * np.array(ring)]}, default=np.ndarray.tolist
        )
    )
    return path


@pytest.mark.parametrize("scheme", [(), ("--scheme", "euler", "--iterations", "2")])
@pytest.mark.parametrize("selecting", ["where", "polygon"])
def test_ignored_points_are_as_if_they_were_not_there(
    tmp_path: Path, scheme: tuple[str, ...], selecting: str
) -> None:
    source, points = sheet(tmp_path)
    chosen = points[:, 0] + points[:, 1] <= 8
    options: tuple[object, ...] = ("--where", "x + y <= 8 and `scan half` in (0, 1)")
    if selecting == "polygon":
        options = ("--polygon", triangle(tmp_path))
    alone = tmp_path / "alone.csv"
    lines = source.read_text().splitlines(keepends=True)
    alone.write_text(lines[0] + "".join(np.array(lines[1:])[chosen]))
    outs = [tmp_path / f"{name}.csv" for name in ("ignoring", "tiled", "of_alone", "acting")]
    run = succeeds(
        "denoise", source, "-o", outs[0], *options, "--others", "ignore", "--json", *scheme
    )
    succeeds(
        "denoise", source, "-o", outs[1], *options, "--others", "ignore", "--tile", 400, *scheme
    )
    succeeds("denoise", alone, "-o", outs[2], *scheme)
    succeeds("denoise", source, "-o", outs[3], *options, *scheme)
    assert outs[1].read_bytes() == outs[0].read_bytes()
    results = [np.array(out.read_text().splitlines()[1:]) for out in outs]
    assert results[0][chosen].tolist() == results[2].tolist()
    after, acting = read_cloud(outs[0]).points, read_cloud(outs[3]).points
    assert after[~chosen].tobytes() == points[~chosen].tobytes() == acting[~chosen].tobytes()
    assert (after[chosen] != acting[chosen]).any()
    n_finite = int(np.isfinite(points[chosen, 2]).sum())
    facts = run.json
    assert (facts["selected"], facts["ignored"], facts["not_finite"]) == (
        n_finite,
        1499 - n_finite,
        1,
    )
    assert (facts["others"], facts["fixed"]) == ("ignore", 0)
    assert (
        f"{n_finite} selected, 1 not finite (passed through), {1499 - n_finite} not" in run.stderr
    )


def test_json_says_what_is_selected_and_by_what(tmp_path: Path) -> None:
    source, _ = sheet(tmp_path)
    area = triangle(tmp_path)
    plain, chosen = (
        succeeds(
            "denoise", source, "-o", tmp_path / "out.ply", "--overwrite", "--json", *options
        ).json
        for options in ((), ("--where", "x > 1", "--box=0,0,9,9", "--polygon", area))
    )  # fmt: skip
    assert not {"selected", "where", "box", "polygon", "others"} & plain.keys()
    assert chosen["where"] == "x > 1"
    assert chosen["box"] == [0, 0, 9, 9]
    assert chosen["polygon"] == str(area)
    assert chosen["others"] == "act"
    assert chosen["selected"] + chosen["fixed"] == 1499
    comment = read_cloud(tmp_path / "out.ply").comments[0]
    assert comment.endswith(" where=x%20>%201 box=0,0,9,9 polygon=area.geojson")


def test_others_alone_are_an_error_of_usage() -> None:
    run = pcsmooth("denoise", "none.xyz", "-o", "out.xyz", "--others", "act")
    assert run.status == 2
    assert "--others needs --where, --box or --polygon" in run.stderr


def test_a_polygon_that_cannot_be_read(tmp_path: Path) -> None:
    source, _ = sheet(tmp_path)
    (tmp_path / "area").write_text("POLYGON ((0 0")
    run = pcsmooth("denoise", source, "-o", tmp_path / "out.csv", "--polygon", tmp_path / "area")
    assert run.status == 1
    assert f"Error: {tmp_path / 'area'}: is neither GeoJSON nor WKT" in run.stderr


@pytest.mark.parametrize("tile", ["off", "400"])
@pytest.mark.parametrize("command", ["denoise", "curvature"])
def test_a_polygon_elsewhere_is_said(tmp_path: Path, command: str, tile: str) -> None:
    rng = np.random.default_rng(3)
    points = np.c_[5e5 + rng.uniform(0, 10, (900, 2)), rng.normal(0, 0.1, 900)]
    source, out = tmp_path / "in.csv", tmp_path / "out.csv"
    np.savetxt(source, points, "%.3f", ",", header="x,y,z", comments="")
    options = ("--polygon", triangle(tmp_path), "--tile", tile)
    run = succeeds(command, source, "-o", out, *options)
    where = (
        f"no point is selected by the polygon {tmp_path / 'area.geojson'}: the polygon spans "
        "x -1 to 9, y -1 to 9, the points x 5000"
    )
    assert f"warning: {source}: {where}" in run.stderr
    assert "if these are degrees, project it like the points" in run.stderr
    run = pcsmooth(command, source, "-o", out, "--overwrite", *options, "--others", "ignore")
    assert run.status == 1
    assert f"Error: {source}: {where}" in run.stderr


@pytest.mark.parametrize("others", ["act", "ignore"])
def test_curvature_of_selected_points(tmp_path: Path, others: str) -> None:
    source, points = sheet(tmp_path)
    chosen = (points[:, 0] <= 5) & np.isfinite(points[:, 2])
    whole, tiled, full = (tmp_path / f"{name}.csv" for name in ("whole", "tiled", "full"))
    options = ("--where", "`scan half` == 0", "--others", others)
    facts = succeeds("curvature", source, "-o", whole, "--json", *options).json
    succeeds("curvature", source, "-o", tiled, "--tile", 400, *options)
    succeeds("curvature", source, "-o", full)
    assert tiled.read_bytes() == whole.read_bytes()
    assert (facts["selected"], facts["without_normal"]) == (chosen.sum(), 0)
    found, expected = read_cloud(whole).columns, read_cloud(full).columns
    for name in ("nx", "nz", "mean_curvature", "confidence"):
        values = found[name].astype(float)
        assert not values[~chosen].any()
        assert (found[name][chosen] == expected[name][chosen]).all() == (others == "act")


@pytest.mark.parametrize("tile", ["off", "400"])
def test_facts_of_selected_points(tmp_path: Path, tile: str) -> None:
    source, points = sheet(tmp_path, "ply")
    chosen = points[:, 0] <= 5
    write_cloud(PointCloud(points[chosen]), tmp_path / "alone.ply")
    facts = succeeds("info", source, "--json", "--where", "x <= 5", "--tile", tile).json
    expected = succeeds("info", tmp_path / "alone.ply", "--json").json
    assert facts["selected"] == expected["points"] - expected["not_finite"]
    assert facts["points"] == 1500
    for name in ("minimum", "maximum", "mean_spacing", "noise", "suggested_radius", "coincident"):
        assert facts[name] == expected[name]
    none = succeeds("info", source, "--json", "--box=90,90,91,91", "--tile", tile).json
    assert none["hint"] == "no point is selected by the box 90,90,91,91"
    assert "noise" not in none


def test_points_of_which_none_is_finite_are_not_said_to_be_unselected(tmp_path: Path) -> None:
    write_cloud(PointCloud(np.full((3, 3), np.nan)), tmp_path / "in.ply")
    run = pcsmooth("denoise", tmp_path / "in.ply", "-o", tmp_path / "out.ply", "--where", "x > 0")
    assert run.status == 1
    assert "there is no point with finite coordinates" in run.stderr


def test_a_batch_makes_results_anew_by_another_polygon(tmp_path: Path) -> None:
    first, _ = sheet(tmp_path)
    second = tmp_path / "second.csv"
    second.write_bytes(first.read_bytes())
    out = tmp_path / "out"
    options = ("--output-dir", out, "--polygon", triangle(tmp_path), "--jobs", 2)
    succeeds("denoise", first, second, *options)
    before = (out / "second.csv").read_bytes()
    again = succeeds("denoise", first, second, *options, "--skip-existing")
    assert "0 done, 2 skipped" in again.stderr
    triangle(tmp_path, 0.5)
    anew = succeeds("denoise", first, second, *options, "--skip-existing")
    assert "2 done, 0 skipped" in anew.stderr
    assert (out / "second.csv").read_bytes() != before
