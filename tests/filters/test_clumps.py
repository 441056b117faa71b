from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import oracles
from oracles import Array
from pcsmooth.filters.clumps import clump_reach, mark_clumps
from pcsmooth.neighbors.grid import build_grid, levels_of


def marked(
    points: Array, cell_size: float, most: int = 20, reaches: Array | None = None
) -> npt.NDArray[np.bool_]:
    """Marks in the order of the points."""
    levels = None if reaches is None else levels_of(reaches, cell_size)
    grid = build_grid(points, cell_size, levels=levels)
    marks = np.empty(len(points), np.bool_)
    marks[grid.order] = mark_clumps(grid, cell_size, most, points.shape[1])
    return marks


def groups_of_cells(points: Array, side: float) -> list[list[int]]:
    """Points whose cells adjoin, and so on: found one by one."""
    cells = np.floor(points / side).astype(int)
    left, groups = set(range(len(points))), []
    while left:
        group, ahead = [], [left.pop()]
        while ahead:
            i = ahead.pop()
            group.append(i)
            near = [j for j in left if np.abs(cells[i] - cells[j]).max() <= 1]
            left.difference_update(near)
            ahead.extend(near)
        groups.append(group)
    return groups


@pytest.mark.parametrize(("dimension", "side"), [(2, 0.004), (3, 0.06)])
def test_groups_are_those_of_cells_that_adjoin(dimension: int, side: float) -> None:
    points = np.random.default_rng(2).random((600, dimension)) - 0.5
    wide, offset = side, 0.0
    if dimension == 2:  # cells are doubled twice, and the first one's number is no multiple of 4
        wide, offset = 4 * side, 0b010101010101010101010 % 4 * side
    expected = np.zeros(len(points), np.bool_)
    for group in groups_of_cells(points + offset, wide * (1 + 1e-6)):
        if len(group) <= 4 and np.ptp(points[group], axis=0).max() <= 3 * wide:
            expected[group] = True
    assert 20 < expected.sum() < 580
    np.testing.assert_array_equal(marked(points, side, 4), expected)


def test_clumps_have_so_many_points_and_no_more() -> None:
    surface = oracles.sphere_surface(3000)
    rng = np.random.default_rng(3)
    clumps = [
        np.array([2.0 + k, 0, 0]) + surface.spacing * rng.random((size, 3))
        for k, size in enumerate((1, 7, 20, 21))
    ]
    marks = marked(np.concatenate([surface.noisy(0.3), *clumps]), 3 * surface.spacing)
    np.testing.assert_array_equal(np.flatnonzero(marks), 3000 + np.arange(28))


def test_a_line_of_few_points_is_no_clump() -> None:
    line = np.zeros((15, 3))
    line[:, 0] = np.arange(15)
    assert not marked(line, 1.1).any()
    assert marked(line[:3], 1.1).all()


def test_what_is_near_depends_on_how_far_a_point_looks() -> None:
    """Two pairs, four and more apart: who looks farther than that sees no clump."""
    points = np.array([[0.0, 0, 0], [0.5, 0, 0], [4.5, 0, 0], [9.5, 0, 0]])
    assert marked(points, 1.0, 2, np.ones(4)).all()
    assert not marked(points, 1.0, 2, np.full(4, 9.0)).any()


def test_reach_is_that_of_the_cells() -> None:
    assert clump_reach(2.0, 3) == pytest.approx(5 * 2.0, rel=1e-4)
    assert clump_reach(2.0, 2) == pytest.approx(5 * 8.0, rel=1e-4)
    assert clump_reach(2.0, 3) > 5 * 2.0 * (1 + 1e-6)
