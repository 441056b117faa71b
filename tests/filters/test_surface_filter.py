from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import oracles
from filters.whole import filter_whole, plan_of
from oracles import Array
from pcsmooth.filters.design import DESIGN
from pcsmooth.filters.neighborhoods import Neighborhoods, find_neighborhoods
from pcsmooth.filters.outliers import OutlierCandidates
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.progress import Progress


def filtered(points: Array, plan: FilterPlan | None = None, *, redistribute: bool = True) -> Array:
    points = np.ascontiguousarray(points)
    return filter_whole(points, plan or plan_of(points), redistribute=redistribute).points


def noisy(dimension: int, n: int = 500) -> Array:
    """A noisy torus, or ellipse."""
    if dimension == 3:
        return oracles.torus_surface(n).noisy(0.4)
    rng = np.random.default_rng(0)
    angles = rng.uniform(0, 2 * np.pi, n)
    clean = np.c_[1.5 * np.cos(angles), np.sin(angles)]
    return np.asarray(clean + 2e-3 * rng.normal(size=(n, 2)))


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize(("noise", "left"), [(0.1, 0.4), (0.36, 0.25), (1.42, 0.2)])
def test_most_of_the_noise_of_a_torus_goes(noise: float, left: float) -> None:
    surface = oracles.torus_surface(10_000)
    points = surface.noisy(noise)
    after = rms(oracles.distance_to_torus(filtered(points)))
    assert after < left * rms(oracles.distance_to_torus(points))


@pytest.mark.parametrize("noise", [0.3, 0.7, 1.5])
@pytest.mark.parametrize(("shape", "left"), [("circle", 0.5), ("square", 0.7)])
def test_curves_lose_noise(shape: str, left: float, noise: float) -> None:
    n = 400
    rng = np.random.default_rng(0)
    places = rng.random(n)
    if shape == "circle":
        clean = np.c_[np.cos(2 * np.pi * places), np.sin(2 * np.pi * places)]
        deviation = noise * 2 * np.pi / n
    else:
        side, along = np.divmod(8 * places, 2)
        corner = np.exp(0.5j * np.pi * side)
        outline = corner * (1 - 1j + 1j * along)
        clean = np.c_[outline.real, outline.imag]
        deviation = noise * 8 / n

    def distances(points: Array) -> Array:
        if shape == "circle":
            return np.asarray(np.linalg.norm(points, axis=1) - 1)
        beyond = np.abs(points) - 1
        outside = np.linalg.norm(np.maximum(beyond, 0), axis=1)
        return np.asarray(np.where(outside > 0, outside, beyond.max(axis=1)))

    points = clean + deviation * rng.normal(size=(n, 2))
    assert rms(distances(filtered(points))) < left * rms(distances(points))


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_sphere_without_noise_hardly_shrinks(dimension: int) -> None:
    """Even when told of noise: what is left of averaging is of fourth order in the radius."""
    n = 500 if dimension == 2 else 5000
    points = oracles.even_circle(n) if dimension == 2 else oracles.even_sphere(n)
    spacing = (oracles.sphere_area(1, dimension) / n) ** (1 / (dimension - 1))
    after = np.linalg.norm(filtered(points, plan_of(points, 0.3 * spacing)), axis=1)
    assert abs(after.mean() - 1) < 0.01 * spacing
    assert np.abs(after - 1).max() < 0.1 * spacing


