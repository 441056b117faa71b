from __future__ import annotations

import numpy as np
import pytest

import oracles
from oracles import Array
from pcsmooth.curvature.cell_normals import CellNormals
from pcsmooth.curvature.shape_operators import find_shape_operators
from pcsmooth.kernels.surface.shape_operators import (
    CONFIDENCE,
    GAUSSIAN,
    MEAN,
    N_ESTIMATES,
    PRINCIPAL,
)
from pcsmooth.kernels.threads import thread_limit

#: Points of a neighbourhood are summed in clusters: those in a cube of this share of its radius,
#: whose diagonal is shorter than this by which points here are apart.
APART = {2: 0.37, 3: 0.59}


def cell_normals(normals: Array, anchors: Array, weights: Array | None = None) -> CellNormals:
    def rows(values: Array) -> Array:
        return np.ascontiguousarray(np.c_[values, np.zeros(len(values))].T[:3])

    n = len(normals)
    ones = np.ones(n) if weights is None else weights
    return CellNormals(
        rows(normals), rows(anchors), np.full((n, 10), n, np.int32), ones, np.ones(n)
    )


def fit(
    normals: Array,
    anchors: Array,
    radii: tuple[float | Array, float | Array],
    points: Array | None = None,
    weights: Array | None = None,
) -> Array:
    cells = cell_normals(normals, anchors, weights)
    places = cell_normals(normals, anchors if points is None else points).anchors
    n, dimension = normals.shape
    return find_shape_operators(cells, places, np.arange(n), n, dimension, *radii)


def unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def scattered(dimension: int, seed: int) -> tuple[Array, Array, Array, Array]:
    """Normals, anchors, points and weights without order, no two anchors in one cluster."""
    rng = np.random.default_rng(seed)
    spread = [1.0] * (dimension - 1) + [0.1]
    anchors = np.empty((0, dimension))
    for candidate in rng.uniform(-3, 3, (1500, dimension)) * spread:
        if (
            len(anchors) == 0
            or np.linalg.norm(anchors - candidate, axis=1).min() > APART[dimension]
        ):
            anchors = np.r_[anchors, [candidate]]
    n = len(anchors)
    up = np.eye(dimension)[-1]
    normals = unit(up + 0.5 * rng.normal(size=(n, dimension)))
    normals[rng.random(n) < 0.2] *= -1
    return normals, anchors, anchors + 0.1 * rng.normal(size=anchors.shape), rng.uniform(0.2, 1, n)


def assert_same(actual: Array, expected: Array, rtol: float) -> None:
    """Compare estimates that end with the confidence, in which a root doubles the rounding."""
    oracles.assert_close(actual[:, :-1], expected[:, :-1], rtol)
    np.testing.assert_allclose(actual[:, -1], expected[:, -1], rtol=0, atol=1e-7)


def weighted(center: Array, anchors: Array, weights: Array, radius: float) -> Array:
    squares = ((anchors - center) ** 2).sum(axis=1)
    return np.asarray(weights * np.maximum(0, 1 - squares / radius**2))


def least_squares(
    normals: Array, anchors: Array, weights: Array, frame: Array
) -> tuple[Array, Array, float]:
    """Best affine map c + E x L of weighted normals: c, L (d - 1, d), variance that it leaves."""
    root = np.sqrt(weights)[:, np.newaxis]
    design = np.c_[np.ones(len(anchors)), anchors @ frame]
    solution = np.linalg.lstsq(root * design, root * normals, rcond=None)[0]
    rest = ((root * (design @ solution - normals)) ** 2).sum() / weights.sum()
    return solution[0], solution[1:], float(rest)


def tangents(normal: Array) -> Array:
    """Columns that span the tangent plane."""
    return np.asarray(np.linalg.svd(normal[np.newaxis])[2][1:].T)


