from __future__ import annotations

from math import sqrt

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial import cKDTree

import oracles
from oracles import Array
from pcsmooth.errors import InvalidInputError, NoFinitePointError
from pcsmooth.kernels.grid.box_tree import LEAF
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.neighbors.local_spacing import SLOPE, BoxedPoints, local_spacings
from pcsmooth.neighbors.spacing import mean_spacing
from pcsmooth.point_order import take_in_order

# --- the definition ---------------------------------------------------------------------------


def nearest_by_definition(points: Array) -> npt.NDArray[np.int64]:
    """All others by distance; of equal distances the one that comes first in the cloud's order."""
    order = take_in_order(points, np.ones(len(points), np.bool_)).rows
    rank = np.empty(len(points))
    rank[order] = np.arange(len(points))
    apart = np.linalg.norm(points[:, np.newaxis] - points, axis=2)
    np.fill_diagonal(apart, -1.0)
    return np.lexsort((np.broadcast_to(rank, apart.shape), apart), axis=1)[:, 1:]


def covers(offsets: Array) -> bool:
    """Whether neighbours lie on all sides along the surface, in the plane along the curve."""
    _, sizes, directions = np.linalg.svd(offsets)
    if offsets.shape[1] == 3:
        return bool(sizes[1] ** 2 >= 0.22 * sizes[0] ** 2) if len(sizes) > 1 else False
    along = offsets @ directions[0]
    behind, ahead = -min(along.min(), 0.0), max(along.max(), 0.0)
    return bool(min(behind, ahead) >= 0.3 * max(behind, ahead))


def own_spacing(offsets: Array) -> float:
    """The spacing at a point whose neighbours are at some offsets, by distance."""
    n, dimension = offsets.shape
    distances = np.linalg.norm(offsets, axis=1)
    least, largest = min({2: 2, 3: 6}[dimension], n), min(128, n)
    size = max(min(24, largest), least)
    while size > least and covers(offsets[:size]):
        smaller = max(int(size / 1.2), least)
        if not covers(offsets[:smaller]):
            break
        size = smaller
    while not covers(offsets[:size]):
        if size == largest:
            return float(distances[:least].mean())
        size = min(max(int(1.2 * size), size + 1), largest)
    share = (least / size) ** 2
    return float(share * distances[:size].mean() + (1 - share) * 0.95 * distances[size - 1])


