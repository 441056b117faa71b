"""Naive union: the sum of the restricted cells V_i and (p_i + r_i K)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.centers import Centers
from pcsmooth.energies.polyhedra.block_rows import add_up
from pcsmooth.energies.polyhedra.body_tables import BodyTables
from pcsmooth.kernels.polyhedra.polyhedral_cells import measure_polyhedral_cells
from pcsmooth.kernels.threads import map_blocks
from pcsmooth.neighbors.grid import cube_starts


def measure_naive(
    centers: Centers, tables: BodyTables, sizes: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Measure the restricted cells (report, Section 3.3.1), with the gradients of their sums.

    V_i is the power cell of the largest balls in the bodies: no place in one of these balls is
    lost. If the bodies are equal, it is the Voronoi cell.

    With a_k the areas of facets of K in the cell, n_k their normals, A_ij and x_ij the area and
    centroid of the facet of cell i in its radical plane with p_j::

        gradient_i = sum_k a_k n_k + sum_j [A_ij (x_ij - p_i) - A_ji (x_ji - p_i)] / |p_j - p_i|

    The two last terms do not cancel, as they do for balls: p_i + r_i K and p_j + r_j K do not meet
    the plane in the same polygon.

    Parameters
    ----------
    centers : Centers
        Positions.
    tables : BodyTables
        r K, r being the largest r_i.
    sizes : ndarray, shape (n,)
        r_i / r of the distinct positions in grid order.

    Returns
    -------
    ndarray, shape (n, N_COLUMNS)
        Rows of the distinct positions in grid order, in units of the prism in 2D.
    """
    grid = centers.grid
    blocks = map_blocks(
        measure_polyhedral_cells, cube_starts(grid, centers.dimension),
        grid.coordinates, grid.cells, centers.dimension, sizes, tables.inradius, tables.reach,
        tables.polyhedron, tables.normals, tables.offsets, tables.n_counted,
    )  # fmt: skip
    return add_up(blocks, len(grid.order))
