"""Balls of local radius in tiles: the same byte for byte as in the whole cloud."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pcsmooth.cloud import PointCloud
from pcsmooth.energies.local_reach import LocalReach
from pcsmooth.errors import CloudFileError
from pcsmooth.files.denoise_file import denoise_file
from pcsmooth.formats import write_cloud
from pcsmooth.measured import measure_cloud
from pcsmooth.methods.flows import ImplicitFlow
from pcsmooth.methods.shapes import Balls
from pcsmooth.neighbors import spacing_in_parts
from pcsmooth.neighbors.coincident import mark_distinct
from pcsmooth.neighbors.local_spacing import local_spacings
from pcsmooth.neighbors.spacing_in_parts import local_spacings_of
from pcsmooth.neighbors.spacing_samples import share_apart
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.positions import usable_rows
from pcsmooth.python.estimating import estimate_curvature
from pcsmooth.tiling.cutting import cut_cloud
from pcsmooth.tiling.runner import InProcess
from pcsmooth.tiling.tiled_cloud import TiledCloud
from tiling.clouds import MAP_COORDINATES, Points, battered, curve, layers
from tiling.test_one_part_equals_many import LOOPS, TUBES, check, check_estimate, marks
from tiling.test_spacing import CLOUDS
from tiling.whole_and_tiled import compare, source_of


def graded(n: int, ratio: float = 30.0, width: float = 10.0, seed: int = 1) -> Points:
    """A ribbon on which points are ever farther apart, up to so many times, with noise."""
    rng = np.random.default_rng(seed)
    along = (ratio ** rng.random(n) - 1.0) / (ratio - 1.0)
    noise = 0.05 * (1.0 + along * (ratio - 1.0))
    return np.column_stack([along * n / 2.0, width * rng.random(n), noise * rng.normal(size=n)])


def lines(across: float, n: int, seed: int = 2) -> Points:
    """A long strip of scan lines that are so many times farther apart than their points."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(float(n // 8)), across * np.arange(8.0))
    heights = 0.3 * rng.normal(size=x.size)
    return np.column_stack([x.ravel() + 0.3 * rng.random(x.size), y.ravel(), heights])


GRADED, ROUGH_CURVE = graded(4000), battered(curve(2000))
STRAY = np.r_[graded(3000), 300.0 * np.random.default_rng(5).normal(size=(40, 3))]

#: Points, and options of `denoise`.
CASES: dict[str, tuple[Points, dict[str, Any]]] = {
    "filter": (GRADED, {"scheme": "filter"}),
    "filter that keeps volume": (GRADED, {"scheme": "filter", "keep_volume": True}),
    "flow": (GRADED, {}),
    "wide balls": (GRADED, {"radius": "local:4x", "iterations": 1}),
    "small balls": (GRADED, {"radius": "local:0.8x"}),
    "area along normals": (GRADED, {"energy": "area", "motion": "normal"}),
    "no weight": (GRADED, {"weight": "none", "max_move": "0.1x"}),
    "kept volume, fixed points": (
        TUBES, {"keep_volume": True, "fixed": marks(TUBES, 0.1), "iterations": 1},
    ),
    "battered": (battered(GRADED) + MAP_COORDINATES, {"weight": "boundary"}),
    "stray points": (STRAY, {}),
    "lines": (lines(6.0, 3000), {}),
    "curve": (ROUGH_CURVE, {}),
    "kept volume of curves": (LOOPS, {"keep_volume": True, "motion": "normal"}),
    "layers of an exact grid": (layers(5, 300), {"iterations": 1}),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("points", "options"), CASES.values(), ids=CASES)
