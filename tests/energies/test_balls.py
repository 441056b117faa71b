from __future__ import annotations

from functools import cache
from itertools import product
from typing import get_args

import numpy as np
import pytest

import oracles
from energies.cases import ball_cloud
from oracles import assert_close, scale_of
from pcsmooth.energies.balls import BallEnergy, BallUnion, measure_balls
from pcsmooth.energies.protocol import Quantity

#: (what, dimension, radius in spacings) of the random clouds.
CLOUDS = list(product(("cloud", "surface"), (2, 3), (1.5, 2.5, 4.0)))
every_cloud = pytest.mark.parametrize(("kind", "dimension", "spacings"), CLOUDS)

TRIANGLES = {
    "equilateral": np.array([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(0.75), 0]]),
    "acute": np.array([[0, 0, 0], [1.1, 0, 0.2], [0.4, 0.8, -0.1]]),
    "obtuse": np.array([[0, 0, 0], [1.5, 0, 0], [0.7, 0.3, 0.2]]),
}


@cache
def union_of(kind: str, dimension: int, spacings: float) -> BallUnion:
    return measure_balls(*ball_cloud(kind, dimension, spacings, 200))


# --- closed forms


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("radius", [1e-3, 1.0, 7.5])
def test_one_ball(dimension: int, radius: float) -> None:
    union = measure_balls(np.full((1, dimension), 3.0), radius)
    area = oracles.sphere_area(radius, dimension)
    assert union.volume == pytest.approx(oracles.ball_volume(radius, dimension), rel=1e-15, abs=0)
    assert union.area == pytest.approx(area, rel=1e-15, abs=0)
    assert not union.volume_gradient.any()
    assert not union.area_gradient.any()
    assert_close(union.normal_tensors[0], area / dimension * np.eye(dimension), 1e-15)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("distance", [1e-3, 0.3, 1.0, 1.7, 1.999])
def test_two_balls(dimension: int, distance: float) -> None:
    points = np.zeros((2, dimension))
    points[1, :2] = distance * np.array([0.6, 0.8])
    union, expected = measure_balls(points, 1.0), oracles.two_balls(points, 1.0)
    for name in oracles.MEASURES:
        assert_close(getattr(union, name), getattr(expected, name), 1e-12)


@pytest.mark.parametrize("distance", [0.3, 1.0, 1.7])
def test_volume_and_area_of_two_balls(distance: float) -> None:
    union = measure_balls(np.array([[0, 0, 0], [0, 0, distance]]), 1.0)
    lens = np.pi * (4 + distance) * (2 - distance) ** 2 / 12
    assert union.volume == pytest.approx(8 * np.pi / 3 - lens, rel=1e-14)
    assert union.area == pytest.approx(4 * np.pi + 2 * np.pi * distance, rel=1e-14)


@pytest.mark.parametrize("distance", [0.3, 1.0, 1.7])
def test_normal_tensor_of_two_balls(distance: float) -> None:
    union = measure_balls(np.array([[0, 0, 0], [distance, 0, 0]]), 1.0)
    for tensor in union.normal_tensors:
        assert_close(tensor, oracles.lens_tensor(1.0, distance), 1e-12)


@pytest.mark.parametrize("triangle", TRIANGLES)
def test_three_balls(triangle: str) -> None:
    points = TRIANGLES[triangle]
    union, expected = measure_balls(points, 1.0), oracles.three_balls(points, 1.0)
    for name in oracles.MEASURES:
        assert_close(getattr(union, name), getattr(expected, name), 1e-12)
    volume, area = oracles.three_ball_totals(points, 1.0)
    assert union.volume == pytest.approx(volume, rel=1e-12)
    assert union.area == pytest.approx(area, rel=1e-12)


@pytest.mark.parametrize("triangle", ["equilateral", "acute"])
def test_three_disks(triangle: str) -> None:
    points = TRIANGLES[triangle][:, :2]
    union, expected = measure_balls(points, 1.0), oracles.three_disks(points, 1.0)
    for name in oracles.MEASURES:
        assert_close(getattr(union, name), getattr(expected, name), 1e-12)


# --- measures of random clouds


