"""The exact union of translates."""

from __future__ import annotations

import numpy as np
import pytest

import oracles
import polyhedron_oracles as expect
from energies.cases import measure_bodies
from oracles import assert_close
from pcsmooth import PolyhedronUnion

ARMS = [(0.3, 0.5, -0.4), (1.1, -0.2, 0.7), (1.5, 1.4, 1.9), (0.01, 0.02, 0.9), (2.1, 0.4, 0.6)]

BOXES = {2: "square", 3: "cube"}


def measure(points: oracles.Array, radius: float, body: expect.Body) -> PolyhedronUnion:
    return measure_bodies(points, radius, body, "exact")


# --- closed forms


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("arm", ARMS)
def test_two_cubes(dimension: int, arm: tuple[float, ...]) -> None:
    r, vector = 0.7, 0.7 * np.array(arm[:dimension])
    points = np.array([np.zeros(dimension), vector]) + 0.1
    union = measure(points, r, expect.solid(BOXES[dimension]))
    volume, area = expect.overlap_of_cubes(points, r)
    assert union.volume == pytest.approx(2 * (2 * r) ** dimension - volume, rel=1e-13)
    whole = 2 * dimension * (2 * r) ** (dimension - 1)
    assert union.area == pytest.approx(2 * whole - area, rel=1e-13)
    assert_close(union.visible_areas, whole - area / 2, 1e-13)
    sides = 2 * r - abs(vector)
    slopes = np.zeros((2, dimension))
    if (sides > 0).all():
        slopes[0] = volume / sides * np.sign(vector)
        slopes[1] = [2 * np.delete(sides, k).sum() if dimension == 3 else 2 for k in (0, 1, 2)][
            :dimension
        ] * np.sign(vector)
    for gradient, slope in zip((union.volume_gradient, union.area_gradient), slopes, strict=True):
        assert_close(gradient, np.array([-slope, slope]), 1e-12, r)


@pytest.mark.parametrize(
    ("arm", "shared"),
    [((2, 0, 0), 4.0), ((0, -2, 0), 4.0), ((0, 1, 2), 2.0), ((2, 2, 0), 0.0), ((2, 2, 2), 0.0)],
)
def test_cubes_that_touch(arm: tuple[float, ...], shared: float) -> None:
    """What two cubes share, seen from both sides, is no boundary."""
    union = measure(np.array([(0, 0, 0), arm], float), 1.0, expect.solid("cube"))
    assert union.volume == pytest.approx(16, rel=1e-14)
    assert union.area == pytest.approx(48 - 2 * shared, rel=1e-14)


