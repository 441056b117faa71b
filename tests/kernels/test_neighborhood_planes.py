from __future__ import annotations

import numpy as np
import pytest

from oracles import Array, random_sphere
from pcsmooth.kernels.surface.neighborhood_planes import fit_planes
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.neighbors.grid import Grid, build_grid

#: Share of the squared reach to which the squared radius is found.
RESOLUTION = 1 / 4096


def cloud(dimension: int) -> Array:
    rng = np.random.default_rng(7)
    points = random_sphere(300, seed=7, dimension=dimension)
    return points * (1 + 0.05 * rng.normal(size=(300, 1)))


def planes(
    grid: Grid,
    dimension: int,
    count: float,
    thickness: float,
    reach: float,
    least_radius: float = 0.0,
) -> tuple[Array, Array, Array, Array]:
    n = len(grid.order)
    thicknesses, least, most = (np.full(n, length) for length in (thickness, least_radius, reach))
    normals, squares, sizes, offsets = np.empty((3, n)), np.empty(n), np.empty(n), np.empty(n)
    fit_planes(
        grid.coordinates, grid.cells, dimension, count, thicknesses, least, most, 0, normals,
        squares, sizes, offsets, np.empty(n, np.int64),
    )  # fmt: skip
    return normals, squares, sizes, offsets


@pytest.mark.parametrize(("dimension", "reach"), [(2, 0.6), (3, 0.9)])
def test_no_radius_is_less_than_the_least(dimension: int, reach: float) -> None:
    grid = build_grid(cloud(dimension), reach)
    _, squares, *_ = planes(grid, dimension, 9.0, 0.0, reach)
    least = float(np.sqrt(np.median(squares)))
    _, bounded, sizes, _ = planes(grid, dimension, 9.0, 0.0, reach, least)
    np.testing.assert_allclose(bounded, np.maximum(squares, least**2), atol=reach**2 / 2048)
    assert sizes.min() >= 9


@pytest.mark.parametrize(("dimension", "reach"), [(2, 0.6), (3, 0.9)])
@pytest.mark.parametrize("thickness", [0.0, 0.1, 0.3])
def test_the_radius_is_the_least_that_the_rule_allows(
    dimension: int, reach: float, thickness: float
) -> None:
    count = 9.0
    grid = build_grid(cloud(dimension), reach)
    _, squares, sizes, _ = planes(grid, dimension, count, thickness, reach)
    apart = grid.coordinates[:, :, np.newaxis] - grid.coordinates[:, np.newaxis]
    square_distances = np.einsum("kij,kij->ij", apart, apart)

    def covered(radii_squared: Array) -> Array:
        within = (square_distances < radii_squared[:, np.newaxis]).sum(axis=1)
        share = (thickness**2 / radii_squared) ** ((dimension - 1) / 2)
        return np.asarray(within * (1 - share))

    np.testing.assert_array_equal(sizes, (square_distances < squares[:, np.newaxis]).sum(axis=1))
    limited = squares == reach**2
    assert np.all(covered(squares)[~limited] >= count)
    smaller = squares - RESOLUTION * reach**2
    inside = smaller > thickness**2
    assert np.all(covered(smaller)[inside] < count)
    assert limited.mean() < 0.5


@pytest.mark.parametrize(("dimension", "reach"), [(2, 0.5), (3, 0.8)])
def test_normals_and_offsets_are_those_of_principal_components(
    dimension: int, reach: float
) -> None:
    grid = build_grid(cloud(dimension), reach)
    normals, squares, _, offsets = planes(grid, dimension, 12.0, 0.1, reach)
    points = grid.coordinates[:dimension].T
    for i, point in enumerate(points):
        near = points[((points - point) ** 2).sum(axis=1) < squares[i]]
        centroid = near.mean(axis=0)
        least = np.linalg.svd(near - centroid)[2][-1]
        assert abs(normals[:dimension, i] @ least) == pytest.approx(1, abs=1e-9)
        expected = np.linalg.norm(centroid - point) / np.sqrt(squares[i])
        assert offsets[i] == pytest.approx(expected, abs=1e-12)
    if dimension == 2:
        assert not normals[2].any()


def test_a_point_without_neighbors_has_no_normal() -> None:
    grid = build_grid(np.array([[0.0, 0, 0], [5, 0, 0]]), 1.0)
    normals, squares, sizes, offsets = planes(grid, 3, 12.0, 0.1, 1.0)
    assert not normals.any()
    np.testing.assert_array_equal(squares, 1)
    np.testing.assert_array_equal(sizes, 1)
    np.testing.assert_array_equal(offsets, 0)


@pytest.mark.parametrize(("dimension", "reach"), [(2, 0.6), (3, 0.9)])
def test_who_is_in_them_is_listed_if_that_is_little(dimension: int, reach: float) -> None:
    grid = build_grid(cloud(dimension), reach)
    n = len(grid.order)
    expected = planes(grid, dimension, 9.0, 0.1, reach)
    _, squares, sizes, _ = expected
    apart = grid.coordinates[:, :, np.newaxis] - grid.coordinates[:, np.newaxis]
    near = np.einsum("kij,kij->ij", apart, apart) < squares[:, np.newaxis]
    np.fill_diagonal(near, False)
    for most in (1, 6, int(sizes.max()), 100):
        found = np.empty((3, n)), np.empty(n), np.empty(n), np.empty(n)
        ends = np.full(n, -1)
        radii = [np.full(n, length) for length in (0.1, 0.0, reach)]
        with thread_limit(1):
            blocks = fit_planes(
                grid.coordinates, grid.cells, dimension, 9.0, *radii, most, *found, ends
            )
        for actual, each in zip(found, expected, strict=True):
            np.testing.assert_array_equal(actual, each)
        assert [block[0] for block in blocks] == [0, *(block[1] for block in blocks[:-1])]
        assert blocks[-1][1] == n
        for first, stop, numbers, are_kept in blocks:
            assert are_kept == (sizes[first:stop].sum() - (stop - first) <= most * (stop - first))
            if are_kept:
                listed = np.split(numbers[: ends[stop - 1]], ends[first : stop - 1])
                for i, each in zip(range(first, stop), listed, strict=True):
                    np.testing.assert_array_equal(np.sort(each), np.flatnonzero(near[i]))
        assert all(kept for *_, kept in blocks) == (most >= sizes.max())
