"""Edges of the restricted cells: where three of them meet.

The points at equal distance from p_i, p_j and p_k form a line through the centre of their
circle (if radii are unequal, those of equal power a line across the plane of the three). What the
other neighbours of p_i leave of the line, inside the ball, is the edge of the
facets F_ij, F_ik and F_jk. Every line is cut on its own, against all neighbours at once.

That is exact unless a plane runs so close along the line, or an end lies so close to the sphere,
that rounding could decide. Such a line is in doubt: it is no edge, and the cells around it have
to be measured in a way that does not depend on such decisions.
"""

import math

import numpy as np

from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    absolute,
    bits,
    compress,
    count_bits,
    everywhere,
    lane_numbers,
    load,
    lowest_bit,
    mask_of,
    multiply_add,
    select,
    square_root,
    store,
)
from pcsmooth.kernels.cells.radical_planes import HALF, RADIUS, difference_of_squares
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.within_reach import SQUARE, X, Y, Z

#: Row of an array of neighbours that holds the length scale of `CLOSE`.
TOLERANCE = 6

#: A plane that runs along a line at less than this share of the radius, in distance at the
#: line's centre and in deviation over its length together, is one of the line's own or too close.
CLOSE = 5e-4

#: An end nearer than this to the sphere, in units of half the chord, may be on it or not.
_NEAR_SPHERE = 1e-9

#: Points closer to each other than the root of LEAST_GAP2, in units of the radius, are too close
#: for differences of u, and three points are too close to collinear for the centre of their circle
#: if the squared sine of the angle at p_j is less than _LEAST_SINE2 (their circle is then smaller
#: than the ball only if |u_k| is less than 2 sine r, here with a margin).
LEAST_GAP2 = 1e-6
_LEAST_SINE2 = 1e-4
_SLIVER2 = 10.0 * 4.0 * _LEAST_SINE2

#: Radical planes at an angle whose squared sine is less than _PARALLEL2 are parallel, and one, if
#: their squared distance in units of the radius is less than that, too. The sine at p_j of other
#: triples with an edge has to be above _LEAST_UNEQUAL_SINE2: to be close to collinear is no
#: exception among them.
_PARALLEL2 = 1e-12
_LEAST_UNEQUAL_SINE2 = 1e-5

#: A line touches the ball if its squared distance from the centre is that of the sphere, relative.
_TANGENT = 1e-11

#: Nearest neighbours that are tried, first without and then with a division, before lines that
#: nothing is left of are taken out.
_FIRST_TRIED = 8
_FIRST_CUTS = 8

#: Rows of the array of lines: start and end in units of half the chord, places of j and k among
#: the others, direction times half the chord, centre, number of planes that are close to the line.
_START, _END, _PLACE_J, _PLACE_K = range(4)
_DX, _DY, _DZ = 4, 5, 6
_CX, _CY, _CZ = 7, 8, 9
_CLOSE_PLANES = 10
N_LINE_ROWS = 11

#: Rows of the array of edges: u_j, u_k, start and end, places of j and k among the others; if
#: radii are unequal those of p_i, p_j and p_k, and whether the facet of j and k belongs to k.
START = 6
END = 7
FIRST_PLACE = 8
SECOND_PLACE = 9
RADII = 10  # and the next two
IS_TURNED = 13
N_EDGE_ROWS = 14


@inner
def prepare_planes(near, count, radius, radii):
    """Fill the rows HALF, if it is not, and TOLERANCE of padded neighbours."""
    for c in range(0, count, WIDTH):
        square = load(near, SQUARE, c)
        if radii is None:
            store(near, HALF, c, square * 0.5)
        store(near, TOLERANCE, c, square_root(square) * (CLOSE * radius))


