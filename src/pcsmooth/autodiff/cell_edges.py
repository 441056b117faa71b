"""Edges of convex cells: restricted Voronoi cells, and intersections of bodies."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from pcsmooth.autodiff.edge_sums import Edges
from pcsmooth.autodiff.polytopes import Polytope, intersect_half_spaces
from pcsmooth.autodiff.shape import Shape

Points = npt.NDArray[np.float64]


def restricted_cell_edges(points: Points, shape: Shape) -> Edges:
    """List the edges of the cells V_i and (p_i + shape), V_i the Voronoi cell.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Distinct points, L.
    shape : Shape
        The ball or polyhedron.

    Returns
    -------
    Edges
        For balls those of the Voronoi cells in the cubes around the balls, without the facets
        that no ball reaches.
    """
    body = intersect_half_spaces(shape.normals, shape.offsets)
    assert body is not None  # the origin is inside
    tree = cKDTree(points)
    collected = []
    for i, point in enumerate(points):
        cell, labels = body, [(i, facet) for facet in range(len(shape.normals))]
        normals = [*shape.normals]
        reach = np.linalg.norm(body.corners, axis=1).max() if shape.ball is None else shape.ball
        near = [j for j in tree.query_ball_point(point, 2.0 * reach) if j != i]
        distances = np.linalg.norm(points[near] - point, axis=1)
        for k in np.argsort(distances, kind="stable"):
            if distances[k] > 2.0 * np.linalg.norm(cell.corners, axis=1).max():
                break
            normals.append((points[near[k]] - point) / distances[k])
            labels.append((near[k], -1))
            # a cell holds its own point
            cell = cell.cut(len(labels) - 1, normals[-1], distances[k] / 2.0) or cell
        is_far = shape.ball is not None and shape.dimension == 3
        left_out = len(shape.normals) if is_far else 0
        collected.append(_edges_of(cell, i, labels, np.array(normals), 1.0, left_out))
    return _joined(collected, shape.dimension)


def intersection_edges(points: Points, shape: Shape, simplices: Iterable[Sequence[int]]) -> Edges:
    """List the edges of the intersections of bodies, with the signs of inclusion-exclusion.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Distinct points, L.
    shape : Shape
        The polyhedron.
    simplices : iterable of sequences of int
        Points whose bodies are intersected, single points among them. Of bodies with a facet in
        one plane that of the first point by x, y, z counts.

    Returns
    -------
    Edges
        Of the intersection of the simplex s with the sign (-1)^dim(s).
    """
    rank = np.empty(len(points), int)
    rank[np.lexsort(points.T[::-1])] = np.arange(len(points))
    collected = []
    for simplex in simplices:
        members = np.array(sorted(simplex, key=lambda j: rank[j]))
        heights = (points[members] - points[members[0]]) @ shape.normals.T
        lowest = np.argmin(heights, axis=0)
        cell = intersect_half_spaces(
            shape.normals, heights[lowest, np.arange(len(lowest))] + shape.offsets
        )
        if cell is None:
            continue
        labels = [(int(members[j]), facet) for facet, j in enumerate(lowest)]
        sign = (-1.0) ** (len(members) - 1)
        collected.append(_edges_of(cell, int(members[0]), labels, shape.normals, sign))
    return _joined(collected, shape.dimension)


Row = tuple[int, list[tuple[int, int]], float]


def _edges_of(
    cell: Polytope,
    point: int,
    labels: list[tuple[int, int]],
    normals: Points,
    sign: float,
    left_out: int = 0,
) -> list[Row]:
    """Orient the edges of a cell; facets with numbers below `left_out` are left out."""
    rows: list[Row] = []
    for planes, ends in cell.edges.items():
        first, second = (
            next(plane for plane in cell.planes[corner] if plane not in planes) for corner in ends
        )
        if len(planes) == 1:
            nx, ny = normals[planes[0]]
            along = np.array([-ny, nx])
        else:
            along = np.cross(normals[planes[0]], normals[planes[1]])
        # behind its first end an edge goes on into that end's half-space
        start, stop = (first, second) if normals[first] @ along < 0.0 else (second, first)
        if planes[0] >= left_out:
            rows.append((point, [labels[k] for k in (*planes, start, stop)], sign))
        if len(planes) == 2 and planes[1] >= left_out:
            rows.append((point, [labels[k] for k in (*planes[::-1], stop, start)], sign))
    return rows


def _joined(collected: list[list[Row]], dimension: int) -> Edges:
    return edges_of_rows([row for rows in collected for row in rows], dimension)


def edges_of_rows(rows: list[Row], dimension: int) -> Edges:
    """Gather edges: of each its cell, the point and facet of its planes, and its sign."""
    planes = np.array([row[1] for row in rows], int).reshape(-1, dimension + 1, 2)
    return Edges(
        np.array([row[0] for row in rows], int),
        planes[:, :, 0],
        planes[:, :, 1],
        np.array([row[2] for row in rows], float),
    )
