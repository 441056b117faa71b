"""Facets of one 3D cell, each clipped as a polygon.

Slower than sharing edges, but nothing combinatorial is shared between facets, so that points on
grids, on spheres and in planes, and clusters much smaller than the ball, are no exception.
"""

import math

import numpy as np

from pcsmooth.kernels.balls.facet_polygon import (
    CHORD2_ROW,
    HALF_ROW,
    RADIUS_ROW,
    facet_arrays,
    measure_polygon,
)
from pcsmooth.kernels.cells.hidden_neighbors import keep_visible
from pcsmooth.kernels.cells.radical_planes import (
    CHORD2,
    HALF,
    RADIUS,
    THROUGH,
    collect_radii,
    place_neighbors,
    select_images,
)
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.within_reach import NUMBER, SQUARE, X, Y, Z, select_within_reach

#: Rows of a facet: u from its cell's point to the other one, area, angle seen from the cell's
#: point, weight of the unit vector in the area's gradient, first moment about the foot, number of
#: the other point, height over the cell's point, what the area's gradient has across u, angle of
#: its fan.
U = 0  # and the next two
AREA = 3
ANGLE = 4
RIM = 5
MOMENT = 6  # and the next two
OTHER = 9
HEIGHT = 10
ACROSS = 11  # and the next two
FAN = 14
_N_ROWS = 15


@inner
def cell_facet_arrays(capacity):
    """Make room for the facets of a cell among `capacity` neighbours, and for clipping them."""
    lines, vertices, edges = facet_arrays(capacity)
    positions = np.empty((CHORD2_ROW + 1, capacity))
    return positions, lines, vertices, edges, np.empty((_N_ROWS, capacity))


@inner
def clip_facets(
    coordinates, i, least_other, candidates, n_candidates, radius, radii, near, spare, hiders,
    positions, lines, vertices, edges, facets,
):  # fmt: skip
    """Find the facets of p_i's cell, farthest first, into facets.

    Returns how many there are, whether p_i lies outside its cell, and whether more than one plane
    passes through it, so that facets may be seen under no certain angle.
    Facets with points of numbers below least_other are left out.
    candidates: the points of the cells of the grid around p_i; near, spare and hiders from
    `neighbor_arrays`, the others from `cell_facet_arrays`.
    """
    x = coordinates[0, i]
    y = coordinates[1, i]
    z = coordinates[2, i]
    is_outside = False
    n_through = 0
    if radii is not None:
        radius = radii[i]
        collect_radii(radii, candidates, n_candidates)
        count, is_outside, _ = select_images(candidates, n_candidates, x, y, z, radius, 0.0, near)
    else:
        count = select_within_reach(candidates, n_candidates, x, y, z, 2.0 * radius, near)
    count = keep_visible(near, count, radius, radii, 0.0, spare, hiders)
    if radii is not None:
        place_neighbors(coordinates, radii, i, near, count)
        for j in range(count):
            height = near[HALF, j] / math.sqrt(near[SQUARE, j])
            n_through += abs(height) < THROUGH * radius
            positions[HALF_ROW, j] = near[HALF, j]
            positions[RADIUS_ROW, j] = near[RADIUS, j]
            positions[CHORD2_ROW, j] = near[CHORD2, j]
    for j in range(count):
        for axis in range(3):
            positions[axis, j] = coordinates[axis, int(near[NUMBER, j])]
    n_facets = np.int64(0)
    # A bisector whose facet is empty bounds no other facet: farthest first, empty ones drop
    # out, and the near ones, whose facets survive, are cut by few lines. Of a cell that may be
    # flat or empty they stay: they may be what leaves nothing of it.
    for j in range(count - 1, -1, -1):
        if near[NUMBER, j] < least_other:
            continue
        height, area, angle, rim, mx, my, mz, sx, sy, sz, fan = measure_polygon(
            x, y, z, j, count, positions, radius, radii, lines, vertices, edges
        )
        if area <= 0.0 and rim <= 0.0:
            if is_outside or n_through > 1:
                continue
            count -= 1
            for row in range(CHORD2_ROW + 1 if radii is not None else 3):
                for k in range(j, count):
                    positions[row, k] = positions[row, k + 1]
            continue
        facets[U + X, n_facets] = positions[0, j] - x
        facets[U + Y, n_facets] = positions[1, j] - y
        facets[U + Z, n_facets] = positions[2, j] - z
        facets[AREA, n_facets] = area
        facets[ANGLE, n_facets] = angle
        facets[RIM, n_facets] = rim
        facets[MOMENT + X, n_facets] = mx
        facets[MOMENT + Y, n_facets] = my
        facets[MOMENT + Z, n_facets] = mz
        facets[OTHER, n_facets] = near[NUMBER, j]
        facets[HEIGHT, n_facets] = height
        facets[ACROSS + X, n_facets] = sx
        facets[ACROSS + Y, n_facets] = sy
        facets[ACROSS + Z, n_facets] = sz
        facets[FAN, n_facets] = fan
        n_facets += 1
    return n_facets, is_outside, n_through > 1
