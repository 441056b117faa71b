from __future__ import annotations

import numpy as np
import pytest

import oracles
from pcsmooth.filters.neighbor_lists import MOST_KEPT
from pcsmooth.filters.neighborhoods import Width, find_neighborhoods


def test_twicing_is_two_averages_and_one_of_the_average() -> None:
    """z - mean of z, written with the matrix W of averages over the aligned normals."""
    points = oracles.sphere_surface(400).noisy(0.3)
    neighborhoods = find_neighborhoods(
        points, Width(12.0, 1.0, 0.05, 0.8, 1.4, 0.8)
    ).with_averaged_normals(4)
    in_order = points[neighborhoods.grid.order]
    cosines = neighborhoods.normals.T @ neighborhoods.normals
    ways = in_order[np.newaxis] - in_order[:, np.newaxis]
    near = (ways**2).sum(axis=2) < neighborhoods.squares[:, np.newaxis]
    weights = np.where(near, cosines**2, 0.0)
    weights /= weights.sum(axis=1, keepdims=True)

    heights = np.einsum("ij,ijk,ki->i", weights, ways, neighborhoods.normals)
    actual = neighborhoods.heights(2).means
    np.testing.assert_allclose(actual, heights, atol=1e-14)
    means = (weights * np.sign(cosines)) @ heights
    np.testing.assert_allclose(neighborhoods.means_along_normals(actual, 2), means, atol=1e-14)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("exponent", [2, 4])
def test_normals_are_averaged_without_regard_to_their_signs(dimension: int, exponent: int) -> None:
    rng = np.random.default_rng(dimension + exponent)
    points = rng.random((200, dimension))
    neighborhoods = find_neighborhoods(points, Width(12.0, 1.0, 0.0, 0.4, 1.4, 0.4))
    ways = (
        neighborhoods.grid.coordinates[:, np.newaxis]
        - neighborhoods.grid.coordinates[:, :, np.newaxis]
    )
    near = (ways**2).sum(axis=0) < neighborhoods.squares[:, np.newaxis]
    cosines = neighborhoods.normals.T @ neighborhoods.normals
    weights = np.where(near, np.abs(cosines) ** exponent * np.sign(cosines), 0.0)
    expected = neighborhoods.normals @ weights.T
    expected /= np.linalg.norm(expected, axis=0)
    averages = neighborhoods.with_averaged_normals(exponent).normals
    np.testing.assert_allclose(averages, expected, atol=1e-13)


def test_means_over_a_share_of_the_area() -> None:
    points = oracles.random_sphere(400)
    neighborhoods = find_neighborhoods(points, Width(30.0, 1.0, 0.0, 0.9, 1.4, 0.9))
    ones = neighborhoods.means(np.ones(400), 2, 0.5)
    np.testing.assert_allclose(ones, 1, rtol=1e-14)
    values = points[neighborhoods.grid.order, 0]
    errors = [
        np.abs(neighborhoods.means(values, 2, share) - values).mean() for share in (1.0, 0.25)
    ]
    assert errors[1] < 0.75 * errors[0]


@pytest.mark.parametrize("dimension", [2, 3])
def test_spacings_are_those_of_lattices(dimension: int) -> None:
    counts = (401,) if dimension == 2 else (61, 61)
    flat = oracles.lattice(*counts)
    points = np.c_[flat, np.zeros(len(flat))]
    neighborhoods = find_neighborhoods(points, Width(100.0, 1.0, 0.0, 60.0, 1.4, 60.0))
    middle = len(flat) // 2
    assert neighborhoods.in_order(neighborhoods.spacings())[middle] == pytest.approx(1, rel=0.03)


def test_offsets_tell_borders() -> None:
    rng = np.random.default_rng(0)
    points = np.c_[rng.random((20_000, 2)), np.zeros(20_000)]
    neighborhoods = find_neighborhoods(points, Width(200.0, 1.0, 0.0, 0.3, 1.4, 0.3))
    offsets = neighborhoods.in_order(neighborhoods.offsets)
    from_border = np.minimum(points[:, :2], 1 - points[:, :2])
    edge = (from_border.min(axis=1) < 0.003) & (from_border.max(axis=1) > 0.2)
    inner = from_border.min(axis=1) > 0.15
    assert np.median(offsets[edge]) == pytest.approx(4 / (3 * np.pi), abs=0.03)  # a half disc's
    assert np.median(offsets[inner]) < 0.06


def test_values_return_to_the_order_of_the_points() -> None:
    points = oracles.random_sphere(100)
    neighborhoods = find_neighborhoods(points, Width(12.0, 1.0, 0.0, 1.0, 1.4, 1.0))
    np.testing.assert_array_equal(
        neighborhoods.in_order(neighborhoods.grid.coordinates[0]), points[:, 0]
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_lists_that_are_kept_change_no_bit(dimension: int) -> None:
    points = oracles.random_sphere(500, dimension=dimension)
    points *= 1.0 + 0.02 * np.random.default_rng(1).normal(size=(500, 1))
    width = Width(12.0, 1.0, 0.02, 0.9, 1.4, 0.9)
    kept = find_neighborhoods(points, width)
    looked_for = find_neighborhoods(points, width, listed=False)
    assert len(kept.lists.ends) == 500
    assert len(looked_for.lists.ends) == 0
    for exponent in (2, 4):
        first, second = (each.with_averaged_normals(exponent) for each in (kept, looked_for))
        np.testing.assert_array_equal(first.normals, second.normals)
        values = first.heights(exponent).means
        np.testing.assert_array_equal(second.heights(exponent).means, values)
        np.testing.assert_array_equal(
            first.heights(exponent).variances, second.heights(exponent).variances
        )
        np.testing.assert_array_equal(
            first.means_along_normals(values, exponent),
            second.means_along_normals(values, exponent),
        )
        np.testing.assert_array_equal(
            first.means(values, exponent, 0.3), second.means(values, exponent, 0.3)
        )


def test_long_lists_are_not_kept() -> None:
    points = oracles.random_sphere(500)
    neighborhoods = find_neighborhoods(points, Width(40.0, 1.0, 0.0, 0.9, 1.4, 0.9))
    assert neighborhoods.sizes.mean() > MOST_KEPT
    assert len(neighborhoods.lists.ends) == 0
