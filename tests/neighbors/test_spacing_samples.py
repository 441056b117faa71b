"""Spacings at a few points of a surface, without the kernel that finds those of all."""

from __future__ import annotations

import numpy as np
import pytest

import oracles
from oracles import Array
from pcsmooth.kernels.surface.covering_neighborhoods import LARGEST, SEEN_FIRST
from pcsmooth.neighbors.coincident import mark_distinct
from pcsmooth.neighbors.local_spacing import BoxedPoints
from pcsmooth.neighbors.spacing_samples import share_apart, spacings_of_samples
from pcsmooth.parts.whole_cloud import WholeCloud


def lines(across: float) -> Array:
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.arange(120.0), across * np.arange(12.0))
    points = np.stack([x, y, np.zeros_like(x)], axis=2).reshape(-1, 3)
    return np.asarray(points + 0.1 * rng.normal(size=points.shape))


CLOUDS = {
    "sphere": oracles.random_sphere(2000),
    "volume": np.random.default_rng(1).random((2000, 3)),
    "lines": lines(5.0),
    "lines far apart": lines(30.0),
    "curve": np.random.default_rng(2).random((500, 1)) * [1.0, 2.0, 3.0],
}


@pytest.mark.parametrize("name", CLOUDS)
def test_spacings_are_those_of_the_kernel(name: str) -> None:
    points = np.ascontiguousarray(WholeCloud.as_it_is(CLOUDS[name]).start.values)
    numbers = np.arange(3, len(points), 7)
    found = BoxedPoints.of(points).spacings_at(numbers, SEEN_FIRST)
    spacings, offsets = spacings_of_samples(points, numbers)
    np.testing.assert_allclose(spacings, found.spacings, rtol=1e-12)
    assert offsets.shape == (len(numbers), LARGEST, 3)
    expected = points[found.neighbors] - points[numbers, np.newaxis]
    np.testing.assert_array_equal(offsets[:, :SEEN_FIRST], expected)


def test_the_share_of_a_surface_that_is_sparse() -> None:
    rng = np.random.default_rng(3)
    dense, sparse = rng.random((6000, 2)), rng.random((2000, 2)) * 4 + [2.0, 0.0]
    cloud = WholeCloud.as_it_is(np.c_[np.concatenate([dense, sparse]), np.zeros(8000)])
    distinct = mark_distinct(cloud)
    assert share_apart(cloud, distinct, 0.04) == pytest.approx(0.25, abs=0.08)
    assert share_apart(cloud, distinct, 1.0) == 0.0
    assert share_apart(cloud, distinct, 1e-4) == 1.0
