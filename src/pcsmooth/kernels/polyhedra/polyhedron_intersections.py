"""Intersections of homothetic convex polyhedra, over the simplices of an alpha-complex."""

import math

import numpy as np

from pcsmooth.kernels.cells.convex_polyhedron import (
    AFTER,
    TORN,
    copy_polyhedron,
    cut_off_leniently,
    measure_excess,
    polyhedron_arrays,
)
from pcsmooth.kernels.cells.hidden_neighbors import keep_visible
from pcsmooth.kernels.cells.radical_planes import collect_radii, place_neighbors
from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS, MOST_RANGES, adjacent_ranges, cell_of_point
from pcsmooth.kernels.grid.within_reach import (
    NUMBER,
    collect_points,
    count_points,
    neighbor_arrays,
)
from pcsmooth.kernels.polyhedra.delaunay_star import (
    EXPANSION,
    IN_DOUBT,
    N_BOX_PLANES,
    TIE,
    find_star,
    plane_table,
)
from pcsmooth.kernels.polyhedra.facet_sums import (
    AREA,
    EDGE,
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
    AREA_GRADIENT,
    N_COLUMNS,
    VISIBLE_AREA,
    VOLUME_GRADIENT,
    VOLUME_SHARE,
    row_of,
    spill_arrays,
)

#: Column of the shifts of a simplex' other points that says by how much their bodies are larger.
_LARGER = 3


@kernel("f2 cells i f f1 f2 (f2 i2 i2) f2 f1 i i", cells=CELLS)
def list_simplices(
    coordinates, cells, dimension, radius, sizes, weights, box, normals, offsets,
    start, stop,
):  # fmt: skip
    """List the simplices of the alpha-complex whose lowest point is one of start .. stop - 1.

    Parameters: the points in grid order (cells of side >= 2 r of each); d; the largest r; sizes
    (n,), the r of the points in units of that; their weights (2, n); the box that stars are cut
    from as vertices, planes, across; its normals (3, 6) and offsets.

    Returns them as rows (s, 4) of numbers of points, -1 for none, and how many stars failed.
    """
    ranges = np.empty((2, MOST_RANGES), np.int64)
    capacity = np.int64(0)
    candidates, near, spare, hiders = neighbor_arrays(capacity)
    arrays = polyhedron_arrays(N_BOX_PLANES)
    table = plane_table(normals, offsets, N_BOX_PLANES)
    star = np.empty((3, 0), np.int64)
    expansion = np.empty(EXPANSION)
    simplices = np.empty((16 * (stop - start), 4), np.int64)
    n_simplices = 0
    n_torn = 0
    reach = radius * (1.0 + TIE)
    cell = cell_of_point(cells, start)
    while cell < cells.codes.size and cells.starts[cell] < stop:
        n_ranges = adjacent_ranges(cells, cell, dimension, ranges)
        n_candidates = count_points(ranges, n_ranges)
        if n_candidates > capacity:
            capacity = 2 * n_candidates
            candidates, near, spare, hiders = neighbor_arrays(capacity)
            arrays = polyhedron_arrays(N_BOX_PLANES + capacity)
            table = plane_table(normals, offsets, N_BOX_PLANES + capacity)
            star = np.empty((3, 6 * (N_BOX_PLANES + capacity)), np.int64)
        collect_points(coordinates, ranges, n_ranges, candidates)
        collect_radii(sizes, candidates, n_candidates)
        for i in range(max(start, cells.starts[cell]), min(stop, cells.starts[cell + 1])):
            x = coordinates[0, i]
            y = coordinates[1, i]
            z = coordinates[2, i]
            size = sizes[i]
            count, is_empty = select_cutting(
                candidates, n_candidates, x, y, z, size, radius, reach, near
            )
            if is_empty:
                continue
            own = reach * size
            count = keep_visible(near, count, own, sizes, IN_DOUBT * own, spare, hiders)
            place_neighbors(coordinates, sizes, i, near, count)
            n = find_star(
                box, i, near, count, weights, radius * size, arrays, table, expansion, star
            )
            if n == TORN:
                n_torn += 1
                continue
            if n_simplices + n > len(simplices):
                simplices = _grown(simplices, n_simplices, 2 * (n_simplices + n))
            for s in range(n):
                simplices[n_simplices, 0] = i
                for m in range(3):
                    place = star[m, s]
                    number = int(near[NUMBER, place]) if place >= 0 else -1
                    simplices[n_simplices, 1 + m] = number
                n_simplices += 1
        cell += 1
    return simplices[:n_simplices], n_torn


@inner
def _grown(simplices, n_simplices, room):
    """Make a larger array and copy the simplices into it."""
    more = np.empty((room, 4), np.int64)
    for s in range(n_simplices):
        for m in range(4):
            more[s, m] = simplices[s, m]
    return more


