from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import cKDTree

import oracles
from flows.dense import rough_sphere
from oracles import Array
from pcsmooth.bodies.presets import load_presets
from pcsmooth.curvature.cell_normals import CELLS, find_cell_normals
from pcsmooth.energies.balls import BallEnergy, measure_balls
from pcsmooth.energies.polyhedra.union import PolyhedronEnergy
from pcsmooth.energies.protocol import Energy
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import run_flow
from pcsmooth.flows.implicit import Implicit
from pcsmooth.flows.restraint import FREE, Restraint
from pcsmooth.flows.scheme import Scheme
from pcsmooth.neighbors.spacing import mean_spacing

every_dimension = pytest.mark.parametrize("dimension", [2, 3])


#: Points and radius of a rough circle and a rough sphere.
DEVIATES = np.random.default_rng(1).normal(size=(400, 1))
ROUGH = {
    2: ((1 + 0.004 * DEVIATES) * oracles.even_circle(400), 0.04),
    3: (rough_sphere(400), 0.3),
}


def normals_of(points: Array, radius: float) -> Array:
    """Cell normals by number, of either sign."""
    union = measure_balls(points, radius)
    dimension = points.shape[1]
    found = find_cell_normals(
        union.grid, union.numbers, union, dimension, CELLS[dimension][0], 2 * radius
    )
    normals = np.zeros_like(points)
    normals[union.numbers] = found.normals[:dimension].T
    return normals[union.carriers]


def first_move(energy: Energy, points: Array, restraint: Restraint) -> Array:
    _, state = run_flow(energy, points, Euler(), 1, restraint=restraint)
    return np.asarray(state.points - points)


@every_dimension
@pytest.mark.parametrize("shape", ["ball", "polyhedron", "twins"])
def test_normal_motion_takes_the_normal_component(dimension: int, shape: str) -> None:
    points, radius = ROUGH[dimension]
    if shape == "twins":
        points = np.r_[points, points[:50]]
    body = load_presets()["cube" if dimension == 3 else "square"]
    energy = PolyhedronEnergy(radius, body) if shape == "polyhedron" else BallEnergy(radius)
    free = first_move(energy, points, FREE)
    normals = normals_of(points, radius)
    expected = np.einsum("ij,ij->i", free, normals)[:, np.newaxis] * normals
    actual = first_move(energy, points, Restraint(along_normals=True))
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-15)
    assert np.abs(actual).max() > 0
    assert np.linalg.norm(actual, axis=1).sum() < 0.999 * np.linalg.norm(free, axis=1).sum()


def disk(n: int, noise: float) -> Array:
    rng = np.random.default_rng(5)
    angle, distance = 2 * np.pi * rng.random(n), np.sqrt(rng.random(n))
    spacing = np.sqrt(np.pi / n)
    heights = noise * spacing * rng.normal(size=n)
    return np.asarray(np.c_[distance * np.cos(angle), distance * np.sin(angle), heights])


def test_normal_motion_leaves_a_flat_disk_alone() -> None:
    points = disk(1000, 0.0)
    radius = 2 * mean_spacing(points)
    *_, free = run_flow(BallEnergy(radius), points, Euler(), 10)
    *_, state = run_flow(BallEnergy(radius), points, Euler(), 10, restraint=Restraint(True))
    np.testing.assert_allclose(state.points, points, rtol=0, atol=1e-12)
    assert np.abs(free.points - points).max() > 0.1 * radius


@pytest.mark.parametrize("order", [0, 1, 2])
def test_normal_motion_keeps_borders_and_opens_no_holes(order: int) -> None:
    points = disk(1500, 0.3)
    spacing = mean_spacing(points)
    schemes: list[tuple[Scheme, int]] = [
        (Euler(), 30),
        (Implicit(spacing, 1), 6),
        (Implicit(spacing, 2), 4),
    ]
    scheme, steps = schemes[order]
    ends = {}
    for along_normals in (False, True):
        restraint = Restraint(along_normals)
        *_, state = run_flow(BallEnergy(2 * spacing), points, scheme, steps, restraint=restraint)
        ends[along_normals] = state.points
    border = np.linalg.norm(points[:, :2], axis=1) > 1 - spacing
    # samples of the disk, away from its border, and how far they are from a point
    samples = 0.9 * disk(20_000, 0.0)
    holes, retreats = {}, {}
    for along_normals, end in ends.items():
        holes[along_normals] = cKDTree(end[:, :2]).query(samples[:, :2])[0].max()
        before, after = (np.linalg.norm(p[border, :2], axis=1) for p in (points, end))
        retreats[along_normals] = (before - after).mean()
    before = cKDTree(points[:, :2]).query(samples[:, :2])[0].max()
    assert holes[True] < before + 0.3 * spacing
    assert abs(retreats[True]) < 0.1 * spacing
    assert abs(retreats[True]) < 0.3 * abs(retreats[False])
    assert ends[True][:, 2].std() < 0.6 * points[:, 2].std()


@every_dimension
@pytest.mark.parametrize("keeps_volume", [False, True])
def test_longest_is_the_whole_way(dimension: int, keeps_volume: bool) -> None:
    points, radius = ROUGH[dimension]
    energy = BallEnergy(radius)
    *_, free = run_flow(energy, points, Euler(), 6, restraint=Restraint(keeps_volume=keeps_volume))
    longest = 0.4 * np.linalg.norm(free.points - points, axis=1).max()
    states = list(
        run_flow(energy, points, Euler(), 6, restraint=Restraint(False, keeps_volume, longest))
    )
    ways = np.linalg.norm(states[-1].points - points, axis=1)
    assert ways.max() == pytest.approx(longest, rel=1e-9)
    assert 10 < (ways > 0.999 * longest).sum() < 400
    for before, after in pairwise(states):
        np.testing.assert_allclose(
            after.moves, np.linalg.norm(after.points - before.points, axis=1), atol=1e-15
        )


