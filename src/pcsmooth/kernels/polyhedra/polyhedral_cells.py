"""Restricted cells V_i and (p_i + s_i K) of a block of points, K a convex polyhedron.

V_i is the power cell of the balls that the bodies hold; if these are equal, the Voronoi cell.
"""

import math

import numpy as np

from pcsmooth.kernels.cells.convex_polyhedron import (
    AFTER,
    copy_polyhedron,
    cut_off_leniently,
    measure_excess,
    polyhedron_arrays,
)
from pcsmooth.kernels.cells.hidden_neighbors import keep_visible
from pcsmooth.kernels.cells.radical_planes import collect_radii
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
)
from pcsmooth.kernels.polyhedra.facet_sums import (
    AREA,
    EDGE,
    EX,
    EY,
    EZ,
    MX,
    NX,
    NY,
    NZ,
    OFFSET,
    TOLERANCE,
    facet_table,
    sum_over_facets,
)
from pcsmooth.kernels.polyhedra.unequal_bodies import scale_vertices, select_cutting
from pcsmooth.kernels.polyhedra.union_rows import (
    AREA_DIAGONAL,
    AREA_GRADIENT,
    N_COLUMNS,
    VISIBLE_AREA,
    VOLUME_DIAGONAL,
    VOLUME_GRADIENT,
    VOLUME_SHARE,
    grown_spill,
    row_of,
    spill_arrays,
)

#: Sine of the angle between two facets below which they count as parallel.
_PARALLEL = 1e-9


@kernel("f2 cells i f1 f f (f2 i2 i2) f2 f1 i i i", cells=CELLS)
def measure_polyhedral_cells(
    coordinates, cells, dimension, sizes, inradius, reach, body, normals, offsets, n_counted,
    start, stop,
):  # fmt: skip
    """Measure the cells of points start .. stop - 1.

    Parameters: the points in grid order (cells of side >= 2 reach of each); d; sizes of their
    bodies (n,), in units of r K; the radius of the largest ball in r K about its centre, and the
    largest distance of a vertex from there; r K as vertices, planes, across; its normals (3, F) and
    offsets; how many of its facets count (in 2D r K is a prism, whose two ends do not).

    Returns the rows of the points, and the spilled rows of others: numbers and rows.
    """
    body_vertices, body_planes, body_across = body
    n_facets = offsets.size
    rows = np.zeros((stop - start, N_COLUMNS))
    spilled, spilled_rows = spill_arrays(1024)
    n_spilled = np.int64(0)
    ranges = np.empty((2, MOST_RANGES), np.int64)
    capacity = np.int64(0)
    candidates, near, spare, hiders = neighbor_arrays(capacity)
    table = facet_table(normals, offsets, n_facets)
    vertices, planes, across, excess, first = polyhedron_arrays(n_facets)
    cell = cell_of_point(cells, start)
    while cell < cells.codes.size and cells.starts[cell] < stop:
        n_ranges = adjacent_ranges(cells, cell, dimension, ranges)
        n_candidates = count_points(ranges, n_ranges)
        if n_candidates > capacity:
            capacity = 2 * n_candidates
            candidates, near, spare, hiders = neighbor_arrays(capacity)
            table = facet_table(normals, offsets, n_facets + capacity)
            vertices, planes, across, excess, first = polyhedron_arrays(n_facets + capacity)
        collect_points(coordinates, ranges, n_ranges, candidates)
        collect_radii(sizes, candidates, n_candidates)
        for i in range(max(start, cells.starts[cell]), min(stop, cells.starts[cell + 1])):
            x = coordinates[0, i]
            y = coordinates[1, i]
            z = coordinates[2, i]
            size = sizes[i]
            tolerance = TOLERANCE * (reach * size)
            count, is_empty = select_cutting(
                candidates, n_candidates, x, y, z, size, inradius, reach, near
            )
            if is_empty:
                continue
            count = keep_visible(near, count, reach * size, sizes, 0.0, spare, hiders)
            n = copy_polyhedron(body_vertices, body_planes, body_across, vertices, planes, across)
            scale_vertices(vertices, n, size, dimension)
            for k in range(n_counted):
                table[OFFSET, k] = offsets[k] * size
            n_planes = n_facets
            for j in range(count):
                length = math.sqrt(abs(near[SQUARE, j]))
                nx = near[X, j] / length
                ny = near[Y, j] / length
                nz = near[Z, j] / length
                offset = 0.5 * length if near[SQUARE, j] > 0.0 else -0.5 * length
                if measure_excess(vertices, n, nx, ny, nz, offset, excess) <= tolerance:
                    continue
                n = cut_off_leniently(
                    vertices, planes, across, n, excess, tolerance, n_planes, first
                )
                table[NX, n_planes] = nx
                table[NY, n_planes] = ny
                table[NZ, n_planes] = nz
                table[OFFSET, n_planes] = offset
                near[NUMBER, n_planes - n_facets] = near[NUMBER, j]
                n_planes += 1
            sum_over_facets(vertices, planes, across, n, n_planes, table)
            if n_spilled + n_planes > spilled.size:
                spilled, spilled_rows = grown_spill(
                    spilled, spilled_rows, n_spilled, n_spilled + n_planes
                )
            _book_own_facets(
                vertices, planes, across, n, n_facets, n_counted, table, rows, i - start
            )
            for k in range(n_facets, n_planes):
                if table[AREA, k] == 0.0 and table[EDGE, k] == 0.0:
                    continue
                target = int(near[NUMBER, k - n_facets])
                theirs, row, n_spilled = row_of(
                    target, start, stop, rows, spilled, spilled_rows, n_spilled
                )
                distance = 2.0 * table[OFFSET, k]
                if sizes[target] != size:
                    distance = _distance_of(coordinates, i, target)
                _book_facet_between(table, k, distance, rows, i - start, theirs, row)
        cell += 1
    return rows, spilled[:n_spilled], spilled_rows[:n_spilled]


