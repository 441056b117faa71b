"""Neighbours whose bisector cannot reach a cell, found with a polyhedron around the cell.

The polyhedron is a cube around the ball, cut by bisectors from near to far, so that soon little
more than the cell is left of it. A bisector beyond all of its vertices bounds nothing. Where many
points lie within one ball this costs a few operations for each pair of them, while one neighbour
alone hides few others there.

Nothing is measured on the polyhedron: it may only not be smaller than the cell. So a cut that
rounding makes contradictory is left out, and cuts that are very many are not made.
"""

import math

import numpy as np

from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    absolute,
    bits,
    count_bits,
    load,
    mask_of,
    multiply_add,
    square_root,
)
from pcsmooth.kernels.cells.convex_polyhedron import (
    TORN,
    cut_off,
    measure_excess,
    place_vertex,
    polyhedron_arrays,
)
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.within_reach import NUMBER, SQUARE, X, Y, Z, store_chosen

#: Margin, in units of the radius, of what may touch a cell, however rounding has it. Where the
#: cells at a facet are measured apart, each has to know of all that touches it: what one drops
#: and another cuts with would leave a gap between their facets.
TOUCHING = 1e-13

#: Facets of the cube; the planes of bisectors are numbered from here on.
_N_SIDES = 6

#: Bisectors that may cut the polyhedron; a cell in a clump has some 15 facets.
_MOST_CUTS = 122

#: Neighbours that are taken at a time: about so many of the nearest at first.
_FIRST_TAKEN = 16

#: What rounding can feign of the distance of a vertex from a plane, in units of how far both are
#: from the centre.
_ROUNDING = 4e-15

#: A vertex is placed where its three planes meet if the determinant of their unit normals is
#: above this. With 1e-4 rounding left one in fifty cells of 4,000 points on a sphere with all of
#: their neighbours, with this none.
_CLEAR = 0.05


@inner
def keep_reaching(near, count, radius, margin):
    """Keep the neighbours whose bisector comes nearer than a margin to a polyhedron around a cell.

    near: `count` neighbours, in any order, or images of them (see `select_images`), with room for
    WIDTH more; margin: a length, with 0 a
    bisector has to cut something off. Returns how many are left; the order changes.
    """
    vertices, planes, across, excess, first = polyhedron_arrays(_N_SIDES + _MOST_CUTS)
    table = np.empty((4, _N_SIDES + _MOST_CUTS))
    n = _make_cube(radius, vertices, planes, across, table)
    extent = math.sqrt(3.0) * radius
    n_cuts = np.int64(0)  # the neighbours that made them come first
    n_taken = np.int64(0)
    wanted = np.int64(_FIRST_TAKEN)
    while n_taken < count and n_cuts < _MOST_CUTS:
        stop = _bring_forward(near, n_taken, count, wanted)
        for j in range(n_taken, stop):
            length = math.sqrt(abs(near[SQUARE, j]))
            tolerance = _ROUNDING * length * (extent + length)
            half = 0.5 * near[SQUARE, j]
            beyond = measure_excess(vertices, n, near[X, j], near[Y, j], near[Z, j], half, excess)
            if beyond <= tolerance or n_cuts == _MOST_CUTS:
                continue
            label = _N_SIDES + n_cuts
            left = cut_off(vertices, planes, across, n, excess, tolerance, label, first)
            if left == TORN:
                continue
            n = left
            table[0, label] = near[X, j]
            table[1, label] = near[Y, j]
            table[2, label] = near[Z, j]
            table[3, label] = half
            for t in range(n):
                if planes[0, t] == label or planes[1, t] == label or planes[2, t] == label:
                    place_vertex(vertices, planes, t, table, _CLEAR)
            _swap(near, j, n_cuts)
            n_cuts += 1
        n_taken = stop
        wanted *= 4
        extent = _extent(vertices, n)
        count = _drop_beyond(near, n_taken, count, vertices, n, extent, margin)
    count = _drop_beyond(near, n_cuts, count, vertices, n, extent, margin)
    return _drop_overtaken(near, n_cuts, count, vertices, planes, n, extent, margin, excess, first)


