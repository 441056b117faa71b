from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree

import oracles
from oracles import Array
from pcsmooth.kernels.surface.forest_pieces import exit_edges, span, thin
from pcsmooth.kernels.surface.parity_union_find import refer_to_lowest
from pcsmooth.kernels.surface.spanning_forest import join_alike
from pcsmooth.kernels.threads import thread_limit

Numbers = npt.NDArray[np.int32]

#: Links between normals with a larger product are joined first, whatever the tree.
ALIKE = 0.9

#: Points of a block.
BLOCK = 4096


def rank_blocks(n: int) -> npt.NDArray[np.int64]:
    """Blocks of n points, equally many each."""
    return np.append(np.arange(0, n, BLOCK), n)


def links_of(points: Array, count: int, reach: float) -> Numbers:
    found = cKDTree(points).query(points, count + 1, distance_upper_bound=reach)[1]
    return np.asarray(found[:, 1:], np.int32)


def without_alike(normals: Array, links: Numbers) -> Numbers:
    """Leave out the links between normals that are alike; the others move up."""
    n = len(normals)
    padded = np.r_[normals, np.zeros((1, normals.shape[1]))]
    products = np.abs(np.einsum("ij,ikj->ik", normals, padded[links]))
    kept = np.where(products >= ALIKE, n, links)
    return np.asarray(np.take_along_axis(kept, np.argsort(kept == n, axis=1, kind="stable"), 1))


def expected_forest(normals: Array, links: Numbers) -> tuple[Array, Array]:
    """Signs relative to the first point of each component, and its number, by SciPy."""
    n = len(normals)
    rows = np.repeat(np.arange(n), links.shape[1])[links.ravel() < n]
    columns = links.ravel()[links.ravel() < n]
    products = np.einsum("ij,ij->i", normals[rows], normals[columns])
    weights = coo_matrix((2 - abs(products), (rows, columns)), (n, n)).tocsr()  # 0 is no link
    tree = minimum_spanning_tree(weights.maximum(weights.T))
    _, labels = connected_components(tree, directed=False)
    firsts = np.unique(labels, return_index=True)[1]
    signs = np.ones(n)
    for root in firsts:
        order, parents = breadth_first_order(tree, root, directed=False)
        for node in order[1:]:
            agrees = normals[node] @ normals[parents[node]] >= 0
            signs[node] = signs[parents[node]] * (1 if agrees else -1)
    return signs, firsts[labels]


def random_normals(n: int, dimension: int, seed: int) -> Array:
    return oracles.random_sphere(n, 1.0, seed, dimension)


def forest(normals: Array, links: Numbers) -> tuple[npt.NDArray[np.int8], npt.NDArray[np.int64]]:
    """Signs relative to the first point of each component, and its number, in a single piece."""
    n = len(normals)
    columns, numbers = np.ascontiguousarray(normals.T), np.arange(n)
    names, signs = refer_to_lowest(*join_alike(columns, links, rank_blocks(n)), numbers)
    edges = exit_edges(columns, links, numbers, names, signs, np.ones(n, np.bool_))
    root_of, sign_of = numbers.copy(), np.ones(n, np.int8)
    joined, lowest, relations = span(thin(edges))
    root_of[joined], sign_of[joined] = lowest, relations
    return signs * sign_of[names], root_of[names]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("count", [2, 6, 8])
@pytest.mark.parametrize("reach", [0.05, 0.1, 0.3])
def test_signs_and_components_are_those_of_scipy(dimension: int, count: int, reach: float) -> None:
    normals = random_normals(500, dimension, count)
    points = oracles.uniform_cloud(500, dimension, count)
    links = without_alike(normals, links_of(points, count, reach))
    signs, roots = forest(normals, links)
    expected_signs, expected_roots = expected_forest(normals, links)
    np.testing.assert_array_equal(roots, expected_roots)
    np.testing.assert_array_equal(signs, expected_signs)


@pytest.mark.parametrize("threads", [1, 2])
def test_links_lead_across_blocks(threads: int) -> None:
    n = 2 * BLOCK + 100
    normals = random_normals(n, 3, 7)
    links = without_alike(normals, links_of(oracles.uniform_cloud(n, 3, 7), 8, np.inf))
    with thread_limit(threads):
        signs, roots = forest(normals, links)
    expected_signs, expected_roots = expected_forest(normals, links)
    np.testing.assert_array_equal(roots, expected_roots)
    np.testing.assert_array_equal(signs, expected_signs)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("along", [True, False])
