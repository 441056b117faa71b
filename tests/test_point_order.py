from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import oracles
from oracles import Array
from pcsmooth.neighbors.spacing import mean_spacing
from pcsmooth.point_order import (
    HALVINGS,
    least_width,
    order_by_position,
    scattered_ranks,
    take_in_order,
)
from pcsmooth.python.denoising import denoise
from pcsmooth.python.estimating import estimate_curvature
from pcsmooth.tiling.cubes import cube_codes

RNG = np.random.default_rng(0)


def raster(rows: int, columns: int) -> Array:
    """A surface measured line by line, with the noise of a scanner."""
    y, x = np.mgrid[:rows, :columns] * 0.1
    return np.stack([x, y, np.sin(x) * np.cos(y) + 0.03 * RNG.normal(size=x.shape)], -1).reshape(
        -1, 3
    )


def soiled(points: Array) -> Array:
    """A cloud with outliers, duplicates and rows that are no numbers."""
    strays = 3.0 * RNG.normal(size=(len(points) // 30, points.shape[1]))
    mixed = np.concatenate([points, strays, points[::7], points[::7], points[::20]])
    mixed[::97] = np.nan
    return mixed


def circle(n: int) -> Array:
    angles = RNG.random(n) * 2 * np.pi
    radii = 1 + 0.01 * RNG.normal(size=n)
    return np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)


SPHERE = oracles.sphere_surface(1200).noisy(0.3)
CLOUDS = {
    "sphere": SPHERE,
    "soiled sphere": soiled(SPHERE),
    "on the map": SPHERE + np.array([4e5, 5.5e6, 300.0]),
    "raster": raster(30, 40),
    "lattice": 0.1 * oracles.lattice(30, 40, 1),
    "solid lattice": 0.1 * oracles.lattice(9, 9, 9),
    "circle": circle(600),
    "soiled circle": soiled(circle(600)),
    "square lattice": 0.1 * oracles.lattice(20, 30, 1)[:, :2],
}
every_cloud = pytest.mark.parametrize("points", CLOUDS.values(), ids=CLOUDS)
WAYS: dict[str, dict[str, Any]] = {
    "filter": {},
    "euler": {"scheme": "euler"},
    "implicit": {"scheme": "implicit"},
    "along normals": {"scheme": "euler", "motion": "normal", "keep_volume": True},
    "propagated": {"iterations": 0, "orient": "propagate"},
}


@every_cloud
@pytest.mark.parametrize("options", WAYS.values(), ids=WAYS)
def test_permuted_rows_give_the_permuted_result(points: Array, options: dict[str, Any]) -> None:
    """To the last bit, degenerate clouds and ties too."""
    order = np.random.default_rng(1).permutation(len(points))
    held = np.random.default_rng(2).random(len(points)) < 0.05
    one = denoise(points, fixed=held, **options)
    other = denoise(points[order], fixed=held[order], **options)
    for name in ("points", "displacement", "normals", "mean_curvature"):
        np.testing.assert_array_equal(getattr(one, name)[order], getattr(other, name))
    if one.outliers is not None and other.outliers is not None:
        np.testing.assert_array_equal(one.outliers[order], other.outliers)
    assert one.history == other.history
    assert (one.spacing, one.plan, one.step) == (other.spacing, other.plan, other.step)
    assert (one.outliers is None) == (other.outliers is None)


@every_cloud
@pytest.mark.parametrize("orient", ["auto", "input"])
def test_permuted_rows_give_the_permuted_estimates(points: Array, orient: str) -> None:
    """Also where coincident points came with different normals."""
    order = np.random.default_rng(3).permutation(len(points))
    given = np.random.default_rng(4).normal(size=points.shape)
    one = estimate_curvature(points, orient=orient, normals=given)
    other = estimate_curvature(points[order], orient=orient, normals=given[order])
    for name in ("normals", "gaussian_curvature", "principal_curvatures", "confidence"):
        np.testing.assert_array_equal(getattr(one, name)[order], getattr(other, name))
    assert one.normal_support == other.normal_support


def test_samples_do_not_follow_the_rows_of_a_raster() -> None:
    """Of lines of 10,000 points the ends alone would be far too sparse."""
    lines = np.repeat(np.arange(20.0), 10_000)
    points = np.stack([np.tile(np.arange(10_000) * 0.01, 20), lines * 0.01], axis=1)
    border = (points[:, 0] == 0.0) | (points[:, 0] == points[-1, 0])
    ranks = scattered_ranks(len(points), 40)
    assert 0 < len(ranks) <= 40
    assert np.count_nonzero(border[ranks]) <= 2
    points = take_in_order(np.c_[points, 0 * lines], np.ones(len(points), np.bool_)).points
    # Of 6 neighbours of an inner point four are at 1, two at sqrt(2).
    assert mean_spacing(points) == pytest.approx(0.01 * (4 + 2 * 2**0.5) / 6, rel=0.02)


@pytest.mark.parametrize("samples", [1, 7, 400, 1000, 5000])
@pytest.mark.parametrize("n", [1, 5, 1000, 1001])
def test_scattered_ranks_are_one_of_each_run(n: int, samples: int) -> None:
    ranks = scattered_ranks(n, samples)
    width = -(-n // samples)
    np.testing.assert_array_equal(ranks // width, np.arange(-(-n // width)))
    assert ranks.max() < n
    np.testing.assert_array_equal(ranks, scattered_ranks(n, samples))


def test_scattered_ranks_are_scattered() -> None:
    places = scattered_ranks(64 * 6400, 6400) % 64
    counts = np.bincount(places, minlength=64)
    assert counts.min() > 60  # 100 in the mean, with a deviation of 10
    assert counts.max() < 140


@every_cloud
def test_points_are_in_the_order_of_their_cells(points: Array) -> None:
    finite = points[np.isfinite(points).all(axis=1)]
    order = order_by_position(finite)
    np.testing.assert_array_equal(np.sort(order), np.arange(len(finite)))
    low, extent = finite.min(axis=0), float(np.ptp(finite, axis=0).max())
    codes = cube_codes(finite[order], low, extent / 2**HALVINGS)
    assert np.all(np.diff(codes) >= 0)


def order_of(points: list[list[float]], vectors: Array | None = None) -> list[int]:
    return list(order_by_position(np.array(points), vectors))


def test_points_of_a_cell_are_in_the_order_of_their_coordinates() -> None:
    far = [1e9, 1e9]
    points = [far, [2.0, 1.0], [1.0, 3.0], [1.0, 2.0], [-0.0, 5.0], [0.0, 4.0]]
    assert order_of(points) == [5, 4, 3, 2, 1, 0]


def test_coincident_points_are_in_the_order_of_their_vectors_and_rows() -> None:
    points = [[1.0, 2.0]] * 4
    assert order_of(points) == [0, 1, 2, 3]
    vectors = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [0.0, 1.0]])
    assert order_of(points, vectors=vectors) == [2, 1, 3, 0]


def test_parts_are_in_the_order_of_the_whole() -> None:
    points = RNG.random((500, 3))
    box = np.stack([points.min(axis=0), points.max(axis=0)])
    whole = order_by_position(points)
    part = np.flatnonzero(points[:, 0] < 0.4)
    np.testing.assert_array_equal(
        part[order_by_position(points[part], box=box)], whole[np.isin(whole, part)]
    )


@pytest.mark.parametrize("extent", [0.0, 1e-310])
def test_clouds_at_one_place_have_one_cell(extent: float) -> None:
    assert least_width(extent) == 1.0
    assert order_of([[extent, 0.0], [0.0, 0.0]]) == ([1, 0] if extent else [0, 1])
