from __future__ import annotations

from dataclasses import fields
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

import oracles
from curvature.found import find
from oracles import Array, Surface, degrees_between
from pcsmooth.curvature.estimate import CurvatureEstimate
from pcsmooth.errors import InvalidInputError
from pcsmooth.python.denoising import denoise
from pcsmooth.python.estimating import estimate_curvature

#: Estimates of the points.
ROWS = (
    "normals",
    "mean_curvature",
    "gaussian_curvature",
    "principal_curvatures",
    "confidence",
)


def assert_identical(actual: CurvatureEstimate, expected: CurvatureEstimate) -> None:
    for field in fields(CurvatureEstimate):
        one, other = getattr(actual, field.name), getattr(expected, field.name)
        if isinstance(one, np.ndarray):
            assert one.tobytes() == other.tobytes(), field.name
        else:
            assert one == other, field.name


def plane(n: int = 1000) -> Array:
    return np.asarray(np.c_[oracles.uniform_cloud(n, 2), np.zeros(n)])


# --- accuracy -------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [0.5, 1.0, 2.0])
@pytest.mark.parametrize(
    ("sample", "median", "largest", "angle"),
    [(oracles.even_sphere, 1e-3, 1.5e-2, 0.1), (oracles.random_sphere, 2e-3, 1e-2, 0.4)],
)
def test_sphere_bends_by_one_over_its_radius(
    sample: Any, median: float, largest: float, angle: float, radius: float
) -> None:
    points = sample(10_000, radius)
    estimate = estimate_curvature(points)
    errors = abs(estimate.mean_curvature * radius - 1)
    assert np.median(errors) < median
    assert errors.max() < largest
    assert np.median(abs(estimate.gaussian_curvature * radius**2 - 1)) < 2 * median
    assert np.median(abs(estimate.principal_curvatures * radius - 1)) < 2 * median
    assert degrees_between(estimate.normals, points / radius).max() < angle
    np.testing.assert_allclose(np.linalg.norm(estimate.normals, axis=1), 1, rtol=1e-14)
    assert estimate.orientation == {"outward": 1}


@pytest.mark.parametrize("radius", [0.5, 1.0, 2.0])
def test_circle_bends_by_one_over_its_radius(radius: float) -> None:
    points = oracles.even_circle(500, radius)
    estimate = estimate_curvature(points)
    np.testing.assert_allclose(estimate.mean_curvature, 1 / radius, rtol=1e-12)
    np.testing.assert_allclose(estimate.normals, points / radius, atol=1e-12)
    np.testing.assert_array_equal(estimate.gaussian_curvature, estimate.mean_curvature)
    np.testing.assert_array_equal(estimate.principal_curvatures[:, 0], estimate.mean_curvature)


def test_ellipse_bends_everywhere_as_the_closed_form_says() -> None:
    t = 2 * np.pi * np.arange(200) / 200
    estimate = estimate_curvature(np.c_[180 * np.cos(t), 120 * np.sin(t)], radius=15)
    slope = (180 * np.sin(t)) ** 2 + (120 * np.cos(t)) ** 2
    np.testing.assert_allclose(estimate.mean_curvature, 180 * 120 / slope**1.5, rtol=0.02)
    normals = np.c_[120 * np.cos(t), 180 * np.sin(t)] / np.sqrt(slope)[:, np.newaxis]
    assert degrees_between(estimate.normals, normals).max() < 0.5


@pytest.mark.parametrize("radius", ["widest gap", "8x"])
def test_a_random_circle_is_of_one_piece(radius: str) -> None:
    """Its gaps are within reach: one sign for all, outward."""
    points = oracles.random_sphere(4000, dimension=2)
    gaps = np.diff(np.sort(np.arctan2(points[:, 1], points[:, 0])))
    estimate = estimate_curvature(points, radius=max(gaps) if radius == "widest gap" else radius)
    assert set(estimate.orientation) == {"outward"}
    assert (np.einsum("ij,ij->i", estimate.normals, points) > 0).mean() > 0.99


