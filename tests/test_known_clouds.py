"""Clouds and scans of the benchmark: they have the noise and the surface that they say."""

from collections.abc import Callable

import numpy as np
import pytest
from known_clouds import KNOWN_CLOUDS, KnownCloud
from scenes import Ball, Box, Column, Ground, edge_distances, gradients, signed_distances, ways_to
from simulated_scans import SIMULATED_SCANS, Law, from_tripod, measured

from oracles import Array

#: Of these, what does not fit together is no noise.
MISFITS = ("three stations that misfit", "flights that misfit")

MAKERS = [
    pytest.param(make, id=name)
    for name, make in {**KNOWN_CLOUDS, **SIMULATED_SCANS}.items()
    if name not in MISFITS
]


@pytest.mark.slow
@pytest.mark.parametrize("make", MAKERS)
def test_clouds_are_what_they_say(make: Callable[[int], KnownCloud]) -> None:
    cloud = make(4)
    good = ~cloud.outliers
    ratios = cloud.errors[good] / cloud.noise[good]
    # Of 10,000 points and more, by chance 1.00 +- 0.01; nearer surfaces make some smaller.
    assert np.sqrt(np.mean(ratios**2)) == pytest.approx(1.0, abs=0.03)
    again = make(4)
    assert again.points.tobytes() == cloud.points.tobytes()
    if cloud.normals is not None:
        moved = cloud.points + 0.1 * cloud.noise[:, np.newaxis] * cloud.normals
        changes = np.abs(cloud.distances(moved) - cloud.errors)[good] / cloud.noise[good]
        assert np.median(changes) == pytest.approx(0.1, rel=0.03)


def nearest_of(surface: Array, points: Array) -> Array:
    return np.asarray(np.linalg.norm(points[:, np.newaxis] - surface, axis=2).min(axis=1))


def test_boxes_know_their_faces_and_edges() -> None:
    center, half, angle = np.array([1.0, -2.0, 0.5]), np.array([0.8, 0.5, 0.3]), 0.4
    rng = np.random.default_rng(0)
    box = Box((1.0, -2.0, 0.5), (0.8, 0.5, 0.3), angle)
    grid = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 61)] * 3), axis=-1).reshape(-1, 3)
    turn = np.array([
        [np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]
    ])  # fmt: skip
    on_faces = np.count_nonzero(np.abs(grid) == 1.0, axis=1)
    solid = (grid * half) @ turn.T + center
    points = center + rng.uniform(-1.5, 1.5, (60, 3))
    # As far as points of the grid are apart, at most.
    fine = float(np.linalg.norm(half)) / 60.0
    distances, to_edges = box.distances(points), box.edge_distances(points)
    np.testing.assert_allclose(
        np.abs(distances), nearest_of(solid[on_faces > 0], points), atol=fine
    )
    np.testing.assert_allclose(to_edges, nearest_of(solid[on_faces > 1], points), atol=fine)
    inside = (np.abs((points - center) @ turn) < half).all(axis=1)
    np.testing.assert_array_equal(distances < 0.0, inside)
    hollow = Box((1.0, -2.0, 0.5), (0.8, 0.5, 0.3), angle, hollow=True)
    np.testing.assert_array_equal(hollow.distances(points), -distances)


def test_rays_meet_the_nearest_surface() -> None:
    scene = (Ball((4.0, 0.0, 0.0), 1.0), Column(0.0, 7.0, 2.0), Ground())
    origins = np.array([[0.0, 0.0, 1.0]] * 4)
    below = np.array([0.6, 0.0, -0.8])
    beams = np.array([[4.0, 0.0, -1.0], [0.0, 1.0, 0.0], below, [0.0, 0.0, 1.0]])
    beams /= np.linalg.norm(beams, axis=1, keepdims=True)
    ways = ways_to(scene, origins, beams, 20.0)
    np.testing.assert_allclose(ways[:3], [np.sqrt(17.0) - 1.0, 5.0, 1.25], rtol=1e-5)
    assert np.isinf(ways[3])
    met = origins[:3] + ways[:3, np.newaxis] * beams[:3]
    np.testing.assert_allclose(signed_distances(scene, met), 0.0, atol=1e-5)
    normals = [-beams[0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]
    np.testing.assert_allclose(gradients(scene, met), normals, atol=1e-4)
    assert np.isinf(edge_distances(scene, met)).all()


def test_split_beams_measure_what_is_between() -> None:
    scene = (Box((6.0, 0.0, 0.0), (0.5, 9.0, 9.0)), Box((4.0, 0.0, 0.0), (0.1, 1.0, 1.0)))
    beams = from_tripod((0.0, 0.0, 0.0), 0.01, 0.6)
    law = Law(0.001, width=0.01)
    cloud = measured(scene, beams, law, 20.0, np.random.default_rng(0))
    assert np.count_nonzero(cloud.outliers) > 50
    x = cloud.points[cloud.outliers, 0]
    assert ((x > 3.89) & (x < 5.7)).all()  # the ways differ with the directions
    assert np.count_nonzero((x > 4.2) & (x < 5.2)) > 0.5 * len(x)
    assert cloud.errors[~cloud.outliers].max() < 0.01
