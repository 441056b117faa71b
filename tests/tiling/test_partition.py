from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pcsmooth.errors import InvalidInputError
from pcsmooth.tiling.cubes import CELLS_PER_AXIS, cube_cells, cube_codes
from pcsmooth.tiling.partition import Partition, partition_of


def partition_points(
    points: npt.NDArray[np.float64], corner: npt.NDArray[np.float64], width: float, most: int
) -> tuple[Partition, npt.NDArray[np.float64]]:
    """A partition, and the points in its order."""
    codes = cube_codes(points, corner, width)
    order = np.argsort(codes, kind="stable")
    distinct, counts = np.unique(codes, return_counts=True)
    return partition_of(distinct, counts, corner, width, most), points[order]


def listed(runs: npt.NDArray[np.int64]) -> list[int]:
    return [row for start, stop in runs.tolist() for row in range(start, stop)]


@given(st.lists(st.integers(0, 9), max_size=30), st.integers(1, 20))
def test_tiles_are_as_large_as_may_be(counts: list[int], most: int) -> None:
    codes = np.arange(len(counts)) * 3
    partition = partition_of(codes, np.array(counts, np.int64), np.zeros(2), 1.0, most)
    occupied = [count for count in counts if count]
    assert np.diff(partition.starts).tolist() == occupied
    np.testing.assert_array_equal(partition.codes, codes[np.array(counts, np.int64) > 0])
    ends = [partition.rows(tile) for tile in range(partition.n_tiles)]
    assert [start for start, _ in ends] + [sum(counts)] == [0] + [stop for _, stop in ends]
    for tile, (start, stop) in enumerate(ends):
        first, after = partition.tile_starts[tile : tile + 2]
        assert stop > start
        assert stop - start <= most or after - first == 1
        if after < len(occupied):
            assert stop - start + occupied[after] > most


@given(st.data(), st.sampled_from([2, 3]))
@settings(deadline=None)
def test_halo_is_that_of_brute_force(data: st.DataObject, dimension: int) -> None:
    seed = data.draw(st.integers(0, 2**32 - 1))
    size = data.draw(st.sampled_from([3, 8, 30]))
    distance = data.draw(st.sampled_from([0.0, 0.5, 1.0, 1.5, 2.0, 40.0, np.inf]))
    rng = np.random.default_rng(seed)
    corner, width = rng.normal(size=dimension), 0.5
    points = corner + width * rng.random((60, dimension)) * size
    partition, ordered = partition_points(points, corner, width, data.draw(st.integers(1, 30)))
    cells = cube_cells(partition.codes, dimension)
    for tile in range(partition.n_tiles):
        first, stop = partition.tile_starts[tile : tile + 2]
        gaps = np.maximum(np.abs(cells[:, None] - cells[first:stop]) - 1, 0).max(axis=2) * width
        near = (gaps <= distance).any(axis=1)
        near[first:stop] = False
        runs = partition.halo(tile, distance)
        expected = [
            row
            for cube in np.flatnonzero(near)
            for row in range(partition.starts[cube], partition.starts[cube + 1])
        ]
        assert listed(runs) == expected
        assert np.all(runs[1:, 0] > runs[:-1, 1])
        _assert_nothing_lost(partition, ordered, tile, distance)


def _assert_nothing_lost(
    partition: Partition, ordered: npt.NDArray[np.float64], tile: int, distance: float
) -> None:
    """All rows near a point of the tile are in the tile or in its halo."""
    start, stop = partition.rows(tile)
    apart = np.abs(ordered[:, None] - ordered[start:stop]).max(axis=2).min(axis=1)
    there = np.zeros(len(ordered), np.bool_)
    there[start:stop] = True
    there[listed(partition.halo(tile, distance))] = True
    assert np.all(there[apart <= distance])


@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]), st.sampled_from([0.0, 0.6, 1.0, 2.7]))
@settings(deadline=None)
def test_points_beyond_the_range_of_cubes_have_halos(
    seed: int, dimension: int, distance: float
) -> None:
    rng = np.random.default_rng(seed)
    ends = rng.choice([0.0, float(CELLS_PER_AXIS)], (40, dimension))
    points = ends + rng.uniform(-6.0, 6.0, (40, dimension))
    partition, ordered = partition_points(points, np.zeros(dimension), 1.0, 5)
    for tile in range(partition.n_tiles):
        _assert_nothing_lost(partition, ordered, tile, distance)


def test_rounding_at_the_faces_of_cubes_loses_no_point() -> None:
    rng = np.random.default_rng(0)
    width = 0.1
    steps = rng.integers(0, 200, 300) * width  # on faces, as far as rounding allows
    points = np.stack([steps, np.zeros(300)], axis=1)
    partition, ordered = partition_points(points, np.array([-0.3, 0.0]), width, 4)
    for tile in range(partition.n_tiles):
        for distance in (width, 3 * width, 0.3, np.nextafter(0.3, 0.0)):
            _assert_nothing_lost(partition, ordered, tile, distance)


def test_one_cube_and_one_point_and_none() -> None:
    for count in (1, 7):
        partition = partition_of(np.array([5]), np.array([count]), np.zeros(3), 1.0, 3)
        assert partition.n_tiles == 1
        assert partition.rows(0) == (0, count)
        assert partition.halo(0, 1.0).shape == (0, 2)
    none = np.zeros(0, np.int64)
    assert partition_of(none, none, np.zeros(3), 1.0, 3).n_tiles == 0


@pytest.mark.parametrize("tile", [-1, 2])
def test_tiles_that_are_not_there(tile: int) -> None:
    partition = partition_of(np.array([5, 6]), np.array([2, 2]), np.zeros(3), 1.0, 2)
    with pytest.raises(IndexError, match="among 2"):
        partition.rows(tile)
    with pytest.raises(IndexError, match="among 2"):
        partition.halo(tile, 1.0)


@pytest.mark.parametrize("distance", [-1.0, np.nan])
def test_halos_that_cannot_be(distance: float) -> None:
    partition = partition_of(np.array([5, 6]), np.array([2, 2]), np.zeros(3), 1.0, 2)
    with pytest.raises(InvalidInputError, match="not a length"):
        partition.halo(0, distance)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"codes": np.array([2, 2])}, "increasing codes"),
        ({"codes": np.array([2])}, "increasing codes"),
        ({"counts": np.array([3, -1])}, "increasing codes"),
        ({"width": 0.0}, "cubes of width 0"),
        ({"width": np.inf}, "cubes of width inf"),
        ({"width": np.nan}, "cubes of width nan"),
        ({"tile_points": 0}, "tiles of 0 points"),
    ],
)
def test_partitions_that_cannot_be(changed: dict[str, Any], message: str) -> None:
    right: dict[str, Any] = {
        "codes": np.array([1, 2]),
        "counts": np.array([3, 1]),
        "corner": np.zeros(2),
        "width": 1.0,
        "tile_points": 2,
    }
    with pytest.raises(InvalidInputError, match=message):
        partition_of(**(right | changed))
