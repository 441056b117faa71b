"""Measures of all restricted cells of a cloud, each facet computed once.

The points come in grid order. They are cut into blocks of fixed size, which the threads share
out; a facet between two points of one block is computed once and booked for both, a facet that
leaves the block is computed by both blocks. Sums are therefore formed in an order that does not
depend on the number of threads.

A bisector whose facet is empty bounds no other facet of the cell. Neighbours are therefore
visited farthest first and dropped as soon as their facet is seen to be empty, so that the near
ones, whose facets survive, are cut by few lines.
"""

import math

import numpy as np
from numba import njit, prange

from pcsmooth.kernels.facet_polygon import facet_arrays, measure_polygon
from pcsmooth.kernels.facet_segment import measure_segment
from pcsmooth.kernels.grid import adjacent_cells
from pcsmooth.kernels.hidden_neighbors import drop_hidden
from pcsmooth.kernels.near_points import (
    DISTANCE_CLASSES,
    collect_points,
    count_points,
    drop_neighbor,
    neighbor_arrays,
    select_nearest_first,
)

#: Points per block: large enough that few facets leave a block, small enough to share out.
BLOCK = 1024

#: Columns of the output of `measure_restricted_cells`.
CELL_VOLUME = 0
VISIBLE_AREA = 1
VOLUME_GRADIENT = 2  # and the next two
AREA_GRADIENT = 5  # and the next two
NORMAL_TENSOR = 8  # xx, xy, xz, yy, yz, zz
VOLUME_DIAGONAL = 14
AREA_DIAGONAL = 15
N_MEASURES = 16


