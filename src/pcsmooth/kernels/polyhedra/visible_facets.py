"""The parts of facets of homothetic convex polyhedra that no other one covers.

A facet starts as one convex piece. Every body that crosses its plane there is subtracted, nearest
first: each piece is split along the lines where the body's other facets cross the plane, and what
is inside of all of them is dropped. In the plane of facet k the line of facet m always has the
same direction, whichever body it belongs to; only its distance from the centre changes. What is
around a body is seen in units of its size: in these a neighbour's facet m is higher than its own
by n_m . u + (s - 1) h_m, if it is at u and of the size s.
"""

import math

import numpy as np

from pcsmooth.kernels.arithmetic.simd import WIDTH, bits, load, lowest_bit, multiply_add, store
from pcsmooth.kernels.cells.radical_planes import collect_radii
from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS, MOST_RANGES, adjacent_ranges, cell_of_point
from pcsmooth.kernels.grid.within_reach import (
    NUMBER,
    X,
    Y,
    Z,
    collect_points,
    count_points,
    neighbor_arrays,
    pad_neighbors,
    sort_by_distance,
)
from pcsmooth.kernels.polyhedra.unequal_bodies import select_touching
from pcsmooth.kernels.polyhedra.union_rows import (
    AREA_GRADIENT,
    N_COLUMNS,
    VISIBLE_AREA,
    VOLUME_GRADIENT,
    VOLUME_SHARE,
)

#: Row of an array of neighbours: by how much they are larger, in units of the body's own size.
_LARGER = 5

#: Vertices that a piece has room for; larger ones are split.
_MOST_VERTICES = 32

#: Pieces that there is room for at first.
_PIECES_AT_FIRST = 16

#: Instead of a number of pieces: they need more room.
_FULL = -1

#: What is beyond a line by less than this, in units of the reach, is on it.
_ON_LINE = 1e-14

#: Heights are compared with all their digits if they differ by less than this, in units of reach.
_NEAR_TIE = 1e-9

#: Rows of a piece: coordinates in the plane, and what the edge from this vertex to the next is
#: part of: an own edge (facet m), or facet m of neighbour j as F (j + 1) + m; _INSIDE for none.
_PX, _PY, _EDGE_OF = 0, 1, 2
_INSIDE = -1.0

#: Rows of lines, for facet m in the plane of facet k: unit normal within the plane, distance from
#: the centre for the body itself, sine of the angle between the facets' normals (0 for opposite
#: facets), and heights of a neighbour's facet over the body's own up to which it covers nothing of
#: the facet, and from which on the line does not cross it.
NU_X, NU_Y, BASE, SINE, NOTHING, ALL = range(6)


@kernel("f2 cells i f1 f1 f f2 f1 f2 f3 i1 f3 i i", cells=CELLS)
def measure_visible_facets(
    coordinates, cells, dimension, sizes, origin, reach, normals, offsets, tangents,
    polygons, corner_counts, lines, start, stop,
):  # fmt: skip
    """Measure what is visible of the facets of points start .. stop - 1.

    Parameters: the points in grid order (cells of side >= 2 reach of each); d; sizes of their
    bodies (n,), in units of r K; an origin (3,) in their midst; the largest distance of a vertex
    of r K from its centre; its normals (3, F), offsets, and tan(angle / 2) between the normals
    (F, F), 0 for those that do not count; of the facets that count polygons (C, 3, ...), rows as a
    piece's, and how many corners they have; lines (6, C, F), by the rows above.

    Returns the rows of the points.
    """
    n_facets = offsets.size
    rows = np.zeros((stop - start, N_COLUMNS))
    ranges = np.empty((2, MOST_RANGES), np.int64)
    capacity = np.int64(0)
    candidates, near, spare, _ = neighbor_arrays(capacity)
    heights = np.empty((n_facets, 0))
    pieces = np.empty((_PIECES_AT_FIRST, 3, _MOST_VERTICES))
    counts = np.empty(_PIECES_AT_FIRST, np.int64)
    cutting = np.empty(n_facets, np.int64)
    ends = np.empty(n_facets)
    room = 2 * (_MOST_VERTICES + polygons.shape[2] + n_facets)
    inside = np.empty((3, room))
    spare_piece = np.empty((3, room))
    outside = np.empty((3, room))
    cell = cell_of_point(cells, start)
    while cell < cells.codes.size and cells.starts[cell] < stop:
        n_ranges = adjacent_ranges(cells, cell, dimension, ranges)
        n_candidates = count_points(ranges, n_ranges)
        if n_candidates > capacity:
            capacity = 2 * n_candidates
            candidates, spare, near, _ = neighbor_arrays(capacity)
            heights = np.empty((n_facets, capacity + WIDTH))
        collect_points(coordinates, ranges, n_ranges, candidates)
        collect_radii(sizes, candidates, n_candidates)
        for i in range(max(start, cells.starts[cell]), min(stop, cells.starts[cell + 1])):
            x = coordinates[0, i]
            y = coordinates[1, i]
            z = coordinates[2, i]
            size = sizes[i]
            count = select_touching(candidates, n_candidates, x, y, z, size, reach, spare)
            pad_neighbors(spare, count)
            sort_by_distance(spare, count, near)
            _use_own_units(near, count, sizes, size)
            _measure_heights(near, count, normals, offsets, corner_counts.size, heights)
            for k in range(corner_counts.size):
                n_pieces = np.int64(_FULL)
                while n_pieces == _FULL:
                    n_pieces = _find_visible_pieces(
                        polygons, corner_counts, k, coordinates, sizes, i, near, count, heights,
                        normals, offsets, lines, reach, cutting, ends, inside, spare_piece,
                        outside, pieces, counts,
                    )  # fmt: skip
                    if n_pieces == _FULL:
                        pieces = np.empty((2 * counts.size, 3, _MOST_VERTICES))
                        counts = np.empty(2 * counts.size, np.int64)
                if n_pieces > 0:
                    _book_pieces(
                        pieces, counts, n_pieces, k, heights, normals, offsets, tangents, lines,
                        size, x - origin[0], y - origin[1], z - origin[2], dimension, rows,
                        i - start,
                    )  # fmt: skip
        cell += 1
    return rows


