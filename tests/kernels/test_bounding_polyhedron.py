"""The neighbours that are kept against the facets of the cell by Qhull, in the cube around it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial import HalfspaceIntersection

import oracles
from kernels.alone import alone, let_python_call
from oracles import Array
from pcsmooth.kernels.arithmetic.simd import WIDTH
from pcsmooth.kernels.cells import bounding_polyhedron, convex_polyhedron
from pcsmooth.kernels.cells.bounding_polyhedron import TOUCHING, keep_reaching
from pcsmooth.kernels.cells.convex_polyhedron import TORN
from pcsmooth.kernels.grid.within_reach import N_ROWS, NUMBER, SQUARE

run_keep_reaching = alone(keep_reaching)


RNG = np.random.default_rng(0)
SIZES = [1.0, 1e-3, 1e-9]


def kept(points: Array, margin: float = 0.0, keep: Any = run_keep_reaching) -> set[int]:
    """Numbers of the neighbours u (m, 3) of the origin that are kept; the radius is 1."""
    count = len(points)
    near = np.full((N_ROWS, count + WIDTH), np.nan)
    near[:3, :count] = points.T
    near[SQUARE, :count] = (points**2).sum(axis=1)
    near[NUMBER, :count] = np.arange(count)
    left = keep(near, count, 1.0, margin)
    numbers = near[NUMBER, :left].astype(int)
    np.testing.assert_array_equal(near[:3, :left].T, points[numbers])
    assert len(set(numbers)) == left
    return set(numbers.tolist())


def facets(points: Array) -> set[int]:
    """Numbers of the neighbours whose bisector bounds the cell of the origin, by Qhull."""
    scale = np.abs(points).max()  # lest the facets be smaller than Qhull's tolerance
    u = points / scale
    planes = np.r_[np.c_[u, -(u**2).sum(axis=1) / 2], np.c_[np.eye(3), -np.ones(3) / scale]]
    planes = np.r_[planes, np.c_[-np.eye(3), -np.ones(3) / scale]]
    found = HalfspaceIntersection(planes, np.zeros(3)).dual_vertices
    return {int(plane) for plane in found if plane < len(points)}


def blob(n: int, seed: int) -> Array:
    return np.random.default_rng(seed).normal(size=(n, 3)) / 5


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("n", [1, 17, 500, 3000])
@pytest.mark.parametrize("seed", range(3))
def test_of_a_solid_clump_the_facets_are_kept_and_no_more(size: float, n: int, seed: int) -> None:
    points = size * blob(n, seed)
    assert kept(points) == facets(points)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("place", [0.9, 1.2])
def test_a_cell_on_the_outside_of_a_clump(size: float, place: float) -> None:
    points = size * (blob(2000, 5) - [place, 0, 0])
    assert kept(points) == facets(points)


@pytest.mark.parametrize("thickness", [0.01, 0.1])
def test_a_noisy_sheet(thickness: float) -> None:
    points = blob(2000, 3) * [1, 1, thickness]
    assert kept(points) == facets(points)


def test_a_margin_keeps_what_comes_near() -> None:
    points = blob(1000, 7)
    exact, near, nearer = kept(points), kept(points, 3e-3), kept(points, TOUCHING)
    assert exact <= nearer <= near
    lengths = np.linalg.norm(points, axis=1)
    u = points / lengths[:, None]
    planes = np.c_[u, -lengths / 2][sorted(exact)]
    corners = HalfspaceIntersection(planes, np.zeros(3)).intersections
    gaps = lengths / 2 - (u @ corners.T).max(axis=1)
    assert near == set(np.flatnonzero(gaps < 3e-3).tolist())
    assert len(near) > len(exact)


def test_the_order_of_the_neighbors_is_of_no_account() -> None:
    points = blob(2000, 9)
    order = RNG.permutation(2000)
    assert {int(order[k]) for k in kept(points[order])} == kept(points)


def test_a_grid_in_rows_keeps_the_neighbors_that_touch() -> None:
    # rows of 16, the stride at which the nearest are looked for
    grid = (oracles.lattice(16, 16, 16) - [7, 7, 7]) / 32
    points = grid[(grid != 0).any(axis=1)]
    lengths = np.linalg.norm(points, axis=1)
    facing = set(np.flatnonzero(lengths < 1.1 / 32).tolist())
    touching = set(np.flatnonzero(lengths < 1.8 / 32).tolist())  # along an edge, at a corner
    assert len(facing) == 6
    assert len(touching) == 26
    assert facing <= kept(points) <= touching
    assert kept(points, TOUCHING) == touching


def test_at_the_centre_of_a_sphere_all_are_kept_though_they_are_more_than_cuts() -> None:
    sphere = RNG.normal(size=(600, 3))
    sphere *= 0.4 / np.linalg.norm(sphere, axis=1)[:, None]
    assert kept(sphere) >= facets(sphere)
    assert len(facets(sphere)) > bounding_polyhedron._MOST_CUTS


def test_of_points_on_a_sphere_a_cell_keeps_few() -> None:
    sphere = RNG.normal(size=(2000, 3))
    sphere *= 0.4 / np.linalg.norm(sphere, axis=1)[:, None]
    for own in range(0, 2000, 100):  # all bisectors pass the centre
        others = np.delete(sphere, own, axis=0) - sphere[own]
        assert len(kept(others)) < 100


def test_a_cut_that_contradicts_itself_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    points = blob(60, 11)
    expected = kept(points)
    cut_off: Any = alone(convex_polyhedron.cut_off)
    calls: list[int] = []

    def torn_at_times(*arguments: Any) -> int:
        calls.append(1)
        return TORN if len(calls) == 4 else cut_off(*arguments)

    let_python_call(bounding_polyhedron, monkeypatch)
    monkeypatch.setattr(bounding_polyhedron, "cut_off", torn_at_times)
    # Drops are made in registers, which only compiled code has: none of the cuts is dropped.
    monkeypatch.setattr(bounding_polyhedron, "_drop_beyond", lambda near, first, count, *_: count)
    left = kept(points, keep=keep_reaching.py_func)
    assert len(calls) > 4
    assert left >= expected
