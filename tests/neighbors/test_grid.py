from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from oracles import Array
from pcsmooth.kernels.grid.grid import CELL_OF_ZERO
from pcsmooth.neighbors.grid import (
    CUBE_LEVEL,
    FULL_CUBE,
    UNEQUAL_CUBE_LEVEL,
    build_grid,
    cube_starts,
    is_in_range,
    levels_of,
)


@pytest.mark.parametrize("dimension", [2, 3])
def test_parts_of_a_cloud_are_in_the_order_of_the_whole(dimension: int) -> None:
    points = np.random.default_rng(8).normal(size=(5000, dimension))
    whole = build_grid(points, 0.03)
    for part in (points[:, 0] > 0.4, points[:, -1] < -0.1, abs(points).max(axis=1) < 0.5):
        numbers = np.flatnonzero(part)
        grid = build_grid(points[part], 0.03)
        np.testing.assert_array_equal(numbers[grid.order], whole.order[part[whole.order]])


def occupied_cubes(points: Array, size: float) -> list[list[int]]:
    """Numbers of the points of each cube, found by halving full ones."""
    cells = np.floor(points / (size * (1 + 1e-6))).astype(int) + CELL_OF_ZERO

    def cut(members: list[int], level: int) -> list[list[int]]:
        cubes: dict[tuple[int, ...], list[int]] = {}
        for i in members:
            cubes.setdefault(tuple(cells[i] >> level), []).append(i)
        return [
            part
            for cube in cubes.values()
            for part in (cut(cube, level - 1) if level and len(cube) > FULL_CUBE else [cube])
        ]

    return cut(list(range(len(points))), CUBE_LEVEL[points.shape[1]])


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("size", [0.003, 0.05, 0.8])
def test_blocks_are_cubes_cut_up_where_they_are_full(dimension: int, size: float) -> None:
    rng = np.random.default_rng(9)
    points = np.concatenate([rng.random((9000, dimension)), 0.01 * rng.random((7000, dimension))])
    grid = build_grid(points, size)
    starts = cube_starts(grid, dimension)
    blocks = [grid.order[a:b].tolist() for a, b in pairwise(starts)]
    expected = occupied_cubes(points, size)
    assert sorted(map(sorted, blocks)) == sorted(map(sorted, expected))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("most", [0.02, 0.3])
def test_unequal_blocks_are_the_largest_cubes_for_all_their_points(
    dimension: int, most: float
) -> None:
    """They are few cells wide for the points that look least far, and full for none."""
    rng, size = np.random.default_rng(11), 0.01
    points = np.concatenate([rng.random((6000, dimension)), 0.01 * rng.random((4000, dimension))])
    levels = levels_of(size + most * points[:, 0] ** 2 * rng.uniform(0.8, 1.0, 10_000), size)
    grid = build_grid(points, size, None, levels)
    assert len(set(levels)) > 1
    cells = np.floor(points / (size * (1 + 1e-6))).astype(int) + CELL_OF_ZERO
    runs = np.repeat(np.arange(len(grid.cells.levels)), np.diff(grid.cells.starts))
    run_of = np.empty(len(points), int)
    run_of[grid.order] = runs

    def cut(members: list[int], level: int) -> list[list[int]]:
        cubes: dict[tuple[int, ...], list[int]] = {}
        for i in members:
            cubes.setdefault(tuple(cells[i] >> level), []).append(i)
        blocks = []
        for cube in cubes.values():
            is_whole = levels[cube].min() >= level - UNEQUAL_CUBE_LEVEL[dimension]
            if len(set(run_of[cube])) == 1 or (is_whole and len(cube) <= FULL_CUBE):
                blocks.append(cube)
            elif level:
                blocks += cut(cube, level - 1)
            else:
                blocks += [[i for i in cube if run_of[i] == run] for run in set(run_of[cube])]
        return blocks

    starts = cube_starts(grid, dimension, are_unequal=True)
    found = [sorted(grid.order[a:b].tolist()) for a, b in pairwise(starts)]
    expected = cut(list(range(len(points))), 20)
    assert sorted(found) == sorted(map(sorted, expected))
    assert len(found) > 3


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("corner", [None, 3.0])
def test_parts_of_a_cloud_in_range_have_the_cells_of_the_whole(
    dimension: int, corner: float | None
) -> None:
    """Of one that is a little too wide a part has others."""
    place = None if corner is None else np.full(dimension, corner)
    spread = np.random.default_rng(10).uniform(-1.0, 1.0, (300, dimension))
    spread[0], spread[1] = -1.0, 1.0
    for share, is_same in ((0.9999, True), (1.0001, False)):
        points = share * CELL_OF_ZERO * spread + (corner or 0.0)
        box = np.stack([points.min(axis=0), points.max(axis=0)])
        assert is_in_range(box, 1.0, place) == is_same
        whole = build_grid(points, 1.0, place)
        part = np.flatnonzero(spread[:, 0] > -0.5)
        grid = build_grid(points[part], 1.0, place)
        kept = np.isin(whole.order, part)
        cells = np.repeat(whole.cells.codes, np.diff(whole.cells.starts))[kept]
        same = np.array_equal(np.repeat(grid.cells.codes, np.diff(grid.cells.starts)), cells)
        assert same == is_same


def test_the_corner_of_a_grid_is_where_a_cell_begins() -> None:
    rng = np.random.default_rng(11)
    points, corner = rng.random((500, 3)), rng.random(3)
    grid, moved = build_grid(points, 0.1, corner), build_grid(points - corner, 0.1)
    np.testing.assert_array_equal(grid.cells.codes, moved.cells.codes)
    np.testing.assert_array_equal(grid.cells.starts, moved.cells.starts)
    np.testing.assert_array_equal(grid.order, moved.order)
