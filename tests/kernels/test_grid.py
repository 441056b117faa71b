from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

import oracles
from kernels.alone import alone
from oracles import Array
from pcsmooth.energies.balls import measure_balls
from pcsmooth.kernels.grid.grid import (
    CELL_OF_ZERO,
    CELLS_PER_AXIS,
    MOST_RANGES,
    Cells,
    adjacent_ranges,
    bounding_box,
    code_points,
)
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.neighbors.grid import Grid, build_grid, cells_of_one_size, levels_of, see_what_touches

adjacent_ranges = alone(adjacent_ranges)


LAST = CELLS_PER_AXIS - 1


def interleaved(*numbers: int) -> int:
    """Morton code of d cell numbers: bit d b + a is bit b of number a."""
    return sum(
        ((number >> bit) & 1) << (len(numbers) * bit + axis)
        for axis, number in enumerate(numbers)
        for bit in range(21)
    )


def points_around(cells: Cells, cell: int, dimension: int) -> list[int]:
    """Places in grid order of the points around a cell."""
    ranges = np.empty((2, MOST_RANGES), np.int64)
    count = adjacent_ranges(cells, cell, dimension, ranges)
    return [k for start, stop in ranges[:, :count].T for k in range(start, stop)]


def cells_near_each_point(grid: Grid, dimension: int) -> list[set[int]]:
    """Original numbers of the points in the cells around each point's cell."""
    near: list[set[int]] = [set() for _ in grid.order]
    members = [
        grid.order[start:stop]
        for start, stop in zip(grid.cells.starts[:-1], grid.cells.starts[1:], strict=True)
    ]
    for cell, own in enumerate(members):
        found = points_around(grid.cells, cell, dimension)
        assert len(set(found)) == len(found)
        around = {int(i) for i in grid.order[found]}
        for i in own:
            near[i] = around
    return near


def assert_no_pair_is_lost(points: Array, size: float) -> None:
    assert_pairs_are_found(points, size, build_grid(points, size))


def assert_pairs_are_found(points: Array, size: float, grid: Grid) -> None:
    assert sorted(grid.order) == list(range(len(points)))
    near = cells_near_each_point(grid, points.shape[1])
    bulk = np.flatnonzero(abs(points).max(axis=1) < 1e9)  # the tree overflows beyond 1e154
    pairs = [(bulk[i], bulk[j]) for i, j in cKDTree(points[bulk]).query_pairs(size)]
    assert pairs
    assert all(j in near[i] and i in near[j] for i, j in pairs)


def coded(points: Array, size: float, cell_of_zero: float) -> list[int]:
    """Codes of the points' cells, checking the rest of what the kernel tells."""
    pairs = np.empty((len(points), 2), np.int64)
    offsets = np.full(points.shape[1], cell_of_zero)
    ends = code_points(points, np.zeros(points.shape[1]), size, offsets, pairs)
    assert ends == (pairs[:, 0].min(), pairs[:, 0].max())
    np.testing.assert_array_equal(pairs[:, 1], np.arange(len(points)))
    return [int(code) for code in pairs[:, 0]]


@pytest.mark.parametrize("dimension", [2, 3])
def test_codes_interleave_the_bits_of_the_cell_numbers(dimension: int) -> None:
    numbers = np.random.default_rng(0).integers(0, CELLS_PER_AXIS, (200, dimension))
    numbers[0], numbers[1] = 0, LAST
    points = np.asarray(0.25 * (numbers + 0.5 - 28), float)
    codes = coded(points, 0.25, 28.0)
    assert codes == [interleaved(*map(int, row)) for row in numbers]


def test_cells_outside_the_range_are_clamped() -> None:
    points = np.array([[-1e300, 1e300], [-1.0, LAST + 2.0], [0.5, 0.5]])
    codes = coded(points, 1.0, 0.0)
    assert codes == [interleaved(0, LAST), interleaved(0, LAST), 0]


