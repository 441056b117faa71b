"""From file to file in Python: what the command does, without the command."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pcsmooth
from cli.clouds import circle, save_ply, save_text, sphere, vertices
from cli.commands import succeeds
from pcsmooth.files import denoise_file as module
from pcsmooth.tiling.runner import InProcess, TileWork


class Counting(InProcess):
    """Counts what it is given."""

    def __init__(self) -> None:
        self.count = 0

    def map(self, work: TileWork, tasks: Any) -> Iterator[Any]:
        for result in super().map(work, tasks):
            self.count += 1
            yield result


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    held = np.arange(150) % 7 == 0
    return save_ply(tmp_path / "scan.ply", vertices(sphere(), "f8", held=held.astype("u1")))


def facts(report: pcsmooth.DenoiseReport) -> dict[str, Any]:
    found = json.loads(json.dumps(report.as_json()))
    return {name: value for name, value in found.items() if name not in ("seconds", "output")}


def test_file_and_report_are_those_of_the_command(scan: Path, tmp_path: Path) -> None:
    done = succeeds("denoise", scan, "-o", tmp_path / "a.ply", "--fixed", "held", "--json")
    told: list[str] = []
    report = pcsmooth.denoise_file(scan, tmp_path / "b.ply", fixed="held", say=told.append)
    assert (tmp_path / "b.ply").read_bytes() == (tmp_path / "a.ply").read_bytes()
    assert facts(report) == {
        name: value for name, value in done.json.items() if name not in ("seconds", "output")
    }
    assert report.output == str(tmp_path / "b.ply")
    assert report.fixed == 22
    assert report.seconds > 0.0
    assert told == []


def test_methods_and_keywords_are_those_of_denoise(scan: Path, tmp_path: Path) -> None:
    flow = pcsmooth.EulerFlow(iterations=2)
    reports = [
        pcsmooth.denoise_file(scan, tmp_path / "a.ply", flow, motion=pcsmooth.Motion("normal")),
        pcsmooth.denoise_file(scan, tmp_path / "a.ply", motion="normal", iterations=2),
    ]
    assert facts(reports[0]) == facts(reports[1])
    assert (reports[0].scheme, reports[0].iterations, reports[0].motion) == ("euler", 2, "normal")
    points = pcsmooth.denoise(pcsmooth.read_cloud(scan).points, flow, motion="normal").points
    np.testing.assert_array_equal(pcsmooth.read_cloud(tmp_path / "a.ply").points, points)


def test_in_tiles_by_a_runner(scan: Path, tmp_path: Path) -> None:
    whole = pcsmooth.denoise_file(scan, tmp_path / "a.ply", iterations=1, tile="off")
    runner, folder = Counting(), tmp_path / "tiles"
    folder.mkdir()
    stages: set[str] = set()
    tiled = pcsmooth.denoise_file(
        scan, tmp_path / "b.ply", iterations=1, tile=30, tile_folder=folder, runner=runner,
        callback=lambda progress: stages.add(progress.stage),
    )  # fmt: skip
    assert (tmp_path / "b.ply").read_bytes() == (tmp_path / "a.ply").read_bytes()
    assert tiled.tiles is not None
    assert tiled.tiles >= 4
    assert runner.count >= 5 * tiled.tiles
    assert {"cutting into tiles", "steps", "writing"} <= stages
    assert list(folder.iterdir()) == []
    assert facts(tiled) == {**facts(whole), "tiles": tiled.tiles}


def test_how_estimates_are_written(scan: Path, tmp_path: Path) -> None:
    writing = pcsmooth.Writing(convention="sum", dialect="meshlab", single=True)
    report = pcsmooth.denoise_file(scan, tmp_path / "a.ply", writing=writing)
    assert report.estimates.mean_convention == "sum"
    cloud = pcsmooth.read_cloud(tmp_path / "a.ply")
    assert cloud.position_type == np.float32
    assert list(cloud.columns) == ["held", "nx", "ny", "nz", "quality"]


def test_the_local_spacing_is_written_where_it_is_asked_for(scan: Path, tmp_path: Path) -> None:
    writing = pcsmooth.Writing(dialect="meshlab", extra_columns=("spacing",))
    pcsmooth.denoise_file(scan, tmp_path / "a.ply", writing=writing)
    cloud = pcsmooth.read_cloud(tmp_path / "a.ply")
    assert list(cloud.columns) == ["held", "nx", "ny", "nz", "quality", "scalar_spacing"]
    with pytest.raises(pcsmooth.CloudFileError, match="the column spacing needs the whole cloud"):
        pcsmooth.denoise_file(scan, tmp_path / "b.ply", writing=writing, tile=30)
    with pytest.raises(pcsmooth.InvalidInputError, match="'density' is not known; there is sp"):
        pcsmooth.Writing(extra_columns=("density",))


def test_the_noise_is_written_where_it_is_asked_for(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    points = rng.random((6000, 3)) * [1.0, 1.0, 0.0]
    points[:, 2] = 0.002 * 4.0 ** points[:, 0] * rng.normal(size=6000)
    points[7] = np.nan
    pcsmooth.write_cloud(pcsmooth.PointCloud(points), tmp_path / "louder.ply")
    writing = pcsmooth.Writing(dialect="meshlab", extra_columns=("sigma",))
    source = tmp_path / "louder.ply"
    pcsmooth.denoise_file(source, tmp_path / "whole.ply", writing=writing, tile="off")
    report = pcsmooth.denoise_file(source, tmp_path / "tiles.ply", writing=writing, tile=1500)
    assert report.plan.noise_range is not None
    whole, tiles = (pcsmooth.read_cloud(tmp_path / f"{name}.ply") for name in ("whole", "tiles"))
    assert list(whole.columns) == ["nx", "ny", "nz", "quality", "scalar_sigma"]
    sigma = whole.columns["scalar_sigma"]
    assert sigma.tobytes() == tiles.columns["scalar_sigma"].tobytes()
    assert sigma[7] == 0.0
    result = pcsmooth.denoise(points)
    assert result.sigma is not None
    assert sigma.tobytes() == result.sigma.astype(np.float32).tobytes()
    ratios = sigma / (0.002 * 4.0 ** points[:, 0])
    for low in (0.1, 0.3, 0.5, 0.7):
        strip = (low < points[:, 0]) & (points[:, 0] < low + 0.2)
        assert np.median(ratios[strip]) == pytest.approx(1.0, abs=0.1)


def test_one_noise_is_that_of_all_points(scan: Path, tmp_path: Path) -> None:
    writing = pcsmooth.Writing(extra_columns=("sigma",))
    report = pcsmooth.denoise_file(scan, tmp_path / "a.ply", writing=writing, noise=0.01)
    assert report.plan.noise == pytest.approx(0.01)
    cloud = pcsmooth.read_cloud(tmp_path / "a.ply")
    assert (cloud.columns["scalar_sigma"] == np.float32(0.01)).all()


def test_only_the_filter_finds_the_noise(scan: Path, tmp_path: Path) -> None:
    writing = pcsmooth.Writing(extra_columns=("sigma",))
    with pytest.raises(pcsmooth.InvalidInputError, match="the scheme euler does not look for it"):
        pcsmooth.denoise_file(scan, tmp_path / "a.ply", writing=writing, scheme="euler")
    after = pcsmooth.Writing(extra_columns=("spacing", "sigma_after"))
    with pytest.raises(pcsmooth.InvalidInputError, match="the column sigma_after is of the noise"):
        pcsmooth.denoise_file(scan, tmp_path / "a.ply", writing=after, scheme="euler")
    with pytest.raises(pcsmooth.InvalidInputError, match="moves no point does not look for it"):
        writing.check_moved_by("")


def test_the_error_that_is_left_is_written_where_it_is_asked_for(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    points = rng.random((6000, 3)) * [1.0, 1.0, 0.0]
    points[:, 2] = 0.002 * 4.0 ** points[:, 0] * rng.normal(size=6000)
    points[7], points[9], points[11] = np.nan, [0.5, 0.5, 0.4], points[12]
    pcsmooth.write_cloud(pcsmooth.PointCloud(points), tmp_path / "louder.ply")
    writing = pcsmooth.Writing(dialect="pcl", extra_columns=("sigma", "sigma_after"))
    source = tmp_path / "louder.ply"
    pcsmooth.denoise_file(source, tmp_path / "whole.ply", writing=writing, tile="off")
    pcsmooth.denoise_file(source, tmp_path / "tiles.ply", writing=writing, tile=1500)
    whole, tiles = (pcsmooth.read_cloud(tmp_path / f"{name}.ply") for name in ("whole", "tiles"))
    assert list(whole.columns)[-2:] == ["scalar_sigma", "scalar_sigma_after"]
    left = whole.columns["scalar_sigma_after"]
    assert left.tobytes() == tiles.columns["scalar_sigma_after"].tobytes()
    result = pcsmooth.denoise(points)
    assert result.sigma_after is not None
    assert left.tobytes() == result.sigma_after.astype(np.float32).tobytes()
    assert left[7] == 0.0
    assert left[9] == whole.columns["scalar_sigma"][9]  # an outlier keeps what it has
    assert left[11] == left[12]
    again = pcsmooth.denoise_file(source, tmp_path / "held.ply", writing=writing, max_move=1e-12)
    held = pcsmooth.read_cloud(tmp_path / "held.ply").columns
    assert again.max_displacement < 2e-12
    np.testing.assert_allclose(held["scalar_sigma_after"], held["scalar_sigma"], rtol=1e-6)


def test_bodies_have_no_name(scan: Path, tmp_path: Path) -> None:
    cube = pcsmooth.load_presets()["cube"]
    report = pcsmooth.denoise_file(scan, tmp_path / "a.ply", polyhedron=cube, iterations=1)
    assert facts(report)["polyhedron"] == "polyhedron"
    assert facts(report)["union"] == "exact"


def test_text_by_its_columns(tmp_path: Path) -> None:
    points = circle()
    path = save_text(tmp_path / "a.txt", np.c_[np.arange(len(points)), points])
    told: list[str] = []
    report = pcsmooth.denoise_file(
        path, tmp_path / "b.txt", columns=("2", "3"), dim=2, say=told.append
    )
    assert report.points.coordinates == ["2", "3"]
    assert told[0] == f"{path}: coordinates: columns 2, 3"


def test_a_file_that_is_there_is_left(scan: Path, tmp_path: Path) -> None:
    target = tmp_path / "a.ply"
    target.write_bytes(b"precious")
    with pytest.raises(pcsmooth.CloudFileError, match="exists already"):
        pcsmooth.denoise_file(scan, target, overwrite=False)
    assert target.read_bytes() == b"precious"
    pcsmooth.denoise_file(scan, target)
    assert len(pcsmooth.read_cloud(target)) == 150


def test_what_needs_the_whole_cloud_is_refused_in_tiles(scan: Path, tmp_path: Path) -> None:
    with pytest.raises(pcsmooth.CloudFileError, match="automatic differentiation needs the whole"):
        pcsmooth.denoise_file(scan, tmp_path / "a.ply", gradient="autodiff", tile=30)
    assert not (tmp_path / "a.ply").exists()


@pytest.mark.parametrize("tile", [0, -5, True, 100.5, "many", None])
def test_sizes_of_tiles_that_are_none(tile: Any, scan: Path, tmp_path: Path) -> None:
    with pytest.raises(pcsmooth.InvalidInputError, match=r"tile is .*; it must be a number of poi"):
        pcsmooth.denoise_file(scan, tmp_path / "a.ply", tile=tile)


def test_sizes_of_tiles_may_be_numbers_of_numpy(scan: Path, tmp_path: Path) -> None:
    tile: Any = np.int64(30)
    report = pcsmooth.denoise_file(scan, tmp_path / "a.ply", iterations=0, tile=tile)
    assert report.tiles is not None


def test_a_cloud_without_a_finite_point(tmp_path: Path) -> None:
    path = save_ply(tmp_path / "a.ply", vertices(np.full((5, 3), np.nan), "f8"))
    for tile in ("off", 2):
        with pytest.raises(pcsmooth.InvalidInputError, match="no point with finite coordinates"):
            pcsmooth.denoise_file(path, tmp_path / "b.ply", tile=tile, radius=1.0)
    assert not (tmp_path / "b.ply").exists()


@pytest.mark.parametrize("tile", ["off", 30])
def test_pictures_are_of_a_part_of_many_points(
    scan: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tile: Any
) -> None:
    """At regular ranks, whatever pieces they come in."""
    monkeypatch.setattr("pcsmooth.files.cloud_input.ROWS", 41)
    seen: dict[int, module.Sample] = {}
    real = module.denoise_input

    def denoise_input(*arguments: Any, **options: Any) -> module.DenoisedFile:
        done = real(*arguments, **options)
        for most in (1000, 50, 29):
            monkeypatch.setattr(module, "_MOST_SHOWN", most)
            seen[most] = done.sample()
        return done

    monkeypatch.setattr(module, "denoise_input", denoise_input)
    pcsmooth.denoise_file(scan, tmp_path / "a.ply", iterations=1, tile=tile)
    before, after = (pcsmooth.read_cloud(tmp_path / name).points for name in ("scan.ply", "a.ply"))
    for most, every in ((1000, 1), (50, 3), (29, 6)):
        np.testing.assert_array_equal(seen[most].before, before[::every])
        np.testing.assert_array_equal(seen[most].after, after[::every])
        assert len(seen[most].normals) == len(seen[most].mean_curvature) == len(before[::every])
