"""The experiments with polyhedra of the thesis: its Figures 34 to 36 and 38."""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial import ConvexHull

import oracles
import polyhedron_oracles as expect
from oracles import assert_close
from pcsmooth import (
    BallEnergy,
    BallUnion,
    ConvexBody,
    PolyhedronEnergy,
    PolyhedronUnion,
    load_presets,
    measure_balls,
    measure_polyhedra,
)
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import FlowState, run_flow
from polyhedron_oracles import RULES, Rule

PRESETS = load_presets()

# --- Figure 34: 16 points on a circle, and a cube


def ring() -> tuple[oracles.Array, npt.NDArray[np.bool_]]:
    """16 points on the unit circle, and which 4 of them are towards the corners of the square."""
    points = oracles.even_circle(16)
    return points, np.arange(16) % 4 == 2


@pytest.mark.parametrize("radius", [0.45, 0.6, 0.8, 1.0])
def test_figure_34_gradients_at_the_corners_point_inwards(radius: float) -> None:
    """The picture shows the cells, and arrows that point inwards at the 4 points at the corners.

    The flow follows minus the gradient: it moves these 4 points outwards and all others inwards,
    towards a square, as the thesis says. The radius is not given; from 0.41 on, which is about
    one distance between neighbours (0.39), it is so.
    """
    points, corner = ring()
    union = measure_polyhedra(points, radius, PRESETS["square"], union="naive")
    outwards = (union.volume_gradient * points).sum(axis=1)
    assert outwards[corner].max() < -0.2 * radius
    assert outwards[~corner].min() > 0.2 * radius

    square = expect.solid("square")
    move = np.where(corner, 1e-6, 0.0)[:, None] * points
    higher, lower = (
        float(expect.naive_cells(points + sign * move, radius, square)[0].sum()) for sign in (1, -1)
    )
    slope = (higher - lower) / 2e-6
    assert slope == pytest.approx(outwards[corner].sum(), rel=1e-4)
    assert slope < 0  # the volume falls when the 4 points move outwards


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("axis", range(3))
def test_figure_34_in_space(axis: int, rule: Rule) -> None:
    """The thesis' code has three dimensions: 16 points in a plane, and a cube."""
    points, _ = ring()
    flat = measure_polyhedra(points, 0.6, PRESETS["square"], union=rule)
    union = measure_polyhedra(
        np.insert(points, axis, 0.0, axis=1), 0.6, PRESETS["cube"], union=rule
    )
    across = np.insert(flat.volume_gradient, axis, 0.0, axis=1)
    gradient = union.volume_gradient
    if rule == "exact":  # the ends lie in one plane, and belong to one body each
        gradient = np.insert(np.delete(gradient, axis, axis=1), axis, 0.0, axis=1)
    assert_close(gradient, 1.2 * across, 1e-13)


def test_figure_34_flow_makes_a_square() -> None:
    points, corner = ring()
    energy = PolyhedronEnergy(0.6, PRESETS["square"], "naive")
    *_, last = run_flow(energy, points, Euler(0.005), 8)
    assert np.linalg.norm(last.points[corner], axis=1).min() > 1.005
    assert np.linalg.norm(last.points[~corner], axis=1).max() < 0.96
    # the ring's largest coordinates range from 0.71 to 1; along a square all are the same
    reach = abs(last.points).max(axis=1)
    assert reach.min() / reach.max() > 0.76


@pytest.mark.parametrize("rule", ["inclusion-exclusion", "exact"])
def test_figure_34_other_unions_leave_the_corners_where_they_are(rule: Rule) -> None:
    """They tend to the support function, for which an edge that is no side of K has no force."""
    points, corner = ring()
    union = measure_polyhedra(points, 0.6, PRESETS["square"], union=rule)
    outwards = (union.volume_gradient * points).sum(axis=1)
    sides = np.arange(16) % 4 == 0
    assert outwards[corner].min() > 0
    assert outwards[corner].max() < 0.2 * outwards[sides].min()


