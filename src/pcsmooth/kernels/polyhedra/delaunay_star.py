"""The star of a point in the alpha-complex: the simplices whose Voronoi faces come near it.

The triangulation is that of weighted points (dual to a power diagram): a weight is the squared
radius of the point's ball, and a tiny number that depends on the position alone. If the radii are
equal it is the Delaunay triangulation; whatever the order of the points, it is one and the same,
and a regular one, even of points that are cospherical, coplanar, or on a grid. Which vertices a
bisector cuts off is decided in floats, where that is in doubt in pairs of floats, and where that
is in doubt without rounding.
"""

import math

import numpy as np

from pcsmooth.kernels.arithmetic import double_double
from pcsmooth.kernels.arithmetic.exact_sum import add_product
from pcsmooth.kernels.cells.convex_polyhedron import (
    AFTER,
    TORN,
    copy_polyhedron,
    cut_off,
    measure_excess,
    place_vertex,
)
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.within_reach import NUMBER, SQUARE, X, Y, Z

#: Facets of the box that a star is cut from, which is larger than 2 r in all directions; the
#: bisector with the neighbour at place j is plane N_BOX_PLANES + j.
N_BOX_PLANES = 6

#: A distance from a plane is in doubt below this, in units of r (it is multiplied by |u| / r).
IN_DOUBT = 1e-9

#: What pairs of floats give is in doubt below this, in units of the terms it is the sum of.
_DOUBT_OF_PAIRS = 1e-28

#: Floats that an exact determinant may need: 384 are added up.
EXPANSION = 400

#: An excess for what is beyond a plane by less than floats can tell.
_BEYOND = 1e-300

#: Three planes meet in an unclear place if the determinant of their unit normals is below this.
_UNCLEAR = 1e-4

#: Rows of the table of planes: normal (not of unit length), offset as a pair of floats, and the
#: squared distance of the nearest point of the facet's edges.
NX, NY, NZ, OFFSET, OFFSET_LOW, NEAREST = range(6)
_N_PLANE_ROWS = 6

#: Ties of a simplex' radius with r count as inside, relative.
TIE = 1e-12


@inner
def plane_table(normals, offsets, n_labels):
    """Make a table for so many planes, with those of the box in front: normals (3, 6), offsets."""
    table = np.zeros((_N_PLANE_ROWS, n_labels))
    for k in range(N_BOX_PLANES):
        table[NX, k] = normals[0, k]
        table[NY, k] = normals[1, k]
        table[NZ, k] = normals[2, k]
        table[OFFSET, k] = offsets[k]
    return table


@inner
def find_star(box, i, near, count, weights, radius, arrays, table, expansion, simplices):
    """Find the simplices of the alpha-complex that p_i has with points of higher numbers only.

    Parameters: the box as vertices, planes, across; i; near, the neighbours that may bound the cell
    within r, nearest planes first, and how many; the weights of all points (2, n), each the sum
    of two; r of p_i; arrays, from `polyhedron_arrays`; table, from `plane_table`; expansion
    (EXPANSION,), scratch; simplices (3, ...), which receives the places in near of the other
    points, -1 for none.

    Returns the number of simplices, or TORN if the signs of the cuts contradict each other.
    """
    vertices, planes, across, excess, first = arrays
    n = copy_polyhedron(box[0], box[1], box[2], vertices, planes, across)
    for j in range(count):
        label = N_BOX_PLANES + j
        x = near[X, j]
        y = near[Y, j]
        z = near[Z, j]
        offset, rest = _offset_of(x, y, z, weights, i, int(near[NUMBER, j]))
        table[NX, label] = x
        table[NY, label] = y
        table[NZ, label] = z
        table[OFFSET, label] = offset
        table[OFFSET_LOW, label] = rest
        doubt = IN_DOUBT * radius * math.sqrt(near[SQUARE, j])
        if measure_excess(vertices, n, x, y, z, offset, excess) < -doubt:
            continue
        _resolve_doubts(planes, n, excess, doubt, table, label, expansion)
        n = cut_off(vertices, planes, across, n, excess, 0.0, label, first)
        if n == TORN:
            return n
        for t in range(n):
            if planes[0, t] == label or planes[1, t] == label or planes[2, t] == label:
                _place_vertex(vertices, planes, t, table)
    return _collect(i, vertices, planes, across, n, near, count, radius, table, simplices)


