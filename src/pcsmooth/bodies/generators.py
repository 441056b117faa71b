"""Bodies made by a rule: each touches the unit ball with every facet, boxes with their nearest."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.errors import InvalidInputError

#: Most facets that a rule makes.
_MOST = 1000

#: Steps of repulsion, and their length in units of what keeps them stable.
_N_STEPS, _STEP = 100, 0.1


def _cyclic(x: float, y: float, z: float) -> list[tuple[float, float, float]]:
    return [(x, y, z), (z, x, y), (y, z, x)]


_GOLDEN = 0.5 * (1.0 + math.sqrt(5.0))

_DIAGONALS = [(1.0, 1.0, 1.0), *_cyclic(-1.0, 1.0, 1.0)]

#: Normals of one of each two opposite facets.
_HALF_OF_PLATONIC = {
    6: _cyclic(1.0, 0.0, 0.0),
    8: _DIAGONALS,
    12: _cyclic(0.0, 1.0, _GOLDEN) + _cyclic(0.0, -1.0, _GOLDEN),
    20: _DIAGONALS + _cyclic(0.0, 1.0 / _GOLDEN, _GOLDEN) + _cyclic(0.0, -1.0 / _GOLDEN, _GOLDEN),
}


def box(edges: Sequence[float]) -> ConvexBody:
    """Make a box (in 2D a rectangle) along the axes.

    Parameters
    ----------
    edges : sequence of 2 or 3 float
        Edges as ratios, > 0; the shortest becomes 2.

    Raises
    ------
    InvalidInputError
        If the edges are not 2 or 3 positive numbers.
    """
    if not (isinstance(edges, Sequence) and len(edges) in (2, 3)):
        raise InvalidInputError(f"edges is {edges!r}; give 2 or 3 numbers")
    shape = [_positive("an edge", edge) for edge in edges]
    axes = np.eye(len(shape))
    return ConvexBody(np.vstack([axes, -axes]), np.tile(shape, 2) / min(shape))


def platonic(facets: int) -> ConvexBody:
    """Make the regular solid of 4, 6, 8, 12 or 20 facets; all but the first are symmetric."""
    if facets == 4:
        return _around_ball(np.array([(1.0, 1.0, 1.0), *_cyclic(1.0, -1.0, -1.0)]))
    if facets not in _HALF_OF_PLATONIC:
        raise InvalidInputError(f"facets is {facets!r}; a regular solid has 4, 6, 8, 12 or 20")
    half = np.array(_HALF_OF_PLATONIC[facets])
    return _around_ball(np.vstack([half, -half]))


def polygon(sides: int) -> ConvexBody:
    """Make a regular polygon in 2D; the normal of one side is the x axis."""
    n_sides = _count("sides", sides, 3)
    angles = 2.0 * math.pi * np.arange(n_sides) / n_sides
    return _around_ball(np.column_stack([np.cos(angles), np.sin(angles)]))


def prism(sides: int, height: float = 2.0) -> ConvexBody:
    """Make a prism of given height, L, along z over a regular polygon around the unit disk."""
    around = polygon(sides).normals
    half = 0.5 * _positive("height", height)
    normals = np.zeros((len(around) + 2, 3))
    normals[:-2, :2] = around
    normals[-2:, 2] = 1.0, -1.0
    return ConvexBody(normals, [*np.ones(len(around)), half, half])


def sphere(facets: int) -> ConvexBody:
    """Make a polyhedron around the unit ball whose facets are spread evenly.

    Parameters
    ----------
    facets : int
        Number of facets, 6 or more; if even, the body is symmetric.

    Raises
    ------
    InvalidInputError
        If that is not a whole number from 6 to 1000.

    Notes
    -----
    The normals start on a Fibonacci spiral and repel each other like equal charges (Thomson's
    problem), those of a symmetric body together with their opposites. Six, eight and twelve give
    the cube, the octahedron and the dodecahedron, turned.
    """
    n_facets = _count("facets", facets, 6)
    mirrored = n_facets % 2 == 0
    n_free = n_facets // 2 if mirrored else n_facets
    ranks = np.arange(n_free) + 0.5
    heights = ranks / n_free if mirrored else 1.0 - 2.0 * ranks / n_free
    angles = ranks * math.pi * (3.0 - math.sqrt(5.0))
    widths = np.sqrt(1.0 - heights**2)
    free = np.column_stack([widths * np.cos(angles), widths * np.sin(angles), heights])
    for _ in range(_N_STEPS):
        everyone = np.vstack([free, -free]) if mirrored else free
        apart = free[:, None] - everyone
        squares = (apart**2).sum(axis=2)
        np.fill_diagonal(squares, np.inf)
        force = (apart / squares[..., None] ** 1.5).sum(axis=1)
        force -= (force * free).sum(axis=1, keepdims=True) * free
        free += _STEP * (4.0 * math.pi / n_facets) ** 1.5 * force
        free /= np.linalg.norm(free, axis=1, keepdims=True)
    return _around_ball(np.vstack([free, -free]) if mirrored else free)


GENERATORS: dict[str, Callable[..., ConvexBody]] = {
    rule.__name__: rule for rule in (box, platonic, polygon, prism, sphere)
}
"""Rules by the names that presets use."""


def _around_ball(normals: npt.NDArray[np.float64]) -> ConvexBody:
    return ConvexBody(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def _count(name: str, value: object, least: int) -> int:
    if not (isinstance(value, (int, np.integer)) and least <= value <= _MOST):
        raise InvalidInputError(
            f"{name} is {value!r}; it must be a whole number from {least} to {_MOST}"
        )
    return int(value)


def _positive(name: str, value: object) -> float:
    if not (isinstance(value, (int, float)) and math.isfinite(value) and value > 0.0):
        raise InvalidInputError(f"{name} is {value!r}; it must be a positive number")
    return float(value)