@cache
def torus() -> Surface:
    return oracles.torus_surface(20_000)


@cache
def on_torus(noise: float, support: int | None = None) -> CurvatureEstimate:
    return estimate_curvature(torus().noisy(noise), support=support or "auto")


def angle_of(normals: Array) -> float:
    return float(np.median(degrees_between(normals, torus().normals)))


@pytest.mark.parametrize(("noise", "angle"), [(0.0, 0.25), (0.1, 0.5), (0.3, 1.2), (0.7, 2.8)])
def test_normals_of_a_torus_from_thirty_points(noise: float, angle: float) -> None:
    normals = on_torus(noise, 30).normals
    points = torus().noisy(noise)
    assert angle_of(normals) < angle
    near = points[cKDTree(points).query(points, 30)[1]]
    near -= near.mean(axis=1, keepdims=True)
    planes = np.linalg.eigh(near.transpose(0, 2, 1) @ near)[1][:, :, 0]
    planes *= np.sign(np.einsum("ij,ij->i", planes, torus().normals))[:, np.newaxis]
    assert angle_of(normals) < angle_of(planes)


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.3, 0.7])
def test_the_chosen_support_makes_better_normals_than_thirty_points(noise: float) -> None:
    found = find(torus().noisy(noise), 2 * torus().spacing, 30)
    cell_normals = np.empty((len(found.order), 3))
    cell_normals[found.order] = found.cells.normals.T
    cell_normals *= np.sign(np.einsum("ij,ij->i", cell_normals, torus().normals))[:, np.newaxis]
    chosen = angle_of(on_torus(noise).normals)
    assert chosen < angle_of(cell_normals)
    if noise > 0:  # without noise thirty points are the best support too
        assert chosen < angle_of(on_torus(noise, 30).normals)


@pytest.mark.parametrize(("noise", "error"), [(0.0, 0.01), (0.1, 0.015), (0.3, 0.025), (0.7, 0.04)])
def test_curvatures_of_a_torus(noise: float, error: float) -> None:
    estimate = on_torus(noise)
    assert np.median(abs(estimate.mean_curvature / torus().mean - 1)) < error
    outer = np.abs(torus().gaussian) > 0.5
    gaussian = estimate.gaussian_curvature[outer] / torus().gaussian[outer]
    assert np.median(abs(gaussian - 1)) < 3 * error
    first, second = estimate.principal_curvatures.T
    assert np.median(abs(first / 2.5 - 1)) < 2 * error
    assert (first >= second).all()
    oracles.assert_close(first * second, estimate.gaussian_curvature, 1e-12)
    oracles.assert_close((first + second) / 2, estimate.mean_curvature, 1e-12)
    vectors = estimate.mean_curvature[:, np.newaxis] * estimate.normals
    np.testing.assert_array_equal(estimate.mean_curvature_vectors, vectors)


def test_waves_look_up_and_bend_both_ways() -> None:
    surface = oracles.waves_surface(20_000)
    inside = np.abs(surface.points[:, :2]).max(axis=1) < 0.85
    estimate = estimate_curvature(surface.points)
    assert estimate.orientation == {"axis": 1}
    assert degrees_between(estimate.normals, surface.normals)[inside].max() < 5
    error = np.abs(estimate.mean_curvature - surface.mean)[inside]
    assert np.median(error) < 0.03 * np.abs(surface.mean).max()
    down = estimate_curvature(surface.points, orient="direction=0,0,-1")
    np.testing.assert_allclose(down.mean_curvature, -estimate.mean_curvature, atol=1e-9)
    np.testing.assert_allclose(down.gaussian_curvature, estimate.gaussian_curvature, atol=1e-7)


@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_plane_does_not_bend(tilt: float) -> None:
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    estimate = estimate_curvature(plane() @ turn.T, radius=0.07)
    expected = np.broadcast_to(turn[:, 2], estimate.normals.shape)
    np.testing.assert_allclose(estimate.normals, expected, atol=1e-12)
    for name in ("mean_curvature", "gaussian_curvature", "principal_curvatures"):
        np.testing.assert_allclose(getattr(estimate, name), 0, atol=1e-11)
    np.testing.assert_allclose(estimate.confidence, 1, atol=1e-6)


