"""Unions of balls whose radii differ: power cells in the place of Voronoi cells."""

from __future__ import annotations

from functools import cache
from itertools import product
from math import pi, sqrt
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

import oracles
from flows.dense import weight_matrix
from oracles import Array, assert_close, assert_identities, scale_of
from pcsmooth import InvalidInputError
from pcsmooth.energies.balls import BallUnion, measure_balls
from pcsmooth.energies.facet_laplacian import facet_laplacian
from pcsmooth.kernels.threads import thread_limit

every_dimension = pytest.mark.parametrize("dimension", [2, 3])

#: (kind of cloud, dimension, by how much of the largest one radii differ).
CLOUDS = list(product(("cloud", "surface"), (2, 3), (0.05, 0.3, 0.8)))
every_cloud = pytest.mark.parametrize(("kind", "dimension", "change"), CLOUDS)


@cache
def cloud(kind: str, dimension: int, change: float, n: int = 150) -> tuple[Array, Array]:
    """Points in a cube or near a sphere, and radii of up to three spacings."""
    rng = np.random.default_rng(3)
    points = oracles.uniform_cloud(n, dimension)
    spacing = n ** (-1 / dimension)
    if kind == "surface":
        points = oracles.random_sphere(n, dimension=dimension)
        points *= 1 + 0.02 * rng.normal(size=(n, 1))
        spacing = oracles.sphere_area(1.0, dimension) / n
        spacing = spacing if dimension == 2 else sqrt(spacing)
    return points, 3 * spacing * (1 - change * rng.random(n))


@cache
def union_of(kind: str, dimension: int, change: float) -> BallUnion:
    return measure_balls(*cloud(kind, dimension, change))


def expected_at(i: int, points: Array, radii: Array) -> dict[str, Array | float]:
    """Measures of one point, by quadrature."""
    radius, d = radii[i], points.shape[1]
    arms, others = np.delete(points, i, axis=0) - points[i], np.delete(radii, i)
    distances = np.linalg.norm(arms, axis=1)
    heights = oracles.radical_heights(arms, radius, others)
    near = (distances < radius + others) & (heights < radius)
    arms, others, distances, heights = arms[near], others[near], distances[near], heights[near]
    area, flux, tensor = oracles.moments_on_sphere(arms, radius, heights, nodes=96)
    facets, rims = np.zeros(len(arms)), np.zeros(len(arms))
    across = np.zeros(d)
    if heights.min(initial=radius) > -radius:
        facets = oracles.facet_areas(arms, radius, heights, nodes=96)
        angles, sums = oracles.visible_rims(arms, radius, heights)
        rho = np.sqrt(radius**2 - heights**2)
        rims = angles * (radius * (distances - heights) + others * heights) / distances
        rims, sums = (rims / rho, sums) if d == 2 else (rims, sums * rho[:, np.newaxis])
        across = (radius - others) / distances @ sums
    units = arms / distances[:, np.newaxis]
    return {
        "cell_volumes": (radius * area + facets @ heights) / d,
        "visible_areas": area,
        "volume_gradient": flux,
        "area_gradient": across - rims @ units,
        "normal_tensors": tensor,
        "volume_diagonal": (facets / distances).sum(),
        "area_diagonal": (rims / distances).sum(),
    }


def is_outside(points: Array, radii: Array) -> npt.NDArray[np.int64]:
    """Numbers of the points that lie outside their cells."""
    powers = ((points[:, np.newaxis] - points) ** 2).sum(axis=2) - radii**2
    return np.flatnonzero(powers.argmin(axis=1) != np.arange(len(points)))


# --- closed forms


@pytest.mark.parametrize(("first", "second", "distance"), [
    (1.0, 0.5, 1.2), (1.0, 0.5, 0.9), (0.5, 1.0, 0.6), (1.0, 0.01, 1.0), (2.0, 1.999, 0.01),
])  # fmt: skip
def test_two_balls(first: float, second: float, distance: float) -> None:
    axis = np.array([0.36, 0.48, 0.8])
    union = measure_balls(np.outer([0, distance], axis), [first, second])
    height = (distance**2 + first**2 - second**2) / (2 * distance)
    rho2 = first**2 - height**2
    heights = np.array([height, distance - height])
    radii = np.array([first, second])
    visible = 2 * pi * radii * (radii + heights)
    volumes = pi * (radii + heights) ** 2 * (2 * radii - heights) / 3
    assert_close(union.visible_areas, visible, 1e-12)
    assert_close(union.cell_volumes, volumes, 1e-12)
    assert_close(union.volume_gradient, pi * rho2 * np.outer([-1, 1], axis), 1e-12)
    rim = 2 * pi * (first * heights[1] + second * heights[0]) / distance
    assert_close(union.area_gradient, rim * np.outer([-1, 1], axis), 1e-12)


