from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from scipy.spatial import cKDTree

import oracles
from oracles import Array
from pcsmooth.errors import InvalidInputError
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.neighbors.spacing import mean_spacing
from pcsmooth.point_order import scattered_ranks, take_in_order

HEXAGONAL = np.array([[1, 0], [0.5, sqrt(0.75)]])

#: Points at which the spacing is looked at.
SAMPLES = 20_000


def flat(points: Array) -> Array:
    return np.asarray(np.c_[points, np.zeros(len(points))])


def hexagon(side: int) -> Array:
    """Points of the hexagonal grid in a regular hexagon."""
    a, b = np.mgrid[-side : side + 1, -side : side + 1].reshape(2, -1)
    return np.asarray(np.c_[a, b][abs(a + b) <= side] @ HEXAGONAL)


@pytest.mark.parametrize("scale", [1.0, 0.125])
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("points", [oracles.lattice(9, 9), oracles.lattice(9, 9) @ HEXAGONAL])
def test_spacing_of_plane_grids(points: Array, scale: float, threads: int) -> None:
    """Every point of these grids has its two nearest neighbours at distance 1."""
    with thread_limit(threads):
        assert mean_spacing(scale * points) == pytest.approx(scale, rel=1e-14)


def test_spacing_of_a_square_grid_in_space() -> None:
    """Six neighbours by distance, inside, on the 4 sides and in the 4 corners of m x m points."""
    m = 12
    inside = (4 + 2 * sqrt(2)) / 6
    side = (3 + 2 * sqrt(2) + 2) / 6
    corner = (2 + sqrt(2) + 2 * 2 + sqrt(5)) / 6
    expected = ((m - 2) ** 2 * inside + 4 * (m - 2) * side + 4 * corner) / m**2
    assert mean_spacing(flat(oracles.lattice(m, m))) == pytest.approx(expected, rel=1e-14)


def test_spacing_of_a_hexagonal_grid_in_space() -> None:
    k = 8
    side, corner = (4 + 2 * sqrt(3)) / 6, (3 + 2 * sqrt(3) + 2) / 6
    total = 3 * k * k + 3 * k + 1
    expected = (total - 6 * k + 6 * (k - 1) * side + 6 * corner) / total
    assert mean_spacing(flat(hexagon(k))) == pytest.approx(expected, rel=1e-14)


def test_coincident_points_count_once() -> None:
    points = flat(hexagon(5))
    repeated = points[
        np.r_[np.arange(len(points)), np.random.default_rng(0).integers(0, len(points), 500)]
    ]
    assert mean_spacing(repeated) == mean_spacing(points)


def test_outliers_do_not_count() -> None:
    points = oracles.lattice(20, 20)
    outliers = np.array([[1e3, 0], [0, -1e5], [1e12, 1e12]])
    assert mean_spacing(np.r_[points, outliers]) == 1.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_spacing_is_zero_without_two_distinct_points(dimension: int) -> None:
    assert mean_spacing(np.ones((1, dimension))) == 0.0
    assert mean_spacing(np.ones((7, dimension))) == 0.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_spacing_of_few_points_is_their_mean_distance(dimension: int) -> None:
    right_triangle = np.array([[0, 0, 0], [3, 0, 0], [0, 4, 0]], float)[:, :dimension]
    assert mean_spacing(right_triangle[:2]) == 3.0
    assert mean_spacing(right_triangle) == pytest.approx(4.0, rel=1e-15)


def test_spacing_of_a_large_cloud_is_sampled() -> None:
    """Of 40,000 points every second one is asked; a point's spacing is the mean of two gaps."""
    n = 40_000
    gaps = 1.0 + 0.5 * np.random.default_rng(3).random(n + 1)
    line = np.c_[np.cumsum(gaps[:n]), np.zeros(n)]
    own = (gaps[1:] + gaps[:n]) / 2
    own[0], own[-1] = gaps[1] + gaps[2] / 2, gaps[n - 1] + gaps[n - 2] / 2
    asked = scattered_ranks(n, SAMPLES)
    assert len(asked) == n // 2
    assert mean_spacing(line) == pytest.approx(own[asked].mean(), rel=1e-11)


def spacing_by_tree(points: Array) -> float:
    """The definition, with a k-d tree."""
    points = take_in_order(points, np.ones(len(points), np.bool_)).points
    distinct = np.unique(points, axis=0, return_index=True)[1]
    distinct.sort()
    count = min({2: 2, 3: 6}[points.shape[1]], len(distinct) - 1)
    asked = points[distinct[scattered_ranks(len(distinct), SAMPLES)]]
    own = cKDTree(points[distinct]).query(asked, count + 1)[0][:, 1:].mean(axis=1)
    return float(own[own <= 4 * np.median(own)].mean())


def clouds_of(dimension: int) -> dict[str, Array]:
    rng = np.random.default_rng(dimension)
    sphere = oracles.random_sphere(5000, dimension=dimension)
    cube = rng.random((5000, dimension))
    line = np.zeros((2000, dimension))
    line[:, 0] = rng.random(2000)
    return {
        "surface": sphere,
        "many points": oracles.random_sphere(50_000, dimension=dimension),
        "filled": cube,
        "far away": sphere + 1e6,
        "tiny": 1e-30 * sphere,
        "crowded": np.r_[1e-4 * cube[:4000], cube[4000:]],
        "line along an axis": line,
        "slanting line": line[:, :1] * np.arange(1, dimension + 1),
        "thin box": cube * ([1, 1e-7, 1e-7][:dimension]),
        "outliers": np.r_[sphere, [[1e3] * dimension, [-1e9] + [0] * (dimension - 1)]],
        "two scales": np.r_[sphere, 1e-3 * sphere + 5],
        "duplicates": sphere[rng.integers(0, 800, 5000)],
        "grid": oracles.lattice(*[40, 40, 3][:dimension]),
        "few": cube[:5],
    }


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", clouds_of(2))
def test_spacing_is_that_of_a_tree(dimension: int, name: str) -> None:
    points = clouds_of(dimension)[name]
    spacings = []
    for threads in (1, 2):
        with thread_limit(threads):
            spacings.append(mean_spacing(points))
    assert spacings[0] == pytest.approx(spacing_by_tree(points), rel=1e-13, abs=0.0)
    assert spacings[0] == spacings[1]


def test_spacing_of_points_almost_in_the_same_place() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    assert mean_spacing(1e-102 * points) == pytest.approx(4 / 3 * 1e-102, rel=1e-13, abs=0.0)
    with pytest.raises(InvalidInputError, match="give the cloud in another unit"):
        mean_spacing(1e-150 * points)


def test_spacing_does_not_depend_on_the_order_of_the_points() -> None:
    points = oracles.random_sphere(50_000)
    order = np.random.default_rng(1).permutation(len(points))
    assert mean_spacing(points[order]) == mean_spacing(points)