@inner
def _collect(i, vertices, planes, across, n, near, count, radius, table, simplices):
    """List the faces of the cell that come within r of p_i, by the points that share them."""
    limit = (radius * (1.0 + TIE)) ** 2
    found = np.int64(0)
    is_inside = n > 0
    for j in range(count):
        table[NEAREST, N_BOX_PLANES + j] = np.inf
        is_inside &= table[OFFSET, N_BOX_PLANES + j] >= 0.0
    if is_inside:
        found = _list(i, near, -1, -1, -1, found, simplices)
    for t in range(n):
        for e in range(3):
            a = planes[e, t]
            b = planes[AFTER[e], t]
            if a < N_BOX_PLANES:
                continue
            nearest = _distance2_of_edge(vertices, t, across[e, t])
            table[NEAREST, a] = min(table[NEAREST, a], nearest)
            if b > a and nearest <= limit:
                found = _list(i, near, a, b, -1, found, simplices)
        a = planes[0, t]
        b = planes[1, t]
        c = planes[2, t]
        if min(a, b, c) >= N_BOX_PLANES:
            x = vertices[0, t]
            y = vertices[1, t]
            z = vertices[2, t]
            if x * x + y * y + z * z <= limit:
                found = _list(i, near, a, b, c, found, simplices)
    for j in range(count):
        if table[NEAREST, N_BOX_PLANES + j] == np.inf:
            continue
        nearest = table[NEAREST, N_BOX_PLANES + j]
        if nearest > limit and _holds_its_foot(near, count, j, table):
            nearest = table[OFFSET, N_BOX_PLANES + j] ** 2 / near[SQUARE, j]
        if nearest <= limit:
            found = _list(i, near, N_BOX_PLANES + j, -1, -1, found, simplices)
            if not is_inside:  # but the cell of p_i comes within r of it
                found = _list(i, near, -1, -1, -1, found, simplices)
                is_inside = True
    return found


@inner
def _distance2_of_edge(vertices, t, q):
    """Squared distance of an edge from p_i."""
    tx = vertices[0, t]
    ty = vertices[1, t]
    tz = vertices[2, t]
    dx = vertices[0, q] - tx
    dy = vertices[1, q] - ty
    dz = vertices[2, q] - tz
    length2 = dx * dx + dy * dy + dz * dz
    if length2 > 0.0:
        share = min(max(-(tx * dx + ty * dy + tz * dz) / length2, 0.0), 1.0)
        tx += share * dx
        ty += share * dy
        tz += share * dz
    return tx * tx + ty * ty + tz * tz


@inner
def _holds_its_foot(near, count, j, table):
    """Whether the point of the bisector with p_j nearest to p_i is beyond no other bisector."""
    share = table[OFFSET, N_BOX_PLANES + j] / near[SQUARE, j]
    x = share * near[X, j]
    y = share * near[Y, j]
    z = share * near[Z, j]
    for k in range(count):
        across = x * near[X, k] + y * near[Y, k] + z * near[Z, k]
        if k != j and across > table[OFFSET, N_BOX_PLANES + k]:
            return False
    return True


@inner
def _list(i, near, a, b, c, found, simplices):
    """List the simplex of p_i and the neighbours of some planes, -1 for none, if i is lowest."""
    labels = (a, b, c)
    for m in range(3):
        if labels[m] >= 0:
            place = labels[m] - N_BOX_PLANES
            if near[NUMBER, place] < i:
                return found
            simplices[m, found] = place
        else:
            simplices[m, found] = -1
    return found + 1


@inner
def _offset_of(x, y, z, weights, i, j):
    """Offset (|u|^2 + w_i - w_j) / 2 of the plane with normal u, as a pair."""
    difference = double_double.add(
        double_double.sum_of(weights[0, i], -weights[0, j]), (weights[1, i] - weights[1, j], 0.0)
    )
    square = double_double.add(
        double_double.add(double_double.product_of(x, x), double_double.product_of(y, y)),
        double_double.add(double_double.product_of(z, z), difference),
    )
    return 0.5 * square[0], 0.5 * square[1]


@inner
def _vector(table, label):
    return (table[NX, label], 0.0), (table[NY, label], 0.0), (table[NZ, label], 0.0)


