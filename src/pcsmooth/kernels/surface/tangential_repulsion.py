"""Points that push each other apart within their surface."""

import math

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS
from pcsmooth.kernels.grid.within_reach import (
    NUMBER,
    X,
    Y,
    Z,
    points_around,
    select_within_reach,
)
from pcsmooth.kernels.threads import shared_out

#: Widths of the Gaussian beyond which nothing is felt.
REACH = 2.2


@shared_out("cells.codes")
@kernel("f2 cells i f2 f1 f f2 i i", cells=CELLS)
def repel(coordinates, cells, dimension, normals, widths, strength, moved, first, last):
    """Move points down the gradient of their density, within their tangent planes.

    Parameters: coordinates (3, n) in grid order; cells; d; unit normals (3, n); widths (n,) of the
    Gaussians, REACH of them less than a cell; strength. Fills moved (3, n), the new positions.
    """
    for cell in range(first, last):
        _repel_in_cell(
            coordinates, cells, cell, dimension, normals, widths,
            strength, moved,
        )  # fmt: skip


@inner
def _repel_in_cell(coordinates, cells, cell, dimension, normals, widths, strength, moved):
    """Do it for the points of one cell."""
    candidates, n_candidates, near = points_around(coordinates, cells, cell, dimension)
    for i in range(cells.starts[cell], cells.starts[cell + 1]):
        width = widths[i]
        n_near = select_within_reach(
            candidates, n_candidates, coordinates[0, i], coordinates[1, i], coordinates[2, i],
            REACH * width, near,
        )  # fmt: skip
        nx = normals[0, i]
        ny = normals[1, i]
        nz = normals[2, i]
        px = py = pz = 0.0
        for k in range(n_near):
            j = int(near[NUMBER, k])
            x = near[X, k]
            y = near[Y, k]
            z = near[Z, k]
            weight = math.exp(-(x * x + y * y + z * z) / (width * width)) * abs(
                nx * normals[0, j] + ny * normals[1, j] + nz * normals[2, j]
            )
            px -= weight * x
            py -= weight * y
            pz -= weight * z
        along = px * nx + py * ny + pz * nz
        moved[0, i] = coordinates[0, i] + strength * (px - along * nx)
        moved[1, i] = coordinates[1, i] + strength * (py - along * ny)
        moved[2, i] = coordinates[2, i] + strength * (pz - along * nz)
