"""Weights w_ij of the graph Laplacians that the gradients of a union of balls are.

gradient_i = sum_j w_ij (p_i - p_j), one term for each facet: for the volume w = area / |u|, for
the area of the boundary w = rim / |u|, rim being the weight of the unit vector in its gradient,
which is all of it if radii are equal.
Each facet is measured once, in the cell of its point with the lower number, so that the weights
are symmetric to the last bit.
"""

import math

import numpy as np

from pcsmooth.kernels.arithmetic.simd import WIDTH, everywhere, load, lowest_bit, store
from pcsmooth.kernels.balls.cell_facets import (
    AREA,
    OTHER,
    RIM,
    U,
    cell_facet_arrays,
    clip_facets,
)
from pcsmooth.kernels.balls.facet_segment import (
    cut_bisectors,
    measure_segments,
    measure_unequal_segments,
)
from pcsmooth.kernels.cells.bounding_polyhedron import TOUCHING
from pcsmooth.kernels.cells.hidden_neighbors import thin_out
from pcsmooth.kernels.cells.radical_planes import (
    RADIUS,
    collect_radii,
    place_neighbors,
    select_images,
)
from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS, MOST_RANGES, adjacent_ranges, cell_of_point
from pcsmooth.kernels.grid.within_reach import (
    NUMBER,
    SQUARE,
    X,
    Y,
    Z,
    collect_points,
    count_points,
    neighbor_arrays,
    pad_neighbors,
    select_open,
    select_within_reach,
)

#: Facets per point with points of higher numbers that there is room for at first.
_FACETS_AT_FIRST = 10


@kernel("f2 cells i f n b i i", "f2 cells i f f1 b i i", cells=CELLS)
def upper_weights(coordinates, cells, dimension, radius, radii, of_area, start, stop):
    """Weights of the facets of points start..stop-1 with points of higher numbers.

    Parameters: coordinates (3, n) in grid order (cells of side >= 2 r_i); d; r; radii (n,)
    in grid order, None if all are r; whether the weights are those of the boundary's area.
    Returns the number of weights of each point, and for each weight the number of the other point
    and the weight.
    """
    counts = np.empty(stop - start, np.int64)
    room = _FACETS_AT_FIRST * (stop - start)
    columns = np.empty(room, np.int32)
    weights = np.empty(room)
    n_weights = np.int64(0)
    ranges = np.empty((2, MOST_RANGES), np.int64)
    capacity = np.int64(0)
    candidates, near, spare, hiders = neighbor_arrays(capacity)
    positions, lines, vertices, edges, facets = cell_facet_arrays(capacity)
    ends = np.empty((4, WIDTH))
    cell = cell_of_point(cells, start)
    while cell < cells.codes.size and cells.starts[cell] < stop:
        n_ranges = adjacent_ranges(cells, cell, dimension, ranges)
        n_candidates = count_points(ranges, n_ranges)
        if n_candidates > capacity:
            capacity = 2 * n_candidates
            candidates, near, spare, hiders = neighbor_arrays(capacity)
            positions, lines, vertices, edges, facets = cell_facet_arrays(capacity)
        collect_points(coordinates, ranges, n_ranges, candidates)
        for i in range(max(start, cells.starts[cell]), min(stop, cells.starts[cell + 1])):
            if n_weights + n_candidates > room:
                room = 2 * (n_weights + n_candidates)
                columns, weights = _grow(columns, weights, n_weights, room)
            before = n_weights
            if dimension == 3:
                n_facets, _, _ = clip_facets(
                    coordinates, i, i, candidates, n_candidates, radius, radii, near, spare, hiders,
                    positions, lines, vertices, edges, facets,
                )  # fmt: skip
                n_weights = _add_polygons(facets, n_facets, of_area, columns, weights, n_weights)
            else:
                n_weights = _add_segments(
                    coordinates, i, candidates, n_candidates, radius, radii, near, spare, hiders,
                    ends, of_area, columns, weights, n_weights,
                )  # fmt: skip
            counts[i - start] = n_weights - before
        cell += 1
    return counts, columns[:n_weights].copy(), weights[:n_weights].copy()


