"""Sums over the facets of some 3D cells, each facet clipped as a polygon.

Slower than sharing edges, but nothing combinatorial is shared between facets, so that points on
grids, on spheres and in planes, and clusters much smaller than the ball, are no exception.
"""

import numpy as np
from numba import njit

from pcsmooth.kernels.facet_booking import N_MEASURES, book_one
from pcsmooth.kernels.facet_polygon import facet_arrays, measure_polygon
from pcsmooth.kernels.grid import adjacent_cells, cell_of_point
from pcsmooth.kernels.hidden_neighbors import keep_visible
from pcsmooth.kernels.near_points import (
    NUMBER,
    collect_points,
    count_points,
    neighbor_arrays,
    select_within_reach,
)


@njit(cache=True, error_model="numpy")
def sum_cells_again(coordinates, cell_codes, cell_starts, radius, start, stop, unsure, terms, sums):
    """Sum anew over the facets of the unsure points, as polygons."""
    found = np.empty(27, np.int64)
    capacity = np.int64(0)
    candidates, near, spare, hiders = neighbor_arrays(capacity)
    positions = np.empty((3, capacity))
    lines, vertices, edges = facet_arrays(capacity)
    cell = -1
    n_candidates = 0
    for i in range(start, stop):
        if not unsure[i - start]:
            continue
        if cell < 0 or i >= cell_starts[cell + 1]:
            cell = cell_of_point(cell_starts, i)
            n_found = adjacent_cells(cell_codes, cell, 3, found)
            n_candidates = count_points(cell_starts, found, n_found)
            if n_candidates > capacity:
                capacity = 2 * n_candidates
                candidates, near, spare, hiders = neighbor_arrays(capacity)
                positions = np.empty((3, capacity))
                lines, vertices, edges = facet_arrays(capacity)
            collect_points(coordinates, cell_starts, found, n_found, candidates)
        x = coordinates[0, i]
        y = coordinates[1, i]
        z = coordinates[2, i]
        count = select_within_reach(candidates, n_candidates, x, y, z, 2.0 * radius, near)
        count = keep_visible(near, count, radius, spare, hiders)
        for j in range(count):
            for axis in range(3):
                positions[axis, j] = coordinates[axis, int(near[NUMBER, j])]
        for column in range(N_MEASURES):
            sums[i - start, column] = 0.0
        # A bisector whose facet is empty bounds no other facet: farthest first, empty ones drop
        # out, and the near ones, whose facets survive, are cut by few lines.
        for j in range(count - 1, -1, -1):
            area, angle, rim, mx, my, mz = measure_polygon(
                x, y, z, j, count, positions, radius, lines, vertices, edges
            )
            if area <= 0.0 and rim <= 0.0:
                count -= 1
                for axis in range(3):
                    for k in range(j, count):
                        positions[axis, k] = positions[axis, k + 1]
                continue
            ux = positions[0, j] - x
            uy = positions[1, j] - y
            uz = positions[2, j] - z
            book_one(terms, sums, i - start, ux, uy, uz, area, angle, rim, mx, my, mz)
