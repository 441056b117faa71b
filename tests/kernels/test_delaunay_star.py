"""What the star of a point decides about planes, against rational numbers.

The kernels run as Python, with a look at what two of their parts are given and return.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import oracles
import polyhedron_oracles as expect
from kernels.alone import let_python_call
from oracles import Array
from pcsmooth.energies.polyhedra import alpha_complex
from pcsmooth.energies.polyhedra.alpha_complex import find_simplices
from pcsmooth.kernels.polyhedra import delaunay_star, polyhedron_intersections
from pcsmooth.kernels.polyhedra.delaunay_star import NX, NZ, OFFSET, OFFSET_LOW

Numbers = npt.NDArray[np.int64]
Rational = tuple[Fraction, Fraction, Fraction]
Plane = tuple[Rational, Fraction]

_TURN = oracles.random_rotation(3, np.random.default_rng(3))
_NOISE = np.random.default_rng(4).normal(size=(27, 3))

#: Points and a radius that is large enough for all simplices that are not too flat, or one of each.
CLOUDS: dict[str, tuple[Array, Any]] = {
    "dodecahedron": (expect.solid("icosahedron").normals, 1.1),
    "turned squares": (
        oracles.lattice(4, 3) @ oracles.random_rotation(2, np.random.default_rng(1)),
        1.5,
    ),
    "squares in space": (np.c_[oracles.lattice(3, 3), np.zeros(9)] @ _TURN, 1.5),
    "grid": (oracles.lattice(3, 3, 3), 1.0),
    "turned grid": (oracles.lattice(3, 3, 3) @ _TURN, 1.0),
    "nearly a grid": (oracles.lattice(3, 3, 3) + 1e-13 * _NOISE, 1.0),
    "grid, but for the ninth digit": (oracles.lattice(3, 3, 3) + 1e-9 * _NOISE, 1.0),
    "small grid": (1e-7 * oracles.lattice(3, 3, 2), 1.0),
    "tiny grid": (3e-12 * oracles.lattice(3, 3, 3), 1.0),
    "rings": (
        np.concatenate([np.c_[oracles.even_circle(10), np.full(10, z)] for z in (0, 0.5)]) @ _TURN,
        1.1,
    ),
    "pentagon": (oracles.even_circle(5), 1.5),
    "pentagon in space": (np.c_[oracles.even_circle(5), np.zeros(5)] @ _TURN, 1.5),
    "grid of unequal balls": (
        oracles.lattice(3, 3, 3),
        np.sqrt(np.random.default_rng(5).choice([0.5, 1.0, 1.5], 27)),
    ),
    "turned grid of unequal balls": (
        oracles.lattice(3, 3, 3) @ _TURN,
        np.sqrt(np.random.default_rng(5).choice([0.5, 1.0, 1.5], 27)),
    ),
    "random": (oracles.uniform_cloud(20, 3), 0.6),
}

every_cloud = pytest.mark.parametrize("name", CLOUDS)

#: Those that pairs of floats do not settle.
HARD = {"dodecahedron", "rings", "pentagon in space"}


@pytest.fixture(autouse=True)
def _kernels_run_as_python(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    kernel = polyhedron_intersections.list_simplices
    monkeypatch.setattr(alpha_complex, "list_simplices", kernel.py_func)
    for module in (delaunay_star, polyhedron_intersections):
        let_python_call(module, monkeypatch)
    monkeypatch.setattr(polyhedron_intersections, "find_star", delaunay_star.find_star.py_func)
    fraction.cache_clear()
    yield
    fraction.cache_clear()


@cache
def fraction(value: float) -> Fraction:
    return Fraction(value)


def plane(table: Array, label: int) -> Plane:
    x, y, z = (fraction(v) for v in table[NX : NZ + 1, label].tolist())
    return (x, y, z), fraction(float(table[OFFSET, label])) + fraction(
        float(table[OFFSET_LOW, label])
    )


def cross(a: Rational, b: Rational) -> Rational:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def dot(a: Rational, b: Rational) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def meeting_place(a: Plane, b: Plane, c: Plane) -> tuple[Rational, Fraction]:
    """Solve for the point of three planes times their determinant, and for that."""
    bc, ca, ab = cross(b[0], c[0]), cross(c[0], a[0]), cross(a[0], b[0])
    x, y, z = (a[1] * bc[k] + b[1] * ca[k] + c[1] * ab[k] for k in range(3))
    return (x, y, z), dot(a[0], bc)


@pytest.mark.slow
@every_cloud
def test_signs_are_exact(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also of what is not in doubt; and (a b c) > 0 at every vertex, on which they depend."""
    resolve = delaunay_star._resolve_doubts
    doubts = pairs_in_doubt = 0

    def check(
        planes: Numbers, n: int, excess: Array, doubt: float, table: Array, label: int, room: Array
    ) -> None:
        nonlocal doubts, pairs_in_doubt
        before = excess[:n].copy()
        resolve(planes, n, excess, doubt, table, label, room)
        new = plane(table, label)
        for t, (a, b, c) in enumerate(planes[:, :n].T.tolist()):
            place, determinant = meeting_place(*(plane(table, p) for p in (a, b, c)))
            assert determinant > 0
            beyond = dot(new[0], place) - new[1] * determinant
            assert (excess[t] > 0) == (beyond > 0)
            if abs(before[t]) > doubt:
                assert excess[t] == before[t]
                continue
            doubts += 1
            in_pairs, size = delaunay_star._four_planes(table, a, b, c, label)
            rounding = abs(Fraction(in_pairs)) / 2**53  # of the pair, the high part is returned
            assert abs(Fraction(in_pairs) - beyond) <= Fraction(size) / 10**29 + rounding
            if abs(in_pairs) <= delaunay_star._DOUBT_OF_PAIRS * size:
                pairs_in_doubt += 1

    monkeypatch.setattr(delaunay_star, "_resolve_doubts", check)
    find_simplices(*CLOUDS[name])
    assert (doubts > 0) == (name != "random")
    assert (pairs_in_doubt > 0) == (name in HARD)


@pytest.mark.slow
@every_cloud
def test_vertices_are_where_planes_meet(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Or, where that is open, on the planes: they have been put between two that are."""
    place_vertex = delaunay_star._place_vertex
    radius = float(np.max(CLOUDS[name][1]))

    def check(vertices: Array, planes: Numbers, t: int, table: Array) -> None:
        place_vertex(vertices, planes, t, table)
        three = [plane(table, label) for label in planes[:, t].tolist()]
        products, determinant = meeting_place(*three)
        lengths = np.array([float(dot(normal, normal)) ** 0.5 for normal, _ in three])
        found = vertices[:, t]
        flatness = float(determinant) / lengths.prod()
        if flatness > 2e-28:
            expected = [float(x / determinant) for x in products]
            error = np.linalg.norm(found - expected)
            precise = flatness < 0.9 * delaunay_star._UNCLEAR
            assert error < radius * (1e-14 if precise else 1e-15 / flatness + 1e-14)
        else:
            for normal, offset in three:
                assert abs(np.dot(found, [float(x) for x in normal]) - float(offset)) < (
                    1e-9 * radius * lengths.max()
                )

    monkeypatch.setattr(delaunay_star, "_place_vertex", check)
    find_simplices(*CLOUDS[name])
