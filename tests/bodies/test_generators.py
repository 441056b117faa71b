"""Bodies made by rule."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from pcsmooth import ConvexBody, InvalidInputError
from pcsmooth.bodies.generators import box, platonic, polygon, prism, sphere


def check_around_ball(body: ConvexBody) -> None:
    """Check that every facet touches the unit ball, inside of itself."""
    assert body.offsets.tolist() == [1.0] * len(body.offsets)
    assert body.norm(body.normals) == pytest.approx(1.0)


#: Volume of the regular solids of inradius 1.
PLATONIC = {
    4: 8 * math.sqrt(3),
    6: 8.0,
    8: 4 * math.sqrt(3),
    12: 10 * math.sqrt(130 - 58 * math.sqrt(5)),
    20: 10 * math.sqrt(3) * (7 - 3 * math.sqrt(5)),
}


@pytest.mark.parametrize(("facets", "volume"), PLATONIC.items())
def test_platonic(facets: int, volume: float) -> None:
    body = platonic(facets)
    check_around_ball(body)
    assert len(body.facets) == facets
    assert body.volume == pytest.approx(volume, rel=1e-14)
    assert np.ptp(body.facet_areas) < 1e-13
    assert body.is_symmetric == (facets != 4)


@pytest.mark.parametrize("sides", [3, 4, 5, 6, 7, 64, 1000])
def test_polygon(sides: int) -> None:
    body = polygon(sides)
    check_around_ball(body)
    assert body.normals[0].tolist() == [1.0, 0.0]
    assert len(body.facets) == len(body.vertices) == sides
    assert body.volume == pytest.approx(sides * math.tan(math.pi / sides), rel=1e-12)
    assert body.is_symmetric == (sides % 2 == 0)


@pytest.mark.parametrize("sides", [3, 6])
@pytest.mark.parametrize("height", [2.0, 0.5, 3])
def test_prism(sides: int, height: float) -> None:
    body = prism(sides, height)
    assert body.volume == pytest.approx(height * polygon(sides).volume, rel=1e-14)
    assert np.ptp(body.vertices, axis=0)[2] == height
    assert len(body.facets) == sides + 2
    assert body.is_symmetric == (sides % 2 == 0)
    check_around_ball(prism(sides))


def test_box() -> None:
    body = box([2, 4, 3])
    assert np.abs(body.vertices).tolist() == [[1.0, 2.0, 1.5]] * 8
    assert np.ptp(box([5, 5.0]).vertices, axis=0).tolist() == [2.0, 2.0]


@pytest.mark.parametrize("facets", [6, 7, 8, 12, 20, 32, 33, 50, 100])
def test_sphere(facets: int) -> None:
    body = sphere(facets)
    check_around_ball(body)
    assert len(body.facets) == facets
    assert body.is_symmetric == (facets % 2 == 0)
    assert body.facet_areas.max() < 1.35 * body.facet_areas.min()
    assert np.array_equal(sphere(facets).normals, body.normals)
    # No polyhedron of so many facets around the ball is smaller (Fejes Toth).
    angle = math.pi / 6 * facets / (facets - 2)
    least = (facets - 2) * math.sin(2 * angle) * (3 * math.tan(angle) ** 2 - 1)
    assert least * (1 - 1e-12) < body.volume < 1.06 * least


def test_spheres_of_few_facets_are_regular() -> None:
    for facets in (6, 8, 12):
        assert sphere(facets).volume == pytest.approx(PLATONIC[facets], rel=1e-6)


#: What is done, what the message must say.
FAULTS: dict[str, tuple[Callable[[], object], str]] = {
    "edges": (lambda: box([1, 2, 3, 4]), "edges is .*; give 2 or 3 numbers"),
    "one edge": (lambda: box(2), "edges is 2; give 2 or 3 numbers"),  # type: ignore[arg-type]
    "flat": (lambda: box([1, 0]), "an edge is 0; it must be a positive number"),
    "word": (lambda: box("ab"), "an edge is 'a'"),  # type: ignore[arg-type]
    "solid": (lambda: platonic(5), "facets is 5; a regular solid has 4, 6, 8, 12 or 20"),
    "two sides": (lambda: polygon(2), "sides is 2; it must be a whole number from 3 to 1000"),
    "many": (lambda: polygon(1001), "sides is 1001"),
    "part": (lambda: prism(4.5), "sides is 4.5"),  # type: ignore[arg-type]
    "height": (lambda: prism(4, -1.0), "height is -1.0; it must be a positive number"),
    "infinite": (lambda: prism(4, math.inf), "height is inf"),
    "few": (lambda: sphere(5), "facets is 5; it must be a whole number from 6 to 1000"),
    "words": (lambda: sphere("50"), "facets is '50'"),  # type: ignore[arg-type]
}


@pytest.mark.parametrize(("act", "message"), FAULTS.values(), ids=FAULTS)
def test_faults(act: Callable[[], object], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        act()
