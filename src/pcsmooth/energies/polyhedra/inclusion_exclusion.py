"""Union by inclusion-exclusion over the alpha-complex."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.centers import Centers
from pcsmooth.energies.polyhedra.alpha_complex import AlphaComplex
from pcsmooth.energies.polyhedra.block_rows import Block, add_up
from pcsmooth.energies.polyhedra.body_tables import BodyTables
from pcsmooth.kernels.polyhedra.polyhedron_intersections import measure_intersections
from pcsmooth.kernels.threads import map_blocks
from pcsmooth.neighbors.grid import cube_starts


def measure_inclusion_exclusion(
    centers: Centers, radius: float, tables: BodyTables, sizes: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Measure the intersections over the simplices s of the alpha-complex (report, Eq. 3.4).

    The intersection of the bodies of a simplex has the normals n_k of K, each facet in the plane
    of the body where that is lowest. With a_k the areas of its facets::

        volume = sum_s (-1)^dim(s) |intersection of s|
        volume_gradient_i = sum_s (-1)^dim(s) sum_k a_k n_k    (facets k that body i bounds)

    and likewise for the boundary, a_k growing by l tan(theta / 2) for every edge, of length l,
    with a facet whose normal is at the angle theta. Of bodies with facet k in one plane the one
    of the first point by x, y, z counts.

    Parameters
    ----------
    centers : Centers
        Positions with coordinates of `alpha_complex.DIGITS` digits.
    radius : float
        Radius in the unit of the positions: that of the largest body, and of its ball.
    tables : BodyTables
        r K, r being this radius.
    sizes : ndarray, shape (n,)
        r_i / r of the distinct positions in grid order.

    Returns
    -------
    ndarray, shape (n, N_COLUMNS)
        Rows of the distinct positions in grid order, in units of the prism in 2D.

    Raises
    ------
    PcsmoothError
        If the alpha-complex contradicts itself.
    """
    coordinates = centers.grid.coordinates
    complex_ = AlphaComplex(centers, radius, sizes)

    def measure_block(start: int, stop: int) -> Block:
        rows, spilled, spilled_rows = measure_intersections(
            coordinates, complex_.list_block(start, stop), centers.dimension, sizes,
            tables.reach, tables.polyhedron, tables.normals, tables.offsets, tables.tangents,
            tables.n_counted, start, stop,
        )  # fmt: skip
        return rows, spilled, spilled_rows

    starts = cube_starts(centers.grid, centers.dimension)
    return add_up(map_blocks(measure_block, starts), coordinates.shape[1])
