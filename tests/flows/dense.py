"""Graph Laplacians as dense matrices, and clouds to flow."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

import oracles
from oracles import Array
from pcsmooth.energies.facet_laplacian import FacetLaplacian


def weight_matrix(laplacian: FacetLaplacian) -> Array:
    """W of the points in the order of the rows."""
    n = len(laplacian.diagonal)
    rows = np.repeat(np.arange(n), np.diff(laplacian.starts))
    matrix = np.zeros((n, n))
    matrix[rows, laplacian.columns] = laplacian.weights
    assert np.count_nonzero(matrix) == len(laplacian.weights)
    return matrix


def dense_laplacian(laplacian: FacetLaplacian, numbers: npt.NDArray[np.int64]) -> Array:
    """L of the points in the order of their numbers."""
    weights = weight_matrix(laplacian)
    order = np.argsort(numbers)
    return np.asarray((np.diag(weights.sum(axis=1)) - weights)[np.ix_(order, order)])


def rough_sphere(n: int, dimension: int = 3, noise: float = 0.03) -> Array:
    deviates = noise * np.random.default_rng(1).normal(size=(n, 1))
    return (1 + deviates) * oracles.random_sphere(n, dimension=dimension)
