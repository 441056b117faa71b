from __future__ import annotations

import numpy as np
import pytest

from pcsmooth.kernels.surface.neighbor_lists import list_neighbors
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.neighbors.grid import build_grid


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("dimension", [2, 3])
def test_points_nearer_than_a_radius_are_listed(dimension: int, threads: int) -> None:
    rng = np.random.default_rng(dimension)
    n, cell = 400, 0.5
    points = rng.random((n, dimension))
    points[:150] *= 0.1  # each has more neighbours there than there is room for at first
    grid = build_grid(points, cell)
    squares = rng.uniform(0.0, cell**2, n)
    ends = np.full(n, -1)
    with thread_limit(threads):
        blocks = list_neighbors(grid.coordinates, grid.cells, dimension, squares, ends)
    ways = grid.coordinates[:, np.newaxis] - grid.coordinates[:, :, np.newaxis]
    near = (ways**2).sum(axis=0) < squares[:, np.newaxis]
    np.fill_diagonal(near, False)
    assert [block[0] for block in blocks] == [0, *(block[1] for block in blocks[:-1])]
    assert blocks[-1][1] == n
    for first, stop, numbers in blocks:
        listed = np.split(numbers[: ends[stop - 1]], ends[first : stop - 1])
        for i, found in zip(range(first, stop), listed, strict=True):
            np.testing.assert_array_equal(np.sort(found), np.flatnonzero(near[i]))