@inner
def _use_own_units(near, count, sizes, size):
    """See neighbours in units of a body's size, and by how much each of them is larger."""
    for j in range(count):
        near[X, j] /= size
        near[Y, j] /= size
        near[Z, j] /= size
        near[_LARGER, j] = sizes[int(near[NUMBER, j])] / size - 1.0


@inner
def _measure_heights(near, count, normals, offsets, n_counted, heights):
    """Compute how much higher the facets of all neighbours are than the body's own, (F, ...).

    Those that do not count, the ends of prisms, are at one height in all bodies.
    """
    for c in range(0, count, WIDTH):
        x = load(near, X, c)
        y = load(near, Y, c)
        z = load(near, Z, c)
        larger = load(near, _LARGER, c)
        for m in range(len(heights)):
            height = multiply_add(
                z, normals[2, m], multiply_add(y, normals[1, m], x * normals[0, m])
            )
            if m < n_counted:
                height = multiply_add(larger, offsets[m], height)
            store(heights, m, c, height)


@inner
def _is_above(coordinates, sizes, i, number, normals, offsets, k):
    """Whether facet k of another point is higher than that of p_i, on any account.

    Of facets in one plane the one of the lowest point by x, y, z counts as the highest. Any two
    points are ranked alike in all places, and any three consistently.
    """
    own = 0.0
    other = 0.0
    for axis in range(3):
        own += coordinates[axis, i] * normals[axis, k]
        other += coordinates[axis, number] * normals[axis, k]
    own += (sizes[i] - 1.0) * offsets[k]
    other += (sizes[number] - 1.0) * offsets[k]
    if own != other:
        return other > own
    for axis in range(3):
        if coordinates[axis, i] != coordinates[axis, number]:
            return coordinates[axis, number] < coordinates[axis, i]
    return False


@inner
def _find_visible_pieces(
    polygons, corner_counts, k, coordinates, sizes, i, near, count, heights, normals, offsets,
    lines, reach, cutting, ends, inside, spare, outside, pieces, counts,
):  # fmt: skip
    """Subtract the bodies of all neighbours from facet k of p_i; returns the number of pieces.

    Eight neighbours at a time are passed over that are below the facet or beyond it. Functions
    return _FULL if the pieces need more room, and not larger arrays: to reassign arrays in a loop
    costs more, in reference counts, than all that is done with them.
    """
    for v in range(corner_counts[k]):
        for row in range(3):
            outside[row, v] = polygons[k, row, v]
    n_pieces = _push(outside, corner_counts[k], pieces, counts, np.int64(0))
    near_tie = _NEAR_TIE * reach
    n_facets = len(heights)
    c = 0
    while c < count and n_pieces > 0:
        left = (1 << min(WIDTH, count - c)) - 1
        left &= bits(load(heights, k, c) >= -near_tie)
        for m in range(n_facets):
            if left == 0:
                break
            left &= bits(load(heights, m, c) > lines[NOTHING, k, m])
        while left != 0 and n_pieces > 0:
            j = c + lowest_bit(left)
            left &= left - 1
            if heights[k, j] <= near_tie and not _is_above(
                coordinates, sizes, i, int(near[NUMBER, j]), normals, offsets, k
            ):
                continue
            n_lines = 0
            for m in range(n_facets):
                if heights[m, j] < lines[ALL, k, m]:
                    cutting[n_lines] = m
                    ends[n_lines] = lines[BASE, k, m] + heights[m, j] / lines[SINE, k, m]
                    n_lines += 1
            n_pieces = _subtract(
                pieces, counts, n_pieces, k, n_facets * (j + 1), n_lines, cutting, ends, lines,
                _ON_LINE * reach, inside, spare, outside,
            )  # fmt: skip
        c += WIDTH
    return n_pieces