@kernel("f2 i2 i f1 f (f2 i2 i2) f2 f1 f2 i i i")
def measure_intersections(
    coordinates, simplices, dimension, sizes, reach, body, normals, offsets, tangents, n_counted,
    start, stop,
):  # fmt: skip
    """Measure the intersections of the polyhedra about the points of simplices, with signs.

    Parameters: the points in grid order; simplices as from `list_simplices` of the same block; d;
    sizes of the bodies (n,), in units of r K; the largest distance of a vertex of r K from its
    centre; r K as vertices, planes, across; its normals (3, F) and offsets; tan(angle / 2) between
    the normals of its facets (F, F), 0 for those that do not count; how many do.

    Returns the rows of the points, and the spilled rows of others: numbers and rows.
    """
    n_facets = offsets.size
    rows = np.zeros((stop - start, N_COLUMNS))
    spilled, spilled_rows = spill_arrays(3 * len(simplices))
    n_spilled = np.int64(0)
    vertices, planes, across, excess, first = polyhedron_arrays(n_facets)
    table = facet_table(normals, offsets, n_facets)
    lowest = np.empty(n_facets, np.int64)
    shifts = np.zeros((4, 4))
    targets = np.empty(4, np.int64)
    for s in range(len(simplices)):
        i = simplices[s, 0]
        count = 1
        while count < 4 and simplices[s, count] >= 0:
            other = simplices[s, count]
            for axis in range(3):
                shifts[count, axis] = coordinates[axis, other] - coordinates[axis, i]
            shifts[count, _LARGER] = sizes[other] - sizes[i]
            count += 1
        sign = -1.0 if count % 2 == 0 else 1.0
        tolerance = TOLERANCE * (reach * sizes[i])
        n = copy_polyhedron(body[0], body[1], body[2], vertices, planes, across)
        scale_vertices(vertices, n, sizes[i], dimension)
        for k in range(n_facets):
            growth = offsets[k] if k < n_counted else 0.0  # the ends of prisms stay where they are
            lowest[k], depth = _lowest_member(shifts, count, table, k, growth)
            table[OFFSET, k] = offsets[k] + (sizes[i] - 1.0) * growth + depth
            if n == 0 or depth >= -tolerance:
                continue
            measure_excess(
                vertices, n, table[NX, k], table[NY, k], table[NZ, k], table[OFFSET, k], excess
            )
            n = cut_off_leniently(vertices, planes, across, n, excess, tolerance, k, first)
        if n == 0:
            continue
        sum_over_facets(vertices, planes, across, n, n_facets, table)
        _sum_over_edges(vertices, planes, across, n, n_counted, tangents, table)
        for member in range(count):
            targets[member] = simplices[s, member] if member > 0 else i
        for member in range(count):
            theirs, row, n_spilled = row_of(
                targets[member], start, stop, rows, spilled, spilled_rows, n_spilled
            )
            for k in range(n_facets):
                area = sign * table[AREA, k]
                if member == 0:
                    theirs[row, VOLUME_SHARE] += area * table[OFFSET, k] / 3.0
                if lowest[k] != member or k >= n_counted:
                    continue
                edges = sign * table[EDGE, k]
                theirs[row, VISIBLE_AREA] += area
                for axis in range(3):
                    theirs[row, VOLUME_GRADIENT + axis] += area * table[NX + axis, k]
                    theirs[row, AREA_GRADIENT + axis] += edges * table[NX + axis, k]
    return rows, spilled[:n_spilled], spilled_rows[:n_spilled]


@inner
def _lowest_member(shifts, count, table, k, growth):
    """Find the member whose facet k bounds the intersection, and how far below that of p_i it is.

    growth: how much higher the facet is in a body larger by 1.

    Of members at one height it is the first by x, y, z, whatever their order.
    """
    lowest = 0
    depth = 0.0
    for member in range(1, count):
        x = shifts[member, 0]
        y = shifts[member, 1]
        z = shifts[member, 2]
        height = x * table[NX, k] + y * table[NY, k] + z * table[NZ, k]
        height += shifts[member, _LARGER] * growth
        if height > depth:
            continue
        if height == depth:
            x -= shifts[lowest, 0]
            y -= shifts[lowest, 1]
            z -= shifts[lowest, 2]
            if x > 0.0 or (x == 0.0 and (y > 0.0 or (y == 0.0 and z > 0.0))):
                continue
        lowest = member
        depth = height
    return lowest, depth


@inner
def _sum_over_edges(vertices, planes, across, n, n_counted, tangents, table):
    """Sum length tan(angle / 2) over the edges of each facet: how fast the area grows with it."""
    for t in range(n):
        for e in range(3):
            a = planes[e, t]
            if a >= n_counted:
                continue
            q = across[e, t]
            dx = vertices[0, t] - vertices[0, q]
            dy = vertices[1, t] - vertices[1, q]
            dz = vertices[2, t] - vertices[2, q]
            length = math.sqrt(dx * dx + dy * dy + dz * dz)
            table[EDGE, a] += length * tangents[a, planes[AFTER[e], t]]
