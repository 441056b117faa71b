"""Sums over the facets of some 3D cells, each facet clipped as a polygon."""

import numpy as np

from pcsmooth.kernels.balls.cell_facets import (
    ACROSS,
    ANGLE,
    AREA,
    FAN,
    HEIGHT,
    MOMENT,
    RIM,
    U,
    cell_facet_arrays,
    clip_facets,
)
from pcsmooth.kernels.balls.facet_booking import N_MEASURES, book_one, book_outside, close_fans
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.grid import MOST_RANGES, adjacent_ranges, cell_of_point
from pcsmooth.kernels.grid.within_reach import (
    X,
    Y,
    Z,
    collect_points,
    count_points,
    neighbor_arrays,
)


@inner
def sum_cells_again(coordinates, cells, radius, radii, start, stop, unsure, terms, sums):
    """Sum anew over the facets of the unsure points, as polygons."""
    ranges = np.empty((2, MOST_RANGES), np.int64)
    capacity = np.int64(0)
    candidates, near, spare, hiders = neighbor_arrays(capacity)
    positions, lines, vertices, edges, facets = cell_facet_arrays(capacity)
    cell = -1
    n_candidates = 0
    for i in range(start, stop):
        if not unsure[i - start]:
            continue
        if cell < 0 or i >= cells.starts[cell + 1]:
            cell = cell_of_point(cells, i)
            n_ranges = adjacent_ranges(cells, cell, 3, ranges)
            n_candidates = count_points(ranges, n_ranges)
            if n_candidates > capacity:
                capacity = 2 * n_candidates
                candidates, near, spare, hiders = neighbor_arrays(capacity)
                positions, lines, vertices, edges, facets = cell_facet_arrays(capacity)
            collect_points(coordinates, ranges, n_ranges, candidates)
        n_facets, is_outside, planes_meet = clip_facets(
            coordinates, i, 0, candidates, n_candidates, radius, radii, near, spare, hiders,
            positions, lines, vertices, edges, facets,
        )  # fmt: skip
        for column in range(N_MEASURES):
            sums[i - start, column] = 0.0
        if is_outside and not planes_meet:
            book_outside(sums, i - start, 3)
        angle_row = FAN if planes_meet else ANGLE
        for f in range(n_facets):
            book_one(
                terms, sums, i - start, facets[U + X, f], facets[U + Y, f], facets[U + Z, f],
                facets[AREA, f], facets[HEIGHT, f], radii, facets[angle_row, f], facets[RIM, f],
                facets[MOMENT + X, f], facets[MOMENT + Y, f], facets[MOMENT + Z, f],
                facets[ACROSS + X, f], facets[ACROSS + Y, f], facets[ACROSS + Z, f],
            )  # fmt: skip
        if planes_meet:
            close_fans(sums, i - start)
