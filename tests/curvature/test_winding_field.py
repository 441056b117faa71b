"""Which side is outside, by winding numbers on a lattice."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

import oracles
from oracles import Array
from pcsmooth.curvature.winding_field import WindingField, find_winding_field, lattice_step


def field_of(points: Array) -> WindingField:
    return find_winding_field(points, np.ones(len(points)))


def share_outward(points: Array, normals: Array) -> float:
    """Share of the points of a surface whose outside is found."""
    outward = field_of(points).outward_at(points)
    return float((np.einsum("ij,ij->i", outward, normals) > 0.0).mean())


def box_surface(n: int, sides: tuple[float, ...], seed: int = 0) -> tuple[Array, Array]:
    """Random points of the surface of a box or a rectangle, and their normals."""
    rng = np.random.default_rng(seed)
    lengths = np.array(sides)
    dimension = len(sides)
    areas = np.repeat(lengths.prod() / lengths, 2)
    faces = rng.choice(2 * dimension, n, p=areas / areas.sum())
    axes, signs = faces // 2, 2.0 * (faces % 2) - 1.0
    points = (rng.random((n, dimension)) - 0.5) * lengths
    normals = np.zeros((n, dimension))
    normals[np.arange(n), axes] = signs
    points[np.arange(n), axes] = 0.5 * signs * lengths[axes]
    return points, normals


def even_ball(dimension: int) -> Array:
    return oracles.even_circle(4000) if dimension == 2 else oracles.even_sphere(4000)


@pytest.mark.parametrize("dimension", [2, 3])
def test_numbers_are_1_inside_and_0_outside(dimension: int) -> None:
    """Those of a ball, but for three cells, and for less in the mean."""
    points = even_ball(dimension) + np.arange(dimension)
    field = field_of(points)
    cells = np.moveaxis(np.indices(field.values.shape), 0, -1)
    radii = np.linalg.norm(cells * field.step + field.origin - np.arange(dimension), axis=-1)
    inside, outside = (
        field.values[far] for far in (radii < 1.0 - 3 * field.step, radii > 1.0 + 3 * field.step)
    )
    assert inside.min() > 0.75
    assert outside.max() < 0.25
    assert inside.mean() == pytest.approx(1.0, abs=0.07)
    assert outside.mean() == pytest.approx(0.0, abs=0.07)
    assert field.step == pytest.approx(lattice_step(float(np.ptp(points, axis=0).max()), 64))


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_gradient_is_that_of_the_numbers(dimension: int) -> None:
    """Its integral from inside to outside is their difference."""
    field = field_of(even_ball(dimension)).smoothed(0.1)
    directions = oracles.random_sphere(20, seed=1, dimension=dimension)
    radii = np.linspace(0.4, 1.2, 801)
    rays = radii[:, np.newaxis, np.newaxis] * directions
    outward = field.outward_at(rays.reshape(-1, dimension)).reshape(rays.shape)
    falls = np.einsum("kij,ij->ki", outward, directions).mean(axis=0) * 0.8
    places = (rays[[0, -1]] - field.origin) / field.step
    inside, outside = (
        map_coordinates(field.values, ends.T, np.float64, order=1) for ends in places
    )
    np.testing.assert_allclose(falls, inside - outside, atol=0.02)


@pytest.mark.parametrize(
    ("sides", "least"), [((1.0, 0.7, 0.1), 0.98), ((1.0, 0.1, 0.1), 0.98), ((1.0, 0.5, 0.06), 0.93)]
)
def test_thin_parts_with_noise_have_two_sides(sides: tuple[float, ...], least: float) -> None:
    """Five noises thick: points are at most as often on the wrong side of their middle."""
    points, normals = box_surface(10_000, sides)
    noise = 0.2 * min(sides) * np.random.default_rng(1).normal(size=points.shape)
    assert share_outward(points + noise, normals) > least


def test_a_thin_ring_has_two_sides_in_the_plane() -> None:
    circle = oracles.random_sphere(2000, dimension=2)
    points, normals = np.r_[circle, 0.85 * circle], np.r_[circle, -circle]
    noise = 0.03 * np.random.default_rng(1).normal(size=points.shape)
    assert share_outward(points + noise, normals) > 0.95


def test_a_cavity_is_outside() -> None:
    shell = oracles.random_sphere(6000)
    cavity = 0.6 * oracles.random_sphere(3000, seed=1)
    assert share_outward(np.r_[shell, cavity], np.r_[shell, -cavity / 0.6]) == 1.0


def test_several_shapes_each_have_their_outside() -> None:
    sphere = oracles.random_sphere(3000)
    points = np.r_[sphere, 0.3 * sphere + [2.5, 0.0, 0.0], 0.5 * sphere + [0.0, 2.0, 1.0]]
    assert share_outward(points, np.tile(sphere, (3, 1))) == 1.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_moving_and_scaling_a_cloud_changes_no_side(dimension: int) -> None:
    points = oracles.random_sphere(1000, dimension=dimension)
    points[:, 0] *= 3.0
    outward = field_of(points).outward_at(points)
    moved = 1e-3 * points + 5.0
    np.testing.assert_allclose(field_of(moved).outward_at(moved), 1e3 * outward, atol=20.0)
    scaled = field_of(points).scaled(1e-3)
    np.testing.assert_allclose(scaled.outward_at(1e-3 * points), 1e3 * outward, rtol=1e-6)


def test_smoothing_widens_the_step_and_keeps_its_height() -> None:
    points = oracles.random_sphere(4000)
    field = field_of(points)
    smooth = field.smoothed(0.1)
    assert field.smoothed(0.1 * field.step) is field
    middle = tuple(np.array(field.values.shape) // 2)
    assert smooth.values[middle] == pytest.approx(1.0, abs=0.02)
    steepest = np.linalg.norm(smooth.outward_at(points), axis=1)
    # That of a Gaussian of this width, and of a cell of linear interpolation and differences.
    width = np.hypot(0.1, 0.5 * field.step)
    assert np.median(steepest) == pytest.approx(1.0 / (np.sqrt(2.0 * np.pi) * width), rel=0.1)


def test_areas_tell_how_much_of_the_surface_a_point_stands_for() -> None:
    """Isolated points, whose areas are large, do not matter."""
    points = oracles.random_sphere(3000)
    strays = 1.5 * oracles.random_sphere(20, seed=2)
    areas = np.r_[np.ones(3000), np.full(20, 1e6)]
    outward = find_winding_field(np.r_[points, strays], areas).outward_at(points)
    assert (np.einsum("ij,ij->i", outward, points) > 0.0).all()