@inner
def _resolve_doubts(planes, n, excess, doubt, table, label, expansion):
    """Replace an excess near 0 by one that has the right sign.

    Where planes a, b, c meet, u_d . x - h_d has the sign of h_a (b c d) + h_b (c a d) +
    h_c (a b d) - h_d (a b c), (a b c) being the determinant of the normals, which is positive.
    """
    for t in range(n):
        if abs(excess[t]) > doubt:
            continue
        a = planes[0, t]
        b = planes[1, t]
        c = planes[2, t]
        beyond, size = _four_planes(table, a, b, c, label)
        if abs(beyond) <= _DOUBT_OF_PAIRS * size:
            m = _add_terms(expansion, np.int64(0), table, a, b, c, label, 1.0)
            m = _add_terms(expansion, m, table, b, c, a, label, 1.0)
            m = _add_terms(expansion, m, table, c, a, b, label, 1.0)
            m = _add_terms(expansion, m, table, label, a, b, c, -1.0)
            beyond = expansion[m - 1] if m > 0 else 0.0
        excess[t] = max(abs(excess[t]), _BEYOND) if beyond > 0.0 else -abs(excess[t])


@inner
def _four_planes(table, a, b, c, d):
    """Compute the determinant of four planes in pairs of floats, and the size of its terms."""
    u_a = _vector(table, a)
    u_b = _vector(table, b)
    u_c = _vector(table, c)
    u_d = _vector(table, d)
    bc = double_double.cross(u_b, u_c)
    ca = double_double.cross(u_c, u_a)
    ab = double_double.cross(u_a, u_b)
    beyond = double_double.subtract(
        double_double.add(
            double_double.add(
                double_double.multiply(_offset(table, a), double_double.dot(u_d, bc)),
                double_double.multiply(_offset(table, b), double_double.dot(u_d, ca)),
            ),
            double_double.multiply(_offset(table, c), double_double.dot(u_d, ab)),
        ),
        double_double.multiply(_offset(table, d), double_double.dot(u_a, bc)),
    )
    long_a = _length(table, a)
    long_b = _length(table, b)
    long_c = _length(table, c)
    long_d = _length(table, d)
    size = (
        abs(table[OFFSET, a]) * long_b * long_c * long_d
        + long_a * abs(table[OFFSET, b]) * long_c * long_d
        + long_a * long_b * abs(table[OFFSET, c]) * long_d
        + long_a * long_b * long_c * abs(table[OFFSET, d])
    )
    return beyond[0], size


@inner
def _add_terms(expansion, n, table, a, b, c, d, sign):
    """Add sign h_a (b c d) to an expansion of n floats, exactly; returns how many there are."""
    for row in range(3):
        x = row
        y = (row + 1) % 3
        z = (row + 2) % 3
        for offset_row in (OFFSET, OFFSET_LOW):
            offset = sign * table[offset_row, a]
            n = add_product(expansion, n, offset, table[x, b], table[y, c], table[z, d])
            n = add_product(expansion, n, -offset, table[x, b], table[z, c], table[y, d])
    return n


@inner
def _offset(table, label):
    return table[OFFSET, label], table[OFFSET_LOW, label]


@inner
def _length(table, label):
    x = table[NX, label]
    y = table[NY, label]
    z = table[NZ, label]
    return math.sqrt(x * x + y * y + z * z)


@inner
def _place_vertex(vertices, planes, t, table):
    """Solve for the point where the three planes of a vertex meet."""
    if place_vertex(vertices, planes, t, table, _UNCLEAR):
        return
    a = planes[0, t]
    b = planes[1, t]
    c = planes[2, t]
    size = _length(table, a) * _length(table, b) * _length(table, c)
    u_a = _vector(table, a)
    u_b = _vector(table, b)
    u_c = _vector(table, c)
    bc = double_double.cross(u_b, u_c)
    ca = double_double.cross(u_c, u_a)
    ab = double_double.cross(u_a, u_b)
    det = double_double.dot(u_a, bc)[0]
    if abs(det) <= _DOUBT_OF_PAIRS * size:
        return  # it stays where the cut has put it
    h_a = _offset(table, a)
    h_b = _offset(table, b)
    h_c = _offset(table, c)
    for row in range(3):
        along = double_double.add(
            double_double.add(
                double_double.multiply(h_a, bc[row]), double_double.multiply(h_b, ca[row])
            ),
            double_double.multiply(h_c, ab[row]),
        )
        vertices[row, t] = along[0] / det
