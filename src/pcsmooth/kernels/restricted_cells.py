"""Measures of all restricted cells of a cloud, each facet computed once.

The points come in grid order. They are cut into blocks of fixed size, which the threads share
out; a facet between two points of one block is computed once and booked for both, a facet that
leaves the block is computed by both blocks. Sums are therefore formed in an order that does not
depend on the number of threads.
"""

import math

import numpy as np
from numba import njit, prange

from pcsmooth.kernels.facet_polygon import measure_polygon
from pcsmooth.kernels.facet_segment import measure_segment
from pcsmooth.kernels.grid import adjacent_cells

#: Points per block: large enough that few facets leave a block, small enough to share out.
BLOCK = 1024

#: Distance classes that stand in for a sort of the neighbours.
_DISTANCE_CLASSES = 32

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
            _close_cell(sums[i - start], dimension, radius, measures[order[i]])
    return measures


@njit(cache=True, error_model="numpy")
def _sum_facets(coordinates, cell_codes, cell_starts, dimension, radius, start, stop):
    """Sum over the facets of points start..stop-1; rows laid out as the measures they become."""
    sums = np.zeros((stop - start, N_MEASURES))
    found = np.empty(27, np.int64)
    capacity = 256
    near, near_ids, lines, polygon = _scratch(capacity)
    candidates = np.empty((3, capacity))
    candidate_ids = np.empty(capacity, np.int64)
    kept = np.empty(capacity, np.int64)
    kept_class = np.empty(capacity, np.int64)
    class_ends = np.empty(_DISTANCE_CLASSES + 1, np.int64)
    reach2 = 4.0 * radius * radius

    cell = np.searchsorted(cell_starts, start, side="right") - 1
    while cell < cell_codes.size and cell_starts[cell] < stop:
        n_found = adjacent_cells(cell_codes, cell, dimension, found)
        n_candidates = 0
        for f in range(n_found):
            n_candidates += cell_starts[found[f] + 1] - cell_starts[found[f]]
        if n_candidates > capacity:
            capacity = 2 * n_candidates
            near, near_ids, lines, polygon = _scratch(capacity)
            candidates = np.empty((3, capacity))
            candidate_ids = np.empty(capacity, np.int64)
            kept = np.empty(capacity, np.int64)
            kept_class = np.empty(capacity, np.int64)
        c = 0
        for f in range(n_found):
            for k in range(cell_starts[found[f]], cell_starts[found[f] + 1]):
                candidates[0, c] = coordinates[0, k]
                candidates[1, c] = coordinates[1, k]
                candidates[2, c] = coordinates[2, k]
                candidate_ids[c] = k
                c += 1

        for i in range(max(start, cell_starts[cell]), min(stop, cell_starts[cell + 1])):
            xi = coordinates[0, i]
            yi = coordinates[1, i]
            zi = coordinates[2, i]
            class_ends[:] = 0
            count = 0
            for c in range(n_candidates):
                dx = candidates[0, c] - xi
                dy = candidates[1, c] - yi
                dz = candidates[2, c] - zi
                distance2 = dx * dx + dy * dy + dz * dz
                if distance2 < reach2 and candidate_ids[c] != i:
                    # nearer classes first: they cut most
                    number = np.int64(distance2 * (_DISTANCE_CLASSES / reach2))
                    number = min(number, _DISTANCE_CLASSES - 1)
                    kept[count] = c
                    kept_class[count] = number
                    class_ends[number + 1] += 1
                    count += 1
            for number in range(_DISTANCE_CLASSES):
                class_ends[number + 1] += class_ends[number]
            for k in range(count):
                place = class_ends[kept_class[k]]
                class_ends[kept_class[k]] += 1
                near[0, place] = candidates[0, kept[k]]
                near[1, place] = candidates[1, kept[k]]
                near[2, place] = candidates[2, kept[k]]
                near_ids[place] = candidate_ids[kept[k]]

            for j in range(count):
                other = near_ids[j]
                if start <= other < i:
                    continue  # booked when `other` was visited
                if dimension == 3:
                    area, angle, rim, mx, my, mz = measure_polygon(
                        xi, yi, zi, j, count, near[0], near[1], near[2], radius, lines, polygon
                    )
                else:
                    area, angle, rim, mx, my, mz = measure_segment(
                        xi, yi, j, count, near[0], near[1], radius
                    )
                if area <= 0.0 and rim <= 0.0:
                    continue
                ux = near[0, j] - xi
                uy = near[1, j] - yi
                uz = near[2, j] - zi
                distance = math.sqrt(ux * ux + uy * uy + uz * uz)
                scale = 1.0 / distance
                ux *= scale
                uy *= scale
                uz *= scale
                _book(sums[i - start], ux, uy, uz, distance, area, angle, rim, mx, my, mz)
                if other < stop and other > i:
                    _book(
                        sums[other - start], -ux, -uy, -uz, distance, area, angle, rim, mx, my, mz
                    )
        cell += 1
    return sums