@pytest.mark.parametrize(("dimension", "n", "runs", "most"), [(2, 600, 4, 1.4), (3, 2400, 1, 1.1)])
def test_edges_sparser_than_their_noise_are_not_harmed(
    dimension: int, n: int, runs: int, most: float
) -> None:
    """A cube, or square, with a spacing of 12 noises. Edges whole moves would harm by 2 to 3."""
    noise = (8 / n if dimension == 2 else np.sqrt(24 / n)) / 12

    def distances(points: Array) -> Array:
        beyond = np.abs(points) - 1
        outside = np.linalg.norm(np.maximum(beyond, 0), axis=1)
        return np.asarray(np.where(outside > 0, outside, np.abs(beyond.max(axis=1))))

    errors = []
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        clean = rng.uniform(-1, 1, (n, dimension))
        side = np.arange(n) % (2 * dimension)
        clean[np.arange(n), side // 2] = np.where(side % 2, 1.0, -1.0)
        points = clean + noise * rng.normal(size=clean.shape)
        is_edge = np.sort(np.abs(clean), axis=1)[:, -2] > 1 - 12 * noise
        after = distances(filtered(points, plan_of(points, noise)))
        errors.append(np.stack([is_edge, distances(points), after]))
    is_edge, before, after = np.concatenate(errors, axis=1)
    at_edge = is_edge > 0
    assert rms(after[at_edge]) <= most * rms(before[at_edge])
    assert rms(after[~at_edge]) < 0.7 * rms(before[~at_edge])


@pytest.mark.parametrize("dimension", [2, 3])
def test_without_noise_nothing_moves(dimension: int) -> None:
    points = noisy(dimension)
    np.testing.assert_array_equal(filtered(points, plan_of(points, 0.0)), points)
    flat = oracles.lattice(20, 20)
    grid = np.c_[flat, np.zeros(400)]
    np.testing.assert_array_equal(filtered(grid), grid)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 6, 12, 13, 20])
@pytest.mark.parametrize("dimension", [2, 3])
def test_few_points_stay_within_the_limits(n: int, dimension: int) -> None:
    points = np.random.default_rng(n).normal(size=(n, dimension))
    for noise in (None, 0.01):
        plan = plan_of(points, noise)
        after = filtered(points, plan)
        assert np.isfinite(after).all()
        if plan is None:
            np.testing.assert_array_equal(after, points)
        else:  # three passes, redistribution, last step
            limit = (4 * 4 + 1) * plan.noise.deviation
            assert np.linalg.norm(after - points, axis=1).max(initial=0.0) <= limit


def test_fixed_points_stay_and_act() -> None:
    points = noisy(3)
    plan = plan_of(points)
    fixed = np.arange(len(points)) % 3 == 0
    after = filter_whole(points, plan, fixed).points
    np.testing.assert_array_equal(after[fixed], points[fixed])
    free = np.ascontiguousarray(points[~fixed])
    without = filter_whole(free, plan).points
    assert np.abs(after[~fixed] - without).max() > 0.01


def test_outliers_stay_and_do_not_act() -> None:
    points = noisy(3)
    plan = plan_of(points)
    stray = np.r_[points, [[0.0, 0.0, 0.0]]]
    found = filter_whole(stray, plan)
    np.testing.assert_array_equal(np.flatnonzero(found.outliers), [len(points)])
    np.testing.assert_array_equal(found.points[-1], 0)
    np.testing.assert_allclose(found.points[:-1], filtered(points, plan), atol=1e-13)


def test_borders_stay_within_the_noise() -> None:
    rng = np.random.default_rng(0)
    angles, radii = rng.uniform(0, 2 * np.pi, 5000), np.sqrt(rng.random(5000))
    noise = 0.5 * np.sqrt(np.pi / 5000)
    disc = np.c_[radii * np.cos(angles), radii * np.sin(angles), noise * rng.normal(size=5000)]
    after = filtered(disc)
    outmost = radii > 1 - 2 * noise
    creep = np.linalg.norm(after[outmost, :2], axis=1) - radii[outmost]
    assert abs(creep.mean()) < 0.2 * noise
    assert np.linalg.norm(after[:, :2], axis=1).max() < 1 + noise


