from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial import cKDTree

import oracles
from oracles import Array
from pcsmooth.kernels.surface.forest_pieces import EDGE, exit_edges, span, thin
from pcsmooth.kernels.surface.parity_union_find import refer_to_lowest
from pcsmooth.kernels.surface.spanning_forest import join_alike
from pcsmooth.neighbors.grid import build_grid

Numbers = npt.NDArray[np.int64]
Edges = npt.NDArray[np.void]


@dataclass(frozen=True)
class Cloud:
    """Points in grid order, and what signs are handed on by."""

    points: Array
    normals: Array  # (d, n)
    links: npt.NDArray[np.int32]
    numbers: Numbers
    block_starts: Numbers


def cloud_of(points: Array, normals: Array, reach: float = np.inf, seed: int = 0) -> Cloud:
    """Points numbered in random order, in blocks of random sizes."""
    rng = np.random.default_rng(seed)
    n = len(points)
    rows = rng.permutation(n)
    points, normals = points[rows], normals[rows]
    normals = rng.choice([-1.0, 1.0], (n, 1)) * normals
    order = build_grid(points, 0.1 * float(np.ptp(points))).order
    points, normals = points[order], normals[order]
    links = cKDTree(points).query(points, 9, distance_upper_bound=reach)[1][:, 1:]
    cuts = np.unique(np.r_[0, rng.integers(0, n, 12), n])
    return Cloud(points, np.ascontiguousarray(normals.T), links.astype(np.int32), order, cuts)


def torus() -> Cloud:
    return cloud_of(*oracles.random_torus(3000))


def noise(dimension: int, reach: float = np.inf) -> Cloud:
    normals = oracles.random_sphere(1500, 1.0, 3, dimension)
    return cloud_of(oracles.uniform_cloud(1500, dimension), normals, reach)


def lattice() -> Cloud:
    """Products of 0, 1/2 and -1/2 only: nothing but numbers tells which link is lighter."""
    thirds = np.pi / 3 * np.arange(6)
    flat = np.stack([np.cos(thirds), np.sin(thirds), 0 * thirds], axis=1)
    directions = np.concatenate([np.round(flat, 3), [[0.0, 0.0, 1.0]]])
    places = oracles.lattice(11, 11, 11)
    chosen = np.random.default_rng(4).integers(0, 7, len(places))
    return cloud_of(places, directions[chosen], 1.1)


def with_gaps() -> Cloud:
    """Some normals missing, and one that is not a number."""
    cloud = noise(3)
    normals = cloud.normals.copy()
    normals[:, ::7] = 0.0
    normals[:, 100] = np.nan
    return replace(cloud, normals=normals)


def components() -> Cloud:
    points, normals = oracles.random_torus(800)
    shifts = np.repeat([[0.0, 0, 0], [9, 0, 0], [0, 9, 0]], 800, axis=0)
    alone = 50.0 * oracles.lattice(3, 1, 1) + 100.0
    everywhere = np.concatenate([np.tile(points, (3, 1)) + shifts, alone])
    return cloud_of(everywhere, np.r_[np.tile(normals, (3, 1)), np.ones((3, 3))], 0.25)


CLOUDS = {
    "torus": torus(),
    "noise in the plane": noise(2),
    "noise": noise(3),
    "noise in clusters": noise(3, 0.07),
    "lattice": lattice(),
    "gaps": with_gaps(),
    "components": components(),
}


