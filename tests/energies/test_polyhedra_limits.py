"""What the volume of a union of polyhedra tends to over a surface (report, Eq. 4.19).

With n the normals of a surface, rho the radial function and h the support function of K, the naive
volume tends to the integral of r (rho(n) + rho(-n)) and that of the union itself to the integral
of r (h(n) + h(-n)), as the points become dense compared with r, and r small compared with the
radii of curvature.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import oracles
from pcsmooth import ConvexBody, load_presets, measure_polyhedra
from polyhedron_oracles import Rule

PRESETS = load_presets()

SHAPES = ("cube", "tetrahedron", "icosahedron")

#: Normals of planes that touch each of the bodies in one vertex, and whose lines through the
#: centre cross it far from the edges.
GENERIC = [(0.26, 0.95, -0.16), (0.70, -0.58, 0.42), (0.16, 0.26, -0.95)]

#: Cell of a lattice in a plane, of area 1 and without right angles.
CELL = np.array([[1.0, 0.0], [0.37, 1.0]])


def unit(direction: tuple[float, ...]) -> oracles.Array:
    return np.asarray(np.array(direction) / np.linalg.norm(direction))


def width(body: ConvexBody, normal: oracles.Array) -> float:
    """Width of a body, the sum of its support function over both sides."""
    return float(body.support(normal) + body.support(-normal))


def chord(body: ConvexBody, normal: oracles.Array) -> float:
    """Length of a line through the origin that is inside a body."""
    return float(body.radial(normal) + body.radial(-normal))


def lattice_in_plane(normal: oracles.Array, *counts: int) -> oracles.Array:
    """Points of density 1 in the plane through the origin with a normal."""
    across = np.linalg.qr(np.column_stack([normal, np.eye(3)]))[0][:, 1:]
    return np.asarray(oracles.lattice(*counts) @ CELL @ across.T)


def naive_per_point(normal: oracles.Array, radius: float, body: ConvexBody) -> tuple[float, float]:
    """Volume and boundary of the naive union over one point of an endless lattice.

    The nearest points alone shape a cell, however large the bodies are.
    """
    union = measure_polyhedra(lattice_in_plane(normal, 7, 7), radius, body, union="naive")
    return float(union.cell_volumes[24]), float(union.visible_areas[24])


def exact_per_point(normal: oracles.Array, radius: float, body: ConvexBody) -> tuple[float, float]:
    """Volume and boundary of the union over one point of an endless lattice.

    Beyond the reach of a body, what one row of points adds grows by the same with each point of
    the other rows.
    """
    reach = int(2.4 * radius * body.circumradius) + 3
    total = np.zeros(2)
    for more in product((0, 1), repeat=2):
        points = lattice_in_plane(normal, reach + more[0], reach + more[1])
        found = measure_polyhedra(points, radius, body, union="exact")
        total += (-1) ** sum(more) * np.array([found.volume, found.area])
    return float(total[0]), float(total[1])


# --- planes


@pytest.mark.parametrize("degrees", [0, 10, 20, 30])
def test_cubes_over_a_tilted_plane(degrees: float) -> None:
    """The chord of a cube is 1 / cos, and its width cos + sin.

    The width is that between two edges, whose ends show up to the square of the spacing over r.
    """
    angle = np.radians(degrees)
    normal = np.array([np.sin(angle), 0.0, np.cos(angle)])
    cube = PRESETS["cube"]
    naive, _ = naive_per_point(normal, 4.0, cube)
    assert naive / 4.0 == pytest.approx(2 / np.cos(angle), rel=1e-11)
    _, exact = exact_per_point(normal, 4.0, cube)
    assert exact == pytest.approx(2 * (np.cos(angle) + np.sin(angle)), abs=0.15 / 4.0**2)


@pytest.mark.parametrize("normal", GENERIC)
@pytest.mark.parametrize("shape", SHAPES)
def test_naive_union_over_a_plane_tends_to_the_chord(shape: str, normal: tuple[float, ...]) -> None:
    """Once the two facets that it meets cover a cell, the volume is that of a slanted prism."""
    body = PRESETS[shape]
    expected = chord(body, unit(normal))
    for radius in (6.0, 12.0):
        volume, area = naive_per_point(unit(normal), radius, body)
        assert volume == pytest.approx(radius * expected, rel=1e-12)
        assert area == pytest.approx(expected, rel=1e-11)  # dV / dr, all offsets being 1
    assert width(body, unit(normal)) > 1.09 * expected


@pytest.mark.parametrize("normal", GENERIC)
@pytest.mark.parametrize("shape", SHAPES)
def test_exact_union_over_a_plane_tends_to_the_width(shape: str, normal: tuple[float, ...]) -> None:
    """Vertices tower above the plane; between them a layer is missing, as thick as the spacing.

    It does not depend on r, so that the boundary is exact, and the volume's error is of first
    order in the spacing over r.
    """
    body = PRESETS[shape]
    expected = width(body, unit(normal))
    missing = []
    for radius in (1.5, 3.0):
        volume, area = exact_per_point(unit(normal), radius, body)
        assert area == pytest.approx(expected, rel=1e-11)
        missing.append(radius * expected - volume)
    assert missing[1] == pytest.approx(missing[0], rel=1e-9)
    assert 0 < missing[0] < 1.2  # spacings


# --- spheres


RADIUS = 0.15


def limits_over_sphere(body: ConvexBody) -> tuple[float, float]:
    """Integrals over the unit sphere of what is along the normals, and of the width, over r.

    Along the normals each layer of the shell has its own area, (1 + t)² (report, Eq. 4.17).
    """
    normals = oracles.even_sphere(100_000)
    out, inward = 1 + RADIUS * body.radial(normals), 1 - RADIUS * body.radial(-normals)
    along = 4 * np.pi / 3 * float((out**3 - inward**3).mean()) / RADIUS
    across = 4 * np.pi * float((body.support(normals) + body.support(-normals)).mean())
    return along, across


def volumes_over_sphere(body: ConvexBody, union: Rule, *ratios: float) -> oracles.Array:
    """Volumes over r where r is some ratio of the spacing on the unit sphere."""
    counts = [round(4 * np.pi * (ratio / RADIUS) ** 2) for ratio in ratios]
    return np.array(
        [
            measure_polyhedra(oracles.even_sphere(n), RADIUS, body, union=union).volume / RADIUS
            for n in counts
        ]
    )


@pytest.mark.parametrize("shape", SHAPES)
def test_naive_union_over_a_sphere_tends_to_the_radial_function(shape: str) -> None:
    """The error is of second order in the spacing over r."""
    body = PRESETS[shape]
    along, across = limits_over_sphere(body)
    coarse, fine = abs(volumes_over_sphere(body, "naive", 2.0, 4.0) / along - 1)
    assert fine < 0.006
    assert coarse / fine == pytest.approx(4, rel=0.15)
    assert across / along - 1 > 10 * fine


@pytest.mark.parametrize("shape", SHAPES)
def test_exact_union_over_a_sphere_tends_to_the_support_function(shape: str) -> None:
    """The error is of first order in the spacing over r, and what curvature adds of order r²."""
    body = PRESETS[shape]
    along, across = limits_over_sphere(body)
    coarse, fine = volumes_over_sphere(body, "exact", 1.25, 2.5) / across - 1
    assert -0.09 < fine < 0
    assert coarse / fine == pytest.approx(2, rel=0.2)
    assert abs(2 * fine - coarse) < 0.015
    assert across / along - 1 > 0.07
