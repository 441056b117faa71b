"""Facets of a body in coordinates of their planes, for `kernels.polyhedra.visible_facets`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.polyhedra.body_tables import BodyTables
from pcsmooth.kernels.polyhedra import visible_facets as rows

#: Bodies whose opposite facets are this near, relative, touch.
_TOUCHING = 1e-12


@dataclass(frozen=True)
class FacetPlanes:
    """The facets that count, each in coordinates of its plane.

    Attributes
    ----------
    polygons : ndarray, shape (C, 3, most corners)
        Coordinates of the corners, L, and the facet beyond the edge to the next one.
    corner_counts : ndarray of int, shape (C,)
        Number of corners.
    lines : ndarray, shape (6, C, F)
        Where the planes of the other facets cross, by the rows of the kernel.
    """

    polygons: npt.NDArray[np.float64]
    corner_counts: npt.NDArray[np.int64]
    lines: npt.NDArray[np.float64]


def facet_planes(tables: BodyTables) -> FacetPlanes:
    """Lay out the facets of r K in their planes."""
    normals = tables.normals.T
    counted = range(tables.n_counted)
    beyond = {
        edge: number
        for number, facet in enumerate(tables.facets)
        for edge in zip(facet, (*facet[1:], facet[0]), strict=True)
    }
    corner_counts = np.array([len(tables.facets[k]) for k in counted])
    polygons = np.zeros((tables.n_counted, 3, corner_counts.max()))
    lines = np.empty((6, tables.n_counted, len(normals)))
    for k in counted:
        facet = tables.facets[k]
        axes = _axes_across(normals[k])
        flat = tables.corners[list(facet)] @ axes.T
        polygons[k, :2, : len(facet)] = flat.T
        polygons[k, 2, : len(facet)] = [
            beyond[w, v] for v, w in zip(facet, (*facet[1:], facet[0]), strict=True)
        ]
        lines[:, k] = _crossing_lines(tables, k, axes, flat)
    return FacetPlanes(polygons, corner_counts, lines)


def _axes_across(normal: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Two axes that make a right-handed frame with a normal, (2, 3); exact ones where they can."""
    start = np.eye(3)[np.argmin(np.abs(normal))]
    first = start - (start @ normal) * normal
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)])


def _crossing_lines(
    tables: BodyTables,
    k: int,
    axes: npt.NDArray[np.float64],
    corners: npt.NDArray[np.float64],
) -> npt.NDArray[np.float64]:
    """Rows of the lines in which the facets' planes cross that of facet k, (6, F)."""
    normals, offsets = tables.normals.T, tables.offsets
    within = normals @ axes.T
    sines = np.linalg.norm(within, axis=1)
    cosines = normals @ normals[k]
    opposite = np.all(normals == -normals[k], axis=1)
    sines[opposite] = sines[k] = 0.0
    crossing = sines > 0.0
    lines = np.zeros((6, len(offsets)))
    lines[rows.SINE] = sines
    lines[rows.NU_X : rows.NU_Y + 1, crossing] = (within[crossing] / sines[crossing, None]).T
    lines[rows.BASE, crossing] = (offsets - cosines * offsets[k])[crossing] / sines[crossing]
    along = corners @ lines[rows.NU_X : rows.NU_Y + 1]
    for row, extreme in ((rows.NOTHING, along.min(axis=0)), (rows.ALL, along.max(axis=0))):
        lines[row] = sines * (extreme - lines[rows.BASE])
    lines[rows.NOTHING, ~crossing] = -np.inf
    lines[rows.ALL, ~crossing] = -np.inf
    lines[rows.NOTHING, opposite] = -(1.0 + _TOUCHING) * (offsets[opposite] + offsets[k])
    return lines