@njit(parallel=True, cache=True, error_model="numpy")
def measure_restricted_cells(coordinates, order, cell_codes, cell_starts, dimension, radius):
    """Measure every restricted cell V_i and B(p_i, r) of distinct points.

    Parameters: coordinates (3, n) in grid order (cells of side >= 2 r); order (n,), the original
    number of each; codes (m,) and starts (m + 1,) of the occupied cells; d; r.
    Returns (n, N_MEASURES) in original order, rows NaN where a block did not finish.
    """
    n = coordinates.shape[1]
    measures = np.full((n, N_MEASURES), np.nan)
    for block in prange((n + BLOCK - 1) // BLOCK):
        start = block * BLOCK
        stop = min(start + BLOCK, n)
        sums = _sum_facets(coordinates, cell_codes, cell_starts, dimension, radius, start, stop)
        for i in range(start, stop):
            _close_cell(sums, i - start, dimension, radius, measures, order[i])
    return measures


@njit(cache=True, error_model="numpy")
def _sum_facets(coordinates, cell_codes, cell_starts, dimension, radius, start, stop):
    """Sum over the facets of points start..stop-1; rows laid out as the measures they become."""
    sums = np.zeros((stop - start, N_MEASURES))
    found = np.empty(27, np.int64)
    class_ends = np.empty(DISTANCE_CLASSES + 1, np.int64)
    met = np.zeros((stop - start, stop - start), np.bool_)  # pairs with a facet between them
    capacity = 0
    candidates, candidate_ids, kept, near, near_ids, scratch = neighbor_arrays(capacity)
    lines, vertices, edges = facet_arrays(capacity)

    cell = np.searchsorted(cell_starts, start, side="right") - 1
    while cell < cell_codes.size and cell_starts[cell] < stop:
        n_found = adjacent_cells(cell_codes, cell, dimension, found)
        n_candidates = count_points(cell_starts, found, n_found)
        if n_candidates > capacity:
            capacity = 2 * n_candidates
            candidates, candidate_ids, kept, near, near_ids, scratch = neighbor_arrays(capacity)
            lines, vertices, edges = facet_arrays(capacity)
        collect_points(coordinates, cell_starts, found, n_found, candidates, candidate_ids)

        for i in range(max(start, cell_starts[cell]), min(stop, cell_starts[cell + 1])):
            xi = coordinates[0, i]
            yi = coordinates[1, i]
            zi = coordinates[2, i]
            count = select_nearest_first(
                candidates,
                candidate_ids,
                n_candidates,
                i,
                xi,
                yi,
                zi,
                2.0 * radius,
                kept,
                scratch,
                class_ends,
                near,
                near_ids,
            )
            count = _drop_unmet(near, near_ids, count, met, start, i)
            count = drop_hidden(near, near_ids, count, xi, yi, zi, radius, scratch)
            for j in range(count - 1, -1, -1):
                other = near_ids[j]
                if start <= other < i:
                    continue  # booked when `other` was visited
                if dimension == 3:
                    area, angle, rim, mx, my, mz = measure_polygon(
                        xi, yi, zi, j, count, near, radius, lines, vertices, edges
                    )
                else:
                    area, angle, rim, mx, my, mz = measure_segment(xi, yi, j, count, near, radius)
                if area <= 0.0 and rim <= 0.0:
                    count = drop_neighbor(near, near_ids, count, j)
                    continue
                ux = near[0, j] - xi
                uy = near[1, j] - yi
                uz = near[2, j] - zi
                distance = math.sqrt(ux * ux + uy * uy + uz * uz)
                scale = 1.0 / distance
                ux *= scale
                uy *= scale
                uz *= scale
                _book(sums, i - start, ux, uy, uz, distance, area, angle, rim, mx, my, mz)
                if other < stop and other > i:
                    met[i - start, other - start] = True
                    _book(
                        sums, other - start, -ux, -uy, -uz, distance, area, angle, rim, mx, my, mz
                    )
        cell += 1
    return sums


@njit(cache=True)
def _drop_unmet(near, near_ids, count, met, start, i):
    """Drop the neighbours of p_i visited before it whose facet with p_i came out empty."""
    left = 0
    for j in range(count):
        other = near_ids[j]
        near[0, left] = near[0, j]
        near[1, left] = near[1, j]
        near[2, left] = near[2, j]
        near_ids[left] = other
        if start <= other < i and not met[other - start, i - start]:
            continue
        left += 1
    return left


@njit(cache=True, error_model="numpy", inline="always")
def _book(sums, row, ux, uy, uz, distance, area, angle, rim, mx, my, mz):
    """Add one facet, in direction u of a point, to the point's sums."""
    moment = 0.5 * distance * area
    sums[row, CELL_VOLUME] += moment
    sums[row, VISIBLE_AREA] += angle
    sums[row, VOLUME_GRADIENT] -= area * ux
    sums[row, VOLUME_GRADIENT + 1] -= area * uy
    sums[row, VOLUME_GRADIENT + 2] -= area * uz
    sums[row, AREA_GRADIENT] -= rim * ux
    sums[row, AREA_GRADIENT + 1] -= rim * uy
    sums[row, AREA_GRADIENT + 2] -= rim * uz
    # u (x) A c with A c = A h u + m, made symmetric (its sum over the facets is)
    sums[row, NORMAL_TENSOR] += (moment * ux + mx) * ux
    sums[row, NORMAL_TENSOR + 1] += moment * ux * uy + 0.5 * (ux * my + uy * mx)
    sums[row, NORMAL_TENSOR + 2] += moment * ux * uz + 0.5 * (ux * mz + uz * mx)
    sums[row, NORMAL_TENSOR + 3] += (moment * uy + my) * uy
    sums[row, NORMAL_TENSOR + 4] += moment * uy * uz + 0.5 * (uy * mz + uz * my)
    sums[row, NORMAL_TENSOR + 5] += (moment * uz + mz) * uz
    sums[row, VOLUME_DIAGONAL] += area / distance
    sums[row, AREA_DIAGONAL] += rim / distance


@njit(cache=True, error_model="numpy")
def _close_cell(sums, row, dimension, radius, out, target):
    """Turn the sums over the facets of one cell into its measures.

    With Omega the solid angles of the facets and h their distances: S = r^(d-1) (full - sum
    Omega), |C| = (r S + sum h A) / d, T = (|C| I - sum A u (x) c) / r.
    """
    for k in range(N_MEASURES):
        out[target, k] = sums[row, k]
    full = 4.0 * math.pi if dimension == 3 else 2.0 * math.pi
    sphere = radius * radius if dimension == 3 else radius
    visible = max(0.0, sphere * (full - sums[row, VISIBLE_AREA]))
    if sums[row, CELL_VOLUME] > 0.0 and sums[row, AREA_DIAGONAL] <= 0.0:
        visible = 0.0  # no facet reaches the sphere: it is covered, rounding aside
    volume = (radius * visible + sums[row, CELL_VOLUME]) / dimension
    out[target, VISIBLE_AREA] = visible
    out[target, CELL_VOLUME] = volume
    for k in range(6):
        out[target, NORMAL_TENSOR + k] = (
            -sums[row, NORMAL_TENSOR + k] / radius if visible > 0.0 else 0.0
        )
    if visible > 0.0:
        out[target, NORMAL_TENSOR] += volume / radius
        out[target, NORMAL_TENSOR + 3] += volume / radius
        if dimension == 3:
            out[target, NORMAL_TENSOR + 5] += volume / radius