def test_three_cubes_in_the_plane() -> None:
    """A square of side 3 that lacks one of side 1, 2 high."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    union = measure(points, 1.0, expect.solid("cube"))
    assert union.volume == pytest.approx(16, rel=1e-14)
    assert union.area == pytest.approx(2 * 8 + 2 * 12, rel=1e-14)


def test_three_cubes() -> None:
    points = np.array([[0, 0, 0], [0.5, 0.75, 1.0], [1.25, -0.25, 0.5]])
    union = measure(points, 1.0, expect.solid("cube"))
    # overlaps of 0 and 1, 0 and 2, 1 and 2, and of all, by their sides
    sides = [(1.5, 1.25, 1.0), (0.75, 1.75, 1.5), (1.25, 1.0, 1.5), (0.75, 1.0, 1.0)]
    volumes = [a * b * c for a, b, c in sides]
    areas = [2 * (a * b + b * c + c * a) for a, b, c in sides]
    volume, area = 24 - sum(volumes[:3]) + volumes[3], 72 - sum(areas[:3]) + areas[3]
    assert union.volume == pytest.approx(volume, rel=1e-14)
    assert union.area == pytest.approx(area, rel=1e-14)


@pytest.mark.parametrize("n", [2, 3, 8])
@pytest.mark.parametrize("shape", ["triangle", "tetrahedron"])
def test_simplices(shape: str, n: int) -> None:
    """Translates of a simplex meet in a smaller one: all is known, gradients too."""
    body = expect.solid(shape)
    scene = expect.scene(shape, "cloud", 8)
    points = scene.points[:n]
    union = measure(points, scene.radius, body)
    expected, area_gradient = expect.simplex_union(points, scene.radius, body)
    expect.assert_union(union, expected, 1e-12)
    assert_close(union.area_gradient, area_gradient, 1e-12, scene.radius)


# --- boxes


@pytest.mark.parametrize("n", [1, 2, 5, 20, 60])
@pytest.mark.parametrize("dimension", [2, 3])
def test_random_cubes(dimension: int, n: int) -> None:
    for seed in range(3):
        points = oracles.uniform_cloud(n, dimension, seed)
        radius = 0.6 * n ** (-1 / dimension)
        union = measure(points, radius, expect.solid(BOXES[dimension]))
        expect.assert_union(union, expect.box_union(points, radius), 1e-12)


@pytest.mark.parametrize("spacing", [2.0, 1.5, 1.0, 0.5])
@pytest.mark.parametrize("counts", [(4, 4), (7, 1), (3, 3, 3), (2, 2, 2), (4, 4, 1), (1, 5, 1)])
def test_grids_of_cubes(counts: tuple[int, ...], spacing: float) -> None:
    """Facets coincide, from the same side and from both; 2 radii apart they just touch."""
    points = 0.5 * spacing * oracles.lattice(*counts)
    for order in (np.arange(len(points)), np.random.default_rng(1).permutation(len(points))):
        union = measure(points[order], 0.5, expect.solid(BOXES[len(counts)]))
        expect.assert_totals(union, expect.box_union(points, 0.5), 1e-13)
        assert union.visible_areas.min() >= 0
        assert_close(union.volume_gradient.sum(axis=0), 0, 1e-13, union.area)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("dimension", [2, 3])
def test_cubes_on_random_places_of_a_grid(dimension: int, seed: int) -> None:
    """Coincident coordinates, duplicated points, facets that overlap in part."""
    rng = np.random.default_rng(seed)
    points = rng.integers(0, 7, (30, dimension)).astype(float) / 4
    union = measure(points, 0.5, expect.solid(BOXES[dimension]))
    expect.assert_totals(union, expect.box_union(points, 0.5), 1e-13)
    again = measure(np.unique(points, axis=0), 0.5, expect.solid(BOXES[dimension]))
    assert again.area == pytest.approx(union.area, rel=1e-13)
    assert_close(union.volume_gradient.sum(axis=0), 0, 1e-13, union.area)


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_cubes_at_equal_heights(levels: int) -> None:
    points = oracles.uniform_cloud(40, 3)
    points[:, 2] = np.floor(levels * points[:, 2]) / 4
    union = measure(points, 0.25, expect.solid("cube"))
    expect.assert_totals(union, expect.box_union(points, 0.25), 1e-12)


@pytest.mark.parametrize("spacing", [0.1, 0.2, 0.4])
@pytest.mark.parametrize("counts", [(5, 5), (3, 3, 3)])
def test_grids_that_rounding_disturbs(counts: tuple[int, ...], spacing: float) -> None:
    """Facets that coincide up to rounding: gaps of 1e-16 may count as boundary, or not."""
    dimension = len(counts)
    points = spacing * oracles.lattice(*counts) + 0.3
    rotation = oracles.random_rotation(dimension, np.random.default_rng(0))
    body = expect.solid(BOXES[dimension])
    expected = expect.box_union(points, 0.2, tolerance=1e-9)
    for moved, turned in (
        (points, body),
        (points @ rotation.T, expect.rotated(body, rotation)),
    ):
        union = measure(moved, 0.2, turned)
        assert union.volume == pytest.approx(expected.volume, rel=1e-12)
        assert union.area > expected.area * (1 - 1e-12)
        if spacing < 0.4:
            assert union.area == pytest.approx(expected.area, rel=1e-12)
        else:
            assert union.area <= len(points) * 2 * dimension * 0.4 ** (dimension - 1) * (1 + 1e-12)
        assert np.isfinite(union.area_gradient).all()


# --- any body


@pytest.mark.parametrize("n", [8, 20])
@pytest.mark.parametrize("kind", ["cloud", "cap"])
@pytest.mark.parametrize("shape", expect.SHAPES[2])
def test_polygons(shape: str, kind: str, n: int) -> None:
    scene = expect.scene(shape, kind, n)
    union = measure(scene.points, scene.radius, scene.body)
    expected = expect.polygon_union(scene.points, scene.radius, scene.body)
    expect.assert_union(union, expected, 1e-12)


@pytest.mark.parametrize("shape", expect.SHAPES[3])
def test_whole_nerve(shape: str) -> None:
    scene = expect.scene(shape, "cloud", 7, seed=2)
    union = measure(scene.points, scene.radius, scene.body)
    expected = expect.sum_over_simplices(scene.points, scene.radius, scene.body)
    # Qhull's vertices are good to some 1e-14, and up to 127 terms cancel
    expect.assert_union(union, expected, 1e-10)
    volumes, _ = expect.naive_cells(scene.points, scene.radius, scene.body)
    assert_close(union.cell_volumes, volumes, 1e-11)


@pytest.mark.parametrize("kind", ["cloud", "cap"])
@pytest.mark.parametrize("shape", expect.SHAPES[3])
def test_monte_carlo(shape: str, kind: str) -> None:
    scene = expect.scene(shape, kind, 8, seed=3)
    union = measure(scene.points, scene.radius, scene.body)
    sampled = expect.sample_union(scene.points, scene.radius, scene.body, 8000)
    assert abs(union.volume - sampled.volume) < 4 * sampled.volume_error
    assert abs(union.area - sampled.area) < 4 * sampled.area_error
    assert (abs(union.visible_areas - sampled.visible_areas) < 4 * sampled.area_errors).all()
    assert union.visible_areas.min() >= 0


@pytest.mark.parametrize("shape", ["hexagon", "icosahedron", "sphere"])
def test_covered_body(shape: str) -> None:
    """A body among near ones in every direction has no boundary and no gradient."""
    body = expect.solid(shape)
    dimension = body.normals.shape[1]
    around = np.r_[np.eye(dimension), -np.eye(dimension)]
    points = np.r_[0.01 * np.ones((1, dimension)), 0.4 * around]
    union = measure(points, 1.0, body)
    assert union.visible_areas[0] == 0
    assert not union.volume_gradient[0].any()
    assert not union.area_gradient[0].any()
    assert union.cell_volumes[0] > 0
