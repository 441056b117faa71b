"""`pcsmooth info`."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pcsmooth
from cli.clouds import (
    DATA,
    Points,
    brute_force_spacing,
    circle,
    save_ply,
    save_text,
    sphere,
    vertices,
)
from cli.commands import succeeds


def facts(*arguments: object, stdin: bytes = b"") -> dict[str, Any]:
    finished = succeeds("info", *arguments, "--json", stdin=stdin)
    assert all("coordinates:" in line for line in finished.stderr.splitlines())
    return finished.json


@pytest.fixture
def survey(tmp_path: Path) -> Path:
    """A sphere with two broken rows, three repeated points and two more columns."""
    points = np.vstack([sphere(), sphere()[[4, 4, 90]], [[np.nan, 0, 0], [0, np.inf, 9]]])
    element = vertices(points, "f8", red=np.full(155, 3, "u1"), intensity=np.full(155, 0.5, "f4"))
    return save_ply(tmp_path / "survey.ply", element)


def test_json_holds_every_fact(survey: Path) -> None:
    points = sphere()
    spacing = brute_force_spacing(points)
    assert facts(survey) == {
        "file": str(survey),
        "format": "ply",
        "points": 155,
        "dimension": 3,
        "coordinates": ["x", "y", "z"],
        "position_type": "float64",
        "columns": {"red": "uint8", "intensity": "float32"},
        "comments": [],
        "warnings": [],
        "not_finite": 2,
        "noise_class": 0,
        "fixed": 0,
        "coincident": 3,
        "minimum": points.min(axis=0).tolist(),
        "maximum": points.max(axis=0).tolist(),
        "extent": np.ptp(points, axis=0).tolist(),
        "mean_spacing": pytest.approx(spacing, rel=1e-12),
        "local_spacing_p5": pytest.approx(0.9 * spacing, rel=0.15),
        "local_spacing_p50": pytest.approx(spacing, rel=0.1),
        "local_spacing_p95": pytest.approx(1.1 * spacing, rel=0.15),
        "spacing_variation": pytest.approx(1.2, abs=0.2),
        "suggested_radius": pytest.approx(2 * spacing, rel=1e-12),
        "sparse_share": 0.0,
        "noise": pytest.approx(0.02, rel=0.2),
        "noise_range": None,
        "noise_ratio": pytest.approx(0.02 / np.sqrt(4 * np.pi / 150), rel=0.2),
        "surface": True,
        "density_variation": pytest.approx(1.1, abs=0.1),
        "filter_support": 13.0,
        "suggested_scheme": "filter",
        "why": "noise measured in neighbourhoods of 16 points is 0.065 local spacings: the filter "
        "takes 13 points, as small as little noise allows",
    }


def test_text_holds_the_same_facts(survey: Path) -> None:
    finished = succeeds("info", survey)
    assert finished.stderr == ""
    lines = [line.split("  ", 1) for line in finished.stdout.decode().splitlines()]
    said = {name.strip(): value.strip() for name, value in lines}
    expected = facts(survey)
    known = [name for name, value in expected.items() if value is not None]
    assert [name.replace(" ", "_") for name in said] == known
    assert said["surface"] == "yes"
    assert said["points"] == "155"
    assert said["columns"] == "red (uint8), intensity (float32)"
    assert said["not finite"] == "2"
    assert said["coincident"] == "3"
    assert said["mean spacing"] == f"{expected['mean_spacing']:.6g}"
    assert said["local spacing p95"] == f"{expected['local_spacing_p95']:.6g}"
    assert said["spacing variation"] == f"{expected['spacing_variation']:.6g}"
    assert said["noise"] == f"{expected['noise']:.6g}"
    assert said["suggested scheme"] == "filter"
    assert said["why"] == expected["why"]
    assert said["suggested radius"] == f"{expected['suggested_radius']:.6g}"
    assert said["maximum"].split() == [f"{value:.10g}" for value in expected["maximum"]]


def test_the_suggested_radius_is_the_one_denoise_takes(tmp_path: Path) -> None:
    points = sphere() + np.array([4.3e5, 5.4e6, 200.0])
    cloud = save_ply(tmp_path / "utm.ply", vertices(points, "f8"))
    radius = pcsmooth.denoise(points, iterations=0).radius
    assert facts(cloud)["suggested_radius"] == pytest.approx(radius, rel=1e-6)


@pytest.mark.parametrize("offset", [[0.0, 0.0, 0.0], [4.3e5, 5.4e6, 200.0]], ids=["near", "utm"])
def test_the_noise_is_that_which_denoise_takes(tmp_path: Path, offset: list[float]) -> None:
    points = np.vstack([sphere(3000), sphere(3000)[:7], [[np.nan, 0, 0]]]) + offset
    cloud = save_ply(tmp_path / "scan.ply", vertices(points, "f8"))
    found = facts(cloud)
    done = succeeds("denoise", cloud, "-o", tmp_path / "out.ply", "--json").json
    assert found["suggested_scheme"] == done["scheme"] == "filter"
    for name in ("noise", "noise_ratio", "density_variation", "filter_support"):
        assert found[name] == pytest.approx(done[name], rel=1e-6)
    assert found["noise"] == pytest.approx(0.02, rel=0.1)
    assert found["why"].endswith(" points, wide enough for the noise")


WIDE = "as wide as noise thicker than the spacing needs"


@pytest.mark.parametrize(
    ("points", "why", "ratio"),
    [
        (sphere(3000, noise=0.1), f" {WIDE}", (1.0, 2.0)),
        (sphere(3000, noise=0.02), " wide enough for the noise", (0.3, 1.0)),
        (sphere(3000, noise=0.005), " as small as little noise allows", (0.0, 0.3)),
        (circle(500, noise=0.002), " as small as little noise allows", (0.0, 0.3)),
        (circle(500, noise=0.02), f" {WIDE}", (1.0, 2.0)),
    ],
    ids=["noisy", "usual", "fine", "curve", "noisy curve"],
)
def test_why(tmp_path: Path, points: Points, why: str, ratio: tuple[float, float]) -> None:
    found = facts(save_text(tmp_path / "cloud.txt", points))
    assert found["why"].endswith(f"{found['filter_support']:.0f} points,{why}")
    assert f" is {found['noise_ratio']:.2g} local spacings: " in found["why"]
    low, high = ratio
    assert low < found["noise_ratio"] < high
    assert found["noise"] > 0
    assert found["density_variation"] >= 1


def test_why_nothing_would_move(tmp_path: Path) -> None:
    axes = np.meshgrid(np.arange(15.0), np.arange(15.0), [2.0])
    clean = facts(save_text(tmp_path / "clean.xyz", np.stack(axes, -1).reshape(-1, 3)))
    assert (clean["noise"], clean["noise_ratio"]) == (0.0, 0.0)
    assert clean["why"] == "no noise was found: no point would move"
    assert clean["suggested_scheme"] == "filter"
    few = "too few points to measure noise: no point would move"
    for n in (1, 2, 3, 5, 12):
        path = save_text(tmp_path / "few.xyz", sphere(n))
        tiny = facts(path)
        assert tiny["why"] == few
        assert tiny["noise"] in (None, 0.0)
        assert f"{few}\n" in succeeds("info", path).stdout.decode()
        if n > 1:
            done = succeeds("denoise", path, "-o", tmp_path / "o.ply", "--overwrite", "--json").json
            assert (done["scheme"], done["max_displacement"]) == ("filter", 0.0)
            assert done["noise"] == tiny["noise"]


def test_extent_of_far_coordinates_shows_their_digits(tmp_path: Path) -> None:
    cloud = save_text(
        tmp_path / "utm.xyz", [[431234.25, 5412345.5, 1.0], [431235.75, 5412346.0, 2.0]]
    )
    text = succeeds("info", cloud).stdout.decode()
    assert "431234.25  5412345.5  1\n" in text
    assert "1.5  0.5  1\n" in text


def test_the_local_spacing_is_in_the_unit_of_the_file(tmp_path: Path) -> None:
    """Two spheres, one a hundred times smaller: half of the points are that much denser."""
    points = np.vstack([sphere(400), 0.01 * sphere(600) + [5.0, 0.0, 0.0]])
    found = facts(save_ply(tmp_path / "two.ply", vertices(points, "f8")))
    assert found["local_spacing_p95"] == pytest.approx(brute_force_spacing(sphere(400)), rel=0.25)
    assert found["local_spacing_p50"] < 0.05 * found["local_spacing_p95"]
    assert found["spacing_variation"] == pytest.approx(
        found["local_spacing_p95"] / found["local_spacing_p5"], rel=1e-12
    )
    large = facts(save_ply(tmp_path / "large.ply", vertices(2.0**40 * points, "f8")))
    for share in ("p5", "p50", "p95"):
        name = f"local_spacing_{share}"
        assert large[name] == pytest.approx(2.0**40 * found[name], rel=1e-12)


@pytest.mark.parametrize("arguments", [[], ["--threads", "1"], ["--threads", "2"]])
def test_a_curve(tmp_path: Path, arguments: list[str]) -> None:
    cloud = save_text(tmp_path / "curve.xy", circle())
    found = facts(cloud, *arguments)
    spacing = brute_force_spacing(circle())
    assert (found["points"], found["dimension"]) == (60, 2)
    assert found["mean_spacing"] == pytest.approx(spacing, rel=1e-12)
    assert "hint" not in found


def test_fixed_rows_are_counted() -> None:
    assert facts(DATA / "report/line_fixed.xy")["fixed"] == 2


def test_columns_and_comments_of_text(tmp_path: Path) -> None:
    rows = ["# made by hand", "x,y,z,id", *(f"{a},{b},{c},7" for a, b, c in sphere().tolist())]
    (tmp_path / "scan.csv").write_text("\n".join(rows) + "\n")
    found = facts(tmp_path / "scan.csv")
    assert list(found["columns"]) == ["id"]
    assert found["comments"] == ["made by hand"]
    assert "made by hand" in succeeds("info", tmp_path / "scan.csv").stdout.decode()


def test_a_constant_third_coordinate_is_hinted_at(tmp_path: Path) -> None:
    points = np.column_stack([circle(), np.full(60, 7.5)])
    cloud = save_text(tmp_path / "plane.xyz", points)
    assert facts(cloud)["dimension"] == 3
    assert "--dim 2" in facts(cloud)["hint"]
    assert "--dim 2" in succeeds("info", cloud).stdout.decode()
    flat = facts(cloud, "--dim", "2")
    assert flat["dimension"] == 2
    assert "hint" not in flat
    assert "z" in flat["columns"] or len(flat["columns"]) == 1


def test_a_local_radius_is_hinted_at_where_the_spacing_varies(tmp_path: Path) -> None:
    shares = np.random.default_rng(2).random((4000, 2))
    for power, is_uneven in ((1, False), (4, True)):
        points = np.column_stack([shares[:, 0] ** power, shares[:, 1], 0.1 * shares[:, 0]])
        found = facts(save_text(tmp_path / f"{power}.xyz", points))
        assert (found["spacing_variation"] > 2.0) == is_uneven
        assert ("--radius " in found.get("hint", "")) == is_uneven


def test_points_that_fill_a_volume(tmp_path: Path) -> None:
    points = np.indices((8, 8, 8)).reshape(3, -1).T.astype(float)
    found = facts(save_text(tmp_path / "solid.xyz", points))
    assert found["surface"] is False
    assert found["why"].startswith("no surface shows at any scale, the points fill a volume: no ")
    points = np.indices((20, 20)).reshape(2, -1).T.astype(float)
    found = facts(save_text(tmp_path / "solid.xy", points))
    assert found["surface"] is False
    assert found["why"].startswith("no curve shows at any scale, the points fill an area: no ")


@pytest.mark.parametrize("repeats", [1, 3])
def test_one_place_has_no_radius(tmp_path: Path, repeats: int) -> None:
    cloud = save_text(tmp_path / "one.xyz", np.array([[1.0, 2.0, 3.0]] * repeats))
    found = facts(cloud)
    assert (found["points"], found["coincident"]) == (repeats, repeats - 1)
    assert (found["mean_spacing"], found["suggested_radius"]) == (0.0, None)
    assert [found[f"local_spacing_p{share}"] for share in (5, 50, 95)] == [0.0, 0.0, 0.0]
    assert found["spacing_variation"] is None
    assert found["extent"] == [0.0, 0.0, 0.0]
    assert (found["noise"], found["filter_support"]) == (None, None)
    assert succeeds("info", cloud).status == 0


def test_rows_without_a_finite_one_are_counted(tmp_path: Path) -> None:
    (tmp_path / "nan.xyz").write_text("nan 0 0\n0 inf 0\n")
    found = facts(tmp_path / "nan.xyz")
    assert (found["points"], found["not_finite"]) == (2, 2)
    assert "minimum" not in found


def test_stdin(survey: Path) -> None:
    found = facts("-", stdin=survey.read_bytes())
    assert found == {**facts(survey), "file": "<stdin>"}


def test_json_is_one_line(survey: Path) -> None:
    stdout = succeeds("info", survey, "--json").stdout.decode()
    assert stdout.count("\n") == 1
    assert isinstance(json.loads(stdout), dict)


def test_the_shipped_scan() -> None:
    found = facts(DATA / "scans/kinect_milk.ply")
    assert (found["points"], found["position_type"]) == (13_704, "float32")
    assert found["not_finite"] == found["coincident"] == 0
    assert 0.001 < found["mean_spacing"] < 0.003
    assert found["suggested_radius"] == pytest.approx(2 * found["mean_spacing"])


def test_nothing_is_changed(survey: Path) -> None:
    before = survey.read_bytes()
    succeeds("info", survey)
    assert survey.read_bytes() == before
    assert [path.name for path in survey.parent.iterdir()] == ["survey.ply"]


def test_says_how_a_file_is_compressed_and_what_columns_hold(tmp_path: Path) -> None:
    path = tmp_path / "named.xyz.gz"
    path.write_bytes(gzip.compress(b"1 2 3 tree\n2 3 5 house\n4 5 6 tree\n"))
    text = succeeds("info", path).stdout.decode()
    assert "None" not in text
    assert "<U" not in text
    said = facts(path)
    assert said["format"] == "xyz, gzip"
    assert said["columns"] == {"column_4": "text"}
    assert facts("-", stdin=path.read_bytes())["format"] == "txt"
