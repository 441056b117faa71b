"""Neighbours whose bisector cannot reach a restricted cell, found before anything is cut.

Where balls are unequal, the neighbours are images, and SQUARE has a sign (see `select_images`).
"""

import numpy as np

from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    absolute,
    bits,
    compress,
    count_bits,
    load,
    mask_of,
    multiply_add,
    select,
    square_root,
    store,
)
from pcsmooth.kernels.cells.bounding_polyhedron import keep_reaching
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.within_reach import (
    MOST_HIDERS,
    NUMBER,
    SQUARE,
    X,
    Y,
    Z,
    pad_neighbors,
    sort_by_distance,
    store_chosen,
)

#: Neighbours that hide others: so many of the nearest in the first round, three times as many in
#: each of the next ones, and of the sorted ones in the last.
_FIRST_HIDERS = 8
_LAST_HIDERS = 32

#: Row of the hiders' lengths, with the sign of SQUARE; they are stored as unit vectors.
_LENGTH = 3

#: With more neighbours than this, those that together hide others are looked for first.
_MANY = 400

#: Rounds go on while more neighbours than this are left.
_FEW = 48

#: A neighbour is dropped only if it is hidden by more than this, relative; rounding cannot
#: feign as much.
_MARGIN = 1e-12


@inner
def keep_visible(near, count, radius, radii, margin, spare, hiders):
    """Keep the neighbours that may bound the cell, sorted by distance; returns how many.

    near holds `count` neighbours within 2 r and gets the result, padded; margin as for
    `thin_out`; spare is an array like near; hiders has room for MOST_HIDERS + WIDTH neighbours;
    radii is None unless the neighbours are images of those of unequal balls.
    """
    count = thin_out(near, count, radius, radii, margin, hiders)
    return sort_visible(near, count, radius, radii, spare, hiders)


@inner
def sort_visible(near, count, radius, radii, spare, hiders):
    """Sort neighbours by distance and drop some that cannot bound the cell; returns how many stay.

    All as for `keep_visible`.
    """
    pad_neighbors(near, count)
    sort_by_distance(near, count, spare)
    pad_neighbors(spare, count)
    n_hiders = _take_hiders(spare, min(count, _LAST_HIDERS), hiders)
    count = _drop_hidden(spare, count, radius, radii, hiders, n_hiders, near)
    pad_neighbors(near, count)
    return count


@inner
def thin_out(near, count, radius, radii, margin, hiders):
    """Drop most of the neighbours that cannot bound the cell; returns how many are left.

    near and hiders as for `keep_visible`. Of many neighbours only those are kept whose bisector
    comes nearer than `margin` to what the others leave of the ball; 0 asks for a cut.
    """
    if count > _MANY:
        count = keep_reaching(near, count, radius, margin)
    wanted = np.int64(_FIRST_HIDERS)
    while count > 0:
        pad_neighbors(near, count)
        n_hiders = _choose_hiders(near, count, wanted, radius, hiders)
        count = _drop_hidden(near, count, radius, radii, hiders, n_hiders, near)
        wanted *= 3
        if count <= _FEW or wanted > MOST_HIDERS:
            break
    return count


@inner
def _choose_hiders(near, count, wanted, radius, hiders):
    """Make hiders of about as many of the nearest neighbours as wanted, as if on a surface."""
    limit2 = 4.0 * radius * radius * wanted / count
    n_hiders = 0
    for c in range(0, count, WIDTH):
        square = load(near, SQUARE, c)
        chosen = square < limit2
        number = bits(chosen)
        if number == 0 or n_hiders > MOST_HIDERS - WIDTH:
            continue
        length = square_root(absolute(square))
        scale = 1.0 / length
        store(hiders, X, n_hiders, compress(load(near, X, c) * scale, chosen))
        store(hiders, Y, n_hiders, compress(load(near, Y, c) * scale, chosen))
        store(hiders, Z, n_hiders, compress(load(near, Z, c) * scale, chosen))
        length = select(square < 0.0, 0.0 - length, length)
        store(hiders, _LENGTH, n_hiders, compress(length, chosen))
        n_hiders += count_bits(number)
    return n_hiders


@inner
def _take_hiders(near, count, hiders):
    """Make hiders of the first neighbours."""
    for c in range(0, count, WIDTH):
        square = load(near, SQUARE, c)
        length = square_root(absolute(square))
        scale = 1.0 / length
        store(hiders, X, c, load(near, X, c) * scale)
        store(hiders, Y, c, load(near, Y, c) * scale)
        store(hiders, Z, c, load(near, Z, c) * scale)
        store(hiders, _LENGTH, c, select(square < 0.0, 0.0 - length, length))
    return count


@inner
def _drop_hidden(source, count, radius, radii, hiders, n_hiders, target):
    """Copy the neighbours j whose facet no hider k covers; target may be source.

    The bisector of p_j cuts the ball in a disk of radius rho, rho^2 = r^2 - |u_j|^2 / 4. All of
    it lies beyond the bisector of p_k if E > 0 and E^2 U / 4 >= rho^2 (U - D^2), with
    U = |u_j|^2, D = u_j . u_k / |u_k|, E = D - |u_k|. Such a j bounds neither the cell nor any
    of its facets. (A plane beyond p_i has the opposite of u_j for D, and -|u_k| for |u_k|. If the
    disk of p_k lies beyond the bisector of p_j, too, nothing is left between them, and both stay.)
    """
    radius2 = radius * radius
    left = 0
    for c in range(0, count, WIDTH):
        x = load(source, X, c)
        y = load(source, Y, c)
        z = load(source, Z, c)
        square = load(source, SQUARE, c)
        size = absolute(square)
        quarter = size * 0.25
        rho2 = radius2 - quarter
        limit = size * (rho2 + _MARGIN * radius2)
        kept = bits(square < 5.0 * radius2)  # not the padding
        fx, fy, fz = x, y, z  # twice the foot of the perpendicular from p_i
        if radii is not None:
            is_behind = square < 0.0
            fx = select(is_behind, 0.0 - x, x)
            fy = select(is_behind, 0.0 - y, y)
            fz = select(is_behind, 0.0 - z, z)
        for k in range(n_hiders):
            along = multiply_add(
                fz, hiders[Z, k], multiply_add(fy, hiders[Y, k], fx * hiders[X, k])
            )
            beyond = along - hiders[_LENGTH, k]
            reach = multiply_add(beyond * quarter, beyond, rho2 * along * along)
            hidden = bits((beyond > 0.0) & (reach >= limit))
            if radii is not None:
                foot = select(is_behind, 0.0 - along, along) * hiders[_LENGTH, k]
                hidden &= bits(foot <= square)
            kept &= ~hidden
            if kept == 0:
                break
        numbers = load(source, NUMBER, c)
        store_chosen(target, left, x, y, z, square, numbers, mask_of(kept))
        left += count_bits(kept)
    return left
