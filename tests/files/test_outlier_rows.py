"""Outliers left out of files, or alone in them: every format, whole and in tiles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pcsmooth
from cli.commands import pcsmooth as run
from cli.commands import succeeds
from pcsmooth.errors import CloudFileError, InvalidInputError

FAR = (30, 500, 900)


@pytest.fixture(scope="module")
def cloud() -> pcsmooth.PointCloud:
    """Give a noisy sheet; three points are far away, one of these fixed, one row is NaN."""
    rng = np.random.default_rng(4)
    points = np.round(rng.random((1200, 3)) * [1.0, 1.0, 0.0], 4)
    points[:, 2] = np.round(0.003 * rng.normal(size=1200), 5)
    points[FAR, 2] = [0.4, -0.5, 0.6]
    held = np.zeros(1200, np.uint8)
    held[FAR[2]] = 1
    return pcsmooth.PointCloud(points, {"held": held, "number": np.arange(1200, dtype=np.int32)})


def written(tmp_path: Path, name: str, cloud: pcsmooth.PointCloud) -> Path:
    pcsmooth.write_cloud(cloud, tmp_path / name)
    return tmp_path / name


def denoised(source: Path, target: Path, outliers: Any, **others: Any) -> pcsmooth.DenoiseReport:
    writing = pcsmooth.Writing(outliers=outliers)
    return pcsmooth.denoise_file(source, target, writing=writing, fixed="held", **others)


@pytest.mark.parametrize("suffix", ["ply", "las", "laz", "pcd", "csv", "ply.gz"])
def test_what_is_removed_and_what_is_alone_are_all_rows(
    cloud: pcsmooth.PointCloud, tmp_path: Path, suffix: str
) -> None:
    source = written(tmp_path, f"scan.{suffix}", cloud)
    reports, found = {}, {}
    for outliers in ("mark", "remove", "only"):
        target = tmp_path / f"{outliers}.{suffix}"
        reports[outliers] = denoised(source, target, outliers)
        found[outliers] = pcsmooth.read_cloud(target)
    numbers = {
        name: np.asarray(each.columns["number"]).astype(int).tolist()
        for name, each in found.items()
    }
    assert numbers["only"] == [30, 500]
    assert numbers["remove"] == [row for row in range(1200) if row not in (30, 500)]
    for name in ("remove", "only"):
        same = found["mark"].points[numbers[name]]
        assert found[name].points.tobytes() == same.tobytes()
        assert not {"outlier", "scalar_outlier"} & found[name].columns.keys()
    assert [reports[name].outliers for name in reports] == [3, 3, 3]
    assert [reports[name].removed for name in reports] == [0, 2, 1198]


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["ply", "las", "pcd", "csv"])
@pytest.mark.parametrize("outliers", ["remove", "only"])
def test_tiles_give_the_bytes_of_the_whole(
    cloud: pcsmooth.PointCloud, tmp_path: Path, suffix: str, outliers: Any
) -> None:
    source = written(tmp_path, "scan.ply", cloud)
    for tile in ("off", 400):
        denoised(source, tmp_path / f"{tile}.{suffix}", outliers, tile=tile)
    whole, tiles = ((tmp_path / f"{tile}.{suffix}").read_bytes() for tile in ("off", 400))
    assert tiles == whole


@pytest.mark.parametrize(
    ("name", "head"),
    [
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\n"
                  "property double y\nproperty double z\nend_header\n"),
        ("a.pcd", "VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {}\n"
                  "HEIGHT 1\nPOINTS {}\nDATA ascii\n"),
        ("a.pts", "{}\n"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("tile", ["off", "400"])
def test_odd_spellings_stay_with_their_rows(
    cloud: pcsmooth.PointCloud, tmp_path: Path, name: str, head: str, tile: str
) -> None:
    lines = [" ".join(map(str, point)) for point in cloud.points.tolist()]
    lines.insert(10, "NAN 0.5 -NaN")
    lines.insert(1000, "NaN 1.5 +Inf")
    source = tmp_path / name
    source.write_text(head.format(len(lines), len(lines)) + "\n".join(lines) + "\n")
    target = tmp_path / f"out{source.suffix}"
    done = succeeds("denoise", source, "-o", target, "--outliers", "remove", "--tile", tile,
                    "--json")  # fmt: skip
    assert done.json["removed"] == 3
    text = target.read_text().splitlines()[-1199:]
    assert text[10].startswith("NAN 0.5 -NaN")
    assert text[997].startswith("NaN 1.5 +Inf")


def test_what_it_says(cloud: pcsmooth.PointCloud, tmp_path: Path) -> None:
    source = written(tmp_path, "scan.ply", cloud)
    target = tmp_path / "a.ply"
    done = succeeds("denoise", source, "-o", target, "--outliers", "remove", "--fixed", "held")
    assert "  3 outliers, 1 of them fixed: 2 removed, 1198 points written\n" in done.stderr
    assert pcsmooth.read_cloud(target).comments[0].endswith(" outliers=remove")
    done = succeeds("denoise", source, "-o", target, "--overwrite", "--outliers", "only")
    assert "  3 outliers: only they are written, 1197 points are not\n" in done.stderr


def test_where_there_is_none(tmp_path: Path) -> None:
    x, y = np.meshgrid(np.arange(12.0), np.arange(12.0))
    flat = pcsmooth.PointCloud(np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1))
    source, target = written(tmp_path, "flat.ply", flat), tmp_path / "a.ply"
    report = pcsmooth.denoise_file(source, target, writing=pcsmooth.Writing(outliers="remove"))
    assert report.removed == 0
    assert len(pcsmooth.read_cloud(target)) == 144
    target.unlink()
    with pytest.raises(CloudFileError, match="no point is an outlier"):
        pcsmooth.denoise_file(source, target, writing=pcsmooth.Writing(outliers="only"))
    assert not target.exists()


@pytest.mark.parametrize(
    ("source", "target", "named"),
    [
        ("a.ply", "b.ply", "element 'face'"),
        ("a.off", "b.off", "a face"),
        ("a.ply", "b.pcd", ""),
        ("a.off", "b.ply", ""),
    ],
)
def test_faces_never_name_other_points(
    tmp_path: Path, source: str, target: str, named: str
) -> None:
    rng = np.random.default_rng(4)
    points = rng.random((400, 3)) * [1.0, 1.0, 0.002]
    points[7] += [0.0, 0.0, 0.7]
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in points.tolist()) + "3 0 1 2\n"
    heads = {
        "a.off": "OFF\n400 1 0\n",
        "a.ply": "ply\nformat ascii 1.0\nelement vertex 400\nproperty double x\n"
        "property double y\nproperty double z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n",
    }
    (tmp_path / source).write_text(heads[source] + rows)
    command = ("denoise", tmp_path / source, "-o", tmp_path / target, "--outliers", "remove")
    if named:
        failed = run(*command)
        assert failed.status == 1
        assert f"{named} would name other points; write .pcd" in failed.stderr
        assert not (tmp_path / target).exists()
    else:
        assert succeeds(*command, "--json").json["removed"] == 1
        assert len(pcsmooth.read_cloud(tmp_path / target)) == 399


def test_only_the_filter_finds_them(cloud: pcsmooth.PointCloud, tmp_path: Path) -> None:
    source = written(tmp_path, "scan.ply", cloud)
    writing = pcsmooth.Writing(outliers="remove")
    with pytest.raises(InvalidInputError, match="the scheme euler does not look for them"):
        pcsmooth.denoise_file(source, tmp_path / "a.ply", writing=writing, iterations=1)
    result = pcsmooth.denoise(cloud.points)
    with pytest.raises(InvalidInputError, match="'remove' is for denoise_file"):
        result.save(tmp_path / "a.ply", writing)
    with pytest.raises(InvalidInputError, match="outliers 'drop' is not known; there is mark, re"):
        pcsmooth.Writing(outliers="drop")  # type: ignore[arg-type]


def test_an_organised_cloud_becomes_one_row_and_that_is_said(
    cloud: pcsmooth.PointCloud, tmp_path: Path
) -> None:
    source = written(tmp_path, "scan.pcd", cloud)
    grid = source.read_bytes().replace(b"WIDTH 1200\nHEIGHT 1\n", b"WIDTH 40\nHEIGHT 30\n")
    source.write_bytes(grid)
    for outliers, said in (("mark", ""), ("remove", "40 x 30 points in rows and columns become")):
        told: list[str] = []
        target = tmp_path / f"{outliers}.pcd"
        denoised(source, target, outliers, say=told.append)
        assert [said in line for line in told if "rows and columns" in line] == [True] * bool(said)
    assert b"WIDTH 1198\nHEIGHT 1\n" in target.read_bytes()