def expected_estimates(
    normals: Array, anchors: Array, radii: tuple[float, float], points: Array, weights: Array
) -> tuple[Array, Array, Array]:
    """Normals, principal curvatures and confidences by numpy, and NaN for few points."""
    n, dimension = normals.shape
    fitted = np.full(normals.shape, np.nan)
    principal, confidence = np.full((n, dimension - 1), np.nan), np.full(n, np.nan)
    for i in range(n):
        alike = normals @ normals[i] > 0
        inner = weighted(anchors[i], anchors, weights * alike, radii[0])
        outer = weighted(anchors[i], anchors, weights * alike, radii[1])
        if min((inner > 0).sum(), (outer > 0).sum()) < dimension + 2:
            continue
        frame = tangents(normals[i])
        start, slope, _ = least_squares(normals, anchors, inner, frame)
        fitted[i] = unit((start + points[i] @ frame @ slope)[np.newaxis])[0]
        frame = tangents(fitted[i])
        _, slope, rest = least_squares(normals, anchors, outer, frame)
        operator = slope @ frame
        principal[i] = np.linalg.eigvalsh((operator + operator.T) / 2)[::-1]
        confidence[i] = max(0, 1 - np.sqrt(rest))
    return fitted, principal, confidence


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("radii", [(1.0, 1.0), (0.9, 1.0)])
def test_fit_is_that_of_weighted_least_squares(
    dimension: int, seed: int, radii: tuple[float, float]
) -> None:
    normals, anchors, points, weights = scattered(dimension, seed)
    if dimension == 2:  # there is room for few anchors along a line
        anchors, points = 0.6 * anchors, 0.6 * points
        keep = np.linalg.norm(anchors[:, np.newaxis] - anchors, axis=2)
        keep[np.diag_indices(len(keep))] = 1
        assert keep.min() > np.sqrt(2) / 4 * 0.6
        radii = (0.6 * radii[0], 0.6 * radii[1])
    expected = expected_estimates(normals, anchors, radii, points, weights)
    actual = fit(normals, anchors, radii, points, weights)
    known = np.isfinite(expected[2])
    assert known.sum() > 8
    np.testing.assert_allclose(actual[known, :dimension], expected[0][known], atol=1e-9)
    curvatures = actual[known, PRINCIPAL : PRINCIPAL + dimension - 1]
    size = np.abs(expected[1][known]).max()
    np.testing.assert_allclose(curvatures, expected[1][known], atol=1e-9 * size)
    np.testing.assert_allclose(actual[known, CONFIDENCE], expected[2][known], atol=1e-7)


@pytest.mark.parametrize("dimension", [2, 3])
def test_mean_and_gaussian_follow_from_the_principal_curvatures(dimension: int) -> None:
    normals, anchors, points, weights = scattered(dimension, 3)
    estimates = fit(normals, anchors, (1.0, 1.0), points, weights)
    first, second = estimates[:, PRINCIPAL], estimates[:, PRINCIPAL + 1]
    assert (first >= second).all()
    if dimension == 2:
        np.testing.assert_array_equal(estimates[:, [MEAN, GAUSSIAN]], np.c_[first, first])
    else:
        size = np.abs(first).max()
        oracles.assert_close(estimates[:, MEAN], (first + second) / 2, 1e-14, size)
        oracles.assert_close(estimates[:, GAUSSIAN], first * second, 1e-14, size**2)


