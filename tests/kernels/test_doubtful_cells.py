"""The two ways of measuring a 3D cell, from shared edges and from polygons, beside each other."""

from __future__ import annotations

import numpy as np
import pytest

from kernels.alone import alone
from pcsmooth.kernels.balls.cells_3d import sum_cells_3d
from pcsmooth.kernels.balls.cells_again import sum_cells_again
from pcsmooth.kernels.balls.facet_booking import N_BOOKING_ROWS, N_MEASURES
from pcsmooth.neighbors.grid import build_grid

sum_cells_3d, sum_cells_again = alone(sum_cells_3d), alone(sum_cells_again)


def both_ways(
    points: np.ndarray, radius: float, radii: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Sums of all points in grid order."""
    grid = build_grid(points, 2.0 * radius)
    ordered = None if radii is None else radii[grid.order]
    where = (grid.coordinates, grid.cells, radius, ordered, 0, len(points))
    polygons = np.full((len(points), N_MEASURES), np.nan)
    every = np.ones(len(points), bool)
    terms = np.empty((N_BOOKING_ROWS, N_MEASURES))
    sum_cells_again(*where, every, terms, polygons)
    return sum_cells_3d(*where), polygons


@pytest.mark.parametrize("radius", [0.03, 0.08, 0.2])
@pytest.mark.parametrize("flatness", [1.0, 0.1, 0.0])
def test_edges_and_polygons_agree(flatness: float, radius: float) -> None:
    points = np.random.default_rng(5).random((600, 3)) * [1, 1, flatness]
    from_edges, polygons = both_ways(points, radius)
    scale = np.abs(polygons).max(axis=0) + 1e-3 * np.abs(polygons).max()
    assert np.max(np.abs(from_edges - polygons) / scale) < 1e-11


@pytest.mark.parametrize("radius", [0.03, 0.08, 0.2])
@pytest.mark.parametrize("flatness", [1.0, 0.1, 0.0])
@pytest.mark.parametrize("change", [1e-6, 0.01, 0.1, 0.5, 0.95])
def test_edges_and_polygons_agree_on_unequal_balls(
    change: float, flatness: float, radius: float
) -> None:
    rng = np.random.default_rng(5)
    points = rng.random((600, 3)) * [1, 1, flatness]
    radii = radius * (1 - change * rng.random(600))
    from_edges, polygons = both_ways(points, radius, radii)
    scale = np.abs(polygons).max(axis=0) + 1e-3 * np.abs(polygons).max()
    assert np.max(np.abs(from_edges - polygons) / scale) < 1e-11
    assert change < 0.5 or np.any(np.all(polygons[:, 2:] == 0.0, axis=1))  # a hidden ball


@pytest.mark.parametrize("gap", [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9])
def test_pairs_of_close_points_are_measured_well(gap: float) -> None:
    rng = np.random.default_rng(6)
    points = rng.random((150, 3)) * [1, 1, 0.1]
    twins = points[:40] + 0.1 * gap * rng.standard_normal((40, 3))
    from_edges, polygons = both_ways(np.concatenate([points, twins]), 0.15)
    columns = slice(0, 14)  # the diagonals grow like one over the distance
    scale = np.abs(polygons[:, columns]).max(axis=0)
    assert np.max(np.abs(from_edges - polygons)[:, columns] / scale) < 1e-10


@pytest.mark.parametrize("spacing", [1.0, 0.1, 1.0 / 3.0])
def test_grids_are_measured_as_polygons(spacing: float) -> None:
    steps = spacing * np.arange(6)
    points = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    from_edges, polygons = both_ways(points, 1.3 * spacing)
    np.testing.assert_array_equal(from_edges, polygons)
