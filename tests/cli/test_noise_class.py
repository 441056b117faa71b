"""Points that a LAS file calls noise stay where they are, and the rest is as without them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import laspy
import numpy as np
import numpy.typing as npt
import pytest

from cli.clouds import sphere
from cli.commands import pcsmooth as command
from cli.commands import succeeds
from pcsmooth.files import cloud_input, result_file
from pcsmooth.formats import open_chunks, read_cloud

N = 300
NOISE = np.zeros(N, np.bool_)
NOISE[[0, 7, 8, 100, 101, 250, N - 1]] = True
"""Rows that are noise: of class 7, of class 18 and withheld in turn."""

SCHEMES = {
    "filter": (),
    "euler": ("--scheme", "euler", "--iterations", "2"),
    "implicit": ("--scheme", "implicit", "--iterations", "1"),
}

KEPT = ("--keep-noise-class",)


@pytest.fixture(autouse=True)
def _few_rows_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (cloud_input, result_file):
        monkeypatch.setattr(module, "ROWS", 77)


def save(path: Path, rows: npt.NDArray[np.bool_], point_format: int, *, marked: bool = True) -> Any:
    """Write rows of a sphere that has noise inside it."""
    points = sphere(N)
    points[NOISE] *= 0.97
    header = laspy.LasHeader(version="1.4", point_format=point_format)
    header.scales, header.offsets = np.full(3, 1e-6), np.array([5e5, 4e6, 100.0])
    header.add_extra_dim(laspy.ExtraBytesParams("number", "i4"))
    las = laspy.LasData(header)
    kinds = np.where(NOISE, np.cumsum(NOISE) % 3, -1)[rows]
    las.xyz = points[rows] + header.offsets
    las.number = np.arange(N)[rows]
    las.classification = np.full(len(kinds), 2)
    if marked:
        las.classification = np.select([kinds == 0, kinds == 1], [7, 18], 2)
        las.withheld = kinds == 2
    las.write(str(path))
    return laspy.read(path)


def everything(path: Path) -> Any:
    return laspy.read(path).points.array


BOTH = pytest.mark.parametrize("suffix", ["las", "laz"])


@pytest.mark.parametrize(
    ("scheme", "suffix", "point_format"),
    [
        ("filter", "las", 1), ("filter", "laz", 6), ("euler", "laz", 1), ("euler", "las", 6),
        ("implicit", "las", 6), ("implicit", "laz", 1),
    ],
)  # fmt: skip
def test_denoise(tmp_path: Path, scheme: str, suffix: str, point_format: int) -> None:
    whole, rest = tmp_path / f"whole.{suffix}", tmp_path / f"rest.{suffix}"
    before = save(whole, NOISE | True, point_format)
    save(rest, ~NOISE, point_format)
    results = [tmp_path / f"{name}.{suffix}" for name in ("a", "b")]
    finished = [
        succeeds("denoise", source, "-o", result, "--json", *SCHEMES[scheme])
        for source, result in zip((whole, rest), results, strict=True)
    ]
    after, expected = map(everything, results)
    np.testing.assert_array_equal(after[~NOISE], expected)
    assert (after[~NOISE]["X"] != before.X[~NOISE]).mean() > 0.9
    for axis in "XYZ":
        np.testing.assert_array_equal(after[axis][NOISE], before[axis][NOISE])
    summary = finished[0].json
    assert (summary["points"], summary["noise_class"], summary["not_finite"]) == (N, NOISE.sum(), 0)
    assert finished[1].json["noise_class"] == 0
    own = ("input", "output", "points", "noise_class", "seconds")
    assert {k: v for k, v in summary.items() if k not in own} == {
        k: v for k, v in finished[1].json.items() if k not in own
    }
    note = f"{N} points in 3D, {NOISE.sum()} of a noise class or withheld (passed through)"
    assert note in finished[0].stderr


@pytest.mark.parametrize(
    ("scheme", "suffix", "options"),
    [
        ("filter", "las", ()), ("filter", "laz", KEPT), ("euler", "laz", ()),
        ("euler", "las", KEPT), ("implicit", "las", ()), ("implicit", "laz", KEPT),
    ],
)  # fmt: skip
def test_tiles(tmp_path: Path, scheme: str, suffix: str, options: tuple[str, ...]) -> None:
    source = tmp_path / f"a.{suffix}"
    save(source, NOISE | True, 6)
    results = [tmp_path / f"{name}.{suffix}" for name in ("whole", "tiled")]
    chosen = (*SCHEMES[scheme], *options)
    whole = succeeds("denoise", source, "-o", results[0], "--json", *chosen).json
    parts = succeeds("denoise", source, "-o", results[1], "--json", "--tile", "75", *chosen).json
    assert parts["tiles"] >= 3
    assert parts["noise_class"] == whole["noise_class"] == (0 if options else NOISE.sum())
    assert parts["not_finite"] == whole["not_finite"] == 0
    if scheme == "implicit":  # which solves a system for each tile
        marked = everything(results[1])[NOISE], everything(source)[NOISE]
        assert all((marked[0][axis] == marked[1][axis]).all() for axis in "XYZ") != bool(options)
        return
    assert results[0].read_bytes() == results[1].read_bytes()


@BOTH
def test_curvature(tmp_path: Path, suffix: str) -> None:
    whole, rest = tmp_path / f"whole.{suffix}", tmp_path / f"rest.{suffix}"
    save(whole, NOISE | True, 6)
    save(rest, ~NOISE, 6)
    results = [tmp_path / f"{name}.{suffix}" for name in ("a", "b")]
    summary = succeeds("curvature", whole, "-o", results[0], "--json").json
    succeeds("curvature", rest, "-o", results[1])
    np.testing.assert_array_equal(everything(results[0])[~NOISE], everything(results[1]))
    assert not read_cloud(results[0]).columns["confidence"][NOISE].any()
    assert (summary["noise_class"], summary["not_finite"]) == (NOISE.sum(), 0)


@BOTH
def test_info(tmp_path: Path, suffix: str) -> None:
    whole, rest = tmp_path / f"whole.{suffix}", tmp_path / f"rest.{suffix}"
    save(whole, NOISE | True, 6)
    save(rest, ~NOISE, 6)
    facts, expected = (succeeds("info", path, "--json").json for path in (whole, rest))
    assert facts == {**expected, "file": str(whole), "points": N, "noise_class": NOISE.sum()}
    kept = succeeds("info", whole, "--json", "--keep-noise-class").json
    assert kept["noise_class"] == 0
    assert kept["mean_spacing"] != expected["mean_spacing"]


@pytest.mark.parametrize(("name", "suffix"), [("denoise", "las"), ("curvature", "laz")])
def test_kept_points_are_like_any_other(tmp_path: Path, suffix: str, name: str) -> None:
    marked, plain = tmp_path / f"marked.{suffix}", tmp_path / f"plain.{suffix}"
    save(marked, NOISE | True, 6)
    save(plain, NOISE | True, 6, marked=False)
    results = [tmp_path / f"{name}.{suffix}" for name in ("a", "b")]
    summary = succeeds(name, marked, "-o", results[0], "--keep-noise-class", "--json").json
    succeeds(name, plain, "-o", results[1])
    after, expected = map(read_cloud, results)
    np.testing.assert_array_equal(after.points, expected.points)
    np.testing.assert_array_equal(after.columns["confidence"], expected.columns["confidence"])
    assert summary["noise_class"] == 0
    assert set(after.columns["classification"][NOISE]) == {2, 7, 18}


@pytest.mark.parametrize("name", ["denoise", "denoise --tile 100", "curvature"])
def test_nothing_but_noise(tmp_path: Path, name: str) -> None:
    save(tmp_path / "a.las", NOISE, 6)
    finished = command(*name.split(), tmp_path / "a.las", "-o", tmp_path / "b.las")
    assert finished.status == 1
    assert finished.stderr.endswith(
        "a.las: all its points are of a noise class or withheld; pass --keep-noise-class\n"
    )


@BOTH
def test_chunks_have_the_marks_with_and_without_columns(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a.{suffix}"
    save(path, NOISE | True, 6)
    np.testing.assert_array_equal(read_cloud(path).noise_marks, NOISE)
    with open_chunks(path) as chunks:
        for columns in (True, False):
            found = [
                np.zeros(len(cloud), np.bool_) if cloud.noise_marks is None else cloud.noise_marks
                for cloud in chunks.read(3, columns)
            ]
            np.testing.assert_array_equal(np.concatenate(found), NOISE)


def test_classes_of_other_formats_mean_nothing(tmp_path: Path) -> None:
    save(tmp_path / "a.las", NOISE | True, 6)
    succeeds("convert", tmp_path / "a.las", "-o", tmp_path / "a.ply")
    cloud = read_cloud(tmp_path / "a.ply")
    assert cloud.noise_marks is None
    assert 7 in cloud.columns["classification"]
