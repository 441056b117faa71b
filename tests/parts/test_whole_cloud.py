"""A cloud in memory and one in tiles are the same to all who work on their parts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from parts.steps import Copy, LookAround, MeanAround, Remember
from pcsmooth.errors import InvalidInputError, NoFinitePointError
from pcsmooth.parts.column import ArrayColumn, Column
from pcsmooth.parts.part import Parts, PartStep
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.positions import usable_rows
from pcsmooth.progress import Callback, Progress, ignore
from pcsmooth.tiling.cutting import cut_cloud
from pcsmooth.tiling.runner import InProcess
from pcsmooth.tiling.tiled_cloud import TiledCloud
from tiling.clouds import MAP_COORDINATES, Points, battered, curve, layers, ribbon
from tiling.whole_and_tiled import source_of

CLOUDS: dict[str, Points] = {
    "sheet": ribbon(500, width=5.0),
    "rough sheet": battered(ribbon(500, width=5.0)),
    "rough sheet on the map": battered(ribbon(500, width=5.0)) + MAP_COORDINATES,
    "rough curve": battered(curve(500)),
    "layers": layers(3, 80),
    "small": ribbon(500, width=5.0) * 2.0**-60,
    "large": battered(ribbon(500, width=5.0)) * 2.0**80,
}


def length_of(points: Points) -> float:
    """Spacing of the clouds above, as a power of two."""
    return {"small": 2.0**-60, "large": 2.0**80}.get(
        next(name for name, cloud in CLOUDS.items() if cloud is points), 1.0
    )


@dataclass(frozen=True)
class Both:
    """A cloud as a whole and in tiles, and the points that they were made of."""

    points: Points
    fixed: npt.NDArray[np.bool_]
    given: Points
    whole: WholeCloud
    tiles: TiledCloud

    def unit(self, cloud: Parts) -> float:
        """How large lengths are there, if spacings are about 1 here."""
        return length_of(self.points) / cloud.unit


def both_of(points: Points, folder: Path, callback: Callback = ignore) -> Both:
    rng = np.random.default_rng(3)
    fixed, given = rng.random(len(points)) < 0.2, rng.normal(size=points.shape)
    whole = WholeCloud.of(points, usable_rows(points), fixed=fixed, given=given, callback=callback)
    source = source_of(points, fixed=fixed, normals=given)
    tiles = TiledCloud(cut_cloud(source, folder, 80), InProcess(), callback)
    assert (whole.n_parts, tiles.n_parts > 4) == (1, True)
    return Both(points, fixed, given, whole, tiles)


@pytest.fixture(params=CLOUDS)
def both(request: pytest.FixtureRequest, tmp_path: Path) -> Both:
    return both_of(CLOUDS[request.param], tmp_path)


def all_of(column: Column) -> npt.NDArray[Any]:
    return column.read(0, column.rows)


def done(
    cloud: Parts, step: PartStep[Any], points: Column | None = None, drift: float = 0.0
) -> list[Any]:
    return list(cloud.map("some work", step, cloud.start if points is None else points, drift))


def test_both_have_the_same_rows_in_the_same_order(both: Both) -> None:
    whole, tiles = both.whole, both.tiles
    finite = np.flatnonzero(usable_rows(both.points))
    assert whole.count == tiles.count == len(finite)
    assert whole.dimension == tiles.dimension == both.points.shape[1]
    rows = finite[all_of(tiles.store.numbers)]
    np.testing.assert_array_equal(whole.input_rows, rows)
    np.testing.assert_array_equal(whole.origin, tiles.origin)
    for cloud in (whole, tiles):
        starts = all_of(cloud.start)
        np.testing.assert_array_equal(starts * cloud.unit, both.points[rows] - cloud.origin)
        np.testing.assert_array_equal(cloud.box, [starts.min(axis=0), starts.max(axis=0)])
        np.testing.assert_array_equal(all_of(cloud.fixed), both.fixed[rows])
        assert cloud.given is not None
        np.testing.assert_array_equal(all_of(cloud.given), both.given[rows])
        assert cloud.start.dtype == np.dtype((np.float64, (cloud.dimension,)))
        assert np.frexp(cloud.unit)[0] == 0.5


@pytest.mark.parametrize("reach", [0.0, 0.7, 6.0, 1e4])
def test_what_a_step_finds_is_the_same_to_the_last_bit(both: Both, reach: float) -> None:
    results = []
    for cloud in (both.whole, both.tiles):
        target = cloud.create("means", cloud.start.dtype)
        pairs = sum(done(cloud, MeanAround(reach * both.unit(cloud), target)))
        results.append((pairs, all_of(target) * cloud.unit))
    assert results[0][0] == results[1][0]
    np.testing.assert_array_equal(results[0][1], results[1][1])


@pytest.mark.parametrize("reach", [0.0, 5.0])
def test_steps_follow_points_that_move(both: Both, reach: float) -> None:
    """As far as they may have come, wherever they were cut."""
    results = []
    for cloud in (both.whole, both.tiles):
        unit = both.unit(cloud)
        start = all_of(cloud.start)
        moved = cloud.create("moved", cloud.start.dtype)
        moves = 20.0 * np.random.default_rng(6).uniform(-1.0, 1.0, start.shape)
        moved.write(0, start + unit * moves)
        target = cloud.create("means", cloud.start.dtype)
        done(cloud, MeanAround(reach * unit, target), moved, 20.0 * unit)
        results.append(all_of(target) / unit)
    np.testing.assert_array_equal(results[0], results[1])


def test_own_rows_are_all_rows_and_the_others_are_near(both: Both) -> None:
    for cloud in (both.whole, both.tiles):
        starts = all_of(cloud.start)
        reach = 4.0 * both.unit(cloud)
        begin = 0
        for first, stop, rows, own, points in done(cloud, LookAround(reach)):
            assert first == begin
            np.testing.assert_array_equal(own, np.arange(first, stop))
            assert np.all(np.diff(rows) > 0)
            np.testing.assert_array_equal(points, starts[rows])
            begin = stop
        assert begin == cloud.count
        assert len(done(cloud, LookAround(reach))) == cloud.n_parts


@pytest.mark.parametrize("reach", [0.0, 4.0])
def test_columns_are_read_around_and_written_within(both: Both, reach: float) -> None:
    for cloud in (both.whole, both.tiles):
        for dtype in (np.bool_, np.int64, (np.float64, (2, 2))):
            source, target = cloud.create("source", dtype), cloud.create("target", dtype)
            values = np.zeros(cloud.count, dtype)
            values[...] = np.random.default_rng(7).integers(0, 2, values.shape)
            source.write(0, values.copy())
            done(cloud, Copy(source, target, reach * both.unit(cloud)))
            np.testing.assert_array_equal(all_of(target), values)
            np.testing.assert_array_equal(all_of(source), values)


def test_columns_are_created_empty_and_dropped(both: Both) -> None:
    for cloud in (both.whole, both.tiles):
        marks = cloud.create("marks", np.bool_)
        marks.write(0, np.ones(cloud.count, np.bool_))
        assert all_of(marks).all()
        again = cloud.create("marks", np.bool_)
        assert again.rows == cloud.count
        assert not all_of(again).any()
        cloud.drop("marks", "never created")


def test_a_step_is_done_when_its_result_is_asked_for(both: Both) -> None:
    for cloud in (both.whole, both.tiles):
        values = cloud.create("values", np.float64)
        values.write(0, np.ones(cloud.count))
        target = cloud.create("target", np.float64)
        results = cloud.map("copies", Copy(values, target), cloud.start)
        assert not all_of(target).any()
        next(results)
        assert all_of(target).any()
        assert all_of(target).all() == (cloud.n_parts == 1)


def test_the_whole_remembers_until_it_is_to_forget() -> None:
    cloud = WholeCloud.of(ribbon(50))
    n = cloud.count
    assert done(cloud, Remember("a")) == [(f"a of {n}", 1)]
    assert done(cloud, Remember("a")) == [(f"a of {n}", 0)]
    assert done(cloud, Remember("b")) == [(f"b of {n}", 1)]
    cloud.forget("a", "never heard of")
    assert done(cloud, Remember("b")) == [(f"b of {n}", 0)]
    assert done(cloud, Remember("a")) == [(f"a of {n}", 1)]
    box = cloud.box
    cloud.forget()
    assert done(cloud, Remember("a")) == [(f"a of {n}", 1)]
    np.testing.assert_array_equal(cloud.box, box)


def test_tiles_remember_nothing(tmp_path: Path) -> None:
    tiles = both_of(CLOUDS["sheet"], tmp_path).tiles
    for _ in range(2):
        assert [made for _, made in done(tiles, Remember("a"))] == [2] * tiles.n_parts
        tiles.forget("a")
        tiles.forget()


def test_progress_is_told(tmp_path: Path) -> None:
    told: list[Progress] = []
    both = both_of(CLOUDS["sheet"], tmp_path, told.append)
    for cloud in (both.whole, both.tiles):
        told.clear()
        done(cloud, LookAround(0.0))
        total = cloud.n_parts
        assert told == [Progress("some work", number, total) for number in range(total + 1)]


def test_only_tiles_can_be_too_narrow_for_a_cloud(tmp_path: Path) -> None:
    both = both_of(CLOUDS["sheet"], tmp_path)
    both.whole.check_width(both.whole.box, 1e-9, "x")
    both.tiles.check_width(both.tiles.box, 1.0, "x")
    with pytest.raises(
        InvalidInputError, match=r"wide, more than .* times hairs \(1e-09\), .* pass tile off"
    ):
        both.tiles.check_width(both.tiles.box, 1e-9, "hairs")


def test_points_as_they_are() -> None:
    points = ribbon(40) + MAP_COORDINATES
    marks = np.arange(40) % 3 == 0
    cloud = WholeCloud.as_it_is(points, marks)
    assert (cloud.unit, cloud.origin.tolist(), cloud.given) == (1.0, [0.0] * 3, None)
    np.testing.assert_array_equal(all_of(cloud.start), points)
    np.testing.assert_array_equal(all_of(cloud.fixed), marks)
    np.testing.assert_array_equal(cloud.input_rows, np.arange(40))
    assert not all_of(WholeCloud.as_it_is(points).fixed).any()


def test_the_input_is_left_alone() -> None:
    points = battered(ribbon(300))
    before = points.copy()
    cloud = WholeCloud.of(points, usable_rows(points))
    target = cloud.create("target", cloud.start.dtype)
    done(cloud, MeanAround(2.0, target))
    np.testing.assert_array_equal(points, before)
    assert isinstance(cloud.start, ArrayColumn)
    assert not np.shares_memory(cloud.start.values, points)


def test_without_finite_points_there_is_no_cloud() -> None:
    with pytest.raises(NoFinitePointError):
        WholeCloud.of(np.full((3, 2), np.nan), np.zeros(3, np.bool_))


@pytest.mark.parametrize("scale", [1e-130, 1e130])
def test_clouds_that_cannot_be_measured_are_refused(scale: float) -> None:
    with pytest.raises(InvalidInputError, match="give the cloud in another unit"):
        WholeCloud.of(ribbon(100) * scale)