def test_alike_normals_come_out_alike_across_blocks(threads: int, along: bool) -> None:
    """On a smooth surface, its points in the order of a line or in none."""
    n = 3 * BLOCK + 17
    points = oracles.even_sphere(n)
    if not along:
        points = np.random.default_rng(5).permutation(points)
    flips = np.random.default_rng(6).choice([-1.0, 1.0], n)
    with thread_limit(threads):
        signs, roots = forest(flips[:, np.newaxis] * points, links_of(points, 8, np.inf))
    assert not roots.any()
    np.testing.assert_array_equal(signs, flips * flips[0])


def test_a_sharp_edge_is_crossed_where_it_bends_least() -> None:
    """Alike normals within two faces, and links between the faces with products of either sign."""
    rng = np.random.default_rng(8)
    n = 60
    points = np.c_[rng.uniform(-1, 1, (n, 2)), np.zeros(n)]
    left = points[:, 0] < 0
    normals = np.where(left[:, np.newaxis], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    normals[left, 2] = 0.1 * rng.uniform(-1, 1, left.sum())
    normals[~left, 2] = 0.1 * rng.uniform(-1, 1, (~left).sum())
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    links = links_of(points, 10, np.inf)
    rows, columns = np.repeat(np.arange(n), 10), links.ravel()
    crossing = left[rows] != left[columns]
    products = np.einsum("ij,ij->i", normals[rows], normals[columns])[crossing]
    assert products.min() < 0 < products.max()
    strongest = products[np.abs(products).argmax()]
    signs, roots = forest(normals, links)
    assert not roots.any()
    assert len(set(signs[left])) == len(set(signs[~left])) == 1
    assert signs[left][0] * signs[~left][0] == np.sign(strongest)


def test_links_of_equal_weight_make_no_cycle() -> None:
    """All links weigh the same; every two points agree along any path."""
    rng = np.random.default_rng(0)
    links = links_of(rng.random((400, 2)), 8, np.inf)
    flips = rng.choice([-1.0, 1.0], 400)
    signs, roots = forest(np.outer(flips, [0.0, 0.0, 1.0]), links)
    for root in set(roots):
        assert len(set((signs * flips)[roots == root])) == 1
        assert roots[root] == root


def test_links_of_equal_weight_that_are_not_alike_make_no_cycle() -> None:
    """On a square grid with normals like a chessboard's, each link has the product 1/2."""
    places = oracles.lattice(20, 20)
    is_black = places.sum(axis=1) % 2 == 1
    flips = np.random.default_rng(1).choice([-1.0, 1.0], 400)
    normals = np.where(is_black[:, np.newaxis], [0.5, np.sqrt(0.75)], [1.0, 0.0])
    signs, roots = forest(flips[:, np.newaxis] * normals, links_of(places, 4, 1.1))
    assert not roots.any()
    np.testing.assert_array_equal(signs, flips * flips[0])


@pytest.mark.parametrize("step", [1, -1])
def test_a_long_chain_hands_on_its_sign(step: int) -> None:
    """Angles that grow along the chain, so that one round joins all of it."""
    n = 3000
    angles = np.cumsum(np.linspace(0.5, 1.0, n))[::step]
    flips = np.random.default_rng(1).choice([-1.0, 1.0], n)
    normals = flips[:, np.newaxis] * np.c_[np.cos(angles), np.sin(angles)]
    chain = np.arange(1, n + 1, dtype=np.int32)[:, np.newaxis]
    signs, roots = forest(normals, chain)
    assert not roots.any()
    np.testing.assert_array_equal(signs, flips * flips[0])


def test_points_without_links_are_their_own_components() -> None:
    signs, roots = forest(np.ones((5, 3)), np.full((5, 3), 5, np.int32))
    assert signs.tolist() == [1] * 5
    assert roots.tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("turn", [0.0, 1.0])
def test_a_normal_that_is_not_a_number_joins_nothing(turn: float) -> None:
    chain = np.arange(1, 5, dtype=np.int32)[:, np.newaxis]
    normals = np.array([[1, 0], [-np.cos(turn), np.sin(turn)], [np.nan, 0.0], [1.0, 0.0]])
    signs, roots = forest(normals, chain)
    assert roots.tolist() == [0, 0, 2, 3]
    assert signs.tolist() == [1, -1, 1, 1]