@njit(cache=True)
def _scratch(capacity):
    """Room for the neighbours of a point and the clipping of a facet."""
    return (
        np.empty((3, capacity)),
        np.empty(capacity, np.int64),
        np.empty((3, capacity)),
        np.empty((2, 5, capacity + 8)),
    )


@njit(cache=True, error_model="numpy", inline="always")
def _book(row, ux, uy, uz, distance, area, angle, rim, mx, my, mz):
    """Add one facet, in direction u of a point, to the point's sums."""
    moment = 0.5 * distance * area
    row[CELL_VOLUME] += moment
    row[VISIBLE_AREA] += angle
    row[VOLUME_GRADIENT] -= area * ux
    row[VOLUME_GRADIENT + 1] -= area * uy
    row[VOLUME_GRADIENT + 2] -= area * uz
    row[AREA_GRADIENT] -= rim * ux
    row[AREA_GRADIENT + 1] -= rim * uy
    row[AREA_GRADIENT + 2] -= rim * uz
    # u (x) A c with A c = A h u + m, made symmetric (its sum over the facets is)
    row[NORMAL_TENSOR] += (moment * ux + mx) * ux
    row[NORMAL_TENSOR + 1] += moment * ux * uy + 0.5 * (ux * my + uy * mx)
    row[NORMAL_TENSOR + 2] += moment * ux * uz + 0.5 * (ux * mz + uz * mx)
    row[NORMAL_TENSOR + 3] += (moment * uy + my) * uy
    row[NORMAL_TENSOR + 4] += moment * uy * uz + 0.5 * (uy * mz + uz * my)
    row[NORMAL_TENSOR + 5] += (moment * uz + mz) * uz
    row[VOLUME_DIAGONAL] += area / distance
    row[AREA_DIAGONAL] += rim / distance


@njit(cache=True, error_model="numpy")
def _close_cell(sums, dimension, radius, out):
    """Turn the sums over the facets of one cell into its measures.

    With Omega the solid angles of the facets and h their distances: S = r^(d-1) (full - sum
    Omega), |C| = (r S + sum h A) / d, T = (|C| I - sum A u (x) c) / r.
    """
    for k in range(N_MEASURES):
        out[k] = sums[k]
    full = 4.0 * math.pi if dimension == 3 else 2.0 * math.pi
    sphere = radius * radius if dimension == 3 else radius
    visible = max(0.0, sphere * (full - sums[VISIBLE_AREA]))
    if sums[CELL_VOLUME] > 0.0 and sums[AREA_DIAGONAL] <= 0.0:
        visible = 0.0  # no facet reaches the sphere: it is covered, rounding aside
    volume = (radius * visible + sums[CELL_VOLUME]) / dimension
    out[VISIBLE_AREA] = visible
    out[CELL_VOLUME] = volume
    for k in range(6):
        out[NORMAL_TENSOR + k] = -sums[NORMAL_TENSOR + k] / radius if visible > 0.0 else 0.0
    if visible > 0.0:
        out[NORMAL_TENSOR] += volume / radius
        out[NORMAL_TENSOR + 3] += volume / radius
        if dimension == 3:
            out[NORMAL_TENSOR + 5] += volume / radius
