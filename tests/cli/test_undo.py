"""`denoise --write-displacement`, and `pcsmooth undo`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from cli.clouds import circle, sphere
from cli.commands import pcsmooth, succeeds
from pcsmooth import PointCloud, denoise, read_cloud, write_cloud
from pcsmooth.cli.exit_status import ExitStatus

RNG = np.random.default_rng(2)
POINTS = sphere() * (1.0 + 0.02 * RNG.normal(size=(len(sphere()), 1)))


def scan(path: Path, points: npt.NDArray[np.float64] = POINTS, dtype: str = "f8") -> Path:
    """A cloud with a column, as the format keeps it."""
    numbers = np.arange(len(points), dtype=np.uint16)
    write_cloud(PointCloud(points, {"intensity": numbers}, np.dtype(dtype), ("by hand",)), path)
    return path


@pytest.mark.parametrize("dtype", ["f4", "f8"])
@pytest.mark.parametrize("name", ["a.ply", "a.csv", "a.pcd", "a.las", "a.csv.gz"])
def test_there_and_back(name: str, dtype: str, tmp_path: Path) -> None:
    offset = [431_000.0, 5_518_000.0, 200.0] if dtype == "f8" else [3.0, 3.0, 3.0]
    source = scan(tmp_path / name, POINTS + offset, dtype)
    smooth, back = tmp_path / f"smooth_{name}", tmp_path / f"back_{name}"
    succeeds("denoise", source, "-o", smooth, "--write-displacement")
    said = succeeds("undo", smooth, "-o", back)
    expected, found = read_cloud(source), read_cloud(back)
    assert (read_cloud(smooth).points != expected.points).any()
    np.testing.assert_array_equal(found.points, expected.points)
    assert found.position_type == expected.position_type
    assert "of 150 points brought back" in said.stderr
    if name == "a.ply":
        assert back.read_bytes() == source.read_bytes()


def test_of_curves_flows_and_rows_that_are_not_finite(tmp_path: Path) -> None:
    points = np.vstack([circle(), [[np.nan, 1.0]]])
    source, smooth, back = (tmp_path / f"{name}.csv" for name in "abc")
    scan(source, points)
    succeeds("denoise", source, "-o", smooth, "--iterations", 2, "--write-displacement")
    columns = read_cloud(smooth).columns
    assert float(columns["dy"][-1]) == 0.0
    assert "dz" not in columns
    succeeds("undo", smooth, "-o", back)
    np.testing.assert_array_equal(read_cloud(back).points, points)


def test_of_the_last_of_several_runs(tmp_path: Path) -> None:
    first, second, back = (tmp_path / f"{name}.ply" for name in "abc")
    succeeds("denoise", scan(tmp_path / "s.ply"), "-o", first, "--write-displacement")
    succeeds("denoise", first, "-o", second, "--noise", 0.02, "--write-displacement")
    succeeds("undo", second, "-o", back)
    np.testing.assert_array_equal(read_cloud(back).points, read_cloud(first).points)
    (told,) = (text for text in read_cloud(back).comments if text.startswith("pcsmooth"))
    assert told in read_cloud(first).comments


@pytest.mark.slow
def test_in_tiles_and_batches(tmp_path: Path) -> None:
    points = np.c_[RNG.uniform(5, 45, (25_000, 2)), RNG.normal(9, 0.1, 25_000)]
    (tmp_path / "scans").mkdir()
    for name in ("a.ply", "b.las"):
        scan(tmp_path / "scans" / name, points)
    options = ("--write-displacement", "--strength", 0.7)
    for folder, tile in (("whole", "off"), ("tiled", 10_000)):
        succeeds(
            "denoise",
            tmp_path / "scans",
            "--output-dir",
            tmp_path / folder,
            "--tile",
            tile,
            *options,
        )
    for name in ("a.ply", "b.las"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "tiled" / name).read_bytes()
    succeeds("undo", tmp_path / "tiled", "--output-dir", tmp_path / "back")
    for name in ("a.ply", "b.las"):
        original = read_cloud(tmp_path / "scans" / name)
        np.testing.assert_array_equal(read_cloud(tmp_path / "back" / name).points, original.points)


def test_vectors_in_python() -> None:
    result = denoise(np.vstack([POINTS, [[np.nan, 0, 0]]]))
    lengths = np.linalg.norm(result.displacement_vectors, axis=1)
    np.testing.assert_allclose(lengths, result.displacement, rtol=1e-12, atol=1e-15)


def test_what_cannot_be(tmp_path: Path) -> None:
    source, out = scan(tmp_path / "a.ply"), tmp_path / "out.ply"
    plain = pcsmooth("undo", source, "-o", out)
    assert plain.status == ExitStatus.FAILED
    assert "no columns dx dy dz" in plain.stderr
    assert "denoise --write-displacement" in plain.stderr
    mesh = pcsmooth("denoise", source, "-o", tmp_path / "out.obj", "--write-displacement")
    assert "obj files like this have no named columns for the displacement" in mesh.stderr
    bare = pcsmooth("denoise", source, "-o", tmp_path / "out.xyz", "--write-displacement")
    assert "write .ply or .csv instead" in bare.stderr
    own = tmp_path / "own.ply"
    write_cloud(PointCloud(POINTS, {"dy": np.ones(len(POINTS))}), own)
    taken = pcsmooth("denoise", own, "-o", out, "--write-displacement")
    assert "a column 'dy' of its own" in taken.stderr
    for arguments in (
        ("curvature", source, "-o", out, "--write-displacement"),
        ("denoise", source, "-o", out, "--strength", "1.5"),
    ):
        assert pcsmooth(*arguments).status == ExitStatus.USAGE
    assert not out.exists()


def test_into_a_format_that_rounds(tmp_path: Path) -> None:
    smooth = tmp_path / "smooth.ply"
    succeeds("denoise", scan(tmp_path / "a.ply"), "-o", smooth, "--write-displacement")
    said = succeeds("undo", smooth, "-o", tmp_path / "back.las", "--json")
    assert 0.0 < said.json["rounding"] < 1e-4
    assert "round these coordinates by up to" in said.stderr
    stream = pcsmooth(
        "denoise", "-", "-o", "-", "--write-displacement", stdin=b"x,y,dx\n0,1,2\n3,4,5\n"
    )
    assert stream.status == ExitStatus.FAILED
    assert "<stdout>" in stream.stderr
