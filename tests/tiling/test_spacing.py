from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pcsmooth.measured import measure_cloud
from pcsmooth.neighbors import spacing
from pcsmooth.neighbors.coincident import mark_distinct
from pcsmooth.neighbors.spacing import measure_spacing
from pcsmooth.neighbors.spacing_quantiles import spacing_quantiles
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Parts
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.positions import usable_rows
from pcsmooth.progress import Progress
from pcsmooth.tiling.cutting import cut_cloud
from pcsmooth.tiling.runner import InProcess
from pcsmooth.tiling.tiled_cloud import TiledCloud
from tiling.clouds import MAP_COORDINATES, Points, battered, curve, layers, ribbon, sphere
from tiling.whole_and_tiled import source_of


def crowded(dimension: int) -> Points:
    """Nearly all points in one place of a wide cloud."""
    rng = np.random.default_rng(7)
    heap = 100.0 + 1e-3 * rng.normal(size=(3000, dimension))
    return rng.permutation(np.concatenate([heap, 1e3 * rng.normal(size=(300, dimension))]))


CLOUDS = {
    "sheet": ribbon(3000),
    "sphere": sphere(3000),
    "curve": curve(3000),
    "rough sheet": battered(ribbon(3000)),
    "rough curve": battered(curve(3000)),
    "on the map": battered(ribbon(3000)) + MAP_COORDINATES,
    "layers": layers(5, 200),
    "heap": crowded(3),
    "heap in the plane": crowded(2),
    "on an axis": np.outer(np.random.default_rng(8).random(900), [0.0, 0.0, 1.0]),
    "on a line": np.outer(np.random.default_rng(8).random(900), [3.0, 2.0, 1.0]),
    "far outlier": np.r_[ribbon(2000), [[1e7, 0.0, 0.0], [0.0, 1e9, -1e9]]],
    "few distinct points": np.repeat(ribbon(5), 80, axis=0),
    "two points": np.repeat(ribbon(2), 50, axis=0),
    "one place": np.ones((300, 2)),
    "zeros of both signs": np.repeat([[0.0, 1.0, -0.0], [-0.0, 1.0, 0.0], [0.0, 2.0, 0.0]], 40, 0),
}


@pytest.mark.parametrize("points", CLOUDS.values(), ids=CLOUDS)
@pytest.mark.parametrize("samples", [20_000, 150])
def test_spacing_is_that_of_the_whole_to_the_last_bit(
    points: Points, samples: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(spacing, "_SAMPLES", samples)
    store = cut_cloud(source_of(points), tmp_path, 1 + len(points) // 8)
    told: list[Progress] = []
    found = measure_cloud(TiledCloud(store, InProcess(), told.append))
    whole = WholeCloud.of(points, usable_rows(points))
    expected = measure_cloud(whole)
    assert found.spacing * store.unit == expected.spacing * whole.unit
    assert found.distinct.count == expected.distinct.count
    np.testing.assert_array_equal(found.ends * store.unit, expected.ends * whole.unit)
    tiles = store.partition.n_tiles
    stages = [progress.stage for progress in told if progress.done == tiles]
    assert stages[0] == "coincident points"
    assert set(stages[1:]) == ({"spacing"} if found.spacing > 0.0 else set())


@pytest.mark.parametrize("points", CLOUDS.values(), ids=CLOUDS)
def test_quantiles_of_the_local_spacing_are_those_of_the_whole(
    points: Points, tmp_path: Path
) -> None:
    tiled = TiledCloud(cut_cloud(source_of(points), tmp_path, 1 + len(points) // 8), InProcess())
    whole = WholeCloud.of(points, usable_rows(points))
    found = spacing_quantiles(tiled, mark_distinct(tiled))
    expected = spacing_quantiles(whole, mark_distinct(whole))
    assert tiled.unit == whole.unit
    assert found == expected
    assert np.all(np.isfinite([found.dense, found.median, found.sparse]))


def test_clouds_ask_for_cells_for_a_tree_and_for_both(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []
    search = spacing._spacings_far

    def noted(parts: Parts, marks: Column, samples: Points, count: int) -> Points:
        asked.append(len(samples))
        return search(parts, marks, samples, count)  # type: ignore[arg-type]

    monkeypatch.setattr(spacing, "_spacings_far", noted)

    def searched(name: str) -> int:
        asked.clear()
        cloud = TiledCloud(cut_cloud(source_of(CLOUDS[name]), tmp_path, 1000), InProcess())
        measure_spacing(cloud, mark_distinct(cloud))
        return sum(asked)

    assert searched("layers") == 0
    assert 0 < searched("far outlier") <= 2002
    assert 0 < searched("rough sheet") < 1000
    assert searched("heap") == 3300
    assert searched("on an axis") == 900