@inner
def add_lines(near, count, others, n_others, j, radius, radii, lines, n_lines, doubts):
    """Append to lines those of p_i, others[j] and others[k], k > j, that may be edges.

    near holds the `count` neighbours of p_i, nearest first; others is padded. doubts (n_others,)
    is set for j and k whose line cannot be told. Returns the number of lines; room for
    n_others - j + WIDTH more is needed.
    """
    radius2 = radius * radius
    xj = others[X, j]
    yj = others[Y, j]
    zj = others[Z, j]
    square_j = others[SQUARE, j]
    if radii is not None:
        radius_j = others[RADIUS, j]
        power_j = 2.0 * others[HALF, j]
    n_tried = min(count, _FIRST_TRIED)
    for c in range(j + 1, n_others, WIDTH):
        x = load(others, X, c)
        y = load(others, Y, c)
        z = load(others, Z, c)
        square = load(others, SQUARE, c)
        # In terms of w = u_k - u_j nothing cancels where p_j and p_k are close.
        wx = x - xj
        wy = y - yj
        wz = z - zj
        gap2 = multiply_add(wz, wz, multiply_add(wy, wy, wx * wx))
        along_j = multiply_add(wz, zj, multiply_add(wy, yj, wx * xj))
        dx = wz * yj - wy * zj
        dy = wx * zj - wz * xj
        dz = wy * xj - wx * yj
        sine2 = multiply_add(dx, dx, multiply_add(dy, dy, dz * dz))
        most = sine2 * (4.0 * radius2)
        if radii is not None:
            inside = (1 << min(WIDTH, n_others - c)) - 1
            # Twice w . x and u_j . x on the line; squared distance of it times 4 sine2.
            other = load(others, RADIUS, c)
            power_w = along_j * 2.0 + gap2 + difference_of_squares(radius_j, other)
            share_w = power_w * square_j - along_j * power_j
            share_j = gap2 * power_j - power_w * along_j
            circle = multiply_add(share_w, power_w, share_j * power_j)
            left = bits(circle < most) & inside
            parallel2 = gap2 * (_PARALLEL2 * square_j)
            is_one = (sine2 < parallel2) & (circle < parallel2 * (4.0 * radius2))
            touches = absolute(circle - most) < most * _TANGENT
            slivers = bits((gap2 < LEAST_GAP2 * radius2) | is_one | touches) & inside
        else:
            # Squared circumradius times 4 sine2; the comparison is false for padding.
            circle = square * square_j * gap2
            left = bits(circle < most)
            thin = (sine2 < gap2 * (_LEAST_SINE2 * square_j)) & (square < _SLIVER2 * radius2)
            slivers = bits((gap2 < LEAST_GAP2 * radius2) | thin)
        left &= ~slivers
        _doubt(doubts, j, c, slivers)
        if left == 0:
            continue
        inverse = 1.0 / sine2
        half = inverse * 0.5
        if radii is not None:
            weight_w = share_w * half
            weight_j = share_j * half
        else:
            weight_w = (along_j + gap2) * half * square_j
            weight_j = (gap2 * (square_j - along_j) - along_j * along_j * 2.0) * half
        scale = square_root((radius2 - circle * inverse * 0.25) * inverse)
        dx = dx * scale
        dy = dy * scale
        dz = dz * scale
        cx = multiply_add(weight_j, xj, weight_w * wx)
        cy = multiply_add(weight_j, yj, weight_w * wy)
        cz = multiply_add(weight_j, zj, weight_w * wz)
        for n in range(n_tried):
            along = multiply_add(dx, near[X, n], multiply_add(dy, near[Y, n], dz * near[Z, n]))
            across = multiply_add(cx, near[X, n], multiply_add(cy, near[Y, n], cz * near[Z, n]))
            left &= bits(absolute(along) - across >= -(near[HALF, n] + near[TOLERANCE, n]))
            if left == 0:
                break
        if radii is not None:
            thin = left & bits(sine2 < gap2 * (_LEAST_UNEQUAL_SINE2 * square_j))
            left &= ~thin
            _doubt(doubts, j, c, thin)
        if left == 0:
            continue
        kept = mask_of(left)
        store(lines, _START, n_lines, everywhere(-1.0))
        store(lines, _END, n_lines, everywhere(1.0))
        store(lines, _PLACE_J, n_lines, everywhere(float(j)))
        store(lines, _PLACE_K, n_lines, compress(lane_numbers() + float(c), kept))
        store(lines, _DX, n_lines, compress(dx, kept))
        store(lines, _DY, n_lines, compress(dy, kept))
        store(lines, _DZ, n_lines, compress(dz, kept))
        store(lines, _CX, n_lines, compress(cx, kept))
        store(lines, _CY, n_lines, compress(cy, kept))
        store(lines, _CZ, n_lines, compress(cz, kept))
        store(lines, _CLOSE_PLANES, n_lines, everywhere(0.0))
        n_lines += count_bits(left)
    return n_lines