def spacings_by_definition(points: Array) -> Array:
    nearest = nearest_by_definition(points)
    own = np.array([own_spacing(points[row] - points[i]) for i, row in enumerate(nearest)])
    around = np.c_[np.arange(len(points)), nearest[:, :24]]
    smooth = np.sort(own[around], axis=1)[:, (around.shape[1] - 1) // 2]
    for _ in range(2):
        smooth = smooth[around].mean(axis=1)
    apart = np.linalg.norm(points[:, np.newaxis] - points, axis=2)
    return np.asarray((smooth + 0.25 * apart).min(axis=1))


def lines(n: int, across: float, noise: float = 0.5, seed: int = 0) -> Array:
    """A plane in lines that are so many times as far apart as the points on them are, 1."""
    rng = np.random.default_rng(seed)
    count = int(sqrt(n / across))
    x, y = np.meshgrid(np.arange(n // count, dtype=float), across * np.arange(count))
    x += rng.uniform(-0.3, 0.3, x.shape)
    return np.asarray(np.c_[x.ravel(), y.ravel(), noise * rng.normal(size=x.size)])


def station(rows: int, columns: int) -> tuple[Array, Array]:
    """Ground around a tripod, 2 to 60 m away, and how far rows or columns are apart there."""
    low, high = np.arctan(2 / 60), np.arctan(2 / 2)
    step, turn = (high - low) / (rows - 1), 0.6 / (columns - 1)
    down, across = np.meshgrid(low + step * np.arange(rows), turn * np.arange(columns))
    away = 2 / np.tan(down.ravel())
    points = np.c_[away * np.cos(across.ravel()), away * np.sin(across.ravel())]
    points = np.c_[points, 0.002 * np.random.default_rng(0).normal(size=len(points))]
    return points, np.maximum((away**2 + 4) / 2 * step, away * turn)


def rough_curve(n: int, seed: int = 0) -> Array:
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * rng.random(n)
    return np.asarray(np.c_[np.cos(angle), np.sin(angle)] * (1 + 2 / n * rng.normal(size=(n, 1))))


def clouds() -> dict[str, Array]:
    rng = np.random.default_rng(1)
    sphere = oracles.random_sphere(700)
    return {
        "sphere": sphere,
        "two scales": np.r_[sphere, 1e-3 * sphere[:400] + [1, 0, 0]],
        "lines": lines(800, 9.0),
        "far lines": lines(700, 70.0),
        "ground": station(30, 25)[0],
        "outliers": np.r_[sphere[:500], rng.uniform(-2, 2, (150, 3))],
        "cable": np.c_[np.linspace(0, 9, 300), 0.01 * rng.normal(size=(300, 2))],
        "straight": np.outer(np.sort(rng.random(200)), [1.0, 2.0, 4.0]),
        "filled": rng.random((500, 3)),
        "lattice": oracles.lattice(12, 11, 2),
        "flat lattice": np.c_[oracles.lattice(20, 19), np.zeros(380)],
        "seven": sphere[:7],
        "three": sphere[:3],
        "far away": sphere[:300] + 1e6,
        "curve": rough_curve(500),
        "even curve": oracles.even_circle(200),
        "line of the plane": oracles.lattice(100, 1),
        "plane lattice": oracles.lattice(15, 14),
        "pairs of the plane": np.r_[oracles.even_circle(90), (1 + 1e-7) * oracles.even_circle(90)],
        "two of the plane": np.array([[0.0, 0.0], [3.0, 4.0]]),
    }


@pytest.mark.parametrize("name", clouds())
def test_spacings_are_those_of_the_definition(name: str) -> None:
    points = clouds()[name]
    np.testing.assert_allclose(local_spacings(points), spacings_by_definition(points), rtol=1e-9)


@pytest.mark.parametrize("n", [LEAF - 1, LEAF, LEAF + 1, 2 * LEAF, 2 * LEAF + 1, 8 * LEAF + 1])
def test_any_number_of_leaves(n: int) -> None:
    points = oracles.random_sphere(n)
    np.testing.assert_allclose(local_spacings(points), spacings_by_definition(points), rtol=1e-9)


# --- what it is good for ----------------------------------------------------------------------


def test_an_even_cloud_has_its_mean_spacing() -> None:
    for points in (oracles.even_sphere(4000), oracles.even_circle(500)):
        np.testing.assert_allclose(local_spacings(points), mean_spacing(points), rtol=0.05)


@pytest.mark.parametrize("noise", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("shape", ["sphere", "torus"])
def test_spacing_of_a_random_surface_hardly_varies(shape: str, noise: float) -> None:
    rng = np.random.default_rng(5)
    if shape == "sphere":
        normals = oracles.random_sphere(12_000, seed=3)
        points, area = normals, 4 * np.pi
    else:
        points, normals = oracles.random_torus(12_000, seed=3)
        area = 4 * np.pi**2 * 0.4
    points = points + noise * sqrt(area / 12_000) * rng.normal(size=(12_000, 1)) * normals
    spacings = local_spacings(points)
    shares = spacings / np.median(spacings)
    assert np.mean((shares > 0.8) & (shares < 1.2)) > 0.98
    assert 0.9 < np.median(spacings) / mean_spacing(points) < 1.1


@pytest.mark.parametrize("across", [5.0, 7.0, 10.0, 20.0, 40.0])
@pytest.mark.parametrize("noise", [0.5, 1.0])
def test_spacing_of_scan_lines_is_their_distance(across: float, noise: float) -> None:
    points = lines(9000, across, noise)
    spacings = local_spacings(points)
    assert np.all((spacings > 0.6 * across) & (spacings < 1.2 * across))
    tree = cKDTree(points)
    for i in range(0, len(points), 97):
        near = points[tree.query_ball_point(points[i], 2 * spacings[i])]
        assert np.abs(near[:, 1] - points[i, 1]).max() > across / 2


def test_spacing_follows_the_ground_around_a_station() -> None:
    points, expected = station(120, 225)
    shares = local_spacings(points) / expected
    assert np.quantile(expected, 0.99) > 50 * np.quantile(expected, 0.01)
    assert np.mean((shares > 1 / 1.5) & (shares < 1.5)) > 0.98


def test_spacing_of_a_cable_is_that_along_it() -> None:
    ground = np.c_[30 * np.random.default_rng(0).random((4000, 2)), np.zeros(4000)]
    cable = np.c_[np.linspace(5, 25, 1000), np.full(1000, 15.0), np.full(1000, 8.0)]
    spacings = local_spacings(np.r_[ground, cable])
    np.testing.assert_allclose(spacings[4100:-100], 2 * 20 / 999, rtol=1e-3)  # 1 1 2 2 3 3 gaps


def test_a_curve_of_the_plane_may_become_sparse() -> None:
    x = np.cumsum(np.exp(np.linspace(0, 6, 2000)))
    spacings = local_spacings(np.c_[x, np.sin(x / x[-1])])
    np.testing.assert_allclose(spacings[1:], np.diff(x), rtol=0.06)


@pytest.mark.parametrize("name", ["outliers", "two scales", "lines", "ground", "filled", "curve"])
def test_spacing_rises_no_faster_than_a_quarter_of_the_distance(name: str) -> None:
    points = clouds()[name]
    spacings = local_spacings(points)
    apart = np.linalg.norm(points[:, np.newaxis] - points, axis=2)
    assert SLOPE == 0.25
    rises = np.abs(spacings[:, np.newaxis] - spacings)
    assert np.all(rises <= 0.25 * apart + 1e-12 * spacings.max())
    if name == "two scales":  # it is their distance from the small one that holds the others down
        assert np.any((rises > 0.249 * apart) & (apart > 0.0))


@pytest.mark.parametrize("spread", [0.01, 1.0, 100.0])
def test_values_are_lowered_by_all_that_are_near_enough(spread: float) -> None:
    """By few of the points around a leaf, by many, and by most of the cloud."""
    rng = np.random.default_rng(12)
    points = rng.random((2000, 3)) * [1.0, 1.0, 0.01]
    points = points[take_in_order(points, np.ones(2000, np.bool_)).rows]
    values = 0.03 * (1.0 + spread * rng.random(2000))
    apart = np.linalg.norm(points[:, np.newaxis] - points, axis=2)
    expected = np.min(values + SLOPE * apart, axis=1)
    np.testing.assert_allclose(BoxedPoints.of(points).lowered(values), expected, rtol=1e-14)


def test_outliers_hardly_touch_the_surface() -> None:
    surface = oracles.random_sphere(6000)
    alone = local_spacings(surface)
    outliers = np.random.default_rng(2).uniform(-1.5, 1.5, (600, 3))
    off = np.abs(np.linalg.norm(outliers, axis=1) - 1)
    outliers, off = outliers[off > 0.1], off[off > 0.1]
    found = local_spacings(np.r_[surface, outliers])
    np.testing.assert_allclose(found[:6000], alone, rtol=0.15)
    assert np.all(found[6000:] <= found[:6000].max() + off / 4 + 0.02)


# --- what it does not depend on ---------------------------------------------------------------

INVARIANT = ["sphere", "two scales", "lines", "cable", "lattice", "outliers", "curve"]


@pytest.mark.parametrize("name", INVARIANT)
def test_permuted_points_have_the_same_spacings(name: str) -> None:
    points = clouds()[name]
    order = np.random.default_rng(6).permutation(len(points))
    np.testing.assert_array_equal(local_spacings(points[order]), local_spacings(points)[order])


@pytest.mark.parametrize("name", INVARIANT)
def test_spacings_scale_with_the_cloud(name: str) -> None:
    points = clouds()[name]
    expected = local_spacings(points)
    for scale in (0.125, 2.0**-200, 2.0**200):
        np.testing.assert_array_equal(local_spacings(scale * points), scale * expected)


@pytest.mark.parametrize("name", ["sphere", "lines", "cable", "outliers", "curve"])
def test_spacings_are_the_same_elsewhere(name: str) -> None:
    points = clouds()[name]
    shift = np.array([2.0**10, -(2.0**9), 2.0**12])[: points.shape[1]]
    moved = (points + shift) - shift  # no more digits than there is room for
    np.testing.assert_allclose(local_spacings(moved + shift), local_spacings(moved), rtol=1e-9)


@pytest.mark.parametrize("name", ["sphere", "lines", "ground", "curve"])
def test_threads_find_the_same_bytes(name: str) -> None:
    points = clouds()[name]
    found = []
    for threads in (1, 2):
        with thread_limit(threads):
            found.append(local_spacings(points).tobytes())
    assert found[0] == found[1]


def test_coincident_points_share_a_spacing() -> None:
    points = clouds()["lines"]
    repeats = np.random.default_rng(4).integers(0, len(points), 500)
    found = local_spacings(np.r_[points, points[repeats]])
    expected = local_spacings(points)
    np.testing.assert_array_equal(found, np.r_[expected, expected[repeats]])


@pytest.mark.parametrize("dimension", [2, 3])
def test_one_place_has_no_spacing(dimension: int) -> None:
    assert local_spacings(np.ones((1, dimension))).tolist() == [0.0]
    assert local_spacings(np.ones((5, dimension))).tolist() == [0.0] * 5


def test_two_points_are_as_far_apart_as_they_are() -> None:
    points = np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [3.0, 4.0, 0.0]])
    np.testing.assert_allclose(local_spacings(points), 5.0, rtol=1e-15)


def test_points_too_near_to_tell_their_squares() -> None:
    points = np.r_[np.outer(np.arange(40.0), [1e-300, 0, 0]), oracles.random_sphere(100)]
    found = local_spacings(points)
    assert np.all(np.isfinite(found))
    assert np.all(found > 0.0)
    assert np.all(found[:40] < 1e-200)


def test_rows_that_take_no_part() -> None:
    points = oracles.random_sphere(200)
    broken = np.insert(points, [0, 70], [[np.nan, 0, 0], [0, np.inf, 0]], axis=0)
    found = local_spacings(broken)
    np.testing.assert_array_equal(found[[0, 71]], 0.0)
    np.testing.assert_array_equal(np.delete(found, [0, 71]), local_spacings(points))


def test_clouds_that_cannot_be_measured() -> None:
    with pytest.raises(InvalidInputError, match=r"points have shape \(4, 4\)"):
        local_spacings(np.eye(4))
    with pytest.raises(InvalidInputError, match="are not between 1e-103 and 1e\\+100"):
        local_spacings(1e-120 * oracles.random_sphere(30))
    with pytest.raises(NoFinitePointError):
        local_spacings(np.empty((0, 3)))