def test_capped_points_lie_on_their_way() -> None:
    points = rough_sphere(300)
    free = first_move(BallEnergy(0.4), points, FREE)
    capped = first_move(BallEnergy(0.4), points, Restraint(longest=0.01))
    lengths = np.linalg.norm(free, axis=1, keepdims=True)
    expected = free / np.maximum(1, lengths / 0.01)
    np.testing.assert_allclose(capped, expected, rtol=0, atol=1e-15)


def mean_radius(points: Array) -> float:
    return float(np.linalg.norm(points, axis=1).mean())


def mean_tube(points: Array) -> float:
    return float(0.4 + oracles.distance_to_torus(points).mean())


@pytest.mark.parametrize(
    ("points", "size"),
    [
        (oracles.random_sphere(2000), mean_radius),
        (oracles.random_torus(2500)[0], mean_tube),
    ],
    ids=["sphere", "torus"],
)
@pytest.mark.parametrize("along_normals", [False, True])
def test_kept_volume(points: Array, size: object, along_normals: bool) -> None:
    """Twenty Euler steps shrink the sphere by 2 % and the tube of the torus by 6 %."""
    energy = BallEnergy(2 * mean_spacing(points))
    assert callable(size)
    ends = {}
    for keeps_volume in (False, True):
        restraint = Restraint(along_normals, keeps_volume)
        *_, end = run_flow(energy, points, Euler(), 20, restraint=restraint)
        ends[keeps_volume] = size(end.points) / size(points) - 1
    assert ends[False] < -0.015
    assert abs(ends[True]) < (0.002 if size is mean_radius else 0.005)


def test_each_component_keeps_its_volume() -> None:
    """A small sphere beside a large one: one mean for both would swell it."""
    away = np.array([5.0, 0.0, 0.0])
    points = np.r_[0.4 * oracles.even_sphere(300), oracles.even_sphere(1900) + away]
    radius = 2 * mean_spacing(points)
    *_, end = run_flow(
        BallEnergy(radius), points, Euler(), 10, restraint=Restraint(keeps_volume=True)
    )
    assert mean_radius(end.points[:300]) == pytest.approx(0.4, rel=2e-3)
    assert mean_radius(end.points[300:] - away) == pytest.approx(1, rel=2e-3)


def mean_cells(points: Array, radius: float) -> Array:
    """Mean volume of the cells of each point and its linked ones, point by point."""
    union = measure_balls(points, radius)
    numbers = union.numbers
    found = find_cell_normals(
        union.grid, numbers, union, points.shape[1], CELLS[points.shape[1]][0], 2 * radius
    )
    means = np.zeros(len(points))
    for place, links in enumerate(found.links):
        around = [numbers[place], *(numbers[link] for link in links if link < len(numbers))]
        means[numbers[place]] = np.mean(union.cell_volumes[around])
    return means


@every_dimension
def test_mean_normal_displacement_is_taken_out(dimension: int) -> None:
    points, radius = ROUGH[dimension]
    fixed = np.arange(400) < 100
    restraint = Restraint(keeps_volume=True)
    energy = BallEnergy(radius)
    _, free = run_flow(energy, points, Euler(), 1, fixed=fixed)
    _, kept = run_flow(energy, points, Euler(), 1, fixed=fixed, restraint=restraint)
    normals = normals_of(points, radius)
    normals *= np.sign(np.einsum("ij,ij->i", normals, points))[:, np.newaxis]
    shares = np.where(fixed, 0, mean_cells(points, radius))
    along = np.einsum("ij,ij->i", free.points - points, normals)
    mean = shares @ along / shares.sum()
    expected = free.points - mean * np.where(fixed[:, np.newaxis], 0, normals)
    np.testing.assert_allclose(kept.points, expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    "restraint", [Restraint(True), Restraint(False, True), Restraint(True, True, 0.1)]
)
@pytest.mark.parametrize(
    "points",
    [
        np.ones((1, 3)),
        np.eye(3),
        np.array([[0.0, 0.0], [0.2, 0.0]]),
        np.linspace(0, 1, 30)[:, np.newaxis] * [1.0, 2.0, 3.0],
        0.2 * oracles.lattice(5, 5, 5),
    ],
    ids=["one", "isolated", "two", "line", "grid"],
)
def test_degenerate_clouds(points: Array, restraint: Restraint) -> None:
    energy = BallEnergy(0.3)
    *_, state = run_flow(energy, points, Euler(), 3, restraint=restraint)
    assert np.isfinite(state.points).all()
    rests = energy.evaluate(points).diagonal == 0
    np.testing.assert_array_equal(state.points[rests], points[rests])


def test_noise_does_not_swell_what_keeps_its_volume() -> None:
    """Cells are larger where noise has moved points outwards: they alone are no fair shares."""
    rng = np.random.default_rng(0)
    clean = oracles.even_sphere(4000)
    points = clean + 0.02 * rng.normal(size=clean.shape)  # half a spacing
    sizes = {}
    for keeps_volume in (False, True):
        restraint = Restraint(keeps_volume=keeps_volume)
        *_, end = run_flow(
            BallEnergy(2 * mean_spacing(points)), points, Euler(), 6, restraint=restraint
        )
        sizes[keeps_volume] = mean_radius(end.points) / mean_radius(points) - 1
    assert sizes[False] < -4e-3
    assert abs(sizes[True]) < 1e-3