def rounded_disc(n: int, half: float) -> tuple[Array, Array, Array]:
    """Two flat unit discs, 2 half apart, joined by half a torus; mean curvatures."""
    rng = np.random.default_rng(0)
    rim_area = 2 * np.pi * half * (np.pi + 2 * half)
    on_rim = int(n * rim_area / (rim_area + 2 * np.pi))
    angle, tilt = rng.uniform(0, 2 * np.pi, n), rng.uniform(-np.pi / 2, np.pi / 2, 4 * on_rim)
    kept = rng.random(len(tilt)) < (1 + half * np.cos(tilt)) / (1 + half)
    tilt = tilt[kept][:on_rim]
    assert len(tilt) == on_rim
    out = np.c_[np.cos(angle), np.sin(angle)]
    flat = n - on_rim
    up = rng.choice([-1.0, 1.0], flat)
    disc = np.c_[np.sqrt(rng.random(flat))[:, np.newaxis] * out[on_rim:], half * up]
    normals = np.c_[out[:on_rim] * np.cos(tilt)[:, np.newaxis], np.sin(tilt)]
    rim = np.c_[out[:on_rim], np.zeros(on_rim)] + half * normals
    bend = 1 / half + np.cos(tilt) / (1 + half * np.cos(tilt))
    return (
        np.r_[rim, disc],
        np.r_[normals, np.c_[np.zeros((flat, 2)), up]],
        np.r_[bend / 2, np.zeros(flat)],
    )


@pytest.mark.parametrize("support", [120, 960])
def test_faces_of_a_thin_plate_do_not_mix(support: int) -> None:
    """Farther from each other than the balls' radius, and nearer than the neighbourhood's."""
    points, normals, _ = rounded_disc(20_000, 0.08)
    estimate = estimate_curvature(points, support=support)
    assert estimate.radius < 0.16
    inside = np.hypot(points[:, 0], points[:, 1]) < 0.5
    np.testing.assert_allclose(estimate.normals[inside], normals[inside], atol=1e-9)
    np.testing.assert_allclose(estimate.mean_curvature[inside], 0, atol=1e-9)


def test_confidence_is_low_at_edges() -> None:
    faces = oracles.uniform_cloud(19_998, 2).reshape(2, 3, -1, 2)
    cube = np.concatenate(
        [
            np.insert(face, axis, side, axis=1)
            for side in (0, 1)
            for axis, face in enumerate(faces[side])
        ]
    )
    from_faces = np.sort(np.minimum(cube, 1 - cube), axis=1)
    estimate = estimate_curvature(cube, support=60)
    at_edge, inside = from_faces[:, 1] < 0.02, from_faces[:, 1] > 0.2
    assert estimate.confidence[inside].min() > 0.99
    assert np.median(estimate.confidence[at_edge]) < 0.85
    assert (estimate.confidence >= 0).all()
    assert (estimate.confidence <= 1).all()


@pytest.mark.slow
def test_noise_lowers_the_confidence() -> None:
    medians = [np.median(on_torus(noise, 120).confidence) for noise in (0.0, 0.1, 0.3, 0.7)]
    assert (np.diff(medians) < 0).all()


# --- what does not matter -------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("support", ["auto", 12])
@pytest.mark.parametrize("estimator", ["cells", "gradient"])
def test_threads_do_not_matter(dimension: int, support: Any, estimator: Any) -> None:
    points = oracles.random_sphere(6000, dimension=dimension)
    points *= np.random.default_rng(1).normal(1, 0.01, size=(6000, 1))
    one, two = (
        estimate_curvature(points, support=support, estimator=estimator, threads=threads)
        for threads in (1, 2)
    )
    assert_identical(one, two)


