"""A body as the kernels of polyhedra take it; a polygon becomes a prism."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from pcsmooth.bodies.convex_body import ConvexBody

Facets = tuple[tuple[int, ...], ...]
Polyhedron = tuple[npt.NDArray[np.float64], npt.NDArray[np.int64], npt.NDArray[np.int64]]


@dataclass(frozen=True)
class BodyTables:
    """The polyhedron r K about the origin, with F facets.

    In 2D it is the prism over the polygon r K from z = -r to z = r: its volume and the areas of
    its sides are those of the polygon times `thickness`, and its ends do not count.

    Attributes
    ----------
    normals : ndarray, shape (3, F)
        Outward unit normals of the facets, those that do not count last.
    offsets : ndarray, shape (F,)
        Their distances from the origin, L.
    corners : ndarray, shape (V, 3)
        Vertices, L.
    facets : tuple of F tuples of int
        Corners of each facet, counter-clockwise seen from outside.
    n_counted : int
        Facets that count.
    polyhedron : tuple of ndarray
        vertices, planes and across (3, m): see `pcsmooth.kernels.cells.convex_polyhedron`.
    tangents : ndarray, shape (F, F)
        tan(angle / 2) between the normals; 0 for facets that do not count, and opposite ones.
    inradius, reach : float
        Least distance of a facet of the body r K from the origin, and largest of a vertex, L.
    thickness : float
        1 in 3D, 2 r in 2D.
    """

    normals: npt.NDArray[np.float64]
    offsets: npt.NDArray[np.float64]
    corners: npt.NDArray[np.float64]
    facets: Facets
    n_counted: int
    polyhedron: Polyhedron
    tangents: npt.NDArray[np.float64]
    inradius: float
    reach: float
    thickness: float


@lru_cache(maxsize=4)
def body_tables(body: ConvexBody, radius: float) -> BodyTables:
    """Prepare r K for the kernels."""
    if body.dimension == 3:
        normals, offsets = body.normals, body.offsets * radius
        corners, facets = body.vertices * radius, body.facets
        thickness = 1.0
    else:
        normals, offsets, corners, facets = _prism(body, radius)
        thickness = 2.0 * radius
    return BodyTables(
        np.ascontiguousarray(normals.T),
        offsets,
        corners,
        facets,
        len(body.offsets),
        _simple_polyhedron(corners, facets),
        _half_angle_tangents(normals, len(body.offsets)),
        body.inradius * radius,
        body.circumradius * radius,
        thickness,
    )


def _prism(
    body: ConvexBody, radius: float
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64], Facets]:
    """Find normals, offsets, corners and facets of the prism over r K, its ends last."""
    n = len(body.vertices)
    normals = np.zeros((n + 2, 3))
    normals[:n, :2] = body.normals
    normals[n:, 2] = 1.0, -1.0
    offsets = np.r_[body.offsets * radius, radius, radius]
    outline = body.vertices * radius
    corners = np.vstack([np.c_[outline, np.full(n, z)] for z in (-radius, radius)])
    sides = tuple((v, w, w + n, v + n) for v, w in body.facets)
    following = {v: w for v, w in body.facets}  # noqa: C416 (its type)
    around = [0]
    while len(around) < n:
        around.append(following[around[-1]])
    return normals, offsets, corners, (*sides, tuple(v + n for v in around), tuple(around[::-1]))


def _simple_polyhedron(corners: npt.NDArray[np.float64], facets: Facets) -> Polyhedron:
    """Vertices of three planes each; a corner of m facets becomes m - 2 vertices at one place."""
    facet_left_of = {}  # by directed edge (v, w)
    comes_from: list[dict[int, int]] = [{} for _ in corners]  # by facet, where its edge to v begins
    for number, facet in enumerate(facets):
        for v, w in zip(facet, (*facet[1:], facet[0]), strict=True):
            facet_left_of[v, w] = number
            comes_from[w][number] = v
    places, planes = [], []
    for v, incoming in enumerate(comes_from):
        # Counter-clockwise about v the next facet is on the other side of the edge that ends in v.
        start = min(incoming)
        around = [start]
        while (following := facet_left_of[v, incoming[around[-1]]]) != start:
            around.append(following)
        for second, third in pairwise(around[1:]):
            places.append(v)
            planes.append((start, second, third))
    vertex_at = {(p[e], p[(e + 1) % 3]): t for t, p in enumerate(planes) for e in range(3)}
    across = [[vertex_at[p[(e + 1) % 3], p[e]] for p in planes] for e in range(3)]
    return (
        np.ascontiguousarray(corners[places].T),
        np.ascontiguousarray(np.array(planes, dtype=np.int64).T),
        np.array(across, dtype=np.int64),
    )


def _half_angle_tangents(
    normals: npt.NDArray[np.float64], n_counted: int
) -> npt.NDArray[np.float64]:
    """tan(angle / 2) = |n_a - n_b| / |n_a + n_b|, (F, F); 0 where it is not wanted."""
    apart = np.linalg.norm(normals[:, np.newaxis] - normals, axis=2)
    together = np.linalg.norm(normals[:, np.newaxis] + normals, axis=2)
    tangents = np.zeros(apart.shape)
    np.divide(apart, together, out=tangents, where=together > 0.0)
    tangents[n_counted:] = 0.0
    tangents[:, n_counted:] = 0.0
    return tangents
