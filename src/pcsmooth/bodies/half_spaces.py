"""Intersections of half-spaces: their vertices, and which facets meet there."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError, cKDTree

from pcsmooth.bodies.unit_normals import ROUNDING
from pcsmooth.errors import InvalidInputError

_UNBOUNDED = "the body is unbounded; add half-spaces that close it"


def corners(
    normals: npt.NDArray[np.float64], offsets: npt.NDArray[np.float64], tolerance: float
) -> tuple[npt.NDArray[np.float64], tuple[tuple[int, ...], ...]]:
    """Find the vertices of {x : normals x <= offsets} and put them in order around each facet.

    Parameters
    ----------
    normals : ndarray, shape (F, d)
        Unit normals, d = 2 or 3.
    offsets : ndarray, shape (F,)
        Distances of the facets from the origin, > 0.
    tolerance : float
        Vertices nearer than this, in circumradii, are one.

    Returns
    -------
    vertices : ndarray, shape (V, d)
        Each by least squares from all facets that meet there.
    facets : tuple of F tuples of int
        Numbers of the vertices of each facet, counter-clockwise seen from outside; in 2D the two
        ends, counter-clockwise around the body.

    Raises
    ------
    InvalidInputError
        If the intersection is unbounded, or a half-space bounds no part of it.
    """
    # A vertex of the body is a facet of the hull of the polar points, and the other way round.
    try:
        polar = ConvexHull(normals / offsets[:, None])
    except QhullError as error:
        raise InvalidInputError(_UNBOUNDED) from error
    equations = polar.equations
    if (equations[:, -1] > -tolerance * np.abs(polar.points).max()).any():
        raise InvalidInputError(_UNBOUNDED)
    places = equations[:, :-1] / -equations[:, -1:]

    nearest = tolerance * np.linalg.norm(places, axis=1).max()
    pairs = cKDTree(places).query_pairs(nearest, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(places),) * 2)
    n_vertices, vertex_of = connected_components(graph, directed=False)

    vertices = np.empty((n_vertices, normals.shape[1]))
    members: list[list[int]] = [[] for _ in normals]
    for vertex in range(n_vertices):
        meeting = np.unique(polar.simplices[vertex_of == vertex])
        vertices[vertex] = _meeting_point(normals[meeting], offsets[meeting])
        for facet in meeting:
            members[facet].append(vertex)
    for facet, around in enumerate(members):
        if len(around) < normals.shape[1]:
            raise InvalidInputError(f"half-space {facet} bounds no part of the body; remove it")
    vertices[np.abs(vertices) <= ROUNDING * np.abs(vertices).max()] = 0.0
    facets = tuple(
        _in_order(vertices, around, normal) for around, normal in zip(members, normals, strict=True)
    )
    return vertices, facets


def _meeting_point(
    normals: npt.NDArray[np.float64], offsets: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    point = np.linalg.lstsq(normals, offsets)[0]
    refinement = np.linalg.lstsq(normals, offsets - normals @ point)[0]
    return np.asarray(point + refinement)


def _in_order(
    vertices: npt.NDArray[np.float64], around: list[int], normal: npt.NDArray[np.float64]
) -> tuple[int, ...]:
    """Sort the vertices of a facet as `corners` says."""
    spokes = vertices[around] - vertices[around].mean(axis=0)
    if len(normal) == 2:
        keys = spokes @ [-normal[1], normal[0]]
    else:
        keys = np.arctan2(spokes @ np.cross(normal, spokes[0]), spokes @ spokes[0])
    return tuple(around[rank] for rank in np.argsort(keys))