@inner
def _grow(columns, weights, n_weights, room):
    """Copy columns and weights to larger arrays."""
    more_columns = np.empty(room, np.int32)
    more_weights = np.empty(room)
    for k in range(n_weights):
        more_columns[k] = columns[k]
        more_weights[k] = weights[k]
    return more_columns, more_weights


@inner
def _add_polygons(facets, n_facets, of_area, columns, weights, n_weights):
    """Add the weights of some 3D facets of p_i; returns the number of weights."""
    measure = RIM if of_area else AREA
    for f in range(n_facets):
        if facets[measure, f] > 0.0:
            x = facets[U + X, f]
            y = facets[U + Y, f]
            z = facets[U + Z, f]
            columns[n_weights] = int(facets[OTHER, f])
            weights[n_weights] = facets[measure, f] / math.sqrt(x * x + y * y + z * z)
            n_weights += 1
    return n_weights


@inner
def _add_segments(
    coordinates, i, candidates, n_candidates, radius, radii, near, others, hiders, ends, of_area,
    columns, weights, n_weights,
):  # fmt: skip
    """Add the weights of the 2D facets of p_i; returns the number of weights."""
    x = coordinates[0, i]
    y = coordinates[1, i]
    if radii is not None:
        radius = radii[i]
        collect_radii(radii, candidates, n_candidates)
        count, _, _ = select_images(candidates, n_candidates, x, y, 0.0, radius, 0.0, near)
    else:
        count = select_within_reach(candidates, n_candidates, x, y, 0.0, 2.0 * radius, near)
    count = thin_out(near, count, radius, radii, TOUCHING * radius, hiders)
    pad_neighbors(near, count)
    n_others = select_open(near, count, i, 0, others)
    if radii is not None:
        place_neighbors(coordinates, radii, i, near, count)
        place_neighbors(coordinates, radii, i, others, n_others)
    for c in range(0, n_others, WIDTH):
        left = cut_bisectors(others, n_others, c, near, count, radius, radii, ends)
        ux, uy = load(others, X, c), load(others, Y, c)
        low, high = load(ends, 0, 0), load(ends, 1, 0)
        if radii is not None:
            length, _, _, _, _, rim, _, _, _, _ = measure_unequal_segments(
                ux, uy, low, high, everywhere(radius), load(others, RADIUS, c)
            )
        else:
            length, _, rim, _, _ = measure_segments(ux, uy, low, high, radius)
        store(ends, 2, 0, length)
        store(ends, 3, 0, rim)
        while left != 0:
            lane = lowest_bit(left)
            left &= left - 1
            measure = ends[3, lane] if of_area else ends[2, lane]
            if measure > 0.0:
                columns[n_weights] = int(others[NUMBER, c + lane])
                weights[n_weights] = measure / math.sqrt(others[SQUARE, c + lane])
                n_weights += 1
    return n_weights


@kernel("i1 j1 f1")
def mirror_rows(counts, upper_columns, upper_weights):
    """Rows of a symmetric matrix from what is right of its diagonal.

    Number of weights of each row (n,), their columns and the weights -> starts (n + 1,), columns
    and weights of all rows, the columns left of the diagonal in order first; sums of the rows.
    """
    n = counts.size
    starts = np.zeros(n + 1, np.int64)
    for i in range(n):
        starts[i + 1] += counts[i]
    for k in range(upper_columns.size):
        starts[upper_columns[k] + 1] += 1
    ends = np.empty(n, np.int64)  # of the part of each row that is filled
    for i in range(n):
        ends[i] = starts[i]
        starts[i + 1] += starts[i]
    columns = np.empty(starts[n], np.int32)
    weights = np.empty(starts[n])
    sums = np.zeros(n)
    k = 0
    for i in range(n):
        for _ in range(counts[i]):
            j = upper_columns[k]
            columns[ends[i]] = j
            weights[ends[i]] = upper_weights[k]
            columns[ends[j]] = i
            weights[ends[j]] = upper_weights[k]
            sums[i] += upper_weights[k]
            sums[j] += upper_weights[k]
            ends[i] += 1
            ends[j] += 1
            k += 1
    return starts, columns, weights, sums
