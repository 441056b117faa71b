"""Points that move along the beams that saw them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import pcsmooth
from cli.commands import pcsmooth as command
from cli.commands import succeeds
from pcsmooth import InvalidInputError, Motion
from tiling.whole_and_tiled import compare

Floats = npt.NDArray[np.float64]

SCANNER = (0.5, -0.3, 1.7)


def room(n: int, noise: float, far: float = 0.0) -> tuple[Floats, Floats, Floats]:
    """Noisy points of floor and a wall, where the beams met them, and the beams."""
    rng = np.random.default_rng(5)
    beams = rng.normal(size=(n, 3))
    beams[:, 2] = -np.abs(beams[:, 2])
    beams /= np.linalg.norm(beams, axis=1, keepdims=True)
    with np.errstate(divide="ignore"):
        ranges = np.minimum(-SCANNER[2] / beams[:, 2], (3.0 - SCANNER[0]) / np.abs(beams[:, 0]))
    kept = ranges < 8.0
    beams, ranges = beams[kept], ranges[kept]
    scanner = np.array(SCANNER) + far
    true = scanner + ranges[:, np.newaxis] * beams
    return true + noise * rng.normal(size=(len(beams), 1)) * beams, true, beams


METHODS: dict[str, dict[str, Any]] = {
    "filter": {},
    "euler": {"scheme": "euler", "iterations": 2},
    "implicit": {"scheme": "implicit", "order": 1, "iterations": 1},
}


@pytest.mark.parametrize("name", METHODS)
def test_they_stay_on_their_beams(name: str) -> None:
    points, _, beams = room(3000, 0.01)
    result = pcsmooth.denoise(points, motion="ray", origin=SCANNER, **METHODS[name])
    ways = result.points - points
    assert np.linalg.norm(ways, axis=1).max() > 0.01
    assert np.linalg.norm(np.cross(ways, beams), axis=1).max() < 1e-14


@pytest.mark.parametrize("far", [0.0, 4e5])
def test_errors_along_the_beams_are_taken_out(far: float) -> None:
    points, true, beams = room(20_000, 0.01, far)
    scanner = tuple(np.array(SCANNER) + far)
    result = pcsmooth.denoise(points, motion="ray", origin=scanner)
    before, after = (((where - true) * beams).sum(axis=1) for where in (points, result.points))
    assert np.median(np.abs(after)) < 0.3 * np.median(np.abs(before))
    straight = np.abs(beams[:, 2]) > 0.5
    assert after[straight].std() < 0.3 * before[straight].std()
    assert result.sigma_after is not None


def test_a_tilted_plane_is_met_where_the_formula_has_it() -> None:
    rng = np.random.default_rng(1)
    flat = np.c_[rng.uniform(-1, 1, (4000, 2)), np.zeros(4000)]
    points = flat + [0, 0, 1.0] * rng.normal(0, 0.02, (4000, 1))
    along = pcsmooth.denoise(points, motion="normal")
    ray = pcsmooth.denoise(points, motion="ray", origin=(0.0, 0.0, 1.5))
    heights = along.points[:, 2] - points[:, 2]
    beams = points - [0, 0, 1.5]
    beams /= np.linalg.norm(beams, axis=1, keepdims=True)
    ways = ((ray.points - points) * beams).sum(axis=1)
    inner = (np.abs(flat[:, :2]) < 0.8).all(axis=1) & (np.abs(heights) > 0.01)
    cosines = beams[:, 2]
    wanted = heights * cosines / (cosines**2 + 0.07**2)
    # The ways of the filter differ from upright by what noise leaves the normals of its passes.
    assert np.quantile(np.abs(ways / wanted - 1.0)[inner], 0.9) < 0.07


def test_no_point_moves_farther_than_it_may() -> None:
    points, _, _ = room(3000, 0.01)
    result = pcsmooth.denoise(points, motion="ray", origin=SCANNER, max_move=0.004)
    assert result.displacement.max() == pytest.approx(0.004)
    half = pcsmooth.denoise(points, motion="ray", origin=SCANNER, max_move=0.004, strength=0.5)
    assert half.displacement.max() == pytest.approx(0.002)


def test_what_cannot_move_stays() -> None:
    points, _, _ = room(3000, 0.01)
    points[7] = SCANNER  # no beam
    points[8] = np.nan
    fixed = np.zeros(len(points), bool)
    fixed[9] = True
    result = pcsmooth.denoise(points, motion="ray", origin=SCANNER, fixed=fixed)
    np.testing.assert_array_equal(result.points[7:10], points[7:10])


def test_curves() -> None:
    angles = np.linspace(0.0, 2 * np.pi, 500, endpoint=False)
    unit = np.c_[np.cos(angles), np.sin(angles)]
    points = unit * (1.0 + 0.01 * np.random.default_rng(2).normal(size=(500, 1)))
    result = pcsmooth.denoise(points, motion="ray", origin=(0.0, 0.0))
    assert np.abs(np.linalg.norm(result.points, axis=1) - 1.0).std() < 0.004
    across = result.points[:, 0] * unit[:, 1] - result.points[:, 1] * unit[:, 0]
    assert np.abs(across).max() < 1e-14


@pytest.mark.slow
@pytest.mark.parametrize("name", ["filter", "euler"])
def test_in_tiles(name: str, tmp_path: Path) -> None:
    points, _, _ = room(2500, 0.01)
    unlike, whole, _ = compare(
        points, 900, tmp_path, scheme=name, motion="ray", origin=SCANNER, max_move=0.02
    )
    assert unlike == []
    assert whole.displacement.max() > 0.0


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"direction": "ray"}, "motion is 'ray', which needs the origin of the beams; give origin"),
        ({"origin": (0.0, 0.0)}, "origin is given and motion is 'free'; choose motion 'ray'"),
        ({"direction": "ray", "origin": (0.0,)}, "origin is (0.0,); it must be two or three"),
        ({"direction": "ray", "origin": (0.0, np.nan)}, "it must be two or three finite numbers"),
        ({"direction": "ray", "origin": [0.0, 1.0]}, "it must be two or three finite numbers"),
    ],
)
def test_what_is_no_motion_along_beams(options: dict[str, Any], told: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        Motion(**options)
    assert told in str(caught.value)


def test_an_origin_of_another_dimension() -> None:
    points, _, _ = room(100, 0.01)
    with pytest.raises(InvalidInputError, match=r"origin has 2 coordinates and the points 3; give"):
        pcsmooth.denoise(points, motion="ray", origin=(0.0, 0.0))


def test_on_the_command_line(tmp_path: Path) -> None:
    points, _, beams = room(2000, 0.01)
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    np.savetxt(source, points, "%.17g", ",", header="x,y,z", comments="")
    options = ("--motion", "ray", "--origin", "0.5,-0.3,1.7")
    run = succeeds("denoise", source, "-o", target, *options, "--json")
    after = np.loadtxt(target, delimiter=",", skiprows=1)[:, :3]
    assert np.linalg.norm(np.cross(after - points, beams), axis=1).max() < 1e-14
    assert (run.json["motion"], run.json["origin"]) == ("ray", list(SCANNER))
    assert run.json["at_limit"] is None
    assert "motion: along the beams from 0.5,-0.3,1.7" in run.stderr
    for wrong, told in (
        (options[:2], "--motion ray and --origin need each other"),
        (options[2:], "--motion ray and --origin need each other"),
        (("--origin", "1"), "'1' is not two or three numbers, such as 1.5,0,1.7"),
        (("--origin", "1,x"), "is not two or three numbers"),
    ):
        refused = command("denoise", source, "-o", target, *wrong)
        assert refused.status == 2
        assert told in refused.stderr
    flat = command("denoise", source, "-o", tmp_path / "a.csv", *options[:3], "0,0")
    assert flat.status == 1
    assert "the origin has 2 coordinates and the points 3" in flat.stderr
