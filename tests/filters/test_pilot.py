"""The noise that filters take, and what it corrects."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

import oracles
from filters.whole import plan_of
from oracles import Array
from pcsmooth.filters.design import DESIGN
from pcsmooth.filters.pilot import Pieces, Trial, correct_noise, cut_pieces, try_on_pieces
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.neighbors.coincident import mark_distinct
from pcsmooth.parts.whole_cloud import WholeCloud


def planned(points: Array, noise: float | None = None) -> FilterPlan:
    plan = plan_of(points, noise)
    assert plan is not None
    return plan


def pieces_of(points: Array, plan: FilterPlan) -> Pieces:
    cloud = WholeCloud.as_it_is(points)
    return cut_pieces(cloud, mark_distinct(cloud), plan, DESIGN)


def square(n: int, noise: float, seed: int = 0) -> Array:
    """Points of a unit square, and Gaussian noise in all directions."""
    rng = np.random.default_rng(seed)
    return np.asarray(np.c_[rng.random((n, 2)), np.zeros(n)] + noise * rng.normal(size=(n, 3)))


@pytest.mark.parametrize("told", [0.8, 1.0, 1.5, 2.5])
@pytest.mark.parametrize("noise", [0.003, 0.01])
def test_a_plane_gives_its_noise_whatever_is_told(noise: float, told: float) -> None:
    points = square(10_000, noise)
    plan = planned(points, told * noise)
    assert try_on_pieces(plan, pieces_of(points, plan)).taken == pytest.approx(noise, rel=0.05)


def test_turning_normals_around_changes_nothing() -> None:
    """Residuals of neighbours are compared along the same side, whichever sides normals show."""
    points = oracles.torus_surface(4000).noisy(0.4)
    plan = planned(points)
    pieces = pieces_of(points, plan)
    moved = try_on_pieces(plan, Pieces(points[::-1].copy(), np.arange(4000), is_whole=True))
    assert moved.taken == pytest.approx(try_on_pieces(plan, pieces).taken, rel=1e-9)


def test_a_small_cloud_is_one_piece() -> None:
    points = square(3000, 0.01)
    pieces = pieces_of(points, planned(points))
    assert np.array_equal(np.sort(pieces.points, axis=0), np.sort(points, axis=0))
    assert len(pieces.inner) == 3000


@pytest.mark.parametrize("noise", [0.001, 0.01])
def test_pieces_of_a_large_cloud_are_parts_of_it_and_do_not_touch(noise: float) -> None:
    points = square(30_000, noise)
    plan = planned(points, noise)
    pieces = pieces_of(points, plan)
    assert len(pieces.points) <= DESIGN.pilot_points
    size = _size_of_pieces(pieces.points, 2.0 * plan.passes[0].max_radius)
    for piece in pieces.points.reshape(-1, size, 3)[:5]:
        # Distances within a piece are those of the cloud.
        center = piece[0]
        nearest = cKDTree(points).query(points[0], size)[0]
        assert np.linalg.norm(piece - center, axis=1)[-1] < 10 * nearest[-1]
    assert len(pieces.inner) > 0.05 * len(pieces.points)


def _size_of_pieces(points: Array, gap: float) -> int:
    """Points of each of the pieces, which are farther from each other than a gap."""
    breaks = np.flatnonzero(np.diff(np.sort(points[:, 0])) > gap) + 1
    sizes = np.diff(np.r_[0, breaks, len(points)])
    assert len(sizes) > 3
    assert (sizes == sizes[0]).all()
    return int(sizes[0])


def test_no_piece_is_around_a_stray() -> None:
    points = square(30_000, 0.003)
    points[::40] = np.random.default_rng(0).uniform(1e9, 2e9, (750, 3))
    pieces = pieces_of(points, planned(square(30_000, 0.003), 0.003))
    breaks = np.flatnonzero(np.diff(pieces.points[:, 0]) > 0.1)
    assert len(breaks) > 20
    assert np.ptp(pieces.points[:, 1]) < 1.0


def test_inner_points_see_what_they_see_in_the_cloud() -> None:
    points = square(30_000, 0.003)
    plan = planned(points, 0.003)
    pieces = pieces_of(points, plan)
    cloud, own = cKDTree(points), cKDTree(pieces.points)
    radius = plan.passes[0].max_radius
    size = _size_of_pieces(pieces.points, 2.0 * radius)
    shifts = _shifts(points, pieces.points, size)
    for number in pieces.inner[::50]:
        position = pieces.points[number]
        there = position + shifts[number // size]
        assert len(own.query_ball_point(position, radius)) == len(
            cloud.query_ball_point(there, radius)
        )


def _shifts(points: Array, pieces: Array, size: int) -> list[Array]:
    """How far each piece is from where it was cut: its first point is that of the cloud with the
    same distances to its nearest points."""
    tree = cKDTree(points)
    known = tree.query(points, 6)[0]
    shifts = []
    for piece in pieces.reshape(-1, size, 3):
        around = np.sort(np.linalg.norm(piece[:20] - piece[0], axis=1))[:6]
        shifts.append(points[np.abs(known - around).sum(axis=1).argmin()] - piece[0])
    return shifts


def trial(told: float) -> Trial:
    """Takes 0.8 whatever it is told from 0.8 to 1.5, and with two sheets merged twice as much."""
    return Trial(min(told, 0.8) if told < 1.5 else 1.1 * told, 20.0)


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (1.0, np.sqrt(0.8)),  # on the plateau
        (1.2, np.sqrt(0.8 * 0.8 / DESIGN.pilot_share)),  # far from what is taken
        (3.0, np.sqrt(0.8 * 0.8 / DESIGN.pilot_share)),  # beyond: 3, 2.4, 1.92, 1.54, 1.23
    ],
)
def test_noise_is_looked_for_on_the_plateau(found: float, expected: float) -> None:
    assert correct_noise(found, trial, DESIGN) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("power", [0.6, 1.0, 2.0])
def test_without_a_plateau_the_noise_is_that_of_the_start(power: float) -> None:
    def falls(told: float) -> Trial:
        return Trial(0.9 * told**power, 20.0)

    assert correct_noise(2.0, falls, DESIGN) == 2.0


def test_a_plateau_that_only_follows_is_none() -> None:
    """It begins where as much is taken as is told."""

    def follows(told: float) -> Trial:
        return Trial(min(told, 1.0) if told < 1.6 else told, 20.0)

    assert correct_noise(2.0, follows, DESIGN) == 2.0


@pytest.mark.parametrize(
    ("count", "noise"), [(256, 0.02), (300, 0.02), (1000, 0.002), (1000, 0.005), (4000, 0.001)]
)
def test_surfaces_that_bend_by_more_than_their_noise_between_points(
    count: int, noise: float
) -> None:
    """Shares of the passes are small there, and follow what is told."""
    rng = np.random.default_rng(count)
    points = oracles.random_sphere(count) + noise * rng.normal(size=(count, 3))
    assert planned(points).noise.deviation == pytest.approx(noise, rel=0.2)


def test_full_neighborhoods_are_not_trusted() -> None:
    def peak(told: float) -> Trial:
        return Trial(0.9 * told**2, 200.0)

    assert correct_noise(1.1, peak, DESIGN) == 1.1


def test_what_takes_nothing_changes_little() -> None:
    def takes(told: float) -> Trial:
        return Trial(0.95 if told >= 1.0 else 0.0, 20.0)

    assert correct_noise(1.0, takes, DESIGN) == pytest.approx(np.sqrt(0.95), rel=1e-12)


@pytest.mark.parametrize("noise", [0.2, 0.7, 1.3])
@pytest.mark.parametrize("shape", ["sphere", "torus"])
def test_noise_of_even_shapes(shape: str, noise: float) -> None:
    surface = {"sphere": oracles.sphere_surface, "torus": oracles.torus_surface}[shape](10_000)
    found = planned(surface.noisy(noise)).noise.deviation
    assert found == pytest.approx(noise * surface.spacing, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("gap", [5.0, 10.0, 20.0])
def test_noise_of_two_sheets(gap: float) -> None:
    """Neighbourhoods hold both, and a quadric takes their distance for noise."""
    rng = np.random.default_rng(1)
    noise = 0.02 / gap
    sides = np.repeat([0.0, 0.02], 10_000)
    points = np.c_[rng.random((20_000, 2)), sides + noise * rng.normal(size=20_000)]
    assert planned(points).noise.deviation == pytest.approx(noise, rel=0.2)
