from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from oracles import Array
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.neighbors.coincident import first_coincident, first_coincident_in, mark_distinct
from pcsmooth.neighbors.grid import build_grid
from pcsmooth.neighbors.marked import count_marked
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.tiling.cutting import cut_cloud
from pcsmooth.tiling.runner import InProcess
from pcsmooth.tiling.tiled_cloud import TiledCloud
from tiling.whole_and_tiled import source_of


def first_by_brute_force(points: Array) -> list[int]:
    return [int(np.flatnonzero((points == point).all(axis=1))[0]) for point in points]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("places", [1, 2, 30, 10_000])
def test_first_coincident_equals_brute_force(dimension: int, places: int) -> None:
    rng = np.random.default_rng(places)
    points = rng.normal(size=(places, dimension))[rng.integers(0, places, 300)]
    assert first_coincident(points).tolist() == first_by_brute_force(points)


def test_only_the_same_position_coincides() -> None:
    """Neighbours in floating point, swapped, mirrored and shared coordinates are apart."""
    a, b = 0.3, float(np.nextafter(0.3, 1))
    points = np.array([[a, b], [b, a], [a, a], [-a, b], [b, b], [a, b], [0, a], [a, 0]])
    assert first_coincident(points).tolist() == [0, 1, 2, 3, 4, 0, 6, 7]


def test_zeros_of_either_sign_coincide() -> None:
    points = np.array([[0.0, 1.0], [-0.0, 1.0], [1.0, -0.0], [1.0, 0.0], [-0.0, -0.0], [0.0, 0.0]])
    assert first_coincident(points).tolist() == [0, 0, 2, 2, 4, 4]


def test_equal_hashes_do_not_make_equal_points() -> None:
    """Second coordinates chosen so that the hashes of different points agree."""

    def mixed(column: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
        product = column * np.uint64(0x9E3779B97F4A7C15)
        return product ^ (product >> np.uint64(29))

    x = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    target = np.full(5, 0x123456789ABCDEF0, np.uint64)
    y = (mixed(x.view(np.uint64)) ^ target).view(np.float64)
    assert np.isfinite(y).all()
    points = np.c_[x, y][[0, 1, 2, 1, 3, 4, 0]]
    assert first_coincident(points).tolist() == [0, 1, 2, 1, 4, 5, 0]


def test_first_coincident_leaves_the_points_alone() -> None:
    points = np.array([[-0.0, 1.0], [0.0, 1.0]])
    first_coincident(points)
    assert np.signbit(points[0, 0])


def first_by_unique(points: Array) -> Array:
    """First numbers by numpy's sort of rows; + 0.0 makes zeros of either sign one."""
    _, first, place = np.unique(points + 0.0, axis=0, return_index=True, return_inverse=True)
    return np.asarray(first[place.ravel()])


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("size", [0.1, 1.0, 100.0])  # lonely points, small cells, one crowd
@pytest.mark.parametrize("places", [1, 3, 500, 20_000])
def test_points_that_coincide_in_a_grid(
    dimension: int, threads: int, size: float, places: int
) -> None:
    rng = np.random.default_rng(places)
    points = rng.normal(size=(places, dimension))[rng.integers(0, places, 3000)]
    points[rng.random(points.shape) < 0.3] = 0.0
    points[rng.random(points.shape) < 0.3] *= -1.0
    expected = first_by_unique(points)
    with thread_limit(threads):
        np.testing.assert_array_equal(first_coincident_in(build_grid(points, size)), expected)
    np.testing.assert_array_equal(first_coincident(points), expected)


@pytest.mark.parametrize("dimension", [2, 3])
def test_far_points_that_coincide_in_a_grid(dimension: int) -> None:
    """Beyond the range of cells, distinct points share the outermost ones."""
    near = np.random.default_rng(0).random((300, dimension))
    far = np.concatenate([scale * near[:40] for scale in (1e12, -1e12, 1e150)])
    points = np.r_[near, far, far[::-1], near[::3]]
    first = first_coincident_in(build_grid(points, 0.1))
    assert first.tolist() == first_by_brute_force(points)


def test_one_point_is_the_first_at_its_place() -> None:
    assert first_coincident_in(build_grid(np.array([[2.0, -0.0]]), 1.0)).tolist() == [0]


def test_a_crowded_cell_is_not_searched_pair_by_pair() -> None:
    """Pairs of this cell would take minutes."""
    points = np.random.default_rng(0).random((1_000_000, 2))
    points[-1] = points[17]
    first = first_coincident_in(build_grid(points, 10.0))
    assert np.flatnonzero(first != np.arange(len(points))).tolist() == [999_999]
    assert first[-1] == 17


@pytest.mark.parametrize("dimension", [2, 3])
def test_distinct_points_are_the_first_at_their_places_however_the_cloud_is_cut(
    dimension: int, tmp_path: Path
) -> None:
    rng = np.random.default_rng(11)
    points = rng.random((400, dimension))[rng.integers(0, 400, 2000)]
    points[:300, 0] = 0.0
    points[:100, 0] = -0.0
    tiles = TiledCloud(cut_cloud(source_of(points), tmp_path, 150), InProcess())
    assert tiles.n_parts > 8
    for cloud in (WholeCloud.of(points), tiles):
        places = cloud.start.read(0, cloud.count)
        found = mark_distinct(cloud)
        expected = first_by_unique(places) == np.arange(len(places))
        np.testing.assert_array_equal(found.marks.read(0, cloud.count), expected)
        assert found.count == count_marked(found.marks) == np.count_nonzero(expected)
