"""The planes of a polyhedron around a point, and sums over its facets."""

import numpy as np

from pcsmooth.kernels.compiled import inner

#: A vertex is cut off only if it is beyond the plane by this, in units of the reach.
TOLERANCE = 1e-13

#: Rows of the table, a column for each plane: unit normal and offset; area of the facet and its
#: first moment; what callers sum over its edges, a weight and the weight's first moment.
NX, NY, NZ, OFFSET, AREA, MX, MY, MZ, EDGE, EX, EY, EZ = range(12)
_N_ROWS = 12


@inner
def facet_table(normals, offsets, n_planes):
    """Make a table for so many planes, the first being facets of K: normals (3, F), offsets."""
    table = np.zeros((_N_ROWS, n_planes))
    for k in range(offsets.size):
        table[NX, k] = normals[0, k]
        table[NY, k] = normals[1, k]
        table[NZ, k] = normals[2, k]
        table[OFFSET, k] = offsets[k]
    return table


@inner
def sum_over_facets(vertices, planes, across, n, n_planes, table):
    """Fill in areas and their first moments about the origin; all other sums become 0."""
    for k in range(n_planes):
        for row in range(AREA, _N_ROWS):
            table[row, k] = 0.0
    for t in range(n):
        tx = vertices[0, t]
        ty = vertices[1, t]
        tz = vertices[2, t]
        for e in range(3):
            a = planes[e, t]
            q = across[e, t]
            qx = vertices[0, q]
            qy = vertices[1, q]
            qz = vertices[2, q]
            nx = table[NX, a]
            ny = table[NY, a]
            nz = table[NZ, a]
            # The triangle of the edge and the foot of the perpendicular from p_i.
            area = 0.5 * (
                nx * (qy * tz - qz * ty) + ny * (qz * tx - qx * tz) + nz * (qx * ty - qy * tx)
            )
            third = area / 3.0
            offset = table[OFFSET, a]
            table[AREA, a] += area
            table[MX, a] += third * (offset * nx + qx + tx)
            table[MY, a] += third * (offset * ny + qy + ty)
            table[MZ, a] += third * (offset * nz + qz + tz)