@pytest.mark.parametrize(("first", "second", "distance"), [(1.0, 0.5, 1.2), (1.0, 0.7, 0.5)])
def test_two_disks(first: float, second: float, distance: float) -> None:
    union = measure_balls(np.outer([0, distance], [1, 0]), [first, second])
    height = (distance**2 + first**2 - second**2) / (2 * distance)
    rho = sqrt(first**2 - height**2)
    angles = np.arctan2(rho, [height, distance - height])
    radii = np.array([first, second])
    assert_close(union.visible_areas, 2 * radii * (pi - angles), 1e-12)
    volumes = radii**2 * (pi - angles) + rho * np.array([height, distance - height])
    assert_close(union.cell_volumes, volumes, 1e-12)


@pytest.mark.parametrize("radii", [(1.0, 0.9, 0.8), (1.0, 0.6, 0.7), (0.5, 1.1, 0.9)])
def test_three_balls(radii: tuple[float, float, float]) -> None:
    points = np.array([[0, 0, 0], [1.0, 0.1, 0], [0.4, 0.8, -0.1]])
    union = measure_balls(points, radii)
    volume, area = oracles.three_ball_totals(points, np.array(radii))
    assert union.volume == pytest.approx(volume, rel=1e-12)
    assert union.area == pytest.approx(area, rel=1e-12)


@every_dimension
@pytest.mark.parametrize("distance", [0.0, 1e-9, 0.2, 0.5])
def test_ball_inside_another_counts_for_nothing(dimension: int, distance: float) -> None:
    points = np.zeros((2, dimension))
    points[0, 0] = distance  # at 0.5 they touch
    union, alone = measure_balls(points, [0.5, 1.0]), measure_balls(points[1:], 1.0)
    assert not union.measures[0].any()
    np.testing.assert_array_equal(union.measures[1:], alone.measures)


@every_dimension
def test_balls_that_touch_are_whole(dimension: int) -> None:
    points = np.zeros((2, dimension))
    points[1, 0] = 1.75
    union = measure_balls(points, [1.0, 0.75])
    for i, radius in enumerate((1.0, 0.75)):
        alone = measure_balls(points[:1], radius)
        np.testing.assert_array_equal(union.measures[i], alone.measures[0])


def test_ball_hidden_by_several_has_an_empty_cell() -> None:
    around = np.r_[np.eye(3), -np.eye(3)]
    union = measure_balls(np.r_[np.zeros((1, 3)), around], np.r_[0.5, np.full(6, 1.4)])
    assert not union.measures[0].any()
    assert_identities(np.r_[np.zeros((1, 3)), around], union, 1e-12)


# --- random clouds


