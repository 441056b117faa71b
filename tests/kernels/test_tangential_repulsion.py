from __future__ import annotations

import numpy as np
import pytest

from pcsmooth.kernels.surface.tangential_repulsion import REACH, repel
from pcsmooth.neighbors.grid import build_grid


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_step_goes_down_the_gradient_of_the_density_within_the_tangent_planes(
    dimension: int,
) -> None:
    rng = np.random.default_rng(dimension)
    n, cell, strength = 200, 0.4, 0.3
    grid = build_grid(rng.random((n, dimension)), cell)
    normals = np.zeros((3, n))
    normals[:dimension] = rng.normal(size=(dimension, n))
    normals /= np.linalg.norm(normals, axis=0)
    widths = rng.uniform(0.05, cell / REACH, n)
    moved = np.empty((3, n))
    # More are listed than are felt, and not the point itself.
    ways = grid.coordinates[:, np.newaxis] - grid.coordinates[:, :, np.newaxis]
    near = (ways**2).sum(axis=0) < (1.2 * REACH * widths[:, np.newaxis]) ** 2
    np.fill_diagonal(near, False)
    numbers, ends = np.nonzero(near)[1].astype(np.int32), np.cumsum(near.sum(axis=1))
    repel(grid.coordinates, normals, widths, numbers, ends, strength, moved)

    for i in range(n):
        ways = grid.coordinates - grid.coordinates[:, [i]]
        squares = (ways**2).sum(axis=0)
        felt = (squares > 0) & (squares < (REACH * widths[i]) ** 2)
        weights = np.exp(-squares / widths[i] ** 2) * np.abs(normals[:, i] @ normals) * felt
        push = -ways @ weights
        push -= (push @ normals[:, i]) * normals[:, i]
        expected = grid.coordinates[:, i] + strength * push
        np.testing.assert_allclose(moved[:, i], expected, atol=1e-14)
