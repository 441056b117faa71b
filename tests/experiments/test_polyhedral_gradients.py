"""Gradients of unions of cubes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import oracles
import polyhedron_oracles as expect
from experiments.thesis_clouds import INPUTS
from pcsmooth import load_presets, measure_polyhedra
from pcsmooth_experiments.space.polyhedral_gradients import (
    PolyhedralGradients,
    draw_polyhedral_gradients,
    judge,
    measure_polyhedral_gradients,
    outcome_of,
)
from pcsmooth_experiments.space.restricted_polytopes import restricted_corners, restricted_facets


@pytest.fixture(scope="module")
def found() -> PolyhedralGradients:
    return measure_polyhedral_gradients(INPUTS.points("circle_16.xyz"), INPUTS.points("cube.xyz"))


def test_points_at_the_corners(found: PolyhedralGradients) -> None:
    chosen = np.abs(found.circle[found.at_corners])
    assert np.sort(chosen, axis=1) == pytest.approx(
        np.tile([0.0, 0.5**0.5, 0.5**0.5], (4, 1)), abs=1e-6
    )


def test_naive_gradients_are_slopes_of_the_volume(found: PolyhedralGradients) -> None:
    """Central differences of an independent volume, in the plane of the circle."""
    drawn = found.on_circle[0]
    square = expect.solid("square")
    flat = found.circle[:, 1:]
    away = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    for number in (2, 3, 4):
        direction = np.zeros_like(flat)
        direction[number] = 1e-6 * away[number]
        higher, lower = (
            expect.naive_cells(flat + sign * direction, drawn.radius, square)[0].sum()
            for sign in (1, -1)
        )
        # the cubes are 2 r thick
        slope = 2 * drawn.radius * (higher - lower) / 2e-6
        assert drawn.outward[number] == pytest.approx(slope, rel=1e-4)


def test_where_the_gradients_turn(found: PolyhedralGradients) -> None:
    """At 0.41, which is between two of the radii."""
    assert found.turning_radius == 0.45
    naive = {one.radius: one for one in found.on_circle if one.union == "naive"}
    assert naive[0.4].outward[found.at_corners].min() > 0
    assert naive[0.45].outward[found.at_corners].max() < 0


def test_cube(found: PolyhedralGradients) -> None:
    """The naive cells are boxes, whose three outer sides are (1 + r)^2."""
    for one in found.on_cube:
        assert np.linalg.norm(one.vectors, axis=1).min() > 1
        if one.union == "naive":
            assert one.vectors == pytest.approx((1 + one.radius) ** 2 * found.cube, rel=1e-12)
            assert one.cosines == pytest.approx(np.ones(8), abs=1e-12)
        total = (one.vectors * found.cube).sum()
        if one.union == "exact":  # the slope of the union's volume as the cube grows
            assert total == pytest.approx(3 * (2 + 2 * one.radius) ** 2 * 2, rel=1e-12)


def test_verdict(found: PolyhedralGradients) -> None:
    assert judge(found) == "agrees"
    first = found.on_circle[0]
    outward = replace(found, on_circle=(replace(first, outward=abs(first.outward)),))
    assert judge(outward) == "agrees in part"
    inward = tuple(replace(one, vectors=-one.vectors) for one in found.on_cube)
    assert judge(replace(found, on_cube=inward)) == "agrees in part"
    assert judge(replace(outward, on_cube=inward)) == "disagrees"


def test_outcome(found: PolyhedralGradients) -> None:
    outcome = outcome_of(found)
    assert len(outcome.caption) <= 200
    assert "inward from 0.45 on" in outcome.explanation
    table = outcome.tables["polyhedral-gradients-circle"]
    drawn = (table["r"] == 0.6) & (table["union"] == "naive")
    assert np.count_nonzero(table["outward"][drawn] < 0) == 4
    assert len(draw_polyhedral_gradients(found).axes) == 4


@pytest.mark.parametrize(("dimension", "shape"), [(2, "hexagon"), (3, "icosahedron")])
def test_cells_that_are_drawn_are_those_that_are_measured(dimension: int, shape: str) -> None:
    points = oracles.uniform_cloud(20, dimension, seed=4)
    body, radius = load_presets()[shape], 0.25
    volumes = measure_polyhedra(points, radius, body, "naive").cell_volumes
    for number in range(len(points)):
        corners = restricted_corners(points, number, radius, body)
        assert ConvexHull(corners).volume == pytest.approx(volumes[number], rel=1e-9)
        if dimension == 2:  # in turn
            x, y = corners.T
            area = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
            assert area == pytest.approx(volumes[number], rel=1e-9)
        else:
            facets = restricted_facets(points, number, radius, body)
            assert sum(map(area_of, facets)) == pytest.approx(ConvexHull(corners).area, rel=1e-9)


def area_of(facet: oracles.Array) -> float:
    """Area of a plane polygon whose corners come in turn."""
    arms = facet - facet[0]
    return float(np.linalg.norm(np.cross(arms[1:-1], arms[2:]).sum(axis=0)) / 2)