# --- Figure 35: the corners of a cube, and a cube


CORNERS = 2 * oracles.lattice(2, 2, 2) - 1

#: Volume and boundary of the alpha-complex's sum: 8 corners; 12 edges; from sqrt(2) on, 6
#: diagonals and 12 triangles of sides; from sqrt(3) on it is the union.
SUMS = {
    1.2: (8 * 2.4**3 - 12 * 2.4**2 * 0.4, 8 * 6 * 2.4**2 - 12 * (2 * 2.4**2 + 4 * 2.4 * 0.4)),
    1.5: (8 * 27 - 12 * 9 - 6 * 3 + 12 * 3, 8 * 54 - 12 * 30 - 6 * 14 + 12 * 14),
    2.0: (8 * 27, 6 * 36),
}


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("radius", SUMS)
def test_figure_35_gradients_point_outwards(radius: float, rule: Rule) -> None:
    """Bodies share facets here; each belongs to one of them, but in the naive union."""
    union = measure_polyhedra(CORNERS, radius, PRESETS["cube"], union=rule)
    volume, area = SUMS[radius]
    if rule != "inclusion-exclusion":
        volume, area = (2 + 2 * radius) ** 3, 6 * (2 + 2 * radius) ** 2
    assert union.volume == pytest.approx(volume, rel=1e-13)
    assert union.area == pytest.approx(area, rel=1e-13)
    outwards = union.volume_gradient * CORNERS  # along each axis
    assert outwards.min() > 0.9 * radius
    assert_close(union.volume_gradient.sum(axis=0), 0, 1e-13, union.area)
    # d V = sum of p . gradient + r area
    assert outwards.sum() == pytest.approx(3 * volume - radius * area, rel=1e-13)
    if rule == "naive":
        assert_close(union.volume_gradient, (1 + radius) ** 2 * CORNERS, 1e-13)


def test_figure_35_cubes_that_touch() -> None:
    """With r half the side the cubes share sides, which bound the naive union but not the exact."""
    cube = PRESETS["cube"]
    volumes = [measure_polyhedra(CORNERS, 1.0, cube, union=rule).volume for rule in RULES]
    assert volumes == pytest.approx([64.0] * 3, rel=1e-14)
    exact = measure_polyhedra(CORNERS, 1.0, cube, union="exact")
    assert exact.area == pytest.approx(96.0, rel=1e-14)
    assert_close(exact.volume_gradient, 4 * CORNERS, 1e-14)
    naive = measure_polyhedra(CORNERS, 1.0, cube, union="naive")
    assert naive.area == pytest.approx(8 * 24.0, rel=1e-14)
    assert_close(naive.volume_gradient, 0, 1e-14, 4.0)


# --- Figure 36: a sphere, and a polyhedron near the ball


def sphere_and_radius(n: int) -> tuple[oracles.Array, float]:
    """A sphere of even points, and twice their spacing."""
    return oracles.even_sphere(n), 2 * np.sqrt(4 * np.pi / n)


@cache
def near_ball(n: int, rule: Rule) -> tuple[PolyhedronUnion, BallUnion, ConvexBody]:
    """The union of polyhedra of 200 facets around a sphere, and that of balls."""
    points, radius = sphere_and_radius(n)
    body = PRESETS["sphere-200"]
    return measure_polyhedra(points, radius, body, union=rule), measure_balls(points, radius), body


@pytest.mark.parametrize("rule", RULES)
def test_figure_36_volume_and_area(rule: Rule) -> None:
    """K is between the ball and the ball of its circumradius, and so are cells and unions.

    Where the ball is visible in a direction u, K adds r (rho(u) - 1) to first order.
    """
    union, ball, body = near_ball(300, rule)
    if rule != "inclusion-exclusion":
        larger = measure_balls(union.points, union.radius * body.circumradius)
        assert ball.volume < union.volume < larger.volume
        assert (ball.cell_volumes < union.cell_volumes).all()
        assert (union.cell_volumes < larger.cell_volumes).all()
    mean_excess = float(body.radial(oracles.even_sphere(20_000)).mean() - 1)
    added = (union.volume - ball.volume) / (ball.radius * ball.area)
    assert added == pytest.approx(mean_excess, rel=0.05)
    assert union.area == pytest.approx(ball.area, rel=body.circumradius - 1)


