"""Facets of a block of points, put together from their edges.

A facet is a row of sums over its edges. It lies in the list of its owner, the first of its two
points that belongs to the block. The pieces know nothing of each other, so they may come in any
order:

- an edge from P1 to P2 spans a triangle with the foot O of the perpendicular from p_i, of signed
  area P1 x P2 / 2 and moment P1 x P2 (P1 + P2) / 6;
- the angles of the edges seen from O and those of the arcs make a full turn if O is in the
  facet and nothing if it is not;
- the triangle's solid angle seen from p_i is twice the angle of the vector
  ((R1 + h)(R2 + h) + P1 . P2, P1 x P2) (Van Oosterom and Strackee 1983), R the distances of the
  ends from p_i and h that of O; an arc's is its angle times 1 - h / r;
- the arcs' moment, rho^2 / 3 (end - start) turned by a right angle, is a sum over end points.

If radii are unequal, the other point sees the triangles under another angle, and the integral of
the unit vector from O over the arcs counts: rho times it and the lengths of the edges times their
normals add up to nothing.
"""

import math

from pcsmooth.kernels.arithmetic.angles import angles
from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    absolute,
    everywhere,
    load,
    load_transposed,
    multiply_add,
    select,
    square_root,
    store,
    store_transposed,
)
from pcsmooth.kernels.balls.voronoi_edges import END, IS_TURNED, RADII, START
from pcsmooth.kernels.cells.radical_planes import difference_of_squares, half_chord2, heights_over
from pcsmooth.kernels.compiled import inner

#: A row of the table fills one register: twice the area of the triangles; 6 times the moment;
#: half the solid angle; angle of the edges; number of ends on the sphere; number of edges that
#: have O on their outer side, plus _DOUBT for every end too close to O. If radii are unequal it
#: fills two: half the solid angle seen from the other point; the vector of the arcs.
N_FACET_COLUMNS = WIDTH
_DOUBT = 1e6

#: Columns of the table of links: the points and the next facet of the owner's list.
OWNER = 0
OTHER = 1
NEXT = 2
N_LINK_COLUMNS = 3

#: Rows of the terms of eight edges in their three facets, one edge a row.
N_TERM_ROWS = 3 * WIDTH

#: Below this height, in units of the radius, the solid angle of an edge that passes O closely
#: has to be computed without cancellation.
_LOW = 0.05

#: An edge nearer to a point than this, in units of the radius, is seen under no certain angle.
_NEAR_POINT = 1e-4

#: An end nearer to O than this, in units of the radius, has no direction from there.
_NEAR_FOOT = 1e-3


@inner
def new_facet(sums, links, heads, n_facets, owner, other, start):
    """Begin facet number n_facets of owner and other in the list of the owner."""
    for column in range(sums.shape[1]):
        sums[n_facets, column] = 0.0
    links[n_facets, OWNER] = owner
    links[n_facets, OTHER] = other
    links[n_facets, NEXT] = heads[owner - start]
    heads[owner - start] = n_facets
    return n_facets + 1


@inner
def find_facet(links, heads, owner, other, start):
    """Look up a facet in the list of its owner; -1 if it has not begun."""
    facet = heads[owner - start]
    while facet >= 0 and links[facet, OTHER] != other:
        facet = links[facet, NEXT]
    return facet


@inner
def _half_solid_angles(level, height, cross, dot, start, end, r1, r2, radius):
    """Half the solid angles of the triangles of eight edges, seen from a height above O.

    level: signed distance of the edge from O; start and end along it; cross and dot of these; r1
    and r2: distances of the ends from where it is seen; radius: length scale.
    """
    lifted = (r1 + height) * (r2 + height) + dot
    # The same without cancellation, for an edge that passes O closely at small height.
    height2 = height * height
    squares = height2 + level * level * 2.0 + start * start + end * end
    careful = height * (r1 + r2 + height) + (height2 * squares + cross * cross) / (r1 * r2 - dot)
    return angles(select((dot < 0.0) & (height < _LOW * radius), careful, lifted), cross)