@pytest.mark.parametrize("orient", ["auto", "viewpoint"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_map_coordinates_do_not_matter(dimension: int, orient: str) -> None:
    points = np.round(oracles.random_sphere(3000, dimension=dimension) * 2**20) / 2**20
    offset = np.array([2.0**19, 2.0**22, -(2.0**21)])[:dimension]

    def rule(center: Array) -> str:
        return orient if orient == "auto" else "viewpoint=" + ",".join(map(str, center + 0.125))

    def estimate(by: Array) -> CurvatureEstimate:
        return estimate_curvature(points + by, radius="6x", orient=rule(by))

    home, far, farther = estimate(0 * offset), estimate(offset), estimate(2 * offset)
    assert_identical(far, farther)
    assert home.orientation == far.orientation
    for name in ROWS:
        np.testing.assert_allclose(getattr(far, name), getattr(home, name), atol=1e-7)
    if orient == "viewpoint":
        assert (np.einsum("ij,ij->i", far.normals, points) < 0).mean() > 0.99


@pytest.mark.parametrize("scale", [1e-30, 3.7, 1e30])
def test_units_do_not_matter(scale: float) -> None:
    surface = oracles.torus_surface(2000)
    home, scaled = (estimate_curvature(surface.noisy(0.2) * by) for by in (1.0, scale))
    np.testing.assert_allclose(scaled.normals, home.normals, atol=1e-9)
    oracles.assert_close(scaled.mean_curvature * scale, home.mean_curvature, 1e-9)
    oracles.assert_close(scaled.principal_curvatures * scale, home.principal_curvatures, 1e-9)
    oracles.assert_close(scaled.gaussian_curvature * scale * scale, home.gaussian_curvature, 1e-9)
    np.testing.assert_allclose(scaled.confidence, home.confidence, atol=1e-7)


def test_motions_turn_the_normals() -> None:
    """Up to the clusters, which lie along the axes."""
    surface = oracles.torus_surface(5000)
    turn = oracles.random_rotation(3, np.random.default_rng(3))
    mirror = np.diag([-1.0, 1.0, 1.0])
    home = estimate_curvature(surface.points)
    for motion in (turn, mirror, turn @ mirror):
        moved = estimate_curvature(surface.points @ motion.T + [5.0, -7.0, 2.0])
        assert degrees_between(moved.normals, home.normals @ motion.T).max() < 3
        assert np.median(abs(moved.mean_curvature - home.mean_curvature)) < 0.01


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("estimator", ["cells", "gradient"])
def test_rows_that_are_not_finite_do_not_matter(dimension: int, estimator: Any) -> None:
    points = oracles.random_sphere(400, dimension=dimension)
    bad = np.ones((4, dimension))
    bad[0, 0], bad[1, 1], bad[2, 0], bad[3, 1] = np.nan, np.inf, -np.inf, 1e200
    mixed = np.insert(points, [0, 100, 200, 400], bad, axis=0)
    given = np.insert(-points, [0, 100, 200, 400], np.ones((4, dimension)), axis=0)
    finite = np.abs(np.nan_to_num(mixed, nan=1e300)).max(axis=1) < 2
    estimate = estimate_curvature(mixed, normals=given, estimator=estimator)
    expected = estimate_curvature(points, normals=-points, estimator=estimator)
    np.testing.assert_array_equal(estimate.finite, finite)
    assert expected.finite.all()
    for name in ROWS:
        assert not getattr(estimate, name)[~finite].any()
        assert getattr(estimate, name)[finite].tobytes() == getattr(expected, name).tobytes()
    for name in ("radius", "spacing", "normal_support", "curvature_support", "orientation"):
        assert getattr(estimate, name) == getattr(expected, name)


def test_points_are_left_alone() -> None:
    points = oracles.random_sphere(300) + 100
    before = points.copy()
    given = before.copy()
    given[3] = np.nan
    kept = given.copy()
    estimate_curvature(points, normals=given)
    np.testing.assert_array_equal(points, before)
    np.testing.assert_array_equal(given, kept)


@pytest.mark.parametrize("radius", [0.3, "auto"])
def test_coincident_points_share_their_estimates(radius: float | str) -> None:
    points = oracles.random_sphere(500)
    of = np.r_[np.arange(500), np.random.default_rng(3).integers(0, 500, 200)]
    alone, repeated = (estimate_curvature(cloud, radius=radius) for cloud in (points, points[of]))
    for name in ROWS:
        values = getattr(repeated, name)
        np.testing.assert_array_equal(values[500:], values[of[500:]])
        np.testing.assert_allclose(values, getattr(alone, name)[of], rtol=0, atol=1e-6)


# --- few points and special places ----------------------------------------------------------


@pytest.mark.parametrize("support", ["auto", 3, 30])
@pytest.mark.parametrize("dimension", [2, 3])
def test_nothing_is_known_at_an_isolated_point(dimension: int, support: Any) -> None:
    circle = np.c_[oracles.even_circle(100), np.zeros(100)][:, :dimension]
    far = np.full((1, dimension), 5.0)
    estimate = estimate_curvature(np.r_[circle, far], radius=0.1, support=support)
    for name in ROWS:
        assert not getattr(estimate, name)[-1].any()
    np.testing.assert_allclose(np.linalg.norm(estimate.normals[:-1], axis=1), 1, rtol=1e-14)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("n", [1, 4])
def test_one_place_has_no_normal(n: int, dimension: int) -> None:
    estimate = estimate_curvature(np.ones((n, dimension)), radius=1.0)
    for name in ROWS:
        assert not getattr(estimate, name).any()
    assert estimate.spacing == 0


@pytest.mark.parametrize("support", ["auto", 3, 30])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("dimension", [2, 3])
def test_two_points_lie_on_a_line(dimension: int, scale: float, support: Any) -> None:
    points = scale * np.array([[1.0, 0.3, 0.1], [0.2, 1.1, -0.4]])[:, :dimension]
    estimate = estimate_curvature(points, support=support)
    np.testing.assert_allclose(np.linalg.norm(estimate.normals, axis=1), 1, rtol=1e-14)
    np.testing.assert_allclose(estimate.normals @ (points[1] - points[0]) / scale, 0, atol=1e-7)
    np.testing.assert_allclose(estimate.normals[0], estimate.normals[1], atol=1e-9)
    assert not estimate.mean_curvature.any()


@pytest.mark.parametrize("support", ["auto", 3, 30])
@pytest.mark.parametrize("n", [3, 10, 29])
def test_few_points_of_a_plane_agree(n: int, support: Any) -> None:
    """Their neighbourhoods are all the same, and so are their anchors but for rounding."""
    turn = oracles.random_rotation(3, np.random.default_rng(n))
    points = np.c_[oracles.uniform_cloud(n, 2, n), np.zeros(n)] @ turn.T
    estimate = estimate_curvature(points, support=support)
    expected = turn[:, 2] * np.sign(estimate.normals[0] @ turn[:, 2])
    np.testing.assert_allclose(estimate.normals, np.tile(expected, (n, 1)), atol=1e-7)
    np.testing.assert_allclose(estimate.mean_curvature, 0, atol=1e-6)


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.3, -0.5, 0.8)])
@pytest.mark.parametrize("n", [3, 10, 60])
def test_a_line_in_space_has_normals_and_no_curvature(
    n: int, direction: tuple[float, float, float]
) -> None:
    """Any direction across it may be normal; how the normals turn across it is unknown."""
    points = np.outer(np.sort(oracles.uniform_cloud(n, 2)[:, 0]), direction)
    estimate = estimate_curvature(points)
    np.testing.assert_allclose(estimate.normals @ np.array(direction), 0, atol=1e-7)
    np.testing.assert_allclose(np.linalg.norm(estimate.normals, axis=1), 1, rtol=1e-14)
    for name in ROWS[1:]:
        assert not getattr(estimate, name).any()


