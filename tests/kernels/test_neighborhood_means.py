from __future__ import annotations

import numpy as np
import pytest

from oracles import Array
from pcsmooth.kernels.surface.neighborhood_means import (
    ALONG_NORMAL,
    HEIGHT,
    NUMBER_OF,
    neighborhood_means,
)
from pcsmooth.neighbors.grid import Grid, build_grid

REACH = 0.4


class Case:
    """A cloud with random normals, radii and values, and its weights as a matrix."""

    def __init__(self, dimension: int, exponent: int, one_sided: bool = False) -> None:
        rng = np.random.default_rng(dimension + exponent)
        n = 200
        self.dimension, self.exponent, self.one_sided = dimension, exponent, one_sided
        self.grid: Grid = build_grid(rng.random((n, dimension)), REACH)
        self.normals = np.zeros((3, n))
        self.normals[:dimension] = rng.normal(size=(dimension, n))
        self.normals /= np.linalg.norm(self.normals, axis=0)
        self.squares = rng.uniform(0.01, REACH**2, n)
        self.values = rng.normal(size=n)
        coordinates = self.grid.coordinates
        self.ways = coordinates[:, np.newaxis] - coordinates[:, :, np.newaxis]  # (3, i, j)
        near = (self.ways**2).sum(axis=0) < self.squares[:, np.newaxis]
        self.cosines = self.normals.T @ self.normals
        counts = near & (self.cosines >= 0.0) if one_sided else near
        self.weights = np.where(counts, np.abs(self.cosines) ** exponent, 0.0)

    def means(self, kind: int) -> tuple[Array, Array]:
        """Means and variances, which only heights have."""
        found, variances = np.full((2, len(self.squares)), np.nan)
        neighborhood_means(
            self.grid.coordinates, self.grid.cells, self.dimension,
            self.normals, self.one_sided, self.squares, self.exponent, kind, self.values,
            found, variances,
        )  # fmt: skip
        return found, variances


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("exponent", [2, 4, 8])
@pytest.mark.parametrize("one_sided", [False, True])
def test_means_are_those_of_the_matrix_of_weights(
    dimension: int, exponent: int, one_sided: bool
) -> None:
    case = Case(dimension, exponent, one_sided)
    shares = case.weights / case.weights.sum(axis=1, keepdims=True)
    heights = np.einsum("ki,kij->ij", case.normals, case.ways)
    expected = {
        HEIGHT: (shares * heights).sum(axis=1),
        ALONG_NORMAL: (shares * np.sign(case.cosines)) @ case.values,
        NUMBER_OF: shares @ case.values,
    }
    for kind, means in expected.items():
        np.testing.assert_allclose(case.means(kind)[0], means, atol=1e-14)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("exponent", [2, 8])
def test_variances_of_heights_are_about_their_weighted_means(dimension: int, exponent: int) -> None:
    case = Case(dimension, exponent)
    shares = case.weights / case.weights.sum(axis=1, keepdims=True)
    heights = np.einsum("ki,kij->ij", case.normals, case.ways)
    means, variances = case.means(HEIGHT)
    expected = (shares * (heights - means[:, np.newaxis]) ** 2).sum(axis=1)
    np.testing.assert_allclose(variances, expected, atol=1e-14)
