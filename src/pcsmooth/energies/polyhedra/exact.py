"""Exact union: what is visible of every facet of every body."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.centers import Centers
from pcsmooth.energies.polyhedra.body_tables import BodyTables
from pcsmooth.energies.polyhedra.facet_planes import facet_planes
from pcsmooth.kernels.polyhedra.union_rows import N_COLUMNS
from pcsmooth.kernels.polyhedra.visible_facets import measure_visible_facets
from pcsmooth.kernels.threads import map_blocks
from pcsmooth.neighbors.grid import cube_starts


def measure_exact(
    centers: Centers,
    tables: BodyTables,
    sizes: npt.NDArray[np.float64],
    box: npt.NDArray[np.float64] | None = None,
) -> npt.NDArray[np.float64]:
    """Measure the union of the bodies p_i + r_i K and its first variation.

    With a_ik the area of the visible part of facet k of body i, n_k its normal and h_k its
    distance from p_i, by the divergence theorem::

        volume = sum_ik a_ik (n_k . p_i + h_k) / d
        volume_gradient_i = sum_k a_ik n_k

    and with l the lengths of the edges of the visible part, theta the angles between the normals
    of the facets that meet there, and the sign + where these belong to the same body::

        area_gradient_i = sum_k n_k sum_e (+-) l_e tan(theta_e / 2)

    Positions are seen from the middle of the bounding box, of the whole cloud if it is given. Of
    facets of several bodies in one plane, what they share belongs to the first point by x, y,
    z; where facets touch from opposite sides, neither is visible.

    Parameters
    ----------
    centers : Centers
        Positions.
    tables : BodyTables
        r K, r being the largest r_i.
    sizes : ndarray, shape (n,)
        r_i / r of the distinct positions in grid order.
    box : ndarray, shape (2, d), optional
        Bounding box of the whole cloud, in the unit of the positions.

    Returns
    -------
    ndarray, shape (n, N_COLUMNS)
        Rows of the distinct positions in grid order, in units of the prism in 2D.
    """
    grid = centers.grid
    planes = facet_planes(tables)
    if box is None:
        box = np.stack([grid.coordinates.min(axis=1), grid.coordinates.max(axis=1)])
    middle = np.zeros(3)
    middle[: box.shape[1]] = 0.5 * box[0] + 0.5 * box[1]
    rows = np.empty((len(grid.order), N_COLUMNS))
    start = 0
    for own in map_blocks(
        measure_visible_facets, cube_starts(grid, centers.dimension),
        grid.coordinates, grid.cells, centers.dimension,
        sizes, middle, tables.reach, tables.normals, tables.offsets,
        tables.tangents, planes.polygons, planes.corner_counts, planes.lines,
    ):  # fmt: skip
        rows[start : start + len(own)] = own
        start += len(own)
    return rows