@pytest.mark.parametrize("dimension", [2, 3])
def test_adjacent_cells_are_those_whose_numbers_differ_by_one_at_most(dimension: int) -> None:
    rng = np.random.default_rng(1)
    numbers = np.unique(
        np.concatenate(
            [
                rng.integers(0, 6, (60, dimension)),
                LAST - rng.integers(0, 4, (30, dimension)),
                2**20 + rng.integers(-2, 2, (40, dimension)),  # all bits change in the middle
                [[LAST] * dimension],
            ]
        ),
        axis=0,
    )
    codes = [interleaved(*map(int, row)) for row in numbers]
    rank = np.argsort(codes)
    numbers, sorted_codes = numbers[rank], np.array(codes)[rank]
    cells = cells_of_one_size(sorted_codes, np.arange(len(numbers) + 1))
    for cell, number in enumerate(numbers):
        expected = np.flatnonzero(abs(numbers - number).max(axis=1) <= 1)
        assert sorted(points_around(cells, cell, dimension)) == expected.tolist()


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("size", [0.05, 0.3, 2.0])
def test_grid_loses_no_pair(dimension: int, size: float) -> None:
    assert_no_pair_is_lost(oracles.uniform_cloud(300, dimension) - 0.5, size)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("growth", [0.0, 0.03, 0.1])
@pytest.mark.parametrize("far", [0, 3])
def test_points_that_look_farther_lose_no_pair(dimension: int, growth: float, far: int) -> None:
    """Reaches grow from the middle to the borders, at random by as much again; some look far."""
    n, size = 1200, 0.01
    points = oracles.uniform_cloud(n, dimension) - 0.5
    shares = np.random.default_rng(3).uniform(0.5, 1.0, n)
    reaches = 0.8 * size + growth * shares * np.sum(points**2, axis=1)
    reaches[:far] = 0.05
    levels = levels_of(reaches, size)
    grid = build_grid(points, size, None, levels)
    assert (grid.cells.levels.max() > grid.cells.levels.min()) == (growth > 0.0 or far > 0)
    near = cells_near_each_point(grid, dimension)
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    looks = size * 2.0**levels
    for i, j in np.argwhere(distances < looks[:, None]):
        assert j in near[i]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("growth", [0.0, 0.03, 0.1])
@pytest.mark.parametrize("far", [0, 3])
def test_balls_that_touch_see_each_other(dimension: int, growth: float, far: int) -> None:
    n, size = 1200, 0.01
    points = oracles.uniform_cloud(n, dimension) - 0.5
    shares = np.random.default_rng(3).uniform(0.5, 1.0, n)
    radii = 0.4 * size + 0.5 * growth * shares * np.sum(points**2, axis=1)
    radii[:far] = 0.05
    plain = build_grid(points, size, None, levels_of(2 * radii, size))
    grid = see_what_touches(plain, radii[plain.order], size, dimension)
    near = cells_near_each_point(grid, dimension)
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    for i, j in np.argwhere(distances < radii[:, None] + radii[None]):
        assert i in near[j]
    # Few look farther than to what touches: not all that are near a large ball.
    looks = np.empty(n)
    looks[grid.order] = np.repeat(size * 2.0**grid.cells.levels, np.diff(grid.cells.starts))
    largest = np.where(distances < radii[:, None] + radii[None], radii[None], 0.0).max(axis=1)
    assert np.mean(looks > 2 * np.maximum(radii + largest, size)) < 0.1


@pytest.mark.parametrize("dimension", [2, 3])
def test_cells_of_several_sizes_have_the_points_of_their_cubes(dimension: int) -> None:
    points = oracles.uniform_cloud(500, dimension)
    size = 0.02
    levels = levels_of(np.where(points[:, 0] > 0.5, 0.15, 0.01), size)
    grid = build_grid(points, size, None, levels)
    codes, starts, sizes, *_ = grid.cells
    assert sorted(grid.order) == list(range(500))
    assert (starts[0], starts[-1]) == (0, 500)
    assert (np.diff(starts) > 0).all()
    assert set(sizes) == {0, 3}
    numbers = np.floor(points / (size * (1 + 1e-6))).astype(int) + CELL_OF_ZERO
    for code, level, start, stop in zip(codes, sizes, starts[:-1], starts[1:], strict=True):
        members = grid.order[start:stop]
        assert (levels[members] == level).all()
        assert code % (1 << dimension * int(level)) == 0
        for i in members:
            own = interleaved(*map(int, numbers[i]))
            assert own >> dimension * int(level) == int(code) >> dimension * int(level)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_point_that_looks_far_costs_the_others_nothing(dimension: int) -> None:
    points = oracles.uniform_cloud(500, dimension)
    levels = np.zeros(500, np.int8)
    levels[7] = 6
    grid, alone = build_grid(points, 0.02, None, levels), build_grid(points, 0.02)
    near, expected = (cells_near_each_point(each, dimension) for each in (grid, alone))
    assert near[7] == set(range(500))
    assert near[:7] + near[8:] == expected[:7] + expected[8:]


