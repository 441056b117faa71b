from __future__ import annotations

import numpy as np
import pytest

from kernels.alone import alone
from pcsmooth.kernels.arithmetic.simd import WIDTH
from pcsmooth.kernels.balls.facet_polygon import facet_arrays, measure_polygon
from pcsmooth.kernels.cells.hidden_neighbors import keep_visible
from pcsmooth.kernels.grid.within_reach import MOST_HIDERS, N_ROWS, NUMBER, SQUARE

keep_visible = alone(keep_visible)
facet_arrays, measure_polygon = alone(facet_arrays), alone(measure_polygon)


def neighborhood(seed: int, flatness: float, size: int) -> np.ndarray:
    """Neighbours of the origin within 2, in no order, (3, m)."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-2, 2, (size, 3)) * [1, 1, flatness]
    return np.ascontiguousarray(points[np.linalg.norm(points, axis=1) < 2].T)


def visible(
    points: np.ndarray, radius: float, margin: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """What is kept: rows x, y, z and numbers."""
    count = points.shape[1]
    near, spare = np.full((2, N_ROWS, count + WIDTH), np.nan)
    near[:3, :count] = points
    near[SQUARE, :count] = (points**2).sum(axis=0)
    near[NUMBER, :count] = np.arange(count)
    hiders = np.empty((N_ROWS, MOST_HIDERS + WIDTH))
    left = keep_visible(near, count, radius, None, margin, spare, hiders)
    assert np.all(near[SQUARE, left : left + WIDTH] == np.inf)  # padded
    return near[:3, :left].copy(), near[NUMBER, :left].astype(int)


@pytest.mark.parametrize("size", [20, 400, 3000])
@pytest.mark.parametrize("flatness", [1.0, 0.1])
@pytest.mark.parametrize("seed", range(3))
def test_dropped_neighbors_have_empty_facets_and_change_no_other(
    seed: int, flatness: float, size: int
) -> None:
    points = neighborhood(seed, flatness, size)
    count = points.shape[1]
    arrays = facet_arrays(count)
    facets = [
        measure_polygon(0.0, 0.0, 0.0, j, count, points, 1.0, None, *arrays) for j in range(count)
    ]
    left_points, kept = visible(points, 1.0)

    np.testing.assert_array_equal(left_points, points[:, kept])
    assert np.all(np.diff(np.linalg.norm(left_points, axis=0)) >= 0.0)  # nearest first
    assert size < 400 or len(kept) < 0.6 * count  # it does drop some
    dropped = np.setdiff1d(np.arange(count), kept)
    assert not np.any([facets[j] for j in dropped])
    for place, j in enumerate(kept):
        alone = measure_polygon(0.0, 0.0, 0.0, place, len(kept), left_points, 1.0, None, *arrays)
        np.testing.assert_allclose(alone, facets[j], rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(("second", "left"), [((1.5, 0.0), 1), ((1.0, 1.0), 2)])
def test_a_disk_is_dropped_only_if_all_of_it_lies_beyond(
    second: tuple[float, float], left: int
) -> None:
    # Behind the bisector x = 1/2 of (1, 0, 0) lies the disk at x = 3/4; the one of (1, 1, 0)
    # crosses it.
    points = np.array([[1.0, second[0]], [0.0, second[1]], [0.0, 0.0]])
    assert len(visible(points, 1.0)[1]) == left


def test_neighbors_at_equal_distance_are_all_kept() -> None:
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    points = np.stack([np.round(np.cos(angles), 3), np.round(np.sin(angles), 3), 0 * angles])
    kept = visible(np.repeat(points, 2, axis=1), 10.0)[1]
    assert len(np.unique(kept)) == len(kept) >= 24
