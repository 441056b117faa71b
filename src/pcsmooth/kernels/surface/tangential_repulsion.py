"""Points that push each other apart within their surface."""

import math

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.threads import MANY, shared_out

#: Widths of the Gaussian beyond which nothing is felt.
REACH = 2.2


@shared_out("ends", MANY // 8)
@kernel("f2 f2 f1 j1 i1 f f2 i i")
def repel(coordinates, normals, widths, numbers, ends, strength, moved, first, last):
    """Move points down the gradient of their density, within their tangent planes.

    Parameters: coordinates (3, n) in grid order; unit normals (3, n); widths (n,) of the Gaussians;
    numbers of all points that each point may feel, and the ends (n,) of each one's; strength. Fills
    moved (3, n), the new positions.
    """
    for i in range(first, last):
        begin = ends[i - 1] if i > 0 else 0
        _repel(coordinates, normals, widths[i], i, numbers, begin, ends[i], strength, moved)


@inner
def _repel(coordinates, normals, width, i, numbers, begin, end, strength, moved):
    """Do it for one point."""
    nx = normals[0, i]
    ny = normals[1, i]
    nz = normals[2, i]
    reach = REACH * width
    px = py = pz = 0.0
    for k in range(begin, end):
        j = numbers[k]
        x = coordinates[0, j] - coordinates[0, i]
        y = coordinates[1, j] - coordinates[1, i]
        z = coordinates[2, j] - coordinates[2, i]
        square = x * x + y * y + z * z
        if not 0.0 < square < reach * reach:
            continue
        weight = math.exp(-square / (width * width)) * abs(
            nx * normals[0, j] + ny * normals[1, j] + nz * normals[2, j]
        )
        px -= weight * x
        py -= weight * y
        pz -= weight * z
    along = px * nx + py * ny + pz * nz
    moved[0, i] = coordinates[0, i] + strength * (px - along * nx)
    moved[1, i] = coordinates[1, i] + strength * (py - along * ny)
    moved[2, i] = coordinates[2, i] + strength * (pz - along * nz)