def test_redistribution_is_a_choice() -> None:
    """Without it points move along normals alone: on a plane, not within it."""
    rng = np.random.default_rng(0)
    plane = np.c_[rng.random((2000, 2)), 0.005 * rng.normal(size=2000)]
    moves = np.abs(filtered(plane, redistribute=False) - plane).mean(axis=0)
    redistributed = np.abs(filtered(plane) - plane).mean(axis=0)
    assert moves[:2].max() < 0.2 * moves[2]
    assert redistributed[:2].min() > 1.5 * moves[:2].max()


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("scale", [1e-60, 1e6])
def test_scale(dimension: int, scale: float) -> None:
    points = noisy(dimension)
    np.testing.assert_allclose(filtered(points * scale) / scale, filtered(points), atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_rotations_and_mirrors(dimension: int) -> None:
    points = noisy(dimension)
    expected = filtered(points)
    rotation = oracles.random_rotation(dimension, np.random.default_rng(0))
    mirror = rotation * [-1.0, *[1.0] * (dimension - 1)]
    for turn in (rotation, mirror):
        np.testing.assert_allclose(filtered(points @ turn.T), expected @ turn.T, atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_order_does_not_matter(dimension: int) -> None:
    """Nor for the plan, as long as it looks at all points."""
    points = noisy(dimension)
    order = np.random.default_rng(0).permutation(500)
    np.testing.assert_allclose(filtered(points[order]), filtered(points)[order], atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_threads_change_no_byte(dimension: int) -> None:
    points = noisy(dimension)
    results = []
    for count in (1, 2):
        with thread_limit(count):
            results.append(filtered(points).tobytes())
    assert results[0] == results[1]


def test_clouds_without_a_surface_stay_finite() -> None:
    rng = np.random.default_rng(0)
    line = rng.random((500, 1)) * [1.0, 2.0, 3.0]
    assert np.isfinite(filtered(line, plan_of(line, 1e-3))).all()
    for blob in (rng.normal(size=(500, 3)), rng.random((500, 2))):
        assert np.isfinite(filtered(blob)).all()
    sphere = noisy(3)
    apart = filtered(np.r_[sphere, sphere + np.array([1e9, 0, 0])], plan_of(sphere))
    np.testing.assert_allclose(apart[: len(sphere)], filtered(sphere), atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_no_point_goes_farther_than_the_noise_explains(dimension: int) -> None:
    points = noisy(dimension)
    # Told of less than there is, and not to look how much there is.
    plan = plan_of(points, 5e-4, replace(DESIGN, pass_variances=(1e9, 1e9, 1e9)))
    assert plan is not None
    lengths = np.linalg.norm(filtered(points, plan) - points, axis=1)
    assert lengths.max() <= DESIGN.max_move * 5e-4 * (1 + 1e-12)
    assert np.count_nonzero(lengths > 0.999 * DESIGN.max_move * 5e-4) > 1  # some wanted to


@pytest.mark.parametrize("redistribute", [False, True])
def test_stages_are_told_when_they_begin_and_end(redistribute: bool) -> None:
    points = noisy(3)
    told: list[Progress] = []
    filter_whole(points, plan_of(points), redistribute=redistribute, callback=told.append)
    passes = [f"pass {number + 1} of {DESIGN.n_passes}" for number in range(DESIGN.n_passes)]
    stages = ["outliers 1 of 2", *passes[:-1], *["redistribution"] * redistribute, passes[-1]]
    assert told == [Progress(stage, done, 1) for stage in stages for done in (0, 1)]


@pytest.mark.parametrize("strays", [0, 3])
def test_neighborhoods_are_looked_for_again_if_there_are_outliers(
    strays: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = noisy(3)
    points = np.concatenate([points, 9.0 + np.arange(3.0 * strays).reshape(strays, 3)])
    plan = plan_of(points)
    counts: list[int] = []

    def count(chosen: Array, *arguments: Any) -> Neighborhoods:
        counts.append(len(chosen))
        return find_neighborhoods(chosen, *arguments)

    monkeypatch.setattr("pcsmooth.filters.surface_filter.find_neighborhoods", count)
    result = filter_whole(points, plan)
    n_left = len(points) - strays
    assert np.count_nonzero(result.outliers) == strays
    again = DESIGN.n_passes - 2
    assert counts == [len(points)] * (strays > 0) + [n_left] * (1 + again)


def test_nothing_but_outliers_stays_where_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    def all_are_off(points: Array, *_: object) -> OutlierCandidates:
        off = np.ones(len(points), np.bool_)
        return OutlierCandidates(off, ~off)

    points = noisy(3)
    monkeypatch.setattr("pcsmooth.filters.outliers.find_candidates", all_are_off)
    result = filter_whole(points, plan_of(points))
    assert result.outliers.all()
    np.testing.assert_array_equal(result.points, points)