@inner
def _push(polygon, n_vertices, pieces, counts, n_pieces):
    """Add a polygon to the pieces, in parts if it has many vertices; returns their number."""
    first = 1
    while True:
        last = min(n_vertices - 1, first + _MOST_VERTICES - 2)
        if n_pieces == counts.size:
            return np.int64(_FULL)
        for row in range(3):
            pieces[n_pieces, row, 0] = polygon[row, 0]
            for v in range(first, last + 1):
                pieces[n_pieces, row, v - first + 1] = polygon[row, v]
        n = last - first + 2
        if first > 1:
            pieces[n_pieces, _EDGE_OF, 0] = _INSIDE
        if last < n_vertices - 1:
            pieces[n_pieces, _EDGE_OF, n - 1] = _INSIDE
        counts[n_pieces] = n
        n_pieces += 1
        if last == n_vertices - 1:
            return n_pieces
        first = last


@inner
def _subtract(
    pieces, counts, n_pieces, k, code, n_lines, cutting, ends, lines, on_line, inside, spare,
    outside,
):  # fmt: skip
    """Subtract from all pieces what is inside of all lines; returns the number of pieces."""
    p = n_pieces
    while p > 0 and n_pieces != _FULL:
        p -= 1
        if _is_beyond_a_line(pieces, counts, p, k, n_lines, cutting, ends, lines, on_line):
            continue
        before = n_pieces
        n_inside = counts[p]
        for row in range(3):
            for v in range(n_inside):
                inside[row, v] = pieces[p, row, v]
        for c in range(n_lines):
            m = cutting[c]
            n_inside, n_outside = _split(
                inside, n_inside, lines[NU_X, k, m], lines[NU_Y, k, m], ends[c], on_line,
                float(code + m), spare, outside,
            )  # fmt: skip
            if n_inside > 0 and n_outside > 0:
                n_pieces = _push(outside, n_outside, pieces, counts, n_pieces)
            if n_inside == 0 or n_pieces == _FULL:
                break
        if n_inside == 0:
            n_pieces = before  # nothing was inside: the piece stays as it was
        elif n_pieces != _FULL:
            n_pieces -= 1
            counts[p] = counts[n_pieces]
            for row in range(3):
                for v in range(counts[p]):
                    pieces[p, row, v] = pieces[n_pieces, row, v]
    return n_pieces


@inner
def _is_beyond_a_line(pieces, counts, p, k, n_lines, cutting, ends, lines, on_line):
    """Whether one of the lines has all of a piece beyond it."""
    for c in range(n_lines):
        nx = lines[NU_X, k, cutting[c]]
        ny = lines[NU_Y, k, cutting[c]]
        limit = ends[c] - on_line
        is_beyond = True
        for v in range(counts[p]):
            if nx * pieces[p, _PX, v] + ny * pieces[p, _PY, v] < limit:
                is_beyond = False
                break
        if is_beyond:
            return True
    return False


