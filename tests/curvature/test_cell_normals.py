from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

import oracles
from curvature.found import Found, find
from oracles import Array
from pcsmooth.curvature.cell_normals import CELLS
from pcsmooth.kernels.threads import thread_limit

TORUS = oracles.torus_surface(3000)

CLOUDS = {
    "torus": (TORUS.noisy(0.3), 2 * TORUS.spacing),
    "near torus": (TORUS.points, 0.9 * TORUS.spacing),  # often fewer points than wanted
    "sheet": (oracles.waves_surface(2000).points, 0.1),
    "two densities": (np.r_[oracles.random_sphere(300), 3 + oracles.random_sphere(900, 0.3)], 0.2),
    "circle": (oracles.random_sphere(400, dimension=2), 0.1),
    "noisy circle": (
        oracles.random_sphere(600, dimension=2)
        * np.random.default_rng(4).normal(1, 0.02, size=(600, 1)),
        0.05,
    ),
}


def by_number(found: Found, rows: Array) -> Array:
    """Rows (3, n) in grid order as (n, d) in the order of the points."""
    values = np.empty((len(found.order), found.union.dimension))
    values[found.order] = rows[: found.union.dimension].T
    return values


def expected_cells(
    points: Array, found: Found, neighborhoods: list[list[int]]
) -> tuple[Array, Array, Array]:
    """Leading directions, gaps between the two largest eigenvalues, anchors: brute force."""
    union = found.union
    normals, gaps, anchors = np.zeros(points.shape), np.ones(len(points)), points.copy()
    for i, members in enumerate(neighborhoods):
        if members == [i]:
            continue
        values, vectors = np.linalg.eigh(union.normal_tensors[members].sum(axis=0))
        normals[i] = vectors[:, -1]
        gaps[i] = (values[-1] - values[-2]) / max(values[-1], 1e-9)  # 0 where nothing is visible
        volumes = union.cell_volumes[members]
        shift = volumes @ (points[members] - points[i]) / volumes.sum()
        anchors[i] += shift - shift @ normals[i] * normals[i]
    return normals, gaps, anchors


def nearest_within(points: Array, count: int, reach: float) -> list[list[int]]:
    rows = cKDTree(points).query(points, count, distance_upper_bound=reach)[1]
    return [[int(j) for j in row if j < len(points)] for row in rows]


@pytest.mark.parametrize("count", [3, 5, 8, 30])
@pytest.mark.parametrize("name", CLOUDS)
def test_normals_are_the_leading_directions_of_the_nearest_cells(name: str, count: int) -> None:
    points, radius = CLOUDS[name]
    found = find(points, radius, count)
    members = nearest_within(points, count, 2 * radius)
    expected, gaps, anchors = expected_cells(points, found, members)
    normals = by_number(found, found.cells.normals)
    clear = gaps > 1e-3
    assert clear.mean() > 0.7
    agreement = np.abs(np.einsum("ij,ij->i", normals, expected))
    alone = ~expected.any(axis=1)
    np.testing.assert_allclose(agreement[clear & ~alone], 1, rtol=0, atol=1e-13)
    assert not normals[alone].any()
    actual = by_number(found, found.cells.anchors)
    np.testing.assert_allclose(actual[clear], anchors[clear], rtol=0, atol=1e-9 * radius)
    volumes = found.union.cell_volumes[found.order]
    known = found.cells.normals.any(axis=0)
    (unit,) = set((volumes[known] / found.cells.weights[known]).tolist())
    np.testing.assert_array_equal(found.cells.weights, volumes / unit * known)
    assert 0.1 < volumes.max() / unit < 10


@pytest.mark.parametrize("counts", [(9, 9), (40,), (14, 13, 1), (6, 6, 6)])
def test_of_neighbors_at_the_same_distance_all_count(counts: tuple[int, ...]) -> None:
    """On exact grids the farthest of the nearest tie with others: none is preferred."""
    points = oracles.lattice(*counts)
    if points.shape[1] == 1:
        points = np.c_[points, np.zeros(len(points))]
    wanted = CELLS[points.shape[1]][0]
    found = find(points, 3.0)
    tree = cKDTree(points)
    limits = tree.query(points, wanted)[0][:, -1] + 1e-6
    members = [sorted(row) for row in tree.query_ball_point(points, limits)]
    expected, gaps, anchors = expected_cells(points, found, members)
    normals = by_number(found, found.cells.normals)
    clear = gaps > 1e-6
    assert clear.any()
    agreement = np.abs(np.einsum("ij,ij->i", normals, expected))
    np.testing.assert_allclose(agreement[clear], 1, rtol=0, atol=1e-12)
    actual = by_number(found, found.cells.anchors)
    np.testing.assert_allclose(actual[clear], anchors[clear], rtol=0, atol=1e-9)


@pytest.mark.parametrize("count", [3, 8, 30])
@pytest.mark.parametrize("name", CLOUDS)
def test_links_lead_to_the_nearest_points(name: str, count: int) -> None:
    """Eight to ten of them whatever the neighbourhood, or all within reach if these are fewer."""
    points, radius = CLOUDS[name]
    found = find(points, radius, count)
    placed = points[found.order]
    n = len(points)
    distances, expected = cKDTree(placed).query(placed, 11, distance_upper_bound=2 * radius)
    within = np.isfinite(distances[:, 1:]).sum(axis=1)
    for i, row in enumerate(found.cells.links):
        linked = [int(j) for j in row if j < n]
        assert min(8, within[i]) <= len(linked) <= 10
        assert set(linked) == set(expected[i, 1 : len(linked) + 1].tolist())
        assert (row[len(linked) :] == n).all()  # none stands behind a gap


@pytest.mark.parametrize("name", ["torus", "circle"])
def test_extent_is_the_distance_of_the_last_neighbor(name: str) -> None:
    points, radius = CLOUDS[name]
    count = CELLS[points.shape[1]][0]
    distances = np.median(cKDTree(points).query(points, count + 1)[0], axis=0)
    assert distances[-2] < find(points, radius).cells.extent <= distances[-1]


@pytest.mark.parametrize("dimension", [2, 3])
def test_points_that_nothing_touches_have_no_normal(dimension: int) -> None:
    points = 10 * oracles.lattice(3, 3, 3)[:, :dimension][:: 1 if dimension == 3 else 3]
    found = find(points, 1.0)
    assert not found.cells.normals.any()
    assert (found.cells.links == len(points)).all()
    np.testing.assert_array_equal(found.cells.anchors, found.points)


@pytest.mark.parametrize("name", ["torus", "noisy circle"])
def test_cell_normals_do_not_depend_on_threads(name: str) -> None:
    with thread_limit(1):
        one = find(*CLOUDS[name]).cells
    with thread_limit(2):
        two = find(*CLOUDS[name]).cells
    for field in ("normals", "anchors", "links", "weights"):
        assert getattr(one, field).tobytes() == getattr(two, field).tobytes()
    assert one.extent == two.extent
