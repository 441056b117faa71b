"""Sums over the facets of a block of 2D cells."""

import math

import numpy as np

from pcsmooth.kernels.arithmetic.simd import WIDTH, everywhere, load, lowest_bit
from pcsmooth.kernels.balls.facet_booking import (
    N_BOOKING_ROWS,
    N_MEASURES,
    VISIBLE_AREA,
    book,
    book_outside,
    half_length,
    store_booking_terms,
)
from pcsmooth.kernels.balls.facet_segment import (
    cut_bisectors,
    measure_segments,
    measure_unequal_segments,
    sum_visible_arcs,
)
from pcsmooth.kernels.cells.bounding_polyhedron import TOUCHING
from pcsmooth.kernels.cells.hidden_neighbors import thin_out
from pcsmooth.kernels.cells.radical_planes import (
    HALF,
    THROUGH,
    collect_radii,
    place_neighbors,
    select_images,
)
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.grid import MOST_RANGES, adjacent_ranges, cell_of_point
from pcsmooth.kernels.grid.within_reach import (
    NUMBER,
    SQUARE,
    X,
    Y,
    collect_points,
    count_points,
    neighbor_arrays,
    pad_neighbors,
    select_open,
    select_within_reach,
)

#: Neighbours in 2D that are worth thinning out.
_MANY = 24

#: Segments that are gathered before they are booked.
_SEGMENTS_AT_ONCE = 64


@inner
def sum_cells_2d(coordinates, cells, radius, radii, start, stop):
    """Sum over the facets of points start..stop-1; rows laid out as the measures they become."""
    sums = np.zeros((stop - start, N_MEASURES))
    ranges = np.empty((2, MOST_RANGES), np.int64)
    capacity = np.int64(0)
    candidates, near, others, hiders = neighbor_arrays(capacity)
    ends = np.empty((2, WIDTH))
    segments = np.empty((4, _SEGMENTS_AT_ONCE + 2 * WIDTH))
    points = np.empty((2, _SEGMENTS_AT_ONCE + 2 * WIDTH), np.int64)
    n_segments = np.int64(0)
    # What is visible of disks through whose point pass bisectors: from there, facets are seen under
    # no certain angle.
    arcs = np.full(stop - start, -1.0)
    terms = np.empty((N_BOOKING_ROWS, N_MEASURES))
    cell = cell_of_point(cells, start)
    while cell < cells.codes.size and cells.starts[cell] < stop:
        n_ranges = adjacent_ranges(cells, cell, 2, ranges)
        n_candidates = count_points(ranges, n_ranges)
        if n_candidates > capacity:
            capacity = 2 * n_candidates
            candidates, near, others, hiders = neighbor_arrays(capacity)
        collect_points(coordinates, ranges, n_ranges, candidates)
        if radii is not None:
            collect_radii(radii, candidates, n_candidates)
        for i in range(max(start, cells.starts[cell]), min(stop, cells.starts[cell + 1])):
            x = coordinates[0, i]
            y = coordinates[1, i]
            if radii is not None:
                radius = radii[i]
                count, is_outside, _ = select_images(
                    candidates, n_candidates, x, y, 0.0, radius, 0.0, near
                )
                if is_outside:
                    book_outside(sums, i - start, 2)
            else:
                count = select_within_reach(candidates, n_candidates, x, y, 0.0, 2.0 * radius, near)
            if count > _MANY:
                count = thin_out(near, count, radius, radii, TOUCHING * radius, hiders)
            pad_neighbors(near, count)
            n_open = select_open(near, count, i, start, others)
            if radii is not None:
                place_neighbors(coordinates, radii, i, near, count)
                place_neighbors(coordinates, radii, i, others, n_open)
                n_through = 0
                for k in range(count):
                    height = near[HALF, k] / math.sqrt(near[SQUARE, k])
                    n_through += abs(height) < THROUGH * radius
                if n_through > 1:
                    arcs[i - start] = sum_visible_arcs(near, count)
            for c in range(0, n_open, WIDTH):
                left = cut_bisectors(others, n_open, c, near, count, radius, radii, ends)
                while left != 0:
                    lane = lowest_bit(left)
                    left &= left - 1
                    segments[0, n_segments] = others[X, c + lane]
                    segments[1, n_segments] = others[Y, c + lane]
                    segments[2, n_segments] = ends[0, lane]
                    segments[3, n_segments] = ends[1, lane]
                    points[0, n_segments] = i
                    points[1, n_segments] = int(others[NUMBER, c + lane])
                    n_segments += 1
                if n_segments >= _SEGMENTS_AT_ONCE:
                    _book_segments(
                        segments, points, n_segments, radius, radii, start, stop, terms, sums
                    )
                    n_segments = 0
        cell += 1
    _book_segments(segments, points, n_segments, radius, radii, start, stop, terms, sums)
    if radii is not None:
        for row in range(stop - start):
            if arcs[row] >= 0.0:
                sums[row, VISIBLE_AREA] = 2.0 * math.pi - arcs[row]
    return sums


@inner
def _book_segments(segments, points, n_segments, radius, radii, start, stop, terms, sums):
    """Book 2D facets: rows of u and ends; numbers of their points."""
    zero = everywhere(0.0)
    both_radii = np.ones((2, WIDTH))
    for c in range(0, n_segments, WIDTH):
        n_lanes = min(WIDTH, n_segments - c)
        x = load(segments, 0, c)
        y = load(segments, 1, c)
        low = load(segments, 2, c)
        high = load(segments, 3, c)
        if radii is not None:
            for lane in range(n_lanes):
                both_radii[0, lane] = radii[points[0, c + lane]]
                both_radii[1, lane] = radii[points[1, c + lane]]
            length, height, other_height, angle, other_angle, rim, mx, my, sx, sy = (
                measure_unequal_segments(
                    x, y, low, high, load(both_radii, 0, 0), load(both_radii, 1, 0)
                )
            )
        else:
            length, angle, rim, mx, my = measure_segments(x, y, low, high, radius)
            height = half_length(x, y, zero)
            other_height, other_angle, sx, sy = height, angle, zero, zero
        store_booking_terms(
            terms, x, y, zero, length, height, other_height, angle, other_angle, rim, mx, my, zero,
            sx, sy, zero,
        )  # fmt: skip
        for lane in range(n_lanes):
            book(terms, lane, sums, points[0, c + lane] - start)
            other = points[1, c + lane]
            if start <= other < stop:
                book(terms, WIDTH + lane, sums, other - start)
