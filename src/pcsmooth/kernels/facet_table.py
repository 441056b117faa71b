"""Facets of a block of points, put together from their edges.

A facet is a row of sums over its edges and arcs. It lies in the list of its owner, the first of
its two points that belongs to the block. All sums are over pieces that know nothing of each
other, so the edges may come in any order:

- an edge from P1 to P2 spans a triangle with the foot O of the perpendicular from p_i, of signed
  area P1 x P2 / 2 and moment P1 x P2 (P1 + P2) / 6;
- angles add up as the argument of a product: that of the edges seen from O, which together with
  the arcs make a full turn or none, and half of the solid angle of the triangle seen from p_i,
  (R1 + h)(R2 + h) + P1 . P2 + i P1 x P2 (Van Oosterom and Strackee 1983), R the distances from
  p_i and h that of O;
- the arcs' moment, rho^2 / 3 (end - start) turned by a right angle, is a sum over end points.
"""

import math

import numpy as np
from numba import njit

from pcsmooth.kernels.lanes import (
    WIDTH,
    load,
    multiply_add,
    select,
    square_root,
    store,
)
from pcsmooth.kernels.voronoi_edges import END, START

#: Columns of the table of sums: twice the area of the triangles, 6 times the moment, number of
#: ends on the sphere, least level of an edge in units of rho, whether an end is too close to O,
#: the two products of complex numbers.
_AREA2 = 0
_MOMENT = 1  # and the next two
_ENDS = 4
_LEVEL = 5
_DOUBTS = 6
_SOLID = 7  # and the next
_TURN = 9  # and the next
N_FACET_COLUMNS = 11

#: Columns of the table of links: the points and the next facet of the owner's list.
OWNER = 0
OTHER = 1
NEXT = 2
N_LINK_COLUMNS = 3

#: Rows per facet of the terms of eight edges.
_N_TERMS = 10
N_TERM_ROWS = 3 * _N_TERMS

#: Below this height, in units of the radius, the solid angle of an edge that passes O closely
#: has to be computed without cancellation.
_LOW = 0.05

#: An end nearer to O than this, in units of the radius, has no direction from there.
_NEAR_FOOT = 1e-3

#: Products are rescaled before they leave this range (they must not under- or overflow).
_SMALL = 1e-100
_LARGE = 1e100

#: An angle of arcs below this may be nothing or a full turn; levels tell which.
_ROUNDING = 1e-9


@njit(cache=True)
def new_facet(sums, links, heads, n_facets, owner, other, start):
    """Begin facet number n_facets of owner and other in the list of the owner."""
    for column in range(N_FACET_COLUMNS):
        sums[n_facets, column] = 0.0
    sums[n_facets, _LEVEL] = np.inf
    sums[n_facets, _SOLID] = 1.0
    sums[n_facets, _TURN] = 1.0
    links[n_facets, OWNER] = owner
    links[n_facets, OTHER] = other
    links[n_facets, NEXT] = heads[owner - start]
    heads[owner - start] = n_facets
    return n_facets + 1


@njit(cache=True)
def find_facet(links, heads, owner, other, start):
    """Number of a facet in the list of its owner, or -1."""
    facet = heads[owner - start]
    while facet >= 0 and links[facet, OTHER] != other:
        facet = links[facet, NEXT]
    return facet