def tiles_of(cloud: Cloud, way: str) -> Numbers:
    """The tile of each point."""
    n = len(cloud.points)
    if way == "whole":
        return np.zeros(n, np.int64)
    rng = np.random.default_rng(1)
    if way == "slabs":
        return np.asarray((4 * np.argsort(np.argsort(cloud.points[:, 0]))) // n)
    if way == "blocks":
        sizes = np.diff(cloud.block_starts)
        return np.repeat(rng.integers(0, 3, len(sizes)), sizes)
    return rng.integers(0, 3, n)


def edges_of_tile(cloud: Cloud, own: npt.NDArray[np.bool_]) -> tuple[Edges, Numbers, Array]:
    """What a tile finds: its edges, and for its own points what they are joined to and signs.

    It knows its own points, those that they have links to, and all of the blocks of either.
    """
    n = len(own)
    sizes = np.diff(cloud.block_starts)
    block_of = np.repeat(np.arange(len(sizes)), sizes)
    linked = cloud.links[own].ravel()
    blocks = np.unique(np.r_[block_of[own], block_of[linked[linked < n]]])
    local = np.flatnonzero(np.isin(block_of, blocks))
    place_of = np.full(n + 1, len(local), np.int32)
    place_of[local] = np.arange(len(local))
    normals = np.ascontiguousarray(cloud.normals[:, local])
    links = place_of[cloud.links[local]]
    numbers = cloud.numbers[local]
    roots, signs = join_alike(normals, links, np.r_[0, np.cumsum(sizes[blocks])])
    is_own = own[local]
    names, signs = refer_to_lowest(roots, signs, numbers)
    edges = exit_edges(normals, links, numbers, names, signs, is_own)
    return edges, names[is_own], signs[is_own]


def forest_in_tiles(
    cloud: Cloud, way: str, *, is_thin: bool = False, are_numbered: bool = True
) -> tuple[Numbers, Array]:
    n = len(cloud.points)
    tiles = tiles_of(cloud, way)
    contracted, signs = np.empty(n, np.int64), np.empty(n)
    found = []
    for tile in np.unique(tiles):
        own = tiles == tile
        edges, contracted[own], signs[own] = edges_of_tile(cloud, own)
        if not are_numbered:
            edges["low"] = edges["high"] = 0
        found.append(thin(edges) if is_thin else edges)
    edges = np.random.default_rng(2).permutation(np.concatenate(found))
    roots, root_of, sign_of = span(edges)
    roots = np.append(roots, n)  # there is no root n
    places = np.searchsorted(roots, contracted)
    is_joined = roots[places] == contracted
    labels = np.where(is_joined, np.append(root_of, n)[places], contracted)
    return labels, signs * np.where(is_joined, np.append(sign_of, 1)[places], 1)


def in_terms_of_lowest(
    labels: npt.NDArray[np.integer], signs: npt.NDArray[np.integer] | Array, numbers: Numbers
) -> tuple[Numbers, Array]:
    """Lowest number in the component of each point, and its sign relative to that point's."""
    order = np.argsort(numbers)
    _, firsts, components = np.unique(labels[order], return_index=True, return_inverse=True)
    lowest = order[firsts][components][np.argsort(order)]
    return numbers[lowest], np.asarray(signs * signs[lowest], np.float64)


def step_by_step(
    cloud: Cloud, *, by_number: bool = True, in_order: bool = True
) -> tuple[Numbers, Array]:
    """Join alike normals of each block, then all links from the lightest on, one by one."""
    n = len(cloud.points)
    roots, signs = np.arange(n), np.ones(n)

    def join(i: int, j: int, product: float) -> None:
        if roots[i] != roots[j]:
            moved = roots == roots[j]
            signs[moved] *= signs[i] * signs[j] * (1 if product >= 0 else -1)
            roots[moved] = roots[i]

    def product_of(i: int, j: int) -> float:
        x, y = cloud.normals[:, i], cloud.normals[:, j]
        return float(sum(x[a] * y[a] for a in range(len(x))))

    sizes = np.diff(cloud.block_starts)
    block_of = np.repeat(np.arange(len(sizes)), sizes)
    ends = [(i, int(j)) for i in range(n) for j in cloud.links[i] if j < n]
    for i, j in ends if in_order else ends[::-1]:
        if block_of[i] == block_of[j] and abs(product_of(i, j)) >= 0.9:
            join(i, j, product_of(i, j))
    names = cloud.numbers if by_number else np.arange(n)

    def key(link: tuple[int, int]) -> tuple[float, int, int]:
        i, j = link
        return 1 - abs(product_of(i, j)), min(names[i], names[j]), max(names[i], names[j])

    for i, j in sorted((link for link in ends if not np.isnan(product_of(*link))), key=key):
        join(i, j, product_of(i, j))
    return in_terms_of_lowest(roots, signs, cloud.numbers)


@cache
def whole(name: str) -> tuple[Numbers, Array]:
    return step_by_step(CLOUDS[name])


@pytest.mark.parametrize("way", ["whole", "slabs", "blocks", "points"])
@pytest.mark.parametrize("name", CLOUDS)
def test_tiles_are_joined_from_the_lightest_link_on(name: str, way: str) -> None:
    cloud = CLOUDS[name]
    expected_names, expected_signs = whole(name)
    for is_thin in (False, True):
        names, signs = forest_in_tiles(cloud, way, is_thin=is_thin)
        np.testing.assert_array_equal(names, expected_names)
        np.testing.assert_array_equal(signs, expected_signs)


def test_numbers_decide_between_links_of_equal_weight() -> None:
    """Other rules give other signs, so that the tests above do see which one there is."""
    cloud = CLOUDS["lattice"]
    _, signs = whole("lattice")
    assert (signs != step_by_step(cloud, by_number=False)[1]).any()
    assert (signs != forest_in_tiles(cloud, "slabs", are_numbered=False)[1]).any()


def test_the_order_of_points_and_links_decides_between_normals_that_are_alike() -> None:
    """Round a Moebius strip neighbours are alike, but not all the way."""
    n = 300
    angles = np.pi * np.arange(n) / n
    normals = np.c_[np.cos(angles), np.sin(angles)]
    links = np.c_[(np.arange(n) + 1) % n, (np.arange(n) - 1) % n].astype(np.int32)
    cuts = np.array([0, n])
    strip = Cloud(np.zeros((n, 2)), np.ascontiguousarray(normals.T), links, np.arange(n), cuts)
    _, signs = forest_in_tiles(strip, "whole")
    np.testing.assert_array_equal(signs, step_by_step(strip)[1])
    assert (signs != step_by_step(strip, in_order=False)[1]).any()


def test_an_edge_is_the_same_from_either_end() -> None:
    rng = np.random.default_rng(0)
    n = 400
    normals = rng.normal(size=(3, n))
    links = np.where(np.arange(n) % 2 == 0, np.arange(n) + 1, np.arange(n) - 1)[:, np.newaxis]
    numbers = rng.permutation(n)
    arguments = (normals, links.astype(np.int32), numbers, numbers, np.ones(n, np.int8))
    is_even = np.arange(n) % 2 == 0
    one_way = exit_edges(*arguments, is_even)
    other_way = exit_edges(*arguments, ~is_even)
    assert len(one_way) == n // 2
    assert all((one_way[name] == other_way[name]).all() for name in EDGE.names or ())
    assert (one_way["root_a"] < one_way["root_b"]).all()
    assert len(exit_edges(*arguments, np.ones(n, np.bool_))) == n // 2


def test_each_pair_of_roots_has_one_edge_its_lightest() -> None:
    """More pairs than there is room for at first."""
    cloud = CLOUDS["noise"]
    n = len(cloud.points)
    roots, signs = np.arange(n) // 2 * 10**12 - 10**14, np.ones(n, np.int8)
    edges = exit_edges(
        cloud.normals, cloud.links, cloud.numbers, roots, signs, np.ones(n, np.bool_)
    )
    expected: dict[tuple[int, int], tuple[float, int, int, int]] = {}
    for i in range(n):
        for j in cloud.links[i]:
            pair = (min(roots[i], roots[j]), max(roots[i], roots[j]))
            product = float(sum(cloud.normals[a, i] * cloud.normals[a, j] for a in range(3)))
            low, high = sorted((int(cloud.numbers[i]), int(cloud.numbers[j])))
            edge = (1 - abs(product), low, high, 1 if product >= 0 else -1)
            if pair[0] != pair[1]:
                expected[pair] = min(expected.get(pair, edge), edge)
    assert len(edges) == len(expected) > 1024
    for edge in edges:
        names = ("weight", "low", "high", "sign")
        pair = (edge["root_a"], edge["root_b"])
        assert tuple(edge[name] for name in names) == expected[pair]


def test_thinned_edges_are_a_forest() -> None:
    cloud = CLOUDS["noise"]
    edges, _, _ = edges_of_tile(cloud, np.ones(len(cloud.points), np.bool_))
    roots, root_of, _ = span(edges)
    thinned = thin(edges)
    assert len(thinned) == len(roots) - len(np.unique(root_of)) < len(edges)
    np.testing.assert_array_equal(root_of, span(thinned)[1])


def test_no_edges_span_nothing() -> None:
    none = np.empty(0, EDGE)
    assert [len(part) for part in span(none)] == [0, 0, 0]
    assert len(thin(none)) == 0


def test_a_component_is_named_after_its_lowest_root() -> None:
    edges = np.array([(0.5, 1, 2, 70, 90, -1), (0.4, 0, 1, -5, 90, -1), (0, 3, 4, 8, 9, 1)], EDGE)
    roots, root_of, sign_of = span(edges)
    assert roots.tolist() == [-5, 8, 9, 70, 90]
    assert root_of.tolist() == [-5, 8, 8, -5, -5]
    assert sign_of.tolist() == [1, 1, 1, 1, -1]