@pytest.mark.parametrize("rule", RULES)
def test_figure_36_gradients_are_like_the_normals(rule: Rule) -> None:
    """The bodies' normals are those of the ball within arccos(1 / circumradius), 10.5 degrees.

    The picture shows arrows of about one length along the outward normals.
    """
    union, ball, _ = near_ball(300, rule)
    lengths = np.linalg.norm(union.volume_gradient, axis=1)
    normals = union.volume_gradient / lengths[:, None]
    angles = oracles.degrees_between(normals, union.points)
    assert np.median(angles) < 1
    assert angles.max() < 5
    assert lengths.std() < 0.05 * lengths.mean()
    wrong = np.linalg.norm(union.volume_gradient - ball.volume_gradient, axis=1)
    assert np.median(wrong) < 0.03 * lengths.mean()


@pytest.mark.parametrize("rule", RULES)
def test_figure_36_flow_is_that_of_the_balls(rule: Rule) -> None:
    points, radius = sphere_and_radius(200)
    body = PRESETS["sphere-200"]
    *_, ball = run_flow(BallEnergy(radius), points, Euler(), 2)
    *_, last = run_flow(PolyhedronEnergy(radius, body, rule), points, Euler(), 2)
    apart = np.linalg.norm(last.points - ball.points, axis=1)
    assert (
        np.median(apart)
        < (body.circumradius - 1) * np.linalg.norm(ball.points - points, axis=1).mean()
    )


# --- Figure 38: a sphere flows towards K


def median_angle(points: oracles.Array, body: ConvexBody) -> float:
    """Angle to the nearest normal of K of half of the convex hull's area, degrees."""
    hull = ConvexHull(points)
    edges = np.diff(points[hull.simplices], axis=1)
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    angles = np.degrees(np.arccos((hull.equations[:, :3] @ body.normals.T).max(axis=1).clip(-1, 1)))
    order = np.argsort(angles)
    covered = np.cumsum(areas[order])
    return float(angles[order][np.searchsorted(covered, covered[-1] / 2)])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "rule", "share"),
    [
        ("cube", "naive", 0.7),
        ("cube", "inclusion-exclusion", 0.92),
        ("cube", "exact", 0.9),
        ("bipyramid", "naive", 0.7),
        ("bipyramid", "inclusion-exclusion", 0.93),
        ("bipyramid", "exact", 0.9),
        ("icosahedron", "naive", 0.75),
        ("icosahedron", "inclusion-exclusion", 0.75),
        ("icosahedron", "exact", 0.75),
    ],
)
def test_figure_38_sphere_turns_into_the_polyhedron(shape: str, rule: Rule, share: float) -> None:
    """500 points, automatic steps; the picture shows the shapes of many more iterations."""
    points, radius = sphere_and_radius(500)
    body = PRESETS[shape]
    energy = PolyhedronEnergy(radius, body, rule)
    states: list[FlowState] = list(run_flow(energy, points, Euler(), 8))
    start, middle, end = (median_angle(states[i].points, body) for i in (0, 4, 8))
    assert end < middle < start
    assert end < share * start
    volumes = np.array([state.evaluation.value for state in states])
    assert (np.diff(volumes) < 0).all()


def test_figure_38_exact_union_goes_on_to_a_cube() -> None:
    points, radius = sphere_and_radius(300)
    cube = PRESETS["cube"]
    *_, last = run_flow(PolyhedronEnergy(radius, cube), points, Euler(0.06 * radius**2), 16)
    assert median_angle(points, cube) > 30
    assert median_angle(last.points, cube) < 6