@inner
def _doubt(doubts, j, first, lanes):
    """Set the doubts of j and of `first` plus the bits of `lanes`."""
    while lanes != 0:
        doubts[j] = True
        doubts[first + lowest_bit(lanes)] = True
        lanes &= lanes - 1


@inner
def cut_lines(near, count, lines, n_lines):
    """Cut lines by the bisectors of all neighbours and keep those of which something is left.

    Returns how many they are.
    """
    first = np.int64(0)  # a literal would compile the loop twice
    last = min(count, _FIRST_CUTS)
    while first < count:
        n_lines = _cut_by_some(near, first, last, lines, n_lines)
        first = last
        last = min(count, 3 * last)
    return n_lines


@inner
def _cut_by_some(near, first, last, lines, n_lines):
    """Cut lines by the bisectors of neighbours first .. last - 1, keep what is left."""
    n_left = 0
    for c in range(0, n_lines, WIDTH):
        dx = load(lines, _DX, c)
        dy = load(lines, _DY, c)
        dz = load(lines, _DZ, c)
        cx = load(lines, _CX, c)
        cy = load(lines, _CY, c)
        cz = load(lines, _CZ, c)
        start = load(lines, _START, c)
        end = load(lines, _END, c)
        n_close = load(lines, _CLOSE_PLANES, c)
        for n in range(first, last):
            x = near[X, n]
            y = near[Y, n]
            z = near[Z, n]
            slope = multiply_add(dx, x, multiply_add(dy, y, dz * z))
            level = near[HALF, n] - multiply_add(cx, x, multiply_add(cy, y, cz * z))
            steep = absolute(slope)
            close = steep + absolute(level) < near[TOLERANCE, n]
            n_close = select(close, n_close + 1.0, n_close)
            # A line along a plane, slope 0, is cut nowhere or, at minus infinity, away.
            place = select(close, math.inf, level / steep)
            end = select((slope >= 0.0) & (place < end), place, end)
            place = 0.0 - place
            start = select((slope < 0.0) & (place > start), place, start)
        inside = (1 << min(WIDTH, n_lines - c)) - 1
        left = bits(start < end) & inside
        kept = mask_of(left)
        store(lines, _PLACE_J, n_left, compress(load(lines, _PLACE_J, c), kept))
        store(lines, _PLACE_K, n_left, compress(load(lines, _PLACE_K, c), kept))
        store(lines, _START, n_left, compress(start, kept))
        store(lines, _END, n_left, compress(end, kept))
        store(lines, _DX, n_left, compress(dx, kept))
        store(lines, _DY, n_left, compress(dy, kept))
        store(lines, _DZ, n_left, compress(dz, kept))
        store(lines, _CX, n_left, compress(cx, kept))
        store(lines, _CY, n_left, compress(cy, kept))
        store(lines, _CZ, n_left, compress(cz, kept))
        store(lines, _CLOSE_PLANES, n_left, compress(n_close, kept))
        n_left += count_bits(left)
    return n_left


@inner
def split_edges(lines, n_lines, edges, n_edges, doubts):
    """Append the lines that surely are edges to edges, but for u; set the others' doubts.

    Returns the number of edges.
    """
    for c in range(0, n_lines, WIDTH):
        start = load(lines, _START, c)
        end = load(lines, _END, c)
        inside = (1 << min(WIDTH, n_lines - c)) - 1
        # Two planes are close: those of p_j and p_k.
        sure = load(lines, _CLOSE_PLANES, c) == 2.0
        sure = sure & ((start == -1.0) | (start > _NEAR_SPHERE - 1.0))
        sure = sure & ((end == 1.0) | (end < 1.0 - _NEAR_SPHERE))
        first_place = load(lines, _PLACE_J, c)
        second_place = load(lines, _PLACE_K, c)
        kept = bits(sure) & inside
        store(edges, START, n_edges, compress(start, mask_of(kept)))
        store(edges, END, n_edges, compress(end, mask_of(kept)))
        store(edges, FIRST_PLACE, n_edges, compress(first_place, mask_of(kept)))
        store(edges, SECOND_PLACE, n_edges, compress(second_place, mask_of(kept)))
        n_edges += count_bits(kept)
        left = ~kept & inside
        while left != 0:
            lane = lowest_bit(left)
            left &= left - 1
            doubts[int(lines[_PLACE_J, c + lane])] = True
            doubts[int(lines[_PLACE_K, c + lane])] = True
    return n_edges