def test_a_line_in_the_plane_does_not_bend() -> None:
    points = np.outer(np.arange(50.0), [3.0, 4.0])
    estimate = estimate_curvature(points)
    np.testing.assert_allclose(estimate.normals, np.tile([0.8, -0.6], (50, 1)), atol=1e-12)
    np.testing.assert_allclose(estimate.mean_curvature, 0, atol=1e-12)
    np.testing.assert_allclose(estimate.confidence, 1, atol=1e-6)


@pytest.mark.parametrize("counts", [(30, 30), (25, 20, 1), (10, 10, 10)])
def test_exact_grids_have_estimates(counts: tuple[int, ...]) -> None:
    points = oracles.lattice(*counts)
    estimate = estimate_curvature(points)
    for name in ROWS:
        assert np.isfinite(getattr(estimate, name)).all()
    if counts[-1] == 1:
        np.testing.assert_array_equal(estimate.normals, np.tile([0.0, 0.0, 1.0], (500, 1)))
        assert not estimate.mean_curvature.any()
        return
    middles = (np.array(counts) - 1) / 2
    for axis in range(len(counts)):
        side = np.abs(np.delete(points - middles, axis, axis=1)).max(axis=1) < 2
        for end, sign in ((0, -1), (counts[axis] - 1, 1)):
            there = side & (points[:, axis] == end)
            assert (sign * estimate.normals[there, axis] > 0.9).all()