@inner
def _store_terms(
    terms, row, nx, ny, nz, tx, ty, tz, level, height, rho2, start, end, is_start, is_end, r1, r2,
    radius, radii, other_height, other_r1, other_r2,
):  # fmt: skip
    """Store the terms of eight edges in one facet each as rows.

    n: unit normal of the edge in the facet's plane, away from the facet; t: along the edge;
    level: signed distance of the edge from O; height of O over the owner; rho2: squared radius of
    the disk; start and end along t; is_start and is_end: where they are inside the ball; r1 and
    r2: their distances from the owner; radius: length scale; height and distances for the other
    point.
    """
    cross = level * (end - start)
    level2 = level * level
    dot = multiply_add(start, end, level2)
    half_solid = _half_solid_angles(level, height, cross, dot, start, end, r1, r2, radius)

    along_normal = level * cross * 2.0
    along_edge = cross * (start + end)
    arc = rho2 * 2.0
    along_normal = select(is_start, along_normal, along_normal + arc * start)
    along_edge = select(is_start, along_edge, along_edge - arc * level)
    along_normal = select(is_end, along_normal, along_normal - arc * end)
    along_edge = select(is_end, along_edge, along_edge + arc * level)

    zero = level * 0.0
    near_foot = _NEAR_FOOT * _NEAR_FOOT * radius * radius
    flags = select(level < 0.0, 1.0, zero)
    flags = select(is_start & (level2 + start * start < near_foot), flags + _DOUBT, flags)
    flags = select(is_end & (level2 + end * end < near_foot), flags + _DOUBT, flags)
    if radii is not None:
        least = select(height < other_height, height, other_height)
        nearest2 = multiply_add(least, least, level2)
        limit = _NEAR_POINT * _NEAR_POINT * radius * radius
        flags = select(nearest2 < limit, flags + _DOUBT, flags)
        length = start - end
        store_transposed(
            terms,
            row,
            WIDTH,
            _half_solid_angles(
                level, other_height, cross, dot, start, end, other_r1, other_r2, radius
            ),
            length * nx,
            length * ny,
            length * nz,
            zero,
            zero,
            zero,
            zero,
        )
    store_transposed(
        terms,
        row,
        0,
        cross,
        multiply_add(along_normal, nx, along_edge * tx),
        multiply_add(along_normal, ny, along_edge * ty),
        multiply_add(along_normal, nz, along_edge * tz),
        half_solid,
        angles(dot, cross),
        select(is_start, zero, 1.0) + select(is_end, zero, 1.0),
        flags,
    )


@inner
def add_edges(edges, edge_facets, n_edges, radius, radii, terms, sums):
    """Add edges to their facets.

    edges: columns as in `voronoi_edges`; edge_facets (3, n): the facets F_ij, F_ik and F_jk of
    each, or -1.
    """
    for c in range(0, n_edges, WIDTH):
        _edge_terms(edges, c, radius, radii, terms)
        for lane in range(min(WIDTH, n_edges - c)):
            for side in range(3):
                facet = edge_facets[side, c + lane]
                if facet >= 0:
                    row = side * WIDTH + lane
                    store(sums, facet, 0, load(sums, facet, 0) + load(terms, row, 0))
                    if radii is not None:
                        total = load(sums, facet, WIDTH) + load(terms, row, WIDTH)
                        store(sums, facet, WIDTH, total)


