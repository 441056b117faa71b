from __future__ import annotations

import numpy as np
import pytest

from kernels.alone import alone
from oracles import Array
from pcsmooth.kernels.arithmetic.simd import WIDTH
from pcsmooth.kernels.grid.within_reach import (
    N_ROWS,
    NUMBER,
    SQUARE,
    collect_points,
    count_points,
    pad_neighbors,
    select_within_reach,
    sort_by_distance,
)

collect_points = alone(collect_points)
count_points = alone(count_points)
pad_neighbors = alone(pad_neighbors)
select_within_reach = alone(select_within_reach)
sort_by_distance = alone(sort_by_distance)


#: A neighbour at infinity.
PADDING = [0.0, 0.0, 0.0, np.inf, -1.0]


@pytest.mark.parametrize(
    "found", [[], [(3, 11)], [(3, 3)], [(0, 3), (3, 11)], [(17, 30), (0, 3), (12, 17)], [(0, 30)]]
)
def test_points_of_ranges_are_collected_in_order_with_infinities_behind(
    found: list[tuple[int, int]],
) -> None:
    coordinates = np.random.default_rng(0).normal(size=(3, 30))
    numbers = [k for start, stop in found for k in range(start, stop)]
    count = len(numbers)
    ranges = np.array([*found, (3, 5), (3, 5)], np.int64).T.copy()  # more room than ranges
    candidates = np.full((4, count + WIDTH + 1), -9.0)

    assert count_points(ranges, len(found)) == count
    assert collect_points(coordinates, ranges, len(found), candidates) == count
    np.testing.assert_array_equal(candidates[:3, :count], coordinates[:, numbers])
    np.testing.assert_array_equal(candidates[3, :count], numbers)
    assert np.all(candidates[:3, count:-1] == np.inf)
    assert np.all(candidates[:, -1] == -9.0)


def select(points: Array, center: Array, reach: float) -> Array:
    """What is selected of points (n, 3): rows x, y, z, square, number."""
    n = len(points)
    candidates = np.full((4, n + WIDTH), np.inf)
    candidates[:3, :n] = points.T
    candidates[3] = np.nan
    candidates[3, :n] = 100 + np.arange(n)
    near = np.full((N_ROWS + 1, n + WIDTH), -9.0)
    x, y, z = center
    count = select_within_reach(candidates, n, x, y, z, reach, near[:N_ROWS])
    assert np.all(near[N_ROWS] == -9.0)  # nothing is written behind the array
    return near[:N_ROWS, :count]


@pytest.mark.parametrize("reach", [1.0, 5.0, 100.0])
@pytest.mark.parametrize("n", [1, 7, 8, 9, 64, 500])
def test_points_nearer_than_the_reach_are_selected_in_order(n: int, reach: float) -> None:
    # All squares are exact, and many are 1 or 25.
    grid = np.indices((9, 9, 9)).reshape(3, -1).T - 4.0
    points = np.random.default_rng(n).permutation(grid)[:n]
    for center in points[:20]:
        arms = points - center
        squares = (arms**2).sum(axis=1)
        kept = np.flatnonzero((squares < reach**2) & (squares > 0.0))
        expected = np.c_[arms, squares, 100 + np.arange(n)][kept].T
        np.testing.assert_array_equal(select(points, center, reach), expected)


def test_the_point_itself_and_points_exactly_at_reach_are_left_out() -> None:
    inside = np.nextafter(5.0, 0.0)
    points = np.array([[0, 0, 0], [3, 4, 0], [0, 0, -5], [0, inside, 0], [0, 5, 0], [1e-150, 0, 0]])
    assert select(points, np.zeros(3), 5.0)[NUMBER].tolist() == [103, 105]


def neighbors(count: int, room: int) -> Array:
    """Neighbours at few different distances, the room behind them filled with -9."""
    near = np.full((N_ROWS, room), -9.0)
    near[:, :count] = np.random.default_rng(count).normal(size=(N_ROWS, count))
    near[SQUARE, :count] = np.random.default_rng(count).integers(1, 3 + count // 3, count)
    near[NUMBER, :count] = np.arange(count)
    return near


@pytest.mark.parametrize("count", [0, 3, 8, 13])
def test_eight_neighbors_at_infinity_follow_the_last(count: int) -> None:
    near, before = neighbors(count, 30), neighbors(count, 30)
    pad_neighbors(near, count)
    padded = slice(count, count + WIDTH)
    np.testing.assert_array_equal(near[:, padded].T, [PADDING] * WIDTH)
    np.testing.assert_array_equal(
        np.delete(near, np.r_[padded], axis=1), np.delete(before, np.r_[padded], axis=1)
    )


@pytest.mark.parametrize("count", [0, 1, 2, 7, 8, 9, 16, 45, 64, 65, 128, 129, 200, 1000])
def test_neighbors_are_sorted_by_distance_and_ties_keep_their_order(count: int) -> None:
    source = neighbors(count, count + WIDTH)
    source[:, count:] = np.array(PADDING)[:, np.newaxis]
    target = np.full((N_ROWS, count + 2), -9.0)
    sort_by_distance(source.copy(), count, target)
    order = np.argsort(source[SQUARE, :count], kind="stable")
    np.testing.assert_array_equal(target[:, :count], source[:, order])
    assert np.all(target[:, count:] == -9.0)
