from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.tiling.cutting import cut_cloud
from pcsmooth.tiling.tile_store import Tile, TileStore
from tiling.clouds import MAP_COORDINATES, Points, battered, curve, ribbon
from tiling.whole_and_tiled import source_of

CLOUDS = {
    "sheet": ribbon(600, width=6.0),
    "rough sheet on the map": battered(ribbon(600, width=6.0)) + MAP_COORDINATES,
    "rough curve": battered(curve(500)),
}


@pytest.fixture(params=CLOUDS)
def store(request: pytest.FixtureRequest, tmp_path: Path) -> TileStore:
    return cut_cloud(source_of(CLOUDS[request.param]), tmp_path, 100)


def starts(store: TileStore) -> Points:
    """Starts of all points, by row."""
    return np.asarray(store.start.read(0, store.count))


def apart(points: Points, own: Points) -> npt.NDArray[np.float64]:
    """Distance along the axis where it is largest from each point to the nearest own one."""
    return np.asarray(np.abs(points[:, np.newaxis] - own).max(axis=2).min(axis=1))


def check(store: TileStore, tile: Tile, number: int, points: Points, halo: float) -> None:
    """All points that are near are there, none that are far, and each is what it seems."""
    first, stop = store.partition.rows(number)
    assert tile.first == first
    assert np.all(np.diff(tile.rows) > 0)
    np.testing.assert_array_equal(tile.points, points[tile.rows])
    np.testing.assert_array_equal(tile.rows[tile.own], np.arange(first, stop))
    distances = apart(points, points[first:stop])
    assert np.isin(np.flatnonzero(distances <= halo), tile.rows).all()
    assert np.all(distances[tile.rows] <= 1.5 * (1.0 + 1e-5) * halo)


@pytest.mark.parametrize("halo", [0.3, 4.0, 60.0, 1e5])
def test_tile_holds_what_is_near_in_the_order_of_the_rows(store: TileStore, halo: float) -> None:
    assert store.partition.n_tiles >= 5
    points = starts(store)
    for number in range(store.partition.n_tiles):
        check(store, store.tile(number, store.start, halo, 0.0), number, points, halo)


@pytest.mark.parametrize("drift", [0.5, 20.0])
def test_tile_follows_points_that_drift(store: TileStore, drift: float) -> None:
    points = starts(store)
    moved = points + drift * np.random.default_rng(0).uniform(-1.0, 1.0, points.shape)
    column = store.create("moved", (np.float64, (store.dimension,)))
    column.write(0, moved)
    lost = 0
    for number in range(store.partition.n_tiles):
        check(store, store.tile(number, column, 3.0, drift), number, moved, 3.0)
        blind = store.tile(number, column, 3.0, 0.0)
        near = apart(moved, moved[slice(*store.partition.rows(number))]) <= 3.0
        lost += int(np.count_nonzero(~np.isin(np.flatnonzero(near), blind.rows)))
    assert lost > 0 or drift < 1.0


def test_tiles_write_their_own_rows_and_read_all(store: TileStore) -> None:
    points = starts(store)
    column = store.create("squares", (np.float64, (store.dimension, 2)))
    for number in range(store.partition.n_tiles):
        tile = store.tile(number, store.start, 5.0, 0.0)
        tile.write(column, np.stack([tile.points**2, tile.points - 1.0], axis=2))
    np.testing.assert_array_equal(
        column.read(0, store.count), np.stack([points**2, points - 1.0], axis=2)
    )
    tile = store.tile(1, store.start, 5.0, 0.0)
    np.testing.assert_array_equal(tile.read(column)[..., 0], tile.points**2)
    numbers = store.numbers.read(0, store.count)
    np.testing.assert_array_equal(tile.read(store.numbers), numbers[tile.rows])


def test_columns_are_created_empty_and_dropped(store: TileStore) -> None:
    column = store.create("marks", np.bool_)
    column.write(0, np.ones(store.count, np.bool_))
    assert store.column("marks", np.bool_) == column
    assert not store.create("marks", np.bool_).read(0, store.count).any()
    store.drop("marks", "never created")
    assert not Path(column.path).exists()