def test_levels_of_reaches_cover_them() -> None:
    reaches = np.array([0.0, 0.5, 1.0, 1.01, 2.0, 2.1, 4.0, 1e30])
    np.testing.assert_array_equal(levels_of(reaches, 1.0), [0, 0, 0, 1, 1, 2, 2, 20])


@pytest.mark.parametrize("dimension", [2, 3])
def test_points_a_cell_apart_on_the_borders_of_cells_are_neighbors(dimension: int) -> None:
    """Tenths are rounded, so that borders of cells fall on either side of the points."""
    assert_no_pair_is_lost(0.1 * oracles.lattice(*[6] * dimension) + 0.7, 0.1 * (1 + 1e-12))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("distance", [1e12, 1e300])
def test_far_points_cost_no_pair(dimension: int, distance: float) -> None:
    near = oracles.uniform_cloud(200, dimension)
    far = near[:50].copy()
    far[:, 0] += 1e6  # a second crowd, beyond the range of cells
    outliers = distance * np.r_[np.eye(dimension), -np.eye(dimension)]
    assert_no_pair_is_lost(np.r_[near, far, outliers], 0.15)


@pytest.mark.parametrize("dimension", [2, 3])
def test_crowds_on_both_sides_of_the_range_are_measured_alike(dimension: int) -> None:
    part = np.round(oracles.uniform_cloud(100, dimension) * 2**20) / 2**20
    offset = np.zeros(dimension)
    offset[1] = 2.0**24
    union = measure_balls(np.r_[part - offset, part, part + offset], 0.15)
    assert union.cell_volumes[:100].sum() > 0.5 * oracles.ball_volume(0.15, dimension)
    for copy in (union.measures[:100], union.measures[200:]):
        np.testing.assert_allclose(copy, union.measures[100:200], rtol=0, atol=1e-13)


# --- layout


def clouds(dimension: int) -> dict[str, Array]:
    rng = np.random.default_rng(5)
    spread = rng.normal(size=(40_000, dimension))
    outliers = rng.permutation(np.r_[spread[:500], 1e12 * spread[:7], [[-1e150] * dimension]])
    return {
        "one point": spread[:1],
        "one cell": 1e-4 * rng.random((3000, dimension)),
        "one place": np.full((3000, dimension), 0.7),
        "few places": rng.integers(-1, 2, (5000, dimension)) * -0.5,
        "large": 1e9 + spread[:3000],
        "far outliers": outliers,
        "several blocks": spread,
        "columns": np.asfortranarray(spread[:1001]),
        "rows apart": spread[:2001:2],
    }


CLOUDS = list(clouds(2))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("cloud", CLOUDS)
@pytest.mark.parametrize("threads", [1, 2])
def test_grid_lays_out_the_points_by_cell_and_number(
    dimension: int, cloud: str, threads: int
) -> None:
    points = clouds(dimension)[cloud]
    n, size = len(points), 0.05
    with thread_limit(threads):
        grid = build_grid(points, size)

    side = size * (1 + 1e-6)
    numbers = np.floor(points / side)
    for column in numbers.T:
        if column.min() < -CELL_OF_ZERO or column.max() > LAST - CELL_OF_ZERO:
            is_wide = np.ptp(column) > LAST - CELL_OF_ZERO
            column -= np.floor(np.median(column)) if is_wide else column.min()
    numbers = np.clip(numbers + CELL_OF_ZERO, 0, LAST).astype(int)
    codes = np.array([interleaved(*map(int, row)) for row in numbers])
    order = np.lexsort((np.arange(n), codes))
    cell_codes, counts = np.unique(codes, return_counts=True)

    np.testing.assert_array_equal(grid.order, order)
    np.testing.assert_array_equal(grid.cells.codes, cell_codes)
    np.testing.assert_array_equal(grid.cells.starts, np.r_[0, np.cumsum(counts)])
    np.testing.assert_array_equal(grid.coordinates[:dimension], points[order].T)
    np.testing.assert_array_equal(grid.coordinates[dimension:], np.zeros((3 - dimension, n)))
    assert all(row.flags.c_contiguous for row in grid.coordinates)


@pytest.mark.parametrize("dimension", [2, 3])
def test_bounding_box_is_that_of_the_columns(dimension: int) -> None:
    points = np.random.default_rng(0).normal(size=(999, dimension)) - 5.0
    axes = [0, 1, dimension - 1]
    low, high = bounding_box(points)
    np.testing.assert_array_equal(low, points.min(axis=0)[axes])
    np.testing.assert_array_equal(high, points.max(axis=0)[axes])