@inner
def _distance_of(coordinates, i, j):
    """Distance of two points."""
    dx = coordinates[0, j] - coordinates[0, i]
    dy = coordinates[1, j] - coordinates[1, i]
    dz = coordinates[2, j] - coordinates[2, i]
    return math.sqrt(dx * dx + dy * dy + dz * dz)


@inner
def _book_own_facets(
    vertices, planes, across, n, n_facets, n_counted, table, rows, row
):  # fmt: skip
    """Book the volume, the facets of K, and their edges.

    The area of facet a grows by (V_b - cos V_a) / sin per length of its edge with b, where V are
    the speeds of their planes along their normals; p_i carries all planes of K with it.
    """
    for k in range(n_facets):
        area = table[AREA, k]
        rows[row, VOLUME_SHARE] += area * table[OFFSET, k] / 3.0
        if k < n_counted:
            rows[row, VISIBLE_AREA] += area
            rows[row, VOLUME_GRADIENT] += area * table[NX, k]
            rows[row, VOLUME_GRADIENT + 1] += area * table[NY, k]
            rows[row, VOLUME_GRADIENT + 2] += area * table[NZ, k]
    for t in range(n):
        for e in range(3):
            a = planes[e, t]
            if a >= n_counted:
                continue
            b = planes[AFTER[e], t]
            q = across[e, t]
            ax = table[NX, a]
            ay = table[NY, a]
            az = table[NZ, a]
            bx = table[NX, b]
            by = table[NY, b]
            bz = table[NZ, b]
            sx = ay * bz - az * by
            sy = az * bx - ax * bz
            sz = ax * by - ay * bx
            sine = math.sqrt(sx * sx + sy * sy + sz * sz)
            if sine < _PARALLEL:
                continue
            dx = vertices[0, t] - vertices[0, q]
            dy = vertices[1, t] - vertices[1, q]
            dz = vertices[2, t] - vertices[2, q]
            weight = math.sqrt(dx * dx + dy * dy + dz * dz) / sine
            cosine = weight * (ax * bx + ay * by + az * bz)
            rows[row, AREA_GRADIENT] -= cosine * ax
            rows[row, AREA_GRADIENT + 1] -= cosine * ay
            rows[row, AREA_GRADIENT + 2] -= cosine * az
            if b < n_facets:
                rows[row, AREA_GRADIENT] += weight * bx
                rows[row, AREA_GRADIENT + 1] += weight * by
                rows[row, AREA_GRADIENT + 2] += weight * bz
            else:
                half = 0.5 * weight
                table[EDGE, b] += weight
                table[EX, b] += half * (vertices[0, t] + vertices[0, q])
                table[EY, b] += half * (vertices[1, t] + vertices[1, q])
                table[EZ, b] += half * (vertices[2, t] + vertices[2, q])


@inner
def _book_facet_between(table, k, distance, rows, row, theirs, their_row):
    """Book the facet in the radical plane with p_j for p_i and for p_j.

    Its plane moves by (x - p_i) / |p_j - p_i| with p_i, and by -(x - p_j) / |p_j - p_i| with p_j.
    """
    area = table[AREA, k]
    edge = table[EDGE, k]
    scale = 1.0 / distance
    rows[row, VOLUME_SHARE] += area * table[OFFSET, k] / 3.0
    for axis in range(3):
        own = table[MX + axis, k] * scale
        rows[row, VOLUME_GRADIENT + axis] += own
        theirs[their_row, VOLUME_GRADIENT + axis] -= own - area * table[NX + axis, k]
        own = table[EX + axis, k] * scale
        rows[row, AREA_GRADIENT + axis] += own
        theirs[their_row, AREA_GRADIENT + axis] -= own - edge * table[NX + axis, k]
    weight = 0.5 * area * scale
    rows[row, VOLUME_DIAGONAL] += weight
    theirs[their_row, VOLUME_DIAGONAL] += weight
    weight = 0.5 * edge * scale
    rows[row, AREA_DIAGONAL] += weight
    theirs[their_row, AREA_DIAGONAL] += weight
