from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree

from oracles import Array
from pcsmooth.kernels.spanning_forest import signs_along_forest

Numbers = npt.NDArray[np.int32]


def neighbors_of(points: Array, count: int, reach: float) -> Numbers:
    found = cKDTree(points).query(points, count, distance_upper_bound=reach)[1]
    return np.asarray(found, np.int32)


def expected_forest(normals: Array, neighbors: Numbers, links: int) -> tuple[Array, Array]:
    """Signs relative to the first point of each component, and its number, by SciPy."""
    n = len(normals)
    targets = neighbors[:, 1 : links + 1]
    rows = np.repeat(np.arange(n), targets.shape[1])[targets.ravel() < n]
    columns = targets.ravel()[targets.ravel() < n]
    products = np.einsum("ij,ij->i", normals[rows], normals[columns])
    weights = np.zeros((n, n))
    weights[rows, columns] = 2 - abs(products)  # 0 would be no link
    tree = minimum_spanning_tree(coo_matrix(np.maximum(weights, weights.T)).tocsr())
    count, labels = connected_components(tree, directed=False)
    signs, roots = np.ones(n), np.empty(n, int)
    for label in range(count):
        root = np.flatnonzero(labels == label)[0]
        roots[labels == label] = root
        order, parents = breadth_first_order(tree, root, directed=False)
        for node in order[1:]:
            agrees = normals[node] @ normals[parents[node]] >= 0
            signs[node] = signs[parents[node]] * (1 if agrees else -1)
    return signs, roots


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("count", [3, 7, 12])
@pytest.mark.parametrize("reach", [0.05, 0.1, 0.3])
def test_signs_and_components_are_those_of_scipy(dimension: int, count: int, reach: float) -> None:
    rng = np.random.default_rng(count)
    neighbors = neighbors_of(rng.random((500, dimension)), count, reach)
    normals = rng.normal(size=(500, dimension))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    signs, roots = signs_along_forest(normals, neighbors, 8)
    expected_signs, expected_roots = expected_forest(normals, neighbors, 8)
    np.testing.assert_array_equal(roots, expected_roots)
    np.testing.assert_array_equal(signs, expected_signs)


def test_links_of_equal_weight_make_no_cycle() -> None:
    """All links weigh the same; every two points agree along any path."""
    rng = np.random.default_rng(0)
    neighbors = neighbors_of(rng.random((400, 2)), 9, np.inf)
    flips = rng.choice([-1.0, 1.0], 400)
    normals = np.outer(flips, [0.0, 0.0, 1.0])
    signs, roots = signs_along_forest(normals, neighbors, 8)
    for root in set(roots):
        assert len(set((signs * flips)[roots == root])) == 1
        assert roots[root] == root


@pytest.mark.parametrize("step", [1, -1])
def test_a_long_chain_hands_on_its_sign(step: int) -> None:
    """Angles that grow along the chain, so that one round joins all of it."""
    n = 3000
    angles = np.cumsum(np.linspace(0.5, 1.0, n))[::step]
    flips = np.random.default_rng(1).choice([-1.0, 1.0], n)
    normals = flips[:, np.newaxis] * np.c_[np.cos(angles), np.sin(angles)]
    chain = np.c_[np.arange(n), np.arange(1, n + 1)].astype(np.int32)
    signs, roots = signs_along_forest(normals, chain, 1)
    assert not roots.any()
    np.testing.assert_array_equal(signs, flips * flips[0])


def test_points_without_links_are_their_own_components() -> None:
    alone = np.c_[np.arange(5), np.full((5, 3), 5)].astype(np.int32)
    signs, roots = signs_along_forest(np.ones((5, 3)), alone, 3)
    assert signs.tolist() == [1] * 5
    assert roots.tolist() == [0, 1, 2, 3, 4]


def test_a_normal_that_is_not_a_number_joins_nothing() -> None:
    chain = np.c_[np.arange(4), np.arange(1, 5)].astype(np.int32)
    normals = np.array([[1.0, 0.0], [-1.0, 0.0], [np.nan, 0.0], [1.0, 0.0]])
    signs, roots = signs_along_forest(normals, chain, 1)
    assert roots.tolist() == [0, 0, 2, 3]
    assert signs.tolist() == [1, -1, 1, 1]
