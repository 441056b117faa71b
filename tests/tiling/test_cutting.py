from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pcsmooth.errors import InvalidInputError
from pcsmooth.point_order import order_by_position
from pcsmooth.positions import local_origin, usable_rows
from pcsmooth.progress import Progress
from pcsmooth.tiling import cutting
from pcsmooth.tiling.cube_width import choose_width
from pcsmooth.tiling.cubes import cube_codes
from pcsmooth.tiling.cutting import Piece, Source, cut_cloud
from pcsmooth.tiling.tile_store import TileStore
from tiling.clouds import MAP_COORDINATES, Points, battered, curve, layers, ribbon
from tiling.whole_and_tiled import source_of

CLOUDS = {
    "sheet": ribbon(1500),
    "rough sheet": battered(ribbon(1500)),
    "rough sheet on the map": battered(ribbon(1500)) + MAP_COORDINATES,
    "rough curve": battered(curve(1500)),
    "layers": layers(4, 150),
    "on an axis": np.outer(np.linspace(-5.0, 900.0, 700), [0.0, 1.0, 0.0]),
    "one place": np.full((700, 3), 1e6),
    "one point": np.array([[3.0, -4.0]]),
}
every_cloud = pytest.mark.parametrize("points", CLOUDS.values(), ids=CLOUDS)


@every_cloud
def test_every_finite_point_is_in_one_cube_in_the_order_in_which_points_are_taken(
    points: Points, tmp_path: Path
) -> None:
    finite = points[usable_rows(points)]
    marks = np.random.default_rng(1).random(len(points)) < 0.3
    cloud = cut_cloud(source_of(points, fixed=marks, normals=2.0 * points), tmp_path, 150)
    assert (cloud.count, cloud.dimension) == finite.shape
    numbers = cloud.numbers.read(0, cloud.count)
    np.testing.assert_array_equal(np.sort(numbers), np.arange(len(finite)))
    starts = cloud.start.read(0, cloud.count)
    np.testing.assert_array_equal(starts, (finite - cloud.origin)[numbers])
    np.testing.assert_array_equal(
        cloud.fixed.read(0, cloud.count), marks[usable_rows(points)][numbers]
    )
    np.testing.assert_array_equal(cloud.given.read(0, cloud.count), 2.0 * finite[numbers])
    partition = cloud.partition
    cubes = np.repeat(np.arange(len(partition.codes)), np.diff(partition.starts))
    np.testing.assert_array_equal(
        cube_codes(starts, partition.corner, partition.width), partition.codes[cubes]
    )
    np.testing.assert_array_equal(numbers, order_by_position(finite - cloud.origin, 2.0 * finite))


@every_cloud
def test_box_and_origin_are_those_of_the_whole(points: Points, tmp_path: Path) -> None:
    finite = points[usable_rows(points)]
    cloud = cut_cloud(source_of(points), tmp_path, 150)
    origin = local_origin(finite)
    np.testing.assert_array_equal(cloud.origin, origin)
    box = [(finite - origin).min(axis=0), (finite - origin).max(axis=0)]
    np.testing.assert_array_equal(cloud.box, box)


@every_cloud
@pytest.mark.parametrize("most", [40, 200, 10_000])
def test_tiles_are_not_too_large_where_cubes_allow(
    points: Points, most: int, tmp_path: Path
) -> None:
    partition = cut_cloud(source_of(points), tmp_path, most).partition
    for tile in range(partition.n_tiles):
        first, stop = partition.rows(tile)
        first_cube, after = partition.tile_starts[tile : tile + 2]
        assert stop - first <= most or after - first_cube == 1


@pytest.mark.parametrize("most", [100, 400])
def test_tiles_of_a_sheet_are_never_too_large(most: int, tmp_path: Path) -> None:
    partition = cut_cloud(source_of(ribbon(3000)), tmp_path, most).partition
    sizes = [np.subtract(*partition.rows(tile)[::-1]) for tile in range(partition.n_tiles)]
    assert max(sizes) <= most
    assert len(sizes) <= 2 * 3000 / most


def files(cloud: TileStore) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(cloud.folder.iterdir())}


def test_how_the_cloud_is_read_does_not_matter(tmp_path: Path) -> None:
    points = battered(ribbon(300))
    marks = np.arange(len(points)) % 3 == 0
    clouds = []
    for rows in (len(points), 1, 7, 240):
        folder = tmp_path / str(rows)
        folder.mkdir()
        source = source_of(points, fixed=marks, normals=points, rows=rows)
        clouds.append(cut_cloud(source, folder, 60))
    assert files(clouds[0]).keys() == {"number.bin", "start.bin", "fixed.bin", "given.bin"}
    for cloud in clouds[1:]:
        assert files(cloud) == files(clouds[0])
        for name, values in vars(clouds[0].partition).items():
            np.testing.assert_array_equal(getattr(cloud.partition, name), values)


@pytest.mark.parametrize("rows", [1, 7, 240])
def test_the_sample_is_taken_evenly(
    rows: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = battered(ribbon(300))
    seen = []

    def noted(sample: Points, *others: float) -> float:
        seen.append(sample)
        return choose_width(sample, *others)  # type: ignore[arg-type]

    monkeypatch.setattr(cutting, "_SAMPLES", 60)
    monkeypatch.setattr(cutting, "choose_width", noted)
    cloud = cut_cloud(source_of(points, rows=rows), tmp_path, 150)
    chosen = points[:: -(-len(points) // 60)]
    np.testing.assert_array_equal(seen[0], chosen[usable_rows(chosen)] - cloud.origin)


def test_a_sample_without_finite_points(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    points = ribbon(1000)
    points[::20] = np.nan
    monkeypatch.setattr(cutting, "_SAMPLES", 50)
    assert cut_cloud(source_of(points), tmp_path, 150).count == 950


def test_without_marks_and_normals(tmp_path: Path) -> None:
    cloud = cut_cloud(source_of(ribbon(500)), tmp_path, 150)
    assert not cloud.fixed.read(0, 500).any()
    assert files(cloud).keys() == {"number.bin", "start.bin", "fixed.bin"}


def test_passes_are_told(tmp_path: Path) -> None:
    told: list[Progress] = []
    cut_cloud(source_of(ribbon(500)), tmp_path, 150, told.append)
    assert told == [Progress("cutting into tiles", done, 3) for done in range(4)]


@pytest.mark.parametrize("points", [np.full((9, 3), np.nan), np.empty((0, 2))], ids=["NaN", "none"])
def test_no_finite_point(points: Points, tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match="no point with finite coordinates"):
        cut_cloud(source_of(points), tmp_path, 150)


@pytest.mark.parametrize(("change", "message"), [(1, "more"), (-1, "fewer"), (500, "not counted")])
def test_a_cloud_that_changes_while_it_is_read(change: int, message: str, tmp_path: Path) -> None:
    before = np.zeros((10, 3))
    before[5:] = 1.0
    after = {1: np.r_[before, before[:1]], -1: before[1:], 500: before + np.arange(10)[:, None]}
    source = Source(10, 3, False, lambda: [before], lambda: [Piece(after[change])])
    with pytest.raises(InvalidInputError, match=message):
        cut_cloud(source, tmp_path, 3)
