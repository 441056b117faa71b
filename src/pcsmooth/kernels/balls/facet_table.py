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
"""

import math

from pcsmooth.kernels.arithmetic.angles import angles
from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    load,
    load_transposed,
    multiply_add,
    select,
    square_root,
    store,
    store_transposed,
)
from pcsmooth.kernels.balls.voronoi_edges import END, START
from pcsmooth.kernels.compiled import inner

#: A row of the table fills one register: twice the area of the triangles; 6 times the moment;
#: half the solid angle; angle of the edges; number of ends on the sphere; number of edges that
#: have O on their outer side, plus _DOUBT for every end too close to O.
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

#: An end nearer to O than this, in units of the radius, has no direction from there.
_NEAR_FOOT = 1e-3


@inner
def new_facet(sums, links, heads, n_facets, owner, other, start):
    """Begin facet number n_facets of owner and other in the list of the owner."""
    for column in range(N_FACET_COLUMNS):
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
def _store_terms(
    terms, row, nx, ny, nz, tx, ty, tz, level, length2, start, end, is_start, is_end, r1, r2, radius
):
    """Store the terms of eight edges in one facet each as rows.

    n: unit normal of the edge in the facet's plane, away from the facet; t: along the edge;
    level: signed distance of the edge from O; length2: |u|^2; start and end along t; is_start
    and is_end: where they are inside the ball; r1 and r2: their distances from p_i.
    """
    height = square_root(length2) * 0.5
    rho2 = radius * radius - length2 * 0.25
    cross = level * (end - start)
    level2 = level * level
    dot = multiply_add(start, end, level2)
    lifted = (r1 + height) * (r2 + height) + dot
    # The same without cancellation, for an edge that passes O closely at small height.
    height2 = height * height
    squares = height2 + level2 * 2.0 + start * start + end * end
    careful = height * (r1 + r2 + height) + (height2 * squares + cross * cross) / (r1 * r2 - dot)
    lifted = select((dot < 0.0) & (height < _LOW * radius), careful, lifted)

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
    store_transposed(
        terms,
        row,
        0,
        cross,
        multiply_add(along_normal, nx, along_edge * tx),
        multiply_add(along_normal, ny, along_edge * ty),
        multiply_add(along_normal, nz, along_edge * tz),
        angles(lifted, cross),
        angles(dot, cross),
        select(is_start, zero, 1.0) + select(is_end, zero, 1.0),
        flags,
    )


@inner
def add_edges(edges, edge_facets, n_edges, radius, terms, sums):
    """Add edges to their facets.

    edges: columns as in `voronoi_edges`; edge_facets (3, n): the facets F_ij, F_ik and F_jk of
    each, or -1.
    """
    for c in range(0, n_edges, WIDTH):
        _edge_terms(edges, c, radius, terms)
        for lane in range(min(WIDTH, n_edges - c)):
            for side in range(3):
                facet = edge_facets[side, c + lane]
                if facet >= 0:
                    term = load(terms, side * WIDTH + lane, 0)
                    store(sums, facet, 0, load(sums, facet, 0) + term)


@inner
def _edge_terms(edges, c, radius, terms):
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
    # Squared circumradius of p_i, p_j, p_k; its centre is the origin along the edge.
    circle2 = square_j * square_k * square_w * inverse2 * 0.25
    half_chord = square_root(radius * radius - circle2)
    start = low * half_chord
    end = high * half_chord
    is_start = low > -1.0
    is_end = high < 1.0
    r1 = select(is_start, square_root(multiply_add(start, start, circle2)), radius)
    r2 = select(is_end, square_root(multiply_add(end, end, circle2)), radius)

    scale = square_root(square_j) * inverse
    share = product / square_j
    nx = (xk - share * xj) * scale
    ny = (yk - share * yj) * scale
    nz = (zk - share * zj) * scale
    level = along_k * scale * 0.5
    _store_terms(
        terms, 0, nx, ny, nz, tx, ty, tz, level, square_j, start, end, is_start, is_end, r1, r2,
        radius,
    )  # fmt: skip
    scale = square_root(square_k) * inverse
    share = product / square_k
    nx = (xj - share * xk) * scale
    ny = (yj - share * yk) * scale
    nz = (zj - share * zk) * scale
    level = along_j * scale * -0.5
    _store_terms(
        terms, WIDTH, nx, ny, nz, tx, ty, tz, level, square_k, start, end, is_start, is_end, r1,
        r2, radius,
    )  # fmt: skip
    scale = square_root(square_w) * inverse
    share = along_j / square_w
    nx = (share * wx - xj) * scale
    ny = (share * wy - yj) * scale
    nz = (share * wz - zj) * scale
    level = product * scale * 0.5
    _store_terms(
        terms, 2 * WIDTH, nx, ny, nz, tx, ty, tz, level, square_w, start, end, is_start, is_end,
        r1, r2, radius,
    )  # fmt: skip


@inner
def measure_facets(sums, first, length2, radius):
    """Measure facets first .. first + 7, their points at distance root(length2).

    Returns (area, solid angle seen from its points, visible angle of its circle, first moment
    about O: x, y, z, whether all of this is sure), each for eight facets.
    """
    area2, mx, my, mz, half_solid, turn, ends, flags = load_transposed(sums, first, 0)
    arcs = select(flags > 0.0, 0.0 - turn, 2.0 * math.pi - turn)
    arcs = select((ends > 0.0) & (arcs > 0.0), arcs, 0.0)
    area = (area2 + (radius * radius - length2 * 0.25) * arcs) * 0.5
    solid = half_solid * 2.0 + arcs * (1.0 - square_root(length2) * (0.5 / radius))
    sixth = 1.0 / 6.0
    return area, solid, arcs, mx * sixth, my * sixth, mz * sixth, flags < _DOUBT
