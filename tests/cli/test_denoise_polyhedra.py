"""`pcsmooth denoise` with a convex body in place of the ball."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import pytest

import pcsmooth
from cli.clouds import Points, circle, load_ply, positions, save_ply, save_text, sphere, vertices
from cli.commands import pcsmooth as run
from cli.commands import succeeds

Union = Literal["naive", "inclusion-exclusion", "exact"]
UNIONS = get_args(Union)


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """A sphere as double PLY."""
    return save_ply(tmp_path / "scan.ply", vertices(sphere(), "f8"))


@pytest.mark.parametrize("energy", ["volume", "area"])
@pytest.mark.parametrize("union", [None, *UNIONS])
@pytest.mark.parametrize(("points", "name"), [(circle(), "hexagon"), (sphere(), "cube")])
def test_options_mean_what_they_mean_in_python(
    tmp_path: Path,
    points: Points,
    name: str,
    union: Union | None,
    energy: Literal["volume", "area"],
) -> None:
    cloud = save_text(tmp_path / "cloud.txt", points)
    chosen = [] if union is None else ["--union", union]
    succeeds(
        "denoise", cloud, "-o", tmp_path / "out.ply", "--double", "--iterations", "2",
        "--polyhedron", name, *chosen, "--energy", energy,
    )  # fmt: skip
    expected = pcsmooth.denoise(
        points,
        polyhedron=pcsmooth.load_presets()[name],
        union=union or "exact",
        energy=energy,
        iterations=2,
    )
    dimension = points.shape[1]
    np.testing.assert_array_equal(positions(tmp_path / "out.ply")[:, :dimension], expected.points)
    balls = pcsmooth.denoise(points, energy=energy, iterations=2)
    assert np.abs(expected.points - balls.points).max() > 1e-3 * balls.spacing
    assert expected.history[0].volume > balls.history[0].volume  # a body holds its ball


def test_weights_logs_and_fixed_points_are_those_of_balls(tmp_path: Path) -> None:
    points = sphere()
    held = np.arange(len(points)) % 7 == 0
    cloud = save_text(tmp_path / "cloud.csv", np.c_[points, held], ",")
    cloud.write_text("x,y,z,held\n" + cloud.read_text())
    for weight in ("none", "cell", "boundary"):
        out, log = tmp_path / f"{weight}.csv", tmp_path / f"{weight}_log.csv"
        succeeds(
            "denoise", cloud, "-o", out, "--polyhedron", "octahedron", "--weight", weight,
            "--fixed", "held", "--energy-log", log, "--iterations", "3",
        )  # fmt: skip
        moved = np.loadtxt(out, delimiter=",", skiprows=1, usecols=(0, 1, 2)) - points
        assert np.abs(moved[held]).max() < 1e-15
        assert np.abs(moved[~held]).max() > 1e-3
        energies = np.loadtxt(log, delimiter=",", skiprows=1)
        assert energies.shape == (4, 5)
        assert np.all(np.diff(energies[:, 1]) < 0.0)  # the volume of the union of octahedra
        assert energies[0, 1] == pytest.approx(
            pcsmooth.measure_polyhedra(
                points, 2 * spacing_of(points), pcsmooth.load_presets()["octahedron"]
            ).volume
        )


def spacing_of(points: Points) -> float:
    return pcsmooth.denoise(points, iterations=0).spacing


def test_normals_are_those_of_the_surface_and_not_of_the_body(scan: Path, tmp_path: Path) -> None:
    succeeds(
        "denoise", scan, "-o", tmp_path / "out.ply", "--polyhedron", "cube", "--iterations", "0"
    )
    vertex = load_ply(tmp_path / "out.ply")["vertex"]
    normals = np.c_[vertex["nx"], vertex["ny"], vertex["nz"]]
    outward = positions(scan) / np.linalg.norm(positions(scan), axis=1, keepdims=True)
    assert np.median(np.einsum("ij,ij->i", normals, outward)) > 0.99


@pytest.mark.parametrize("union", UNIONS)
def test_bodies_of_local_radius(scan: Path, tmp_path: Path, union: Union) -> None:
    finished = succeeds(
        "denoise", scan, "-o", tmp_path / "out.ply", "--polyhedron", "octahedron", "--union", union,
        "--radius", "local:3x", "--iterations", "2", "--json",
    )  # fmt: skip
    expected = pcsmooth.denoise(
        positions(scan), polyhedron=pcsmooth.load_presets()["octahedron"], union=union,
        radius="local:3x", iterations=2,
    )  # fmt: skip
    np.testing.assert_array_equal(positions(tmp_path / "out.ply"), expected.points)
    assert expected.radii is not None
    assert finished.json["radius_range"] == [expected.radii.min(), expected.radii.max()]
    assert f"polyhedron octahedron, union {union}" in finished.stderr


def test_a_body_of_ones_own(scan: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text('[slab]\nbase = "cube"\nscale = [1, 1, 0.5]\n')
    finished = succeeds(
        "denoise", scan, "-o", tmp_path / "out.ply", "--presets", own, "--polyhedron", "slab",
        "--union", "naive", "--json",
    )  # fmt: skip
    assert finished.json["polyhedron"] == "slab"
    assert finished.json["union"] == "naive"
    expected = pcsmooth.denoise(
        positions(scan), polyhedron=pcsmooth.load_presets(own)["slab"], union="naive"
    )
    assert finished.json["volume_after"] == expected.history[-1].volume


def test_the_output_says_which_body(scan: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text('["my own\\ncube"]\nbase = "cube"\n')
    finished = succeeds(
        "denoise", scan, "-o", tmp_path / "out.ply", "--presets", own, "--iterations", "1",
        "--polyhedron", "my own\ncube",
    )  # fmt: skip
    comments = load_ply(tmp_path / "out.ply").comments
    assert any("polyhedron=my-own-cube union=exact" in comment for comment in comments)
    assert "union exact" in finished.stderr
    succeeds("denoise", scan, "-o", tmp_path / "balls.ply", "--iterations", "1")
    assert not any("polyhedron" in line for line in load_ply(tmp_path / "balls.ply").comments)


FAILURES: dict[str, tuple[list[Any], int, str]] = {
    "unknown": (["--polyhedron", "cub"], 1, "there is no preset 'cub'; did you mean cube?"),
    "other dimension": (["--polyhedron", "square"], 1, "is a body in 2D, but the points have 3"),
    "no file": (["--polyhedron", "cube", "--presets", "no.toml"], 1, "no.toml: "),
    "union alone": (["--union", "naive"], 2, "--union and --presets need --polyhedron"),
    "presets alone": (["--presets", "no.toml"], 2, "--union and --presets need --polyhedron"),
    "bad union": (["--polyhedron", "cube", "--union", "both"], 2, "'both' is not one of"),
}


@pytest.mark.parametrize(("arguments", "status", "message"), FAILURES.values(), ids=FAILURES)
def test_failures(
    scan: Path, tmp_path: Path, arguments: list[Any], status: int, message: str
) -> None:
    finished = run("denoise", scan, "-o", tmp_path / "out.ply", *arguments)
    assert finished.status == status
    assert message in finished.stderr
    assert finished.stderr.count("\n") == 1
    assert not (tmp_path / "out.ply").exists()