@inner
def _edge_terms(edges, c, radius, radii, terms):
    """Terms of edges c .. c + 7 in their three facets."""
    xj = load(edges, 0, c)
    yj = load(edges, 1, c)
    zj = load(edges, 2, c)
    xk = load(edges, 3, c)
    yk = load(edges, 4, c)
    zk = load(edges, 5, c)
    low = load(edges, START, c)
    high = load(edges, END, c)
    wx = xk - xj
    wy = yk - yj
    wz = zk - zj
    product = multiply_add(zj, zk, multiply_add(yj, yk, xj * xk))
    along_j = multiply_add(wz, zj, multiply_add(wy, yj, wx * xj))
    along_k = multiply_add(wz, zk, multiply_add(wy, yk, wx * xk))
    square_j = multiply_add(zj, zj, multiply_add(yj, yj, xj * xj))
    square_k = multiply_add(zk, zk, multiply_add(yk, yk, xk * xk))
    square_w = multiply_add(wz, wz, multiply_add(wy, wy, wx * wx))
    tx = wz * yj - wy * zj
    ty = wx * zj - wz * xj
    tz = wy * xj - wx * yj
    inverse2 = 1.0 / multiply_add(tz, tz, multiply_add(ty, ty, tx * tx))
    inverse = square_root(inverse2)
    tx = tx * inverse
    ty = ty * inverse
    tz = tz * inverse
    share_ij = product / square_j
    share_ik = product / square_k
    share_jk = along_j / square_w
    height_ij = square_root(square_j) * 0.5
    height_ik = square_root(square_k) * 0.5
    height_jk = square_root(square_w) * 0.5
    # Twice the levels of the edge in the three facets, in units of `scale` below.
    level_ij = along_k
    level_ik = 0.0 - along_j
    level_jk = product
    own_radius = radius_j = radius_k = everywhere(radius)
    height_ji, height_ki, height_kj = height_ij, height_ik, height_jk
    if radii is not None:
        own_radius = load(edges, RADII, c)
        radius_j = load(edges, RADII + 1, c)
        radius_k = load(edges, RADII + 2, c)
        minus_j = difference_of_squares(own_radius, radius_j)
        minus_k = difference_of_squares(own_radius, radius_k)
        gain = difference_of_squares(radius_j, radius_k)
        level_ij = level_ij + gain - (share_ij - 1.0) * minus_j
        level_ik = level_ik - gain - (share_ik - 1.0) * minus_k
        level_jk = level_jk - minus_j + share_jk * gain
        height_ij, height_ji = _distances(square_j, own_radius, radius_j)
        height_ik, height_ki = _distances(square_k, own_radius, radius_k)
        height_jk, height_kj = _distances(square_w, radius_j, radius_k)
        # Squared distance of the edge's line from p_i.
        power_j = square_j + minus_j
        power_w = square_w + along_j * 2.0 + gain
        share_j = square_w * power_j - power_w * along_j
        share_w = power_w * square_j - along_j * power_j
        circle2 = multiply_add(share_w, power_w, share_j * power_j) * inverse2 * 0.25
    else:
        # Squared circumradius of p_i, p_j, p_k; its centre is the origin along the edge.
        circle2 = square_j * square_k * square_w * inverse2 * 0.25
    half_chord = square_root(own_radius * own_radius - circle2)
    start = low * half_chord
    end = high * half_chord
    is_start = low > -1.0
    is_end = high < 1.0
    start2 = multiply_add(start, start, circle2)
    end2 = multiply_add(end, end, circle2)
    r1 = select(is_start, square_root(start2), own_radius)
    r2 = select(is_end, square_root(end2), own_radius)
    r1j, r2j, r1k, r2k = r1, r2, r1, r2
    rho2_ij = own_radius * own_radius - square_j * 0.25
    rho2_ik = own_radius * own_radius - square_k * 0.25
    rho2_jk = own_radius * own_radius - square_w * 0.25
    if radii is not None:
        r1j = select(is_start, _root(start2 - minus_j), radius_j)
        r2j = select(is_end, _root(end2 - minus_j), radius_j)
        r1k = select(is_start, _root(start2 - minus_k), radius_k)
        r2k = select(is_end, _root(end2 - minus_k), radius_k)
        rho2_ij = half_chord2(height_ij, height_ji, own_radius, radius_j)
        rho2_ik = half_chord2(height_ik, height_ki, own_radius, radius_k)
        rho2_jk = half_chord2(height_jk, height_kj, radius_j, radius_k)

    scale = square_root(square_j) * inverse
    nx = (xk - share_ij * xj) * scale
    ny = (yk - share_ij * yj) * scale
    nz = (zk - share_ij * zj) * scale
    _store_terms(
        terms, 0, nx, ny, nz, tx, ty, tz, level_ij * scale * 0.5, height_ij, rho2_ij,
        start, end, is_start, is_end, r1, r2, own_radius, radii, height_ji, r1j, r2j,
    )  # fmt: skip
    scale = square_root(square_k) * inverse
    nx = (xj - share_ik * xk) * scale
    ny = (yj - share_ik * yk) * scale
    nz = (zj - share_ik * zk) * scale
    _store_terms(
        terms, WIDTH, nx, ny, nz, tx, ty, tz, level_ik * scale * 0.5, height_ik, rho2_ik,
        start, end, is_start, is_end, r1, r2, own_radius, radii, height_ki, r1k, r2k,
    )  # fmt: skip
    scale = square_root(square_w) * inverse
    nx = (share_jk * wx - xj) * scale
    ny = (share_jk * wy - yj) * scale
    nz = (share_jk * wz - zj) * scale
    if radii is not None:
        is_turned = load(edges, IS_TURNED, c) > 0.0
        height_jk, height_kj = _swap(is_turned, height_jk, height_kj)
        r1j, r1k = _swap(is_turned, r1j, r1k)
        r2j, r2k = _swap(is_turned, r2j, r2k)
        radius_j = select(is_turned, radius_k, radius_j)
    _store_terms(
        terms, 2 * WIDTH, nx, ny, nz, tx, ty, tz, level_jk * scale * 0.5, height_jk,
        rho2_jk, start, end, is_start, is_end, r1j, r2j, radius_j, radii, height_kj,
        r1k, r2k,
    )  # fmt: skip


@inner
def _distances(square, radius, other_radius):
    """How far eight radical planes are from either point."""
    height, other_height = heights_over(square, radius, other_radius)
    return absolute(height), absolute(other_height)


@inner
def _root(square):
    """Square root of what rounding may have made negative."""
    return square_root(select(square > 0.0, square, 0.0))


@inner
def _swap(chosen, a, b):
    """Let the chosen ones of two registers change places."""
    return select(chosen, b, a), select(chosen, a, b)


@inner
def measure_facets(sums, first, rho2):
    """Measure facets first .. first + 7, whose disks have the squared radius rho2.

    Returns (area, half the solid angle of the triangles seen from the owner, visible angle of its
    circle, first moment about O: x, y, z, whether all of this is sure), each for eight facets.
    """
    area2, mx, my, mz, half_solid, turn, ends, flags = load_transposed(sums, first, 0)
    arcs = select(flags > 0.0, 0.0 - turn, 2.0 * math.pi - turn)
    arcs = select((ends > 0.0) & (arcs > 0.0), arcs, 0.0)
    area = (area2 + rho2 * arcs) * 0.5
    sixth = 1.0 / 6.0
    return area, half_solid, arcs, mx * sixth, my * sixth, mz * sixth, flags < _DOUBT


@inner
def signed_angle(half_solid, arcs, height, radius):
    """Solid angle of eight facets, with the sign of the height; half_solid: that of triangles."""
    solid = half_solid * 2.0 + arcs * (1.0 - absolute(height) / radius)
    return select(height < 0.0, 0.0 - solid, solid)