@inner
def _split(inside, n, nx, ny, end, on_line, code, spare, outside):
    """Split a polygon along a line: `inside` keeps what is not beyond it, the rest is `outside`.

    Returns the numbers of vertices of both. A part without area has none, and the other one is
    all of the polygon.
    """
    largest = -np.inf
    smallest = np.inf
    for v in range(n):
        beyond = nx * inside[_PX, v] + ny * inside[_PY, v] - end
        largest = max(largest, beyond)
        smallest = min(smallest, beyond)
    n_inside = n
    n_outside = 0
    if largest > on_line and smallest >= -on_line:
        n_inside = 0
        n_outside = n
    elif largest > on_line:
        n_inside = 0
        x = inside[_PX, n - 1]
        y = inside[_PY, n - 1]
        edge_of = inside[_EDGE_OF, n - 1]
        beyond = nx * x + ny * y - end
        for v in range(n):
            next_x = inside[_PX, v]
            next_y = inside[_PY, v]
            next_beyond = nx * next_x + ny * next_y - end
            # The edge from (x, y) to the next vertex, its first end included.
            if beyond > 0.0:
                outside[_PX, n_outside] = x
                outside[_PY, n_outside] = y
                outside[_EDGE_OF, n_outside] = edge_of
                n_outside += 1
            else:
                spare[_PX, n_inside] = x
                spare[_PY, n_inside] = y
                spare[_EDGE_OF, n_inside] = edge_of
                n_inside += 1
            if (beyond > 0.0) != (next_beyond > 0.0):
                share = beyond / (beyond - next_beyond)
                crossing_x = x + share * (next_x - x)
                crossing_y = y + share * (next_y - y)
                outside[_PX, n_outside] = crossing_x
                outside[_PY, n_outside] = crossing_y
                spare[_PX, n_inside] = crossing_x
                spare[_PY, n_inside] = crossing_y
                if beyond > 0.0:
                    outside[_EDGE_OF, n_outside] = code
                    spare[_EDGE_OF, n_inside] = edge_of
                else:
                    outside[_EDGE_OF, n_outside] = edge_of
                    spare[_EDGE_OF, n_inside] = _INSIDE
                n_outside += 1
                n_inside += 1
            x = next_x
            y = next_y
            edge_of = inside[_EDGE_OF, v]
            beyond = next_beyond
        for row in range(3):
            for v in range(n_inside):
                inside[row, v] = spare[row, v]
    return n_inside, n_outside


@inner
def _book_pieces(
    pieces, counts, n_pieces, k, heights, normals, offsets, tangents, lines, size, x, y, z,
    dimension, rows, row,
):  # fmt: skip
    """Book what is visible of facet k, whose pieces are in units of the size.

    As a facet moves outward the area of the boundary grows by tan(angle / 2) per length of its
    edges with facets of the same body, and shrinks by as much at those with other bodies. x, y
    and z are where the body is.
    """
    area = 0.0
    growth = 0.0
    n_facets = len(heights)
    for p in range(n_pieces):
        n = counts[p]
        for v in range(n):
            w = v + 1 if v + 1 < n else 0
            ax = pieces[p, _PX, v]
            ay = pieces[p, _PY, v]
            bx = pieces[p, _PX, w]
            by = pieces[p, _PY, w]
            area += 0.5 * (ax * by - ay * bx)
            edge_of = int(pieces[p, _EDGE_OF, v])
            if edge_of < 0:
                continue
            m = edge_of % n_facets
            length = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            if edge_of < n_facets:
                growth += length * tangents[k, m]
            elif length > 0.0:
                share = _share_in_body(
                    ax, ay, bx, by, k, m, edge_of // n_facets - 1, heights, lines
                )
                growth -= share * length * tangents[k, m]
    area *= size
    if dimension == 3:
        area *= size
        growth *= size
    nx = normals[0, k]
    ny = normals[1, k]
    nz = normals[2, k]
    rows[row, VISIBLE_AREA] += area
    rows[row, VOLUME_SHARE] += area * (nx * x + ny * y + nz * z + offsets[k] * size) / dimension
    rows[row, VOLUME_GRADIENT] += area * nx
    rows[row, VOLUME_GRADIENT + 1] += area * ny
    rows[row, VOLUME_GRADIENT + 2] += area * nz
    rows[row, AREA_GRADIENT] += growth * nx
    rows[row, AREA_GRADIENT + 1] += growth * ny
    rows[row, AREA_GRADIENT + 2] += growth * nz


@inner
def _share_in_body(ax, ay, bx, by, k, m, j, heights, lines):
    """Share of an edge on line m that the other lines of neighbour j leave inside it."""
    begin = 0.0
    end = 1.0
    for other in range(len(heights)):
        if other in (k, m) or lines[SINE, k, other] == 0.0:
            continue
        nx = lines[NU_X, k, other]
        ny = lines[NU_Y, k, other]
        limit = lines[BASE, k, other] + heights[other, j] / lines[SINE, k, other]
        at_a = nx * ax + ny * ay - limit
        at_b = nx * bx + ny * by - limit
        if at_a > 0.0 and at_b > 0.0:
            return 0.0
        if at_a > 0.0:
            begin = max(begin, at_a / (at_a - at_b))
        elif at_b > 0.0:
            end = min(end, at_a / (at_a - at_b))
    return max(0.0, end - begin)