@pytest.mark.parametrize("counts", [(14, 14), (14, 14, 14)])
def test_nothing_is_known_where_nothing_is_visible(counts: tuple[int, ...]) -> None:
    points = oracles.lattice(*counts)
    estimate = estimate_curvature(points, radius=1.5, support=10)
    deep = ((points > 4) & (points < 9)).all(axis=1)
    for name in ROWS:
        assert not getattr(estimate, name)[deep].any()


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("support", ["auto", 3, 12])
@pytest.mark.parametrize("name", ["volume", "clusters", "pairs"])
def test_estimates_are_finite_whatever_the_cloud(name: str, support: Any, dimension: int) -> None:
    points = oracles.uniform_cloud(600, dimension)
    if name != "volume":
        size = 10 if name == "clusters" else 2
        points = np.repeat(100 * points[::size], size, axis=0)[:600] + 0.01 * points
    estimate = estimate_curvature(points, radius=0.1, support=support)
    for row in ROWS:
        assert np.isfinite(getattr(estimate, row)).all()
    lengths = np.linalg.norm(estimate.normals, axis=1)
    assert (np.abs(lengths - 1) < 1e-12).sum() + (lengths == 0).sum() == 600
    known = lengths > 0
    assert not estimate.confidence[~known].any()
    assert (estimate.confidence >= 0).all()
    assert (estimate.confidence <= 1).all()


# --- options --------------------------------------------------------------------------------


@pytest.mark.parametrize("support", [3, 8, 30, 200, 100_000])
def test_a_support_may_be_any_number_of_points(support: int) -> None:
    points = oracles.even_sphere(3000)
    estimate = estimate_curvature(points, support=support)
    assert estimate.normal_support == pytest.approx(min(support, 3000))
    assert estimate.curvature_support == pytest.approx(min(support, 3000))
    assert estimate.orientation == {"outward": 1}
    if support > 3:  # so few are often thin
        error = np.median(abs(estimate.mean_curvature - 1))
        assert error < (0.05 if support < 30 else 0.005)
    same = estimate_curvature(points, support=np.int32(support))  # type: ignore[arg-type]
    assert_identical(same, estimate)


