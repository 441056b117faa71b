"""Grids, lines, spheres and clusters, where facets vanish, coincide or shrink to points.

The identities of a union hold for wrong facets too. So measures are also compared to the same
set turned and moved, to other radii, and to closed forms.
"""

from __future__ import annotations

from functools import cache
from itertools import permutations, product
from math import acos, pi, sqrt

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import oracles
from oracles import (
    Array,
    assert_close,
    assert_identities,
    assert_positive_tensors,
    ball_volume,
    lattice,
    sphere_area,
)
from pcsmooth.energies.balls import BallUnion, measure_balls

HEXAGONAL = np.array([[1, 0], [0.5, sqrt(0.75)]])
FCC = np.array([[0, 1, 1], [1, 0, 1], [1, 1, 0]]) / sqrt(2)
RNG = np.random.default_rng(0)

#: Nearest neighbours at distance 1, or thereabouts.
SETS: dict[str, Array] = {
    "square": lattice(6, 6),
    "hexagonal": lattice(6, 6) @ HEXAGONAL,
    "collinear-2d": lattice(9, 1) * [1, 0],
    "cocircular-2d": np.r_[oracles.even_circle(12, 1.8), np.zeros((1, 2))],
    "cubic": lattice(4, 4, 4),
    "planar": lattice(6, 6, 1) * [1, 1, 0],
    "fcc": lattice(4, 4, 4) @ FCC,
    "collinear": lattice(9, 1, 1) * [1, 0, 0],
    "collinear-random": np.outer(np.cumsum(0.1 + 0.4 * RNG.random(20)), [0.36, 0.48, 0.8]),
    "coplanar-random": np.c_[4 * RNG.random((30, 2)), np.zeros(30)],
    "cospherical": np.unique(
        [
            np.multiply(p, s) / 2
            for p in permutations((1, 2, 3))
            for s in product((1, -1), repeat=3)
        ],
        axis=0,
    ),
    "cocircular-with-axis": np.r_[
        np.c_[oracles.even_circle(12, 2.0), np.zeros(12)], [[0, 0, z] for z in (-1, 0, 1, 2)]
    ],
    "cube": lattice(2, 2, 2),
}
SETS["cospherical-with-center"] = np.r_[SETS["cospherical"], np.zeros((1, 3))]

#: Radii at which, in unit grids, spheres meet edges and corners of cells, and other points.
RADII = [1 / sqrt(3), sqrt(0.5), sqrt(0.75), 1.0, 1.5, 2.5]

every_case = pytest.mark.parametrize("radius", RADII)
every_set = pytest.mark.parametrize("name", SETS)


@cache
def union_of(name: str, radius: float) -> BallUnion:
    return measure_balls(SETS[name], radius)


def growth_of_area(points: Array, union: BallUnion) -> float:
    """dA / dr, as the area is homogeneous of degree d - 1 in points and radius."""
    virial = float((points * union.area_gradient).sum())
    return ((union.dimension - 1) * union.area - virial) / union.radius


@every_case
@every_set
def test_identities(name: str, radius: float) -> None:
    union = union_of(name, radius)
    assert np.isfinite(union.measures).all()
    assert_identities(SETS[name], union, 1e-13)
    assert_positive_tensors(union, 1e-13)


@every_case
@every_set
@pytest.mark.parametrize("seed", [0, 1])
def test_turned_and_moved_set_has_the_same_measures(name: str, radius: float, seed: int) -> None:
    expected, d = union_of(name, radius), union_of(name, radius).dimension
    rng = np.random.default_rng(seed)
    rotation = oracles.random_rotation(d, rng)
    actual = measure_balls(SETS[name] @ rotation.T + 1e3 * rng.random(d), radius)
    # coordinates near 1,000 are rounded by 1e-13
    assert_close(actual.cell_volumes, expected.cell_volumes, 1e-12, radius**d)
    assert_close(actual.visible_areas, expected.visible_areas, 1e-11, radius ** (d - 1))
    turned = expected.volume_gradient @ rotation.T
    assert_close(actual.volume_gradient, turned, 1e-11, radius ** (d - 1))


@every_case
@every_set
@pytest.mark.parametrize("change", [-1e-7, 1e-7])
def test_measures_are_continuous_in_the_radius(name: str, radius: float, change: float) -> None:
    union, points = union_of(name, radius), SETS[name]
    other = measure_balls(points, radius + change)
    d = union.dimension
    grown = union.cell_volumes + change * (union.visible_areas + other.visible_areas) / 2
    assert_close(other.cell_volumes, grown, 1e-13, radius**d)
    # above a tie the growth of the area falls as a square root, for each contact of a point
    area = other.area - change * growth_of_area(points, other)
    assert union.area == pytest.approx(area, abs=abs(change) ** 1.5 * 40 * len(points))


def segment(radius: float, height: float) -> float:
    """Part of a disk beyond a line at a height above its centre."""
    return radius**2 * acos(height / radius) - height * sqrt(radius**2 - height**2)