@pytest.mark.parametrize("radius", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("extent", [0.4, 0.8, 5.0])
def test_spheres_are_exact_whatever_the_neighborhood(
    extent: float, dimension: int, radius: float
) -> None:
    """Normals are proportional to positions there."""
    points = oracles.random_sphere(3000, radius, 1, dimension)
    weights = np.random.default_rng(2).uniform(0.5, 2, 3000)
    estimates = fit(points / radius, points, (radius * extent / 2, radius * extent), None, weights)
    np.testing.assert_allclose(estimates[:, :dimension], points / radius, rtol=0, atol=1e-12)
    curvatures = estimates[:, PRINCIPAL : PRINCIPAL + dimension - 1] * radius
    np.testing.assert_allclose(curvatures, 1, rtol=1e-11)
    np.testing.assert_allclose(estimates[:, GAUSSIAN] * radius ** (dimension - 1), 1, rtol=1e-11)


def test_cylinders_are_exact_across_and_along() -> None:
    rng = np.random.default_rng(3)
    angle, height = rng.uniform(0, 2 * np.pi, 4000), rng.uniform(-1, 1, 4000)
    normals = np.c_[np.cos(angle), np.sin(angle), np.zeros(4000)]
    estimates = fit(normals, np.c_[normals[:, :2] / 2, height], (0.2, 0.3))
    np.testing.assert_allclose(estimates[:, PRINCIPAL], 2, rtol=1e-10)
    np.testing.assert_allclose(estimates[:, PRINCIPAL + 1 : MEAN], 0, atol=1e-10)
    np.testing.assert_allclose(estimates[:, GAUSSIAN], 0, atol=1e-10)


@pytest.mark.parametrize("scale", [1e-30, 1e-3, 7.0, 1e30])
def test_curvatures_scale_inversely(scale: float) -> None:
    normals, anchors, points, weights = scattered(3, 4)
    plain = fit(normals, anchors, (1.0, 1.0), points, weights)
    scaled = fit(normals, scale * anchors, (scale, scale), scale * points, scale**3 * weights)
    power = np.ones(N_ESTIMATES)
    power[[PRINCIPAL, PRINCIPAL + 1, MEAN]] = scale
    power[GAUSSIAN] = scale**2
    assert_same(scaled * power, plain, 1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("shift", "rtol"), [(0.0, 1e-11), (1e6, 1e-6)])
def test_motions_move_normals_and_keep_curvatures(
    dimension: int, shift: float, rtol: float
) -> None:
    normals, anchors, points, weights = scattered(dimension, 5)
    radii = (1.0, 1.0) if dimension == 3 else (0.99, 1.0)
    turn = oracles.random_rotation(dimension, np.random.default_rng(6))
    plain = fit(normals, anchors, radii, points, weights)
    moved = fit(normals @ turn.T, anchors @ turn.T + shift, radii, points @ turn.T + shift, weights)
    known = plain[:, CONFIDENCE] > 0
    oracles.assert_close(moved[known, :dimension], plain[known, :dimension] @ turn.T, rtol)
    for column in (PRINCIPAL, PRINCIPAL + dimension - 2, MEAN, GAUSSIAN):
        oracles.assert_close(moved[known, column], plain[known, column], 10 * rtol)
    np.testing.assert_allclose(moved[:, CONFIDENCE], plain[:, CONFIDENCE], atol=np.sqrt(rtol))


def test_a_mirror_keeps_curvatures_and_turned_normals_turn_their_signs() -> None:
    normals, anchors, points, weights = scattered(3, 7)
    plain = fit(normals, anchors, (1.0, 1.0), points, weights)
    mirror = np.array([-1.0, 1.0, 1.0])
    mirrored = fit(mirror * normals, mirror * anchors, (1.0, 1.0), mirror * points, weights)
    oracles.assert_close(mirrored[:, :3], mirror * plain[:, :3], 1e-12)
    assert_same(mirrored[:, PRINCIPAL:], plain[:, PRINCIPAL:], 1e-12)

    turned = fit(-normals, anchors, (1.0, 1.0), points, weights)
    oracles.assert_close(turned[:, :3], -plain[:, :3], 1e-12)
    signs = np.array([-1, -1, -1, 1, 1])
    order = [PRINCIPAL + 1, PRINCIPAL, MEAN, GAUSSIAN, CONFIDENCE]
    assert_same(turned[:, PRINCIPAL:], signs * plain[:, order], 1e-12)


def test_faces_of_a_thin_sheet_do_not_mix() -> None:
    """Both within one neighbourhood, and within one cell of clusters, each as if it were alone."""
    outer, inner = oracles.random_sphere(2000), oracles.random_sphere(2000, 0.95, 1)
    normals, anchors = np.r_[outer, -inner / 0.95], np.r_[outer, inner]
    both = fit(normals, anchors, (0.3, 0.4))
    np.testing.assert_allclose(both[:, :3], normals, atol=1e-12)
    np.testing.assert_allclose(both[:2000, MEAN], 1, rtol=1e-10)
    np.testing.assert_allclose(both[2000:, MEAN], -1 / 0.95, rtol=1e-10)


@pytest.mark.slow
def test_clusters_change_little() -> None:
    """Weights differ within a cluster from those of its centroid by a few percent."""
    surface = oracles.torus_surface(2000)
    points, normals = surface.points, surface.normals
    weights = np.ones(2000)
    expected = expected_estimates(normals, points, (0.3, 0.4), points, weights)
    actual = fit(normals, points, (0.3, 0.4))
    assert np.isfinite(expected[2]).all()
    assert oracles.degrees_between(actual[:, :3], expected[0]).max() < 1
    change = np.abs(actual[:, PRINCIPAL:MEAN] - expected[1])
    assert np.median(change) < 0.02
    assert change.max() < 0.3


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_thin_neighborhood_tells_nothing(dimension: int) -> None:
    """One point, or anchors in one place, or in 3D on one line."""
    up = np.eye(dimension)[-1]
    normals = np.tile(up, (9, 1))
    alone = 10.0 * np.arange(9)[:, np.newaxis] * np.eye(dimension)[0]
    places = [alone, 0.3 + np.zeros((9, dimension))]
    if dimension == 3:
        places.append(np.outer(np.linspace(-1, 1, 9), [0.6, 0.8, 0.0]))
    for anchors in places:
        estimates = fit(normals, anchors, (1.0, 1.0))
        np.testing.assert_allclose(estimates[:, :dimension], normals, atol=1e-14)
        assert not estimates[:, PRINCIPAL:].any()


def test_anchors_in_one_place_but_for_rounding_tell_nothing() -> None:
    """Each normal is near the others and none is turned by what is left of their distances."""
    rng = np.random.default_rng(8)
    for dimension in (2, 3):
        normals = unit(np.eye(dimension)[-1] + 1e-3 * rng.normal(size=(20, dimension)))
        anchors = 0.3 + 1e-16 * rng.normal(size=(20, dimension))
        estimates = fit(normals, anchors, (1.0, 1.0))
        assert (np.einsum("ij,ij->i", estimates[:, :dimension], normals) > 0.99).all()
        assert not estimates[:, PRINCIPAL:].any()


@pytest.mark.parametrize("dimension", [2, 3])
def test_each_point_has_a_radius_of_its_own(dimension: int) -> None:
    n = 4000 if dimension == 3 else 1500
    outward = oracles.random_sphere(n, dimension=dimension)
    stretched = outward * [1.5, 1.0, 1.2][:dimension]
    normals = unit(outward / [1.5, 1.0, 1.2][:dimension])
    radii = 0.1 * 3.0 ** (1.0 + stretched[:, 0] / 1.5)
    found = fit(normals, stretched, (0.7 * radii, radii))
    for i in range(0, n, n // 20):
        alone = fit(normals, stretched, (0.7 * radii[i], radii[i]))
        # Clusters are others; they matter little.
        np.testing.assert_allclose(found[i, :dimension], alone[i, :dimension], atol=5e-3)
        np.testing.assert_allclose(found[i, MEAN], alone[i, MEAN], rtol=0.03)


def test_radii_of_their_own_do_not_matter_on_a_sphere() -> None:
    outward = oracles.random_sphere(3000)
    radii = 0.2 * 2.0 ** (outward[:, 2] + np.random.default_rng(5).random(3000))
    found = fit(outward, outward, (radii, radii))
    np.testing.assert_allclose(found[:, MEAN], 1.0, rtol=1e-9)
    np.testing.assert_allclose(found[:, :3], outward, atol=1e-9)


def test_rows_go_where_their_numbers_say() -> None:
    normals, anchors, _, _ = scattered(3, 9)
    numbers = np.random.default_rng(9).permutation(2 * len(normals))[: len(normals)]
    cells = cell_normals(normals, anchors)
    spread = find_shape_operators(cells, cells.anchors, numbers, 2 * len(normals), 3, 1.0, 1.0)
    expected = np.zeros_like(spread)
    expected[numbers] = fit(normals, anchors, (1.0, 1.0))
    np.testing.assert_array_equal(spread, expected)


def test_estimates_do_not_depend_on_threads() -> None:
    surface = oracles.torus_surface(5000)
    results = []
    for threads in (1, 2):
        with thread_limit(threads):
            results.append(fit(surface.normals, surface.points, (0.2, 0.3)).tobytes())
    assert results[0] == results[1]


def test_weights_count_as_points() -> None:
    """A point of twice the weight is as good as two."""
    surface = oracles.torus_surface(400)
    of = np.r_[np.arange(400), np.arange(0, 400, 3)]
    weights = 1.0 + (np.arange(400) % 3 == 0)
    repeated = fit(surface.normals[of], surface.points[of], (0.5, 0.7))
    heavier = fit(surface.normals, surface.points, (0.5, 0.7), None, weights)
    assert_same(repeated[:400], heavier, 1e-11)
    assert not np.allclose(heavier, fit(surface.normals, surface.points, (0.5, 0.7)), atol=1e-3)
