from __future__ import annotations

import numpy as np
import pytest

from pcsmooth.kernels.facet_polygon import facet_arrays, measure_polygon
from pcsmooth.kernels.hidden_neighbors import drop_hidden


def neighborhood(seed: int, flatness: float) -> np.ndarray:
    """Neighbours of the origin within 2, nearest first, (3, m)."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-2, 2, (400, 3)) * [1, 1, flatness]
    distances = np.linalg.norm(points, axis=1)
    return np.ascontiguousarray(points[np.argsort(distances)][np.sort(distances) < 2].T)


@pytest.mark.parametrize("flatness", [1.0, 0.1])
@pytest.mark.parametrize("seed", range(5))
def test_dropped_neighbors_have_empty_facets_and_change_no_other(
    seed: int, flatness: float
) -> None:
    near = neighborhood(seed, flatness)
    count = near.shape[1]
    arrays = facet_arrays(count)
    facets = [measure_polygon(0.0, 0.0, 0.0, j, count, near, 1.0, *arrays) for j in range(count)]
    left_near, ids = near.copy(), np.arange(count)
    left = drop_hidden(left_near, ids, count, 0.0, 0.0, 0.0, 1.0, np.empty((5, count)))

    kept = ids[:left]
    assert np.all(np.diff(kept) > 0)  # in order
    np.testing.assert_array_equal(left_near[:, :left], near[:, kept])
    assert left < 0.7 * count  # it does drop some
    dropped = np.setdiff1d(np.arange(count), kept)
    assert not np.any([facets[j] for j in dropped])
    for place, j in enumerate(kept):
        alone = measure_polygon(0.0, 0.0, 0.0, place, left, left_near, 1.0, *arrays)
        np.testing.assert_allclose(alone, facets[j], rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(("second", "left"), [((1.5, 0.0), 1), ((1.0, 1.0), 2)])
def test_a_disk_is_dropped_only_if_all_of_it_lies_beyond(
    second: tuple[float, float], left: int
) -> None:
    # Behind the bisector x = 1/2 of (1, 0, 0) lies the disk at x = 3/4; the one of (1, 1, 0)
    # crosses it.
    near = np.array([[1.0, second[0]], [0.0, second[1]], [0.0, 0.0]])
    assert drop_hidden(near, np.arange(2), 2, 0.0, 0.0, 0.0, 1.0, np.empty((5, 2))) == left