def cap(radius: float, height: float) -> float:
    """Part of a ball beyond a plane at a height above its centre."""
    return pi / 3 * (radius - height) ** 2 * (2 * radius + height)


SQUARE_TIE, CUBE_TIE = sqrt(0.5), sqrt(0.75)


@pytest.mark.parametrize(
    ("name", "radius", "volume", "area"),
    [
        ("square", SQUARE_TIE, 1.0, 0.0),
        *[("square", r, 1.0, 0.0) for r in (1.0, 1.5, 2.5)],
        ("square", 0.6, 0.36 * pi - 4 * segment(0.6, 0.5), 1.2 * (pi - 4 * acos(5 / 6))),
        *[("hexagonal", r, CUBE_TIE, 0.0) for r in (1 / sqrt(3), 1.0, 1.5, 2.5)],
        ("collinear-2d", 1.0, sqrt(0.75) + pi / 3, 2 * pi / 3),
        *[("cubic", r, 1.0, 0.0) for r in (CUBE_TIE, 1.0, 1.5, 2.5)],
        (
            "cubic",  # the circles of neighbouring facets touch
            SQUARE_TIE,
            ball_volume(SQUARE_TIE, 3) - 6 * cap(SQUARE_TIE, 0.5),
            2 * pi - 12 * pi * SQUARE_TIE * (SQUARE_TIE - 0.5),
        ),
        *[("fcc", r, sqrt(0.5), 0.0) for r in (SQUARE_TIE, 1.0, 1.5, 2.5)],
        *[("collinear", r, pi * (r**2 - 1 / 12), 2 * pi * r) for r in (SQUARE_TIE, 1.0, 2.5)],
    ],
)
def test_interior_cell_has_its_closed_form(
    name: str, radius: float, volume: float, area: float
) -> None:
    union = union_of(name, radius)
    points = SETS[name]
    interior = np.linalg.norm(points - points.mean(axis=0), axis=1).argmin()
    assert union.cell_volumes[interior] == pytest.approx(volume, rel=1e-14)
    assert union.visible_areas[interior] == pytest.approx(area, rel=1e-13, abs=1e-14)
    assert_close(union.volume_gradient[interior], 0, 1e-13, radius ** (union.dimension - 1))
    if union.dimension == 3:  # in 2D it jumps at a tie
        assert_close(union.area_gradient[interior], 0, 1e-13, radius)


@pytest.mark.parametrize("radius", [1.0, 1.5, 2.5])
def test_cell_of_a_planar_grid_is_a_square_prism_with_round_ends(radius: float) -> None:
    x, weights = np.polynomial.legendre.leggauss(60)
    squares = np.add.outer(x**2, x**2) / 4
    both = np.outer(weights, weights) / 4
    height = np.sqrt(radius**2 - squares)
    union = union_of("planar", radius)
    interior = 14  # column 2 of row 2
    assert union.cell_volumes[interior] == pytest.approx((2 * both * height).sum(), rel=1e-13)
    area = (2 * both * radius / height).sum()
    assert union.visible_areas[interior] == pytest.approx(area, rel=1e-13)


def mean_width_integral(points: Array) -> float:
    """Integral over all directions of the support function of the points' convex hull."""
    hull = ConvexHull(points)
    if points.shape[1] == 2:
        return float(hull.area)  # the perimeter
    total = 0.0
    for face, neighbors in enumerate(hull.neighbors):
        for corner, other in enumerate(neighbors):
            edge = points[np.delete(hull.simplices[face], corner)]
            normals = hull.equations[[face, other], :3]
            turn = np.arctan2(np.linalg.norm(np.cross(*normals)), normals[0] @ normals[1])
            total += float(np.linalg.norm(edge[1] - edge[0]) * turn) / 4  # each edge comes twice
    return total


@pytest.mark.parametrize(
    ("dimension", "exponent"), [(2, k) for k in range(1, 10)] + [(3, k) for k in (1, 3, 5, 7, 9)]
)
def test_cluster_within_one_radius(dimension: int, exponent: int) -> None:
    """Around a cluster of size s, the distance in direction w is r + h(w) + O(s^2) from it.

    So V = V_1 + r^(d-1) int h dw and A = A_1 + (d - 1) r^(d-2) int h dw up to terms of order
    s^2; rounding moves corners near a facet's centre by 1e-16, seen from s away.
    """
    points = np.random.default_rng(exponent).normal(size=(1000, dimension))
    points /= np.maximum(1, np.linalg.norm(points, axis=1, keepdims=True))
    size = 10.0**-exponent
    union = measure_balls(size * points, 1.0)
    assert np.isfinite(union.measures).all()
    assert_identities(size * points, union, 1e-12)
    width = size * mean_width_integral(points)
    volume = ball_volume(1.0, dimension) + width
    area = sphere_area(1.0, dimension) + (dimension - 1) * width
    tolerance = 5 * size**2 + (1e-15 if dimension == 2 else 3e-14)
    assert union.volume == pytest.approx(volume, rel=tolerance)
    assert union.area == pytest.approx(area, rel=tolerance)
