"""Simplices of three points in the plane: alpha-complexes, and the nerve of squares."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Simplex = tuple[int, ...]

_EDGES: tuple[tuple[int, int], ...] = ((0, 1), (0, 2), (1, 2))


def alpha_complex(points: Array, radius: float) -> frozenset[Simplex]:
    """Find the alpha-complex of three points in general position in the plane.

    An edge is in it if the smallest circle through its ends without a point inside has a radius
    of alpha or less, and the triangle if its circumcircle has (report, Definition 2).
    """
    sides = {pair: float(np.linalg.norm(points[pair[1]] - points[pair[0]])) for pair in _EDGES}
    lengths = sorted(sides.values())
    half = sum(lengths) / 2.0
    area = np.sqrt(half * np.prod([half - length for length in lengths]))
    circumradius = float(np.prod(lengths) / (4.0 * area))
    found: set[Simplex] = {(0,), (1,), (2,)}
    for pair, length in sides.items():
        (third,) = {0, 1, 2} - set(pair)
        to_ends = points[list(pair)] - points[third]
        smallest = circumradius if to_ends[0] @ to_ends[1] < 0.0 else length / 2.0
        if smallest <= radius:
            found.add(pair)
    if circumradius <= radius:
        found.add((0, 1, 2))
    return frozenset(found)


def square_complex(points: Array, radius: float) -> frozenset[Simplex]:
    """Find the alpha-complex of the maximum norm, of three points in general position.

    A square with two points on its boundary holds the box between them: their edge is in the
    complex unless the third point is in that box, and no triangle is then.
    """
    found: set[Simplex] = {(0,), (1,), (2,)}
    hidden = set()
    for pair in _EDGES:
        (third,) = {0, 1, 2} - set(pair)
        low, high = points[list(pair)].min(axis=0), points[list(pair)].max(axis=0)
        if ((low < points[third]) & (points[third] < high)).all():
            hidden.add(pair)
        elif (high - low).max() <= 2.0 * radius:
            found.add(pair)
    if not hidden and np.ptp(points, axis=0).max() <= 2.0 * radius:
        found.add((0, 1, 2))
    return frozenset(found)


def nerve_of_squares(points: Array, radius: float) -> frozenset[Simplex]:
    """Find all sets of squares of a half side that meet."""
    return frozenset(
        simplex
        for count in range(1, len(points) + 1)
        for simplex in combinations(range(len(points)), count)
        if np.ptp(points[list(simplex)], axis=0).max() <= 2.0 * radius
    )


def sum_over(simplices: frozenset[Simplex], points: Array, radius: float) -> float:
    """Area by inclusion-exclusion over simplices, in closed form (report, Eq. 3.4)."""
    return float(
        sum(
            (-1) ** (len(simplex) - 1)
            * np.prod((2.0 * radius - np.ptp(points[list(simplex)], axis=0)).clip(0.0))
            for simplex in simplices
        )
    )