@every_cloud
def test_measures_agree_with_quadrature(kind: str, dimension: int, change: float) -> None:
    points, radii = cloud(kind, dimension, change)
    union = union_of(kind, dimension, change)
    outside = np.intersect1d(is_outside(points, radii), np.flatnonzero(union.visible_areas))
    visible = np.flatnonzero(union.visible_areas > 0)
    hidden = np.flatnonzero(union.cell_volumes == 0)
    assert change < 0.3 or (len(outside) and len(hidden))
    for i in np.r_[visible[:: len(visible) // 3], outside[:2], hidden[:1]]:
        for name, value in expected_at(i, points, radii).items():
            assert_close(getattr(union, name)[i], value, 3e-10, scale_of(name, union))


@every_cloud
def test_gradients_are_those_of_volume_and_area(kind: str, dimension: int, change: float) -> None:
    points, radii = cloud(kind, dimension, change)
    union = union_of(kind, dimension, change)
    step = 1e-5 * radii.max()
    for i, axis in product(range(0, len(points), 19), range(dimension)):
        moved = [points.copy(), points.copy()]
        moved[0][i, axis] -= step
        moved[1][i, axis] += step
        less, more = (measure_balls(each, radii) for each in moved)
        volume = (more.volume - less.volume) / (2 * step)
        area = (more.area - less.area) / (2 * step)
        assert_close(union.volume_gradient[i, axis], volume, 1e-7, radii.max() ** (dimension - 1))
        assert_close(union.area_gradient[i, axis], area, 1e-6, radii.max() ** (dimension - 2))


@every_cloud
def test_volume_grows_with_a_radius_by_the_visible_boundary(
    kind: str, dimension: int, change: float
) -> None:
    points, radii = cloud(kind, dimension, change)
    union, step = union_of(kind, dimension, change), 1e-5 * radii.max()
    for i in range(0, len(points), 13):
        less, more = radii.copy(), radii.copy()
        less[i] -= step
        more[i] += step
        growth = measure_balls(points, more).volume - measure_balls(points, less).volume
        size = scale_of("visible_areas", union)
        assert_close(growth / (2 * step), union.visible_areas[i], 1e-8, size)


@every_cloud
def test_identities(kind: str, dimension: int, change: float) -> None:
    points, radii = cloud(kind, dimension, change)
    union = union_of(kind, dimension, change)
    assert_identities(points, union, 1e-11)
    scaling = (points * union.area_gradient).sum()
    step = 1e-5
    larger, smaller = (measure_balls(points, radii * (1 + side * step)) for side in (1, -1))
    growth = (larger.area - smaller.area) / (2 * step)
    assert scaling + growth == pytest.approx((dimension - 1) * union.area, rel=1e-7)


@every_dimension
def test_covered_cells_are_those_of_the_power_diagram(dimension: int) -> None:
    points = oracles.uniform_cloud(120, dimension)
    radii = 0.5 + 0.05 * np.random.default_rng(4).random(120)
    union = measure_balls(points, radii)
    covered = np.flatnonzero((union.visible_areas == 0) & (union.cell_volumes > 0))
    assert len(covered) > 5
    for i in covered[::3]:
        others = np.delete(np.arange(120), i)
        arms = points[others] - points[i]
        offsets = ((arms**2).sum(axis=1) + radii[i] ** 2 - radii[others] ** 2) / 2
        norms = np.linalg.norm(arms, axis=1)
        widest = linprog(
            [*[0.0] * dimension, -1.0], np.c_[arms, norms], offsets,
            bounds=[*[(None, None)] * dimension, (0, None)],
        ).x  # fmt: skip
        cell = HalfspaceIntersection(np.c_[arms, -offsets], widest[:dimension])
        volume = ConvexHull(cell.intersections).volume
        assert union.cell_volumes[i] == pytest.approx(volume, rel=1e-8)


@every_dimension
def test_radii_may_differ_a_hundredfold(dimension: int) -> None:
    rng = np.random.default_rng(5)
    radii = 10 ** (2 * rng.random(200) - 2.5)
    points = rng.random((200, dimension)) * [2.0, *[1.0] * (dimension - 1)]
    union = measure_balls(points, radii)
    assert_identities(points, union, 1e-10)
    for i in np.flatnonzero(union.visible_areas > 0)[::25]:
        for name, value in expected_at(i, points, radii).items():
            size = radii[i] ** (dimension + oracles.POWERS[name])
            assert_close(getattr(union, name)[i], value, 1e-9, size)


@every_dimension
def test_large_coordinates_cost_no_more_than_their_rounding(dimension: int) -> None:
    points, radii = cloud("cloud", dimension, 0.3)
    points = np.round(points * 2.0**28) / 2.0**28
    far = measure_balls(points + 2.0**22, radii)
    np.testing.assert_allclose(far.measures, measure_balls(points, radii).measures, atol=1e-11)


# --- grids and other ties

SETS = {
    "square": oracles.lattice(6, 6),
    "row": oracles.lattice(9, 1, 1),
    "plane": oracles.lattice(5, 5, 1),
    "cubic": oracles.lattice(4, 4, 4),
    "face-centred": oracles.lattice(3, 3, 3) @ np.array([[0, 1, 1], [1, 0, 1], [1, 1, 0]]) / 2,
}

#: Radii at which points lie in faces, edges and corners of their own cells, spheres share circles,
#: and others touch.
RADII = {"sides": [1.0, sqrt(2)], "roots": [1.0, sqrt(2), sqrt(3)], "halves": [0.75, 1.25]}


@pytest.mark.parametrize("choice", RADII)
@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("seed", range(3))
def test_ties(name: str, choice: str, seed: int) -> None:
    points, rng = SETS[name], np.random.default_rng(seed)
    n, d = points.shape
    radii = rng.choice(RADII[choice], n)
    union = measure_balls(points, radii)
    assert np.isfinite(union.measures).all()
    assert_close(union.volume_gradient.sum(axis=0), 0, 1e-12, n)
    virial = (points * union.volume_gradient).sum() + radii @ union.visible_areas
    assert virial == pytest.approx(d * union.volume, rel=1e-12)
    # Where circles touch, what is visible of them is the root of a rounding error.
    assert_close(union.area_gradient.sum(axis=0), 0, 1e-7, n)
    rotation = oracles.random_rotation(d, rng)
    turned = measure_balls(points @ rotation.T + rng.random(d), radii)
    assert_close(turned.cell_volumes, union.cell_volumes, 1e-6)
    assert_close(turned.visible_areas, union.visible_areas, 1e-6)


# --- what is given, and how


@every_dimension
def test_equal_radii_are_a_radius(dimension: int) -> None:
    points, _ = cloud("cloud", dimension, 0.3)
    union = measure_balls(points, np.full(len(points), 0.3))
    assert union.radii is None
    assert union.measures.tobytes() == measure_balls(points, 0.3).measures.tobytes()


@every_dimension
def test_largest_of_coincident_balls_carries_the_cell(dimension: int) -> None:
    points, radii = cloud("cloud", dimension, 0.3)
    rng = np.random.default_rng(6)
    of = rng.permutation(np.r_[np.arange(len(points)), rng.integers(0, len(points), 80)])
    scale = rng.choice([0.5, 0.9, 1.0], len(of))
    scale[[np.flatnonzero(of == i)[-1] for i in range(len(points))]] = 1.0
    union = measure_balls(points[of], radii[of] * scale)
    carriers = [np.flatnonzero((of == i) & (scale == 1.0))[0] for i in range(len(points))]
    np.testing.assert_array_equal(union.carriers, np.array(carriers)[of])
    assert_close(union.measures[carriers], measure_balls(points, radii).measures, 1e-12)
    others = np.setdiff1d(np.arange(len(of)), carriers)
    assert not union.measures[others].any()


@every_dimension
def test_threads_and_units_change_no_byte(dimension: int) -> None:
    points = 2 * oracles.uniform_cloud(600, dimension) * [200.0, *[1.0] * (dimension - 1)]
    radii = np.random.default_rng(7).uniform(0.3, 2.0, 600)
    found = []
    for threads in (1, 2):
        with thread_limit(threads):
            found.append(measure_balls(points, radii).measures.tobytes())
    assert found[0] == found[1]
    scaled = measure_balls(np.ldexp(points, 300), np.ldexp(radii, 300))
    volumes = np.ldexp(scaled.cell_volumes, -300 * dimension)
    np.testing.assert_array_equal(volumes, measure_balls(points, radii).cell_volumes)


@every_dimension
def test_facet_weights_give_the_volume_gradient(dimension: int) -> None:
    points, radii = cloud("cloud", dimension, 0.3)
    union = measure_balls(points, radii)
    weights = weight_matrix(facet_laplacian(union, "volume"))
    here = points[union.numbers]
    gradient = weights.sum(axis=1)[:, np.newaxis] * here - weights @ here
    size = scale_of("volume_gradient", union)
    assert_close(gradient, union.volume_gradient[union.numbers], 1e-11, size)
    rims = weight_matrix(facet_laplacian(union, "area"))
    assert_close(rims.sum(axis=1), union.area_diagonal[union.numbers], 1e-10)


@pytest.mark.parametrize(
    ("radii", "message"),
    [
        ([1.0, 2.0], r"radii have shape \(2,\); there must be one for all points, or 3"),
        ([[1.0, 2.0, 3.0]], r"radii have shape \(1, 3\)"),
        ([1.0, 0.0, 3.0], "the radius of point 1 is 0.0; it must be finite and positive"),
        ([1.0, 2.0, -1.0], "the radius of point 2 is -1.0"),
        ([np.nan, 2.0, 1.0], "the radius of point 0 is nan"),
        ([1.0, np.inf, 1.0], "the radius of point 1 is inf"),
        (["a", "b", "c"], "radii are not an array of real numbers"),
    ],
)
def test_radii_that_are_none_are_refused(radii: Any, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        measure_balls(np.eye(3), radii)