@inner
def _make_cube(radius, vertices, planes, across, table):
    """Fill in the cube around the ball; returns the number of its vertices.

    Side k < 3 is where coordinate k is r, side k + 3 where it is -r; bit k of a vertex tells.
    """
    for k in range(_N_SIDES):
        for row in range(3):
            table[row, k] = 0.0
        table[k % 3, k] = 1.0 if k < 3 else -1.0
        table[3, k] = radius
    for t in range(8):
        turn = 1  # from one side of a vertex to the next, counter-clockwise
        for k in range(3):
            on_low_side = (t >> k) & 1
            vertices[k, t] = -radius if on_low_side else radius
            turn = 3 - turn if on_low_side else turn
        for e in range(3):
            k = (e * turn) % 3
            planes[e, t] = k + 3 * ((t >> k) & 1)
            across[e, t] = t ^ (1 << (3 - k - (k + turn) % 3))
    return 8


@inner
def _bring_forward(near, first, count, wanted):
    """Swap some of the nearest neighbours to the places from `first` on.

    Returns the place after them. They are up to 4 wanted: the nearest of every wanted-th has about
    wanted - 1 before it, on a grid perhaps many more, which are then sifted again.
    """
    stop = count
    while stop - first > 4 * wanted:
        limit = np.inf
        for c in range(first, stop, wanted):
            limit = min(limit, near[SQUARE, c])
        target = first
        for c in range(first, stop):
            if near[SQUARE, c] <= limit:
                _swap(near, c, target)
                target += 1
        if target == stop:  # all at one distance
            return first + 4 * wanted
        stop = target
    return stop


@inner
def _swap(near, j, k):
    """Let two neighbours change places."""
    for row in range(NUMBER + 1):
        here = near[row, j]
        near[row, j] = near[row, k]
        near[row, k] = here


@inner
def _extent(vertices, n):
    """Distance of the farthest vertex from the centre."""
    farthest2 = 0.0
    for t in range(n):
        x = vertices[0, t]
        y = vertices[1, t]
        z = vertices[2, t]
        farthest2 = max(farthest2, x * x + y * y + z * z)
    return math.sqrt(farthest2)


@inner
def _drop_beyond(near, first, count, vertices, n, extent, margin):
    """Drop the neighbours from place `first` on whose bisector is beyond all vertices.

    Returns how many neighbours are left, those before that place included.
    """
    left = first
    for c in range(first, count, WIDTH):
        x = load(near, X, c)
        y = load(near, Y, c)
        z = load(near, Z, c)
        square = load(near, SQUARE, c)
        length = square_root(absolute(square))
        limit = square * 0.5 + length * ((length + extent) * _ROUNDING - margin)
        kept = bits(limit < length * extent) & ((1 << min(WIDTH, count - c)) - 1)
        reaching = 0
        for t in range(n):
            if reaching & kept == kept:
                break
            along = multiply_add(
                z, vertices[2, t], multiply_add(y, vertices[1, t], x * vertices[0, t])
            )
            reaching |= bits(along > limit)
        kept &= reaching
        if kept == 0:
            continue
        numbers = load(near, NUMBER, c)
        store_chosen(near, left, x, y, z, square, numbers, mask_of(kept))
        left += count_bits(kept)
    return left


@inner
def _drop_overtaken(near, n_cuts, count, vertices, planes, n, extent, margin, excess, first):
    """Drop those of the first n_cuts neighbours whose cuts later cuts have taken away.

    Returns how many neighbours are left; the last ones fill the gaps.
    """
    for j in range(n_cuts):
        first[_N_SIDES + j] = 0
    for t in range(n):
        for e in range(3):
            first[planes[e, t]] = 1
    for j in range(n_cuts - 1, -1, -1):
        if first[_N_SIDES + j] == 1:
            continue
        length = math.sqrt(abs(near[SQUARE, j]))
        limit = length * (_ROUNDING * (extent + length) - margin)
        half = 0.5 * near[SQUARE, j]
        if measure_excess(vertices, n, near[X, j], near[Y, j], near[Z, j], half, excess) > limit:
            continue
        count -= 1
        _swap(near, j, count)
    return count
