"""Coordinates in steps: found, taken for the noise that they are, and evened out."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import noisy_torus
from known_clouds import depth_steps, scan_lines, two_walls

import pcsmooth
from filters.whole import plan_of, surroundings_of
from oracles import Array
from pcsmooth.filters.design import DESIGN
from pcsmooth.filters.steps import has_steps, radii_over_steps


def is_stepped(points: Array) -> bool:
    return has_steps(surroundings_of(points), DESIGN)


def grid(n: int, spacing: float) -> tuple[Array, Array]:
    x, y = np.meshgrid(spacing * np.arange(n), spacing * np.arange(n))
    return x.ravel(), y.ravel()


def turned(points: Array) -> Array:
    rotation, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    return np.asarray(points @ rotation)


def disparities(step: float) -> tuple[Array, Array, Array]:
    """A slanted wall z = 2 + 0.4 x, seen by a camera whose 1 / z come in steps.

    Points, unit normal, and the noise of each along it.
    """
    u, v = grid(160, 0.006)
    u, v = u - 0.48, v - 0.48
    depth = 1.0 / (step * np.round((1.0 - 0.4 * u) / 2.0 / step))
    normal = np.array([-0.4, 0.0, 1.0]) / np.hypot(1.0, 0.4)
    noise = depth**2 * step / np.sqrt(12.0) * (1.0 - 0.4 * u) * normal[2]
    return np.stack([u * depth, v * depth, depth], axis=1), normal, noise


def check(points: Array, normal: Array, level: float, noise: Array) -> None:
    result = pcsmooth.denoise(points)
    assert result.sigma is not None
    assert np.median(result.sigma / noise) == pytest.approx(1.0, abs=0.15)
    before, after = points @ normal - level, result.points @ normal - level
    assert np.sqrt(np.mean(after**2)) < 0.25 * np.sqrt(np.mean(before**2))
    off = np.degrees(np.arccos(np.minimum(np.abs(result.normals @ normal), 1.0)))
    assert np.median(off) < 1.0
    assert np.quantile(off, 0.95) < 2.0


@pytest.mark.parametrize("seed", [1, 2])
def test_steps_of_depth_are_noise(seed: int) -> None:
    cloud = depth_steps(seed)
    assert cloud.normals is not None
    normal = cloud.normals[0]
    level = float(np.median(cloud.points @ normal))
    check(cloud.points, normal, level, cloud.noise)


@pytest.mark.parametrize("turn", [False, True])
def test_steps_of_disparities_are_noise(turn: bool) -> None:
    points, normal, noise = disparities(0.005)
    if turn:
        points, normal = turned(points), turned(normal)
    check(points, normal, 2.0 / np.hypot(1.0, 0.4), noise)


def test_a_radius_holds_three_layers() -> None:
    x, y = grid(120, 1.0)
    points = np.stack([x, y, 3.0 * np.floor(x / 6.0)], axis=1)
    around = surroundings_of(points)
    radii = radii_over_steps(around, DESIGN)
    assert (radii > 0.0).all()
    inner = np.abs(around.positions[:, 0, :2] - 60.0).max(axis=1) < 40.0
    # Layers are 6 wide: with less than a row and a half of the third it is too narrow.
    assert radii[inner].min() > 4.5
    assert np.median(radii) < 12.0
    assert is_stepped(points)
    assert is_stepped(turned(points))
    assert not is_stepped(points[:, :2])


def lattice_box() -> Array:
    faces = []
    for axis in range(3):
        for side in (0.0, 1.0):
            points = np.stack(grid(50, 1.0 / 49.0), axis=1)
            faces.append(np.insert(points, axis, side, axis=1))
    return np.unique(np.round(np.concatenate(faces), 9), axis=0)


def terrain() -> Array:
    """Heights that are exact, on a lattice."""
    x, y = grid(120, 1.0)
    return np.stack([x, y, 0.3 * x + 4.0 * np.sin(y / 15.0)], axis=1)


def noisy_steps() -> Array:
    """Noise as large as the steps: it blurs them."""
    x, y = grid(120, 1.0)
    heights = 0.3 * x + np.random.default_rng(2).normal(size=len(x))
    return np.stack([x, y, np.round(heights)], axis=1)


@pytest.mark.parametrize(
    "points",
    [
        pytest.param(noisy_torus(10_000, 0.1)[0], id="torus"),
        pytest.param(noisy_torus(10_000, 0.0)[0], id="clean torus"),
        pytest.param(lattice_box(), id="box of lattices"),
        pytest.param(terrain(), id="lattice of heights"),
        pytest.param(noisy_steps(), id="blurred steps"),
        pytest.param(two_walls(0.0005, 1).points, id="two walls"),
        pytest.param(two_walls(0.0, 1).points, id="two clean walls"),
        pytest.param(scan_lines(5, 1).points, id="lines 5"),
        pytest.param(scan_lines(7, 1).points, id="lines 7"),
        pytest.param(scan_lines(10, 1).points, id="lines 10"),
        pytest.param(scan_lines(20, 1).points, id="lines 20"),
    ],
)
def test_other_clouds_have_none(points: Array) -> None:
    assert not is_stepped(points)
    # On crests of a lattice of exact heights rows to both sides have the same height.
    assert np.mean(radii_over_steps(surroundings_of(points), DESIGN) > 0.0) < 0.03


def test_flat_steps_are_let_be() -> None:
    """Layers wider than any neighbourhood: nothing tells them from terraces."""
    x, y = grid(120, 1.0)
    plan = plan_of(np.stack([x, y, np.floor(x / 40.0)], axis=1))
    assert plan is not None
    assert plan.noise.deviation == 0.0
