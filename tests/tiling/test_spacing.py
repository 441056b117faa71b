from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pcsmooth import neighbors
from pcsmooth.point_order import take_in_order
from pcsmooth.positions import usable_rows
from pcsmooth.tiling import spacing
from pcsmooth.tiling.column_store import Column
from pcsmooth.tiling.cutting import cut_cloud
from pcsmooth.tiling.runner import InProcess
from pcsmooth.tiling.spacing import marked_rows, measure_spacing
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
    monkeypatch.setattr(neighbors, "_SPACING_SAMPLES", samples)
    cloud = cut_cloud(source_of(points), tmp_path, 1 + len(points) // 8)
    told: list[int] = []
    found = measure_spacing(cloud, InProcess(), lambda: told.append(1))
    assert found == neighbors.mean_spacing(take_in_order(points, usable_rows(points)).points)
    tiles = cloud.partition.n_tiles
    assert len(told) == (2 if found > 0.0 else 1) * tiles


def test_clouds_ask_for_cells_for_a_tree_and_for_both(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []
    search = spacing._spacings_far

    def noted(cloud: TiledCloud, runner: InProcess, *others: object) -> Points:
        asked.append(len(others[0]))  # type: ignore[arg-type]
        return search(cloud, runner, *others)  # type: ignore[arg-type]

    monkeypatch.setattr(spacing, "_spacings_far", noted)

    def searched(name: str) -> int:
        asked.clear()
        cloud = cut_cloud(source_of(CLOUDS[name]), tmp_path, 1000)
        measure_spacing(cloud, InProcess(), lambda: None)
        return sum(asked)

    assert searched("layers") == 0
    assert 0 < searched("far outlier") <= 2002
    assert 0 < searched("rough sheet") < 1000
    assert searched("heap") == 3300
    assert searched("on an axis") == 900


def test_rows_of_ranks_among_marked_points(tmp_path: Path) -> None:
    marked = np.random.default_rng(3).random(1000) < 0.3
    marked[100:300] = False  # chunks without any
    column = Column.create(str(tmp_path / "marks"), np.bool_, 1000)
    column.write(0, marked)
    rows = np.flatnonzero(marked)
    for ranks in (np.arange(len(rows)), np.arange(3, len(rows), 17), np.empty(0, np.int64)):
        np.testing.assert_array_equal(marked_rows(column, ranks, 64), rows[ranks])
