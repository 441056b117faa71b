from __future__ import annotations

import numpy as np
import pytest

import oracles
from oracles import Array
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.neighbors.coincident import mark_distinct
from pcsmooth.neighbors.local_spacing import local_spacings
from pcsmooth.neighbors.spacing_quantiles import SpacingQuantiles, spacing_quantiles
from pcsmooth.parts.whole_cloud import WholeCloud


def quantiles_of(points: Array) -> SpacingQuantiles:
    cloud = WholeCloud.of(points)
    found = spacing_quantiles(cloud, mark_distinct(cloud))
    return SpacingQuantiles(*(cloud.unit * np.array([found.dense, found.median, found.sparse])))


def clouds() -> dict[str, Array]:
    rng = np.random.default_rng(3)
    sphere = oracles.random_sphere(6000)
    x, y = np.meshgrid(np.arange(200.0), 10 * np.arange(25.0))
    lines = np.c_[x.ravel(), y.ravel(), 0.3 * rng.normal(size=x.size)]
    return {
        "sphere": sphere,
        "lines": lines,
        "two scales": np.r_[sphere, 1e-3 * sphere[:2000] + [3, 0, 0]],
        "curve": np.cumsum(np.linspace(0.5, 5, 2000))[:, np.newaxis] * [0.8, 0.6],
    }


@pytest.mark.parametrize("name", clouds())
def test_quantiles_are_nearly_those_of_all_points(name: str) -> None:
    points = clouds()[name]
    found = quantiles_of(points)
    expected = np.quantile(local_spacings(points), (0.05, 0.5, 0.95))
    np.testing.assert_allclose([found.dense, found.median, found.sparse], expected, rtol=0.1)
    assert found.variation == pytest.approx(expected[2] / expected[0], rel=0.2)


def test_even_points_have_one_spacing() -> None:
    found = quantiles_of(oracles.lattice(60, 1))
    assert (found.dense, found.median, found.sparse) == pytest.approx((1.0, 1.0, 1.0), rel=1e-14)
    assert found.variation == pytest.approx(1.0, rel=1e-14)


def test_coincident_points_count_once() -> None:
    points = clouds()["lines"]
    assert quantiles_of(np.r_[points, points[::3]]) == quantiles_of(points)


def test_threads_find_the_same() -> None:
    found = []
    for threads in (1, 2):
        with thread_limit(threads):
            found.append(quantiles_of(clouds()["two scales"]))
    assert found[0] == found[1]


@pytest.mark.parametrize("n", [2, 3, 7])
def test_few_points(n: int) -> None:
    points = oracles.random_sphere(n)
    apart = np.linalg.norm(points[:, np.newaxis] - points, axis=2)
    found = quantiles_of(points)
    assert apart[apart > 0].min() <= found.dense <= found.median <= found.sparse <= apart.max()


def test_one_place() -> None:
    found = quantiles_of(np.ones((4, 3)))
    assert found == SpacingQuantiles(0.0, 0.0, 0.0)
    assert found.variation is None