@njit(cache=True, error_model="numpy")
def _store_terms(
    terms, row, nx, ny, nz, tx, ty, tz, level, length2, start, end, is_start, is_end, r1, r2, radius
):
    """Terms of eight edges in one facet each.

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
    real = select((dot < 0.0) & (height < _LOW * radius), careful, lifted)
    along_normal = level * cross * 2.0
    along_edge = cross * (start + end)
    arc = rho2 * 2.0
    along_normal = select(is_start, along_normal, along_normal + arc * start)
    along_edge = select(is_start, along_edge, along_edge - arc * level)
    along_normal = select(is_end, along_normal, along_normal - arc * end)
    along_edge = select(is_end, along_edge, along_edge + arc * level)
    zero = level * 0.0
    ends = select(is_start, zero, 1.0) + select(is_end, zero, 1.0)
    near_foot = _NEAR_FOOT * _NEAR_FOOT * radius * radius
    doubts = select(is_start & (level2 + start * start < near_foot), 1.0, zero) + select(
        is_end & (level2 + end * end < near_foot), 1.0, zero
    )
    unit = 1.0 / (radius * radius)
    store(terms, row + _AREA2, 0, cross)
    store(terms, row + _MOMENT, 0, multiply_add(along_normal, nx, along_edge * tx))
    store(terms, row + _MOMENT + 1, 0, multiply_add(along_normal, ny, along_edge * ty))
    store(terms, row + _MOMENT + 2, 0, multiply_add(along_normal, nz, along_edge * tz))
    store(terms, row + _ENDS, 0, ends)
    store(terms, row + _LEVEL, 0, level / square_root(rho2))
    store(terms, row + _DOUBTS, 0, doubts)
    store(terms, row + _SOLID, 0, real * unit)
    store(terms, row + _SOLID + 1, 0, cross * unit)
    store(terms, row + _TURN, 0, dot * unit)


@njit(cache=True, error_model="numpy")
def add_edges(edges, edge_facets, n_edges, radius, terms, sums):
    """Add edges to their facets.

    edges: columns as `find_edges` writes them; edge_facets (3, n): the facets F_ij, F_ik and
    F_jk of each, or -1.
    """
    for c in range(0, n_edges, WIDTH):
        _edge_terms(edges, c, radius, terms)
        for lane in range(min(WIDTH, n_edges - c)):
            for side in range(3):
                facet = edge_facets[side, c + lane]
                if facet >= 0:
                    _add_terms(terms, side * _N_TERMS, lane, sums, facet)


@njit(cache=True, error_model="numpy")
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
    _store_terms(
        terms,
        0,
        (xk - share * xj) * scale,
        (yk - share * yj) * scale,
        (zk - share * zj) * scale,
        tx,
        ty,
        tz,
        along_k * scale * 0.5,
        square_j,
        start,
        end,
        is_start,
        is_end,
        r1,
        r2,
        radius,
    )
    scale = square_root(square_k) * inverse
    share = product / square_k
    _store_terms(
        terms,
        _N_TERMS,
        (xj - share * xk) * scale,
        (yj - share * yk) * scale,
        (zj - share * zk) * scale,
        tx,
        ty,
        tz,
        along_j * scale * -0.5,
        square_k,
        start,
        end,
        is_start,
        is_end,
        r1,
        r2,
        radius,
    )
    scale = square_root(square_w) * inverse
    share = along_j / square_w
    _store_terms(
        terms,
        2 * _N_TERMS,
        (share * wx - xj) * scale,
        (share * wy - yj) * scale,
        (share * wz - zj) * scale,
        tx,
        ty,
        tz,
        product * scale * 0.5,
        square_w,
        start,
        end,
        is_start,
        is_end,
        r1,
        r2,
        radius,
    )


@njit(cache=True, error_model="numpy")
def _add_terms(terms, row, lane, sums, facet):
    """Add the terms of one edge to its facet."""
    for column in range(_LEVEL):
        sums[facet, column] += terms[row + column, lane]
    sums[facet, _LEVEL] = min(sums[facet, _LEVEL], terms[row + _LEVEL, lane])
    sums[facet, _DOUBTS] += terms[row + _DOUBTS, lane]
    cross = terms[row + _SOLID + 1, lane]
    for column, real in ((_SOLID, terms[row + _SOLID, lane]), (_TURN, terms[row + _TURN, lane])):
        old_real = sums[facet, column]
        old_imaginary = sums[facet, column + 1]
        new_real = old_real * real - old_imaginary * cross
        new_imaginary = old_real * cross + old_imaginary * real
        size = abs(new_real) + abs(new_imaginary)
        if size < _SMALL or size > _LARGE:
            new_real /= size
            new_imaginary /= size
        sums[facet, column] = new_real
        sums[facet, column + 1] = new_imaginary


@njit(cache=True, error_model="numpy")
def measure_facet(sums, facet, length2, radius):
    """Measure a facet that has edges, its points at distance root(length2).

    Returns (area, solid angle seen from its points, visible angle of its circle, first moment
    about O: x, y, z, whether all of this is sure).
    """
    rho2 = radius * radius - 0.25 * length2
    visible_angle = 0.0
    if sums[facet, _ENDS] > 0.0:
        visible_angle = -math.atan2(sums[facet, _TURN + 1], sums[facet, _TURN])
        if visible_angle < 0.0:
            visible_angle += 2.0 * math.pi
        # Within rounding of a full turn: chords next to nothing, or arcs next to nothing.
        if visible_angle > 2.0 * math.pi - _ROUNDING and sums[facet, _LEVEL] < 1.0 - _ROUNDING:
            visible_angle = 0.0
    area = 0.5 * (sums[facet, _AREA2] + rho2 * visible_angle)
    solid = 2.0 * math.atan2(sums[facet, _SOLID + 1], sums[facet, _SOLID])
    solid += visible_angle * (1.0 - 0.5 * math.sqrt(length2) / radius)
    return (
        area,
        solid,
        visible_angle,
        sums[facet, _MOMENT] / 6.0,
        sums[facet, _MOMENT + 1] / 6.0,
        sums[facet, _MOMENT + 2] / 6.0,
        sums[facet, _DOUBTS] == 0.0,
    )