@every_cloud
def test_measures_agree_with_quadrature(kind: str, dimension: int, spacings: float) -> None:
    points, radius = ball_cloud(kind, dimension, spacings, 60)
    union = measure_balls(points, radius)
    visible = np.flatnonzero(union.visible_areas > 0)
    for i in visible[:: -(-len(visible) // (2 if spacings < 4 else 1))]:
        arms = np.delete(points, i, axis=0) - points[i]
        distances = np.linalg.norm(arms, axis=1)
        arms, distances = arms[distances < 2 * radius], distances[distances < 2 * radius]
        area, flux, tensor = oracles.moments_on_sphere(arms, radius)
        facets, rims = oracles.facet_areas(arms, radius), oracles.rim_weights(arms, radius)
        expected = {
            "cell_volumes": (radius * area + facets @ distances / 2) / dimension,
            "visible_areas": area,
            "volume_gradient": flux,  # the integral of n over the visible boundary: Prop. 5
            "area_gradient": -(rims / distances) @ arms,
            "normal_tensors": tensor,
            "volume_diagonal": (facets / distances).sum(),
            "area_diagonal": (rims / distances).sum(),
        }
        for name, value in expected.items():
            assert_close(getattr(union, name)[i], value, 3e-10, scale_of(name, union))


@every_cloud
def test_cells_grow_by_their_visible_boundary(kind: str, dimension: int, spacings: float) -> None:
    points, radius = ball_cloud(kind, dimension, spacings, 200)
    step = 1e-5 * radius
    larger, smaller = measure_balls(points, radius + step), measure_balls(points, radius - step)
    growth = (larger.cell_volumes - smaller.cell_volumes) / (2 * step)
    areas = union_of(kind, dimension, spacings).visible_areas
    # the step leaves 1e-10 of truncation, rounding over the step 1e-11
    assert_close(growth, areas, 1e-9, scale_of("visible_areas", larger))


@every_cloud
def test_tensors_are_integrals_of_squares_of_unit_vectors(
    kind: str, dimension: int, spacings: float
) -> None:
    union = union_of(kind, dimension, spacings)
    size = scale_of("visible_areas", union)
    traces = np.trace(union.normal_tensors, axis1=1, axis2=2)
    assert_close(traces, union.visible_areas, 1e-13, size)
    assert_close(np.linalg.eigvalsh(union.normal_tensors).min(initial=0), 0, 1e-13, size)


# --- points that are near, touch, or are covered


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("distance", [1e-20, 1e-150, 1e-200])
def test_points_next_to_each_other_share_a_ball(dimension: int, distance: float) -> None:
    points = np.zeros((3, dimension))
    points[1, 0], points[2, 1] = distance, 1.0
    union, expected = measure_balls(points, 1.0), measure_balls(points[[0, 2]], 1.0)
    assert np.isfinite(union.measures).all()
    assert union.volume == pytest.approx(expected.volume, rel=1e-14)
    assert union.area == pytest.approx(expected.area, rel=1e-14)


@pytest.mark.parametrize("dimension", [2, 3])
def test_balls_that_touch_are_whole(dimension: int) -> None:
    points = np.zeros((3, dimension))
    points[1, 0], points[2, 1] = 0.7, 2.0
    union = measure_balls(points, 1.0)
    pair, one = measure_balls(points[:2], 1.0), measure_balls(points[2:], 1.0)
    np.testing.assert_allclose(union.measures[:2], pair.measures, rtol=1e-15, atol=0)
    np.testing.assert_allclose(union.measures[2:], one.measures, rtol=1e-15, atol=0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_covered_ball(dimension: int) -> None:
    """A ball among near ones in every direction has no visible boundary and no gradient."""
    around = np.r_[np.eye(dimension), -np.eye(dimension)]
    union = measure_balls(np.r_[np.zeros((1, dimension)), around], 1.0)
    assert union.visible_areas[0] == 0
    assert not union.normal_tensors[0].any()
    assert not union.area_gradient[0].any()
    assert_close(union.volume_gradient[0], 0, 1e-15, 1.0)
    assert union.cell_volumes[0] == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("quantity", get_args(Quantity))
def test_boundary_that_rounding_alone_shows_has_no_mass(quantity: Quantity) -> None:
    """At the circumradius of its triangles a hexagonal grid is covered, up to rounding."""
    grid = oracles.lattice(8, 8) @ np.array([[1, 0], [0.5, np.sqrt(0.75)]])
    evaluation = BallEnergy(1 / np.sqrt(3), quantity, "boundary").evaluate(grid)
    inside = ((oracles.lattice(8, 8) > 0) & (oracles.lattice(8, 8) < 7)).all(axis=1)
    assert not evaluation.masses[inside].any()
    assert evaluation.masses[~inside].all()
