"""Batches of files of different formats."""

from __future__ import annotations

import json
from pathlib import Path

import click
import numpy as np
import numpy.typing as npt
import pytest

from cli.clouds import load_ply, sphere
from cli.commands import pcsmooth, succeeds
from formats.e57_files import Scan, save_e57
from pcsmooth import CloudFileError, PointCloud, read_cloud, write_cloud
from pcsmooth.cli.sources import Job, Source, find_sources, plan_jobs
from pcsmooth.formats import FORMATS, WRITTEN_FORMATS, format_of

N = 60
_STL = b"solid a\nfacet normal 0 0 1\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendsolid\n"


def ptx_file(points: npt.NDArray[np.float64]) -> str:
    """Compose a PTX file of one scan that is not moved."""
    rows = "".join(f"{x!r} {y!r} {z!r} 0.5\n" for x, y, z in points.tolist())
    axes = "1 0 0\n0 1 0\n0 0 1\n"
    return f"1\n{len(points)}\n0 0 0\n{axes}1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n{rows}"


@pytest.fixture
def scans(tmp_path: Path) -> Path:
    """One cloud in every format, and a file of none."""
    folder = tmp_path / "scans"
    folder.mkdir()
    for name in WRITTEN_FORMATS:
        if name != "stl":
            points = sphere(N)[:, : 2 if name == "xy" else 3]
            write_cloud(PointCloud(points), folder / f"{name}.{name.upper()}")
    (folder / "stl.STL").write_bytes(_STL)
    fields = {f"cartesian{axis}": sphere(N)[:, rank] for rank, axis in enumerate("XYZ")}
    save_e57(folder / "e57.E57", Scan(fields))
    (folder / "ptx.PTX").write_text(ptx_file(sphere(N)))
    (folder / "notes.md").write_text("not looked at\n")
    return folder


def test_folders_hold_files_of_every_format(scans: Path) -> None:
    assert find_sources((str(scans),)) == [
        Source(str(scans / f"{name}.{name.upper()}")) for name in sorted(FORMATS)
    ]


@pytest.mark.usefixtures("quick_workers")
@pytest.mark.parametrize("jobs", [1, 2])
def test_results_keep_their_formats(tmp_path: Path, scans: Path, jobs: int) -> None:
    out = tmp_path / "out"
    (scans / "stl.STL").unlink()
    finished = succeeds("curvature", scans, "--output-dir", out, "--jobs", jobs)
    expected = {f"{name}.{name.upper()}" for name in WRITTEN_FORMATS if name != "stl"}
    expected |= {"e57.ply", "ptx.ply"}
    assert {path.name for path in out.glob("[!.]*")} == expected
    for path in out.glob("[!.]*"):
        assert len(read_cloud(path)) == N
        assert format_of(str(path), path.read_bytes()) == path.suffix[1:].lower()
    assert f"{scans / 'e57.E57'} -> {out / 'e57.ply'}: {N} points" in finished.stderr
    for name in ("e57", "ptx"):
        np.testing.assert_array_equal(load_ply(out / f"{name}.ply")["vertex"]["x"], sphere(N)[:, 0])
    warnings = [line for line in finished.stderr.splitlines() if "warning" in line]
    for name in ("obj", "off"):
        assert any(f"{name}.{name.upper()}: warning: " in line for line in warnings)


def test_e57_and_ply_of_the_same_name_do_not_meet(tmp_path: Path, scans: Path) -> None:
    (scans / "e57.ply").write_bytes((scans / "ply.PLY").read_bytes())
    finished = pcsmooth("denoise", scans, "--output-dir", tmp_path / "out")
    assert finished.status == 2
    assert "e57.E57 and " in finished.stderr
    assert "would both become" in finished.stderr


def test_what_results_are_called() -> None:
    names = {"": "a.ply", "_x": "a_x.ply", ".laz": "a.laz", "_x.csv": "a_x.csv"}
    for suffix, name in names.items():
        assert plan_jobs([Source("b/a.e57")], "o", suffix) == [Job("b/a.e57", f"o/{name}")]
    assert plan_jobs([Source("a.LAZ")], "o", "_x") == [Job("a.LAZ", "o/a_x.LAZ")]


def test_results_of_copc_files_do_not_claim_its_index() -> None:
    names = {"": "a.laz", "_x": "a_x.laz", ".ply": "a.ply"}
    for suffix, name in names.items():
        assert plan_jobs([Source("b/a.copc.laz")], "o", suffix) == [
            Job("b/a.copc.laz", f"o/{name}")
        ]
    assert plan_jobs([Source("a.COPC.LAZ")], "o", "") == [Job("a.COPC.LAZ", "o/a.LAZ")]
    assert plan_jobs([Source("a.copc.ply")], "o", "") == [Job("a.copc.ply", "o/a.copc.ply")]
    with pytest.raises(click.UsageError, match="would both become"):
        plan_jobs([Source("a.copc.laz"), Source("a.laz")], "o", "")


