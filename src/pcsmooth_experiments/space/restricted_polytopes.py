"""Voronoi cells within convex bodies, as polygons to draw."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import HalfspaceIntersection

from pcsmooth.bodies.convex_body import ConvexBody

Array = npt.NDArray[np.float64]

#: How near a plane a corner is on it, over the radius.
_ON_PLANE = 1e-9


def restricted_corners(points: Array, number: int, radius: float, body: ConvexBody) -> Array:
    """Corners of the Voronoi cell of a point within its body p + r K.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        All points, distinct, L.
    number : int
        Which of them.
    radius : float
        r, L.
    body : ConvexBody
        K.

    Returns
    -------
    ndarray, shape (m, d)
        In 2D counter-clockwise.
    """
    corners = _solve(*_half_spaces(points, number, radius, body), points[number])
    return _around(corners) if points.shape[1] == 2 else corners


def restricted_facets(points: Array, number: int, radius: float, body: ConvexBody) -> list[Array]:
    """Facets of the Voronoi cell of a point within its body, in 3D; parameters as above.

    Returns
    -------
    list of ndarray, each (m, 3)
        Their corners, in turn.
    """
    normals, offsets = _half_spaces(points, number, radius, body)
    corners = _solve(normals, offsets, points[number])
    facets = []
    for normal, offset in zip(normals, offsets, strict=True):
        on = corners[np.abs(corners @ normal - offset) < _ON_PLANE * radius * 1e3]
        if len(on) > 2:
            across = np.linalg.svd(normal[np.newaxis])[2][1:]
            facets.append(on[np.argsort(_angles(on @ across.T))])
    return facets


def _half_spaces(
    points: Array, number: int, radius: float, body: ConvexBody
) -> tuple[Array, Array]:
    """Half-spaces normal . x <= offset of body and bisectors, with unit normals."""
    others = np.delete(points, number, axis=0)
    arms = others - points[number]
    distances = np.linalg.norm(arms, axis=1)
    near = distances < 2.0 * radius * body.circumradius
    arms = arms[near] / distances[near, np.newaxis]
    bisectors = np.einsum("ij,ij->i", arms, (others[near] + points[number]) / 2.0)
    return (
        np.concatenate([body.normals, arms]),
        np.concatenate([body.normals @ points[number] + radius * body.offsets, bisectors]),
    )


def _solve(normals: Array, offsets: Array, inside: Array) -> Array:
    rows = np.concatenate([normals, -offsets[:, np.newaxis]], axis=1)
    found = HalfspaceIntersection(rows, inside).intersections
    # a corner of more than d planes comes once for each simplex of its dual facet
    kept: list[Array] = []
    for corner in found[np.isfinite(found).all(axis=1)]:
        if all(np.abs(corner - other).max() > 1e-9 for other in kept):
            kept.append(corner)
    return np.array(kept)


def _angles(flat: Array) -> Array:
    middle = flat - flat.mean(axis=0)
    return np.asarray(np.arctan2(middle[:, 1], middle[:, 0]))


def _around(corners: Array) -> Array:
    return np.asarray(corners[np.argsort(_angles(corners))])
