from __future__ import annotations

import math

import numpy as np
import pytest

import oracles
from oracles import Array
from pcsmooth.neighbors.k_nearest import build_tree, in_order_of_distance, k_nearest


def distances_between(points: Array, queries: Array) -> Array:
    return np.asarray(np.linalg.norm(points - queries[:, np.newaxis], axis=2))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("farthest", [math.inf, 0.3])
def test_k_nearest_points_equal_brute_force(dimension: int, farthest: float) -> None:
    rng = np.random.default_rng(0)
    points, queries = rng.random((300, dimension)), rng.random((40, dimension))
    apart = distances_between(points, queries)
    expected = np.argsort(apart, axis=1, kind="stable")[:, :12]
    sizes = np.take_along_axis(apart, expected, axis=1)
    distances, numbers = k_nearest(points, queries, 12, farthest)
    np.testing.assert_array_equal(numbers, np.where(sizes < farthest, expected, len(points)))
    np.testing.assert_allclose(
        distances, np.where(sizes < farthest, sizes, np.inf), rtol=1e-14, atol=0.0
    )


def test_points_at_equal_distances_are_in_the_order_of_their_numbers() -> None:
    points = oracles.lattice(7, 7)[np.random.default_rng(1).permutation(49)]
    centre = np.full((1, 2), 3.0)
    distances, numbers = k_nearest(points, centre, 9)
    np.testing.assert_array_equal(distances[0], [0.0, *[1.0] * 4, *[math.sqrt(2.0)] * 4])
    assert np.all(np.diff(numbers[0, 1:5]) > 0)
    assert np.all(np.diff(numbers[0, 5:9]) > 0)


def test_fewer_points_than_are_asked_for() -> None:
    points = np.array([[0.0, 0.0], [3.0, 4.0]])
    distances, numbers = k_nearest(points, points[:1], 4)
    assert distances.tolist() == [[0.0, 5.0, math.inf, math.inf]]
    assert numbers.tolist() == [[0, 1, 2, 2]]


def test_columns_are_sorted_along() -> None:
    distances = np.array([[2.0, 1.0, 2.0, 0.0]])
    numbers = np.array([[7, 5, 3, 9]])
    names = np.array([["a", "b", "c", "d"]])
    found = in_order_of_distance(distances, numbers, names)
    assert [column.tolist() for column in found] == [
        [[0.0, 1.0, 2.0, 2.0]], [[9, 5, 3, 7]], [["d", "b", "c", "a"]],
    ]  # fmt: skip


def test_rows_in_order_stay_and_others_are_sorted() -> None:
    distances = np.array([[0.0, 1.0, 2.0], [0.0, 1.0, 1.0], [2.0, 1.0, math.inf]])
    numbers = np.array([[9, 5, 3], [4, 8, 6], [1, 2, 7]])
    found = in_order_of_distance(distances, numbers)
    assert found[0].tolist() == [[0.0, 1.0, 2.0], [0.0, 1.0, 1.0], [1.0, 2.0, math.inf]]
    assert found[1].tolist() == [[9, 5, 3], [4, 6, 8], [2, 1, 7]]
    assert numbers.tolist() == [[9, 5, 3], [4, 8, 6], [1, 2, 7]]


def test_trees_find_coincident_points() -> None:
    points = np.repeat(np.random.default_rng(2).random((5, 3)), 40, axis=0)
    distances, _ = build_tree(points).query(points, 41)
    assert np.all(distances[:, :40] == 0.0)
    assert np.all(distances[:, 40] > 0.0)