@pytest.mark.parametrize("name", ["a.copc.laz", "A.COPC.LAZ"])
def test_copc_is_not_written(tmp_path: Path, name: str) -> None:
    write_cloud(PointCloud(sphere(N)), tmp_path / "a.ply")
    message = f"{name}: COPC can be read but not written; name it .laz, without .copc"
    for command in ("denoise", "curvature", "convert"):
        finished = pcsmooth(command, tmp_path / "a.ply", "-o", tmp_path / name)
        assert finished.status == 1
        assert finished.stderr.endswith(f"{message}\n")
    with pytest.raises(CloudFileError, match=message):
        write_cloud(PointCloud(sphere(N)), tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == ["a.ply"]


class TestConvert:
    @pytest.mark.usefixtures("quick_workers")
    def test_many_into_one_format(self, tmp_path: Path, scans: Path) -> None:
        out = tmp_path / "out"
        finished = succeeds(
            "convert", scans, "--output-dir", out, "--suffix", ".laz", "--json", "--jobs", 2
        )
        records = [json.loads(line) for line in finished.stdout.splitlines()]
        assert [Path(record["output"]).name for record in records] == [
            f"{name}.laz" for name in sorted(FORMATS)
        ]
        assert {record["format"] for record in records} == {"laz"}
        assert all(record["rounding"] <= 1e-4 for record in records)
        assert [record["lost"] for record in records if record["input"].endswith("STL")] == [
            ["triangles of the STL file (1)"]
        ]
        for record in records:
            np.testing.assert_allclose(
                read_cloud(record["output"]).points[:, :2],
                read_cloud(record["input"]).points[:, :2],
                atol=1e-4,
            )

    def test_what_fails_does_not_stop_the_others(self, tmp_path: Path, scans: Path) -> None:
        out = tmp_path / "out"
        finished = pcsmooth("convert", scans, "--output-dir", out, "--suffix", "_x.stl", "-q")
        assert finished.status == 1
        assert [path.name for path in out.glob("[!.]*")] == ["stl_x.stl"]
        assert len(read_cloud(out / "stl_x.stl")) == 3
        *failures, last = finished.stderr.splitlines()
        assert len(failures) == len(FORMATS) - 1
        assert all("an .stl file holds triangles" in line for line in failures)
        assert last == f"Error: {len(FORMATS) - 1} of {len(FORMATS)} files failed"

    def test_json_of_one(self, scans: Path, tmp_path: Path) -> None:
        target = tmp_path / "a.pcd"
        summary = succeeds("convert", scans / "las.LAS", "-o", target, "--json", "-q").json
        assert summary.pop("seconds") < 60.0
        assert 0.0 < summary.pop("rounding") < 1e-6
        assert summary == {
            "input": str(scans / "las.LAS"),
            "output": str(target),
            "format": "pcd",
            "points": N,
            "coordinates": ["x", "y", "z"],
            "lost": [],
        }


@pytest.mark.usefixtures("quick_workers")
def test_info(scans: Path) -> None:
    finished = succeeds("info", scans, "--json", "--jobs", 2)
    assert len(finished.stdout.splitlines()) == len(FORMATS)


def test_compressed_files_of_a_folder(tmp_path: Path) -> None:
    folder, out = tmp_path / "scans", tmp_path / "out"
    folder.mkdir()
    for name in ("a.ply.gz", "b.xyz", "c.csv.GZ", "notes.txt.gz.old", "d.gz"):
        (folder / name).write_bytes(b"")
    cloud = PointCloud(sphere(N))
    for name in ("a.ply.gz", "b.xyz", "c.csv.GZ"):
        write_cloud(cloud, folder / name)
    succeeds("convert", folder, "--output-dir", out, "--suffix", "_new")
    assert sorted(path.name for path in out.glob("[!.]*")) == [
        "a_new.ply.gz",
        "b_new.xyz",
        "c_new.csv.GZ",
    ]
    np.testing.assert_array_equal(read_cloud(out / "c_new.csv.GZ").points, cloud.points)
    succeeds(
        "convert", folder / "a.ply.gz", folder / "b.xyz", "--output-dir", out, "--suffix", ".laz.gz"
    )
    assert (out / "a.laz.gz").exists()
    assert (out / "b.laz.gz").exists()
    assert plan_jobs([Source("s.e57.gz"), Source("t.copc.laz.gz")], "o", "") == [
        Job("s.e57.gz", str(Path("o/s.ply.gz"))), Job("t.copc.laz.gz", str(Path("o/t.laz.gz"))),
    ]  # fmt: skip
