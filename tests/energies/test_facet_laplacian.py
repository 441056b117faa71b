"""Weights of the facets, against the gradients that they add up to and by brute force."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import HalfspaceIntersection

import oracles
from flows.dense import weight_matrix
from oracles import Array
from pcsmooth.energies.balls import measure_balls
from pcsmooth.energies.facet_laplacian import facet_laplacian
from pcsmooth.energies.protocol import Quantity
from pcsmooth.kernels.threads import thread_limit

every_quantity = pytest.mark.parametrize("quantity", get_args(Quantity))
every_dimension = pytest.mark.parametrize("dimension", [2, 3])

#: Points on an axis. On two skew lines every point of one has a facet with every one of the other.
LINE = np.linspace(-1, 1, 30)[:, np.newaxis] * [1.0, 0.0]

#: The kernels' blocks are 64 diameters wide in 2D, and 8 in 3D.
STRIP = oracles.uniform_cloud(800, 3) * [40.0, 1.0, 1.0]

CLOUDS = {
    "uniform 2D": (oracles.uniform_cloud(300, 2), 0.12),
    "uniform 3D": (oracles.uniform_cloud(300, 3), 0.2),
    "blocks 2D": (STRIP[:, :2], 0.15),
    "blocks 3D": (oracles.random_torus(1000)[0], 0.15),
    "crowded": (0.1 * oracles.uniform_cloud(150, 3), 0.5),
    "grid 2D": (oracles.lattice(9, 9), 0.9),
    "grid 3D": (oracles.lattice(5, 5, 5), 0.9),
    "line": (np.linspace(0, 1, 50)[:, np.newaxis] * [1.0, 2.0, 3.0], 0.2),
    "twins": (np.r_[oracles.uniform_cloud(50, 3), oracles.uniform_cloud(20, 3)], 0.3),
    "skew lines": (np.r_[LINE @ np.eye(2, 3), LINE @ np.eye(2, 3, 1) + [0, 0, 1]], 5.0),
    "one": (np.ones((1, 3)), 1.0),
    "two": (np.array([[0.0, 0.0], [1.0, 0.0]]), 1.0),
    "far apart": (10 * oracles.lattice(3, 2), 1.0),
    "at a distance": (oracles.uniform_cloud(200, 3) + 2.0**12, 0.2),
}


@every_quantity
@pytest.mark.parametrize(("points", "radius"), CLOUDS.values(), ids=CLOUDS)
def test_rows_give_gradient_and_diagonal(points: Array, radius: float, quantity: Quantity) -> None:
    union = measure_balls(points, radius)
    laplacian = facet_laplacian(union, quantity)
    weights = weight_matrix(laplacian)
    assert (laplacian.weights > 0).all()
    np.testing.assert_array_equal(weights, weights.T)
    assert not weights.diagonal().any()
    here = points[union.numbers]
    gradient = getattr(union, f"{quantity}_gradient")[union.numbers]
    diagonal = getattr(union, f"{quantity}_diagonal")[union.numbers]
    sums = weights.sum(axis=1)
    arms = here[:, np.newaxis] - here
    size = max(np.abs(gradient).max(), np.finfo(float).tiny)
    product = np.einsum("ij,ijk->ik", weights, arms)
    np.testing.assert_allclose(product, gradient, rtol=0, atol=1e-12 * size)
    np.testing.assert_allclose(laplacian.diagonal, sums, rtol=1e-13)
    largest = max(sums.max(), np.finfo(float).tiny)
    np.testing.assert_allclose(laplacian.diagonal, diagonal, rtol=1e-12, atol=1e-12 * largest)


def facet_measure(points: Array, i: int, j: int, radius: float) -> float:
    """Measure of the facet of a crowd whose cells are far smaller than the ball, with Qhull."""
    others = np.delete(np.arange(len(points)), [i, j])
    normal = points[j] - points[i]
    middle = (points[i] + points[j]) / 2
    frame = np.linalg.svd(normal[np.newaxis])[2][1:]
    arms = points[others] - points[i]
    levels = np.einsum("ij,ij->i", arms, (points[others] + points[i]) / 2 - middle)
    bounds = np.r_[arms @ frame.T, np.eye(2), -np.eye(2)]
    levels = np.r_[levels, np.full(4, radius)]
    # the centre of the largest disk inside
    found = linprog(
        [0, 0, -1],
        A_ub=np.c_[bounds, np.linalg.norm(bounds, axis=1)],
        b_ub=levels,
        bounds=[(None, None), (None, None), (0, None)],
    )
    if not found.success or found.x[2] < 1e-9:
        return 0.0
    corners = HalfspaceIntersection(np.c_[bounds, -levels], found.x[:2]).intersections
    around = corners - corners.mean(axis=0)
    x, y = around[np.argsort(np.arctan2(around[:, 1], around[:, 0]))].T
    return float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)


def test_weights_are_facets_over_distances() -> None:
    """The facets of points deep in a crowd are those of the unrestricted Voronoi diagram."""
    points, radius = oracles.uniform_cloud(60, 3), 10.0
    union = measure_balls(points, radius)
    weights = weight_matrix(facet_laplacian(union, "volume"))
    places = np.argsort(union.numbers)
    inner = np.argsort(np.linalg.norm(points - 0.5, axis=1))[:2]
    for i in inner:
        distances = np.linalg.norm(points - points[i], axis=1)
        expected = [
            0.0 if i == j else facet_measure(points, i, j, radius) / distances[j]
            for j in range(len(points))
        ]
        actual = weights[places[i]][places]
        np.testing.assert_allclose(actual, expected, rtol=1e-8, atol=1e-8 * actual.max())


@pytest.mark.parametrize(("dimension", "distance"), [(2, 1.2), (3, 1.2), (2, 0.3), (3, 0.3)])
def test_two_balls(dimension: int, distance: float) -> None:
    points = np.zeros((2, dimension))
    points[1, 0] = distance
    union = measure_balls(points, 1.0)
    rho2 = 1 - distance**2 / 4
    area, rim = {
        2: (2 * np.sqrt(rho2), 2 / np.sqrt(rho2)),
        3: (np.pi * rho2, 2 * np.pi),
    }[dimension]
    for quantity, measure in (("volume", area), ("area", rim)):
        laplacian = facet_laplacian(union, quantity)  # type: ignore[arg-type]
        np.testing.assert_allclose(laplacian.weights, 2 * [measure / distance], rtol=1e-14)


@every_quantity
@every_dimension
def test_same_bytes_on_any_number_of_threads(dimension: int, quantity: Quantity) -> None:
    union = measure_balls(STRIP[:, :dimension], {2: 0.15, 3: 0.4}[dimension])
    found = []
    for threads in (1, 2):
        with thread_limit(threads):
            found.append(facet_laplacian(union, quantity))
    for name in ("starts", "columns", "weights", "diagonal"):
        assert getattr(found[0], name).tobytes() == getattr(found[1], name).tobytes()