def test_signs_follow_the_rule() -> None:
    sphere = oracles.random_sphere(1000)
    given = -sphere
    given[:300] = 0
    given[300:400] = np.nan
    for options, sign in (
        ({}, 1),
        ({"orient": "outward", "normals": given}, 1),
        ({"normals": given}, -1),
        ({"orient": "input", "normals": given}, -1),
        ({"orient": "viewpoint=0,0.1,0"}, -1),
        ({"orient": "propagate"}, 1),
    ):
        estimate = estimate_curvature(sphere, **options)
        assert (sign * np.einsum("ij,ij->i", estimate.normals, sphere) > 0.9).all()
        assert (sign * estimate.mean_curvature > 0).all()
        assert (estimate.gaussian_curvature > 0).all()
        assert (sign * estimate.principal_curvatures > 0).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"estimator": "jets"}, "estimator is 'jets'"),
        ({"estimator": None}, "estimator is None"),
        ({"energy": "length"}, "energy is 'length'"),
        ({"support": 2}, "support is 2"),
        ({"support": 2.5}, "support is 2.5"),
        ({"support": 30.0}, "support is 30.0"),
        ({"support": True}, "support is True"),
        ({"support": "x"}, "support is 'x'"),
        ({"support": None}, "support is None"),
        ({"radius": 0}, "radius"),
        ({"radius": -1.0}, "radius"),
        ({"radius": "wide"}, "radius"),
        ({"radius": float("nan")}, "radius"),
        ({"orient": "up"}, "orientation is 'up'"),
        ({"orient": "input"}, "the input has no normals"),
        ({"orient": "viewpoint=1,2"}, "2 coordinates and the points 3"),
        ({"orient": "direction=1,2"}, "2 coordinates and the points 3"),
        ({"normals": np.ones((5, 3))}, "normals have shape"),
        ({"normals": np.ones((300, 2))}, "normals have shape"),
        ({"normals": [["a"] * 3] * 300}, "normals"),
    ],
)
def test_wrong_options_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        estimate_curvature(oracles.random_sphere(300), **options)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.empty((0, 3)), "no point with finite coordinates"),
        (np.full((3, 2), np.nan), "no point with finite coordinates"),
        (np.ones((3, 3)), "all points are at one place, which has no spacing"),
        (np.ones((3, 4)), "shape"),
        ([1.0, 2.0], "shape"),
        (["text"], "numbers"),
    ],
)
def test_wrong_points_are_refused(points: Any, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        estimate_curvature(points)


# --- after denoising ------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("options", [{"support": 40}, {"support": 30, "orient": "propagate"}])
@pytest.mark.parametrize("moving", [{"scheme": "filter"}, {"scheme": "euler", "iterations": 2}])
def test_points_that_did_not_move_get_the_estimates_of_their_places(
    dimension: int, options: dict[str, Any], moving: dict[str, Any]
) -> None:
    points = oracles.random_sphere(1500, dimension=dimension)
    result = denoise(points, radius="4x", fixed=np.ones(1500), **moving, **options)
    expected = estimate_curvature(points, radius="4x", **options)
    for name in (*ROWS, "finite"):
        assert getattr(result.curvature, name).tobytes() == getattr(expected, name).tobytes()
    for name in ("radius", "normal_support", "curvature_support", "orientation"):
        assert getattr(result.curvature, name) == getattr(expected, name)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("options", [{}, {"support": 40}, {"orient": "propagate"}])
@pytest.mark.parametrize("moving", [{"scheme": "filter"}, {"scheme": "euler", "iterations": 2}])
def test_denoised_points_get_the_estimates_of_their_places(
    dimension: int, options: dict[str, Any], moving: dict[str, Any]
) -> None:
    points = oracles.random_sphere(1500, dimension=dimension)
    points *= np.random.default_rng(2).normal(1, 0.01, size=(1500, 1))
    result = denoise(points, radius="4x", **moving, **options)
    expected = estimate_curvature(result.points, radius=result.radius, **options)
    # Supports come from samples, which are other ones along the curve through the new places.
    for name in ("normal_support", "curvature_support"):
        assert getattr(result.curvature, name) == pytest.approx(getattr(expected, name), rel=0.1)
    turned = np.linalg.norm(result.curvature.normals - expected.normals, axis=1)
    assert np.median(turned) < 2e-3
    np.testing.assert_array_equal(result.curvature.finite, expected.finite)
    assert result.curvature.radius == expected.radius
    assert result.curvature.orientation == expected.orientation
    assert result.curvature.spacing == result.spacing
    assert result.normals is result.curvature.normals
    assert result.mean_curvature is result.curvature.mean_curvature