def test_one_part_equals_many(points: Points, options: dict[str, Any], tmp_path: Path) -> None:
    check(points, {"radius": "local", **options}, 1 + len(points) // 7, tmp_path)


def test_flow_of_one_part_equals_that_of_many(tmp_path: Path) -> None:
    check(graded(1500, width=4.0), {"radius": "local", "iterations": 1}, 120, tmp_path)


#: Points, and options of `estimate_curvature`.
ESTIMATES: dict[str, tuple[Points, dict[str, Any]]] = {
    "graded": (GRADED, {}),
    "gradients": (GRADED, {"estimator": "gradient"}),
    "support": (GRADED, {"support": 20}),
    "battered": (battered(GRADED), {"orient": "input"}),
    "stray points": (STRAY, {}),
    "lines": (lines(12.0, 3000), {}),
    "curve": (ROUGH_CURVE, {"radius": "local:3x"}),
}


@pytest.mark.slow
@pytest.mark.parametrize(("points", "options"), ESTIMATES.values(), ids=ESTIMATES)
def test_estimates_of_one_part_equal_those_of_many(
    points: Points, options: dict[str, Any], tmp_path: Path
) -> None:
    check_estimate(points, {"radius": "local", **options}, 6, tmp_path)


def test_radii_are_those_of_the_whole(tmp_path: Path) -> None:
    points = battered(graded(1500, width=4.0))
    _, whole, tiled = compare(points, 150, tmp_path, radius="local", scheme="filter", threads=1)
    assert whole.radii is not None
    found = np.concatenate(
        [part.radii for _, part in tiled.parts([PointCloud(points)]) if part.radii is not None]
    )
    assert found.tobytes() == whole.radii.tobytes()
    least, largest = tiled.denoised.estimated.radius_range or (0.0, 0.0)
    assert (least, largest) == (whole.radii[whole.finite].min(), whole.radii.max())


def test_a_part_looks_as_far_as_it_has_to_and_not_much_farther(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = graded(2500, width=4.0)
    reach = LocalReach.of_parts
    monkeypatch.setattr(LocalReach, "of_parts", lambda self, drift: 0.01 * reach(self, drift))
    unlike, _, _ = compare(points, 250, tmp_path, radius="local", iterations=2, threads=1)
    assert "points" in unlike


def test_a_part_looks_as_far_as_balls_are_large_around_it(tmp_path: Path) -> None:
    # Where it is dense, it looks fifty times less far than where it is sparse.
    points = graded(20_000, 1000.0)
    cloud = TiledCloud(cut_cloud(source_of(points), tmp_path, 1000), InProcess())
    measured = measure_cloud(cloud)
    local = measured.local_radii("local", cloud, may_choose=False)
    assert local is not None
    reaches = LocalReach(local, 3).of_parts(0.0)
    largest = 2.0 * local.around(np.zeros(cloud.n_parts))
    assert reaches.max() > 50.0 * reaches.min()
    assert np.all(reaches > 20.0 * largest)
    assert np.median(reaches / largest) < 150.0
    farther = LocalReach(local, 3).of_parts(local.largest)
    assert np.all(farther >= reaches)
    np.testing.assert_array_equal((LocalReach(local, 3) + 2.0).of_parts(0.0), reaches + 2.0)


# --- what is measured beforehand


@pytest.mark.parametrize("name", [*CLOUDS, "graded", "stray points", "lines"])
@pytest.mark.parametrize("is_alone", [False, True])
def test_local_spacings_are_those_of_the_whole(
    name: str, is_alone: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    more = {"graded": graded(3000), "stray points": STRAY, "lines": lines(8.0, 2000)}
    points = {**CLOUDS, **more}[name]
    if is_alone:  # parts look so little far that many points are looked after one by one
        monkeypatch.setattr(spacing_in_parts, "_FARTHER", 0.4)
        points = points[: 600 if len(points) > 600 else None]
    cloud = TiledCloud(cut_cloud(source_of(points), tmp_path, 1 + len(points) // 8), InProcess())
    found = local_spacings_of(cloud, mark_distinct(cloud)).read(0, cloud.count) * cloud.unit
    whole = WholeCloud.of(points, usable_rows(points))
    expected = local_spacings(points)[whole.input_rows]
    assert found.tobytes() == expected.tobytes()


@pytest.mark.parametrize("name", CLOUDS)
def test_samples_of_the_spacing_are_those_of_the_whole(name: str, tmp_path: Path) -> None:
    points = CLOUDS[name]
    whole = WholeCloud.of(points, usable_rows(points))
    tiles = TiledCloud(cut_cloud(source_of(points), tmp_path, 1 + len(points) // 8), InProcess())
    shares = [
        [share_apart(cloud, mark_distinct(cloud), length) for length in (0.3, 0.7, 1.0, 1.5)]
        for cloud in (whole, tiles)
    ]
    assert shares[0] == shares[1]


# --- what is chosen and what cannot be


def test_an_automatic_radius_is_local_in_tiles_too(tmp_path: Path) -> None:
    points = lines(12.0, 4000)
    assert estimate_curvature(points).radius == estimate_curvature(points, radius="local").radius
    check_estimate(points, {}, 6, tmp_path)


def test_implicit_steps_need_the_whole_cloud(tmp_path: Path) -> None:
    source = tmp_path / "cloud.ply"
    write_cloud(PointCloud(graded(600)), source)
    method = ImplicitFlow(shapes=Balls(radius="local"))
    message = "an implicit step with a local radius needs the whole cloud"
    with pytest.raises(CloudFileError, match=message):
        denoise_file(source, tmp_path / "out.ply", method, tile=100)
