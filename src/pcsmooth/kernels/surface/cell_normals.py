"""Normals from the visible boundary of the cells around each point."""

import math

import numpy as np

from pcsmooth.kernels.arithmetic.leading_direction import leading_direction
from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    bits,
    compress,
    count_bits,
    load,
    multiply_add,
    store,
)
from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS, MOST_RANGES, adjacent_ranges
from pcsmooth.kernels.grid.within_reach import collect_points, count_points
from pcsmooth.kernels.threads import MANY, shared_out

#: Columns of a point: upper triangle of the tensor, volume V of the cell, V x, V y, V z; two are
#: left over, so that two registers cover a row.
_VOLUME = 6
_PLACE = 7
N_TERMS = 12

#: Rows of an array of neighbours.
_SQUARE = 0  # of the distance
_NUMBER = 1

#: Attempts at a distance that just the wanted number of neighbours is nearer than.
_ATTEMPTS = 40


@shared_out("numbers", MANY)
@kernel("f2 f2~ f1~ i1 f f2 i i")
def gather_terms(coordinates, tensors, volumes, numbers, unit, terms, first, last):
    """Lay out what the points (3, n) add to their neighbours' sums: terms (n, N_TERMS), 0 so far.

    Their tensors (m, 6) and volumes (m,), to be divided by a unit, are by number (n,).
    """
    for k in range(first, last):
        i = numbers[k]
        for c in range(6):
            terms[k, c] = tensors[i, c]
        terms[k, _VOLUME] = volumes[i] / unit
        for axis in range(3):
            terms[k, _PLACE + axis] = terms[k, _VOLUME] * coordinates[axis, k]


@shared_out("cells.codes")
@kernel("f2 cells i i f1 f2 j2 f2 f2 f1 f1 i i", cells=CELLS)
def normals_from_cells(
    coordinates, cells, dimension, count, reaches, terms, links, normals, anchors,
    weights, extents, first, last,
):  # fmt: skip
    """Leading direction of the tensors summed over the nearest points of each point.

    Parameters: coordinates (3, n) in grid order (cells of side >= the reaches); d; points
    of a neighbourhood, itself included; reaches, (n,) or, if all are the same, (1,); terms
    (n, N_TERMS). Filled: links (n, l), numbers of the
    nearest others, l to l - 2 of them, n where there are no more; normals (3, n), of either sign, 0
    for a point that has no neighbour; anchors (3, n), where the normal holds: the point moved along
    the surface to the centroid of the cells of its neighbourhood; weights (n,), its cell's volume
    or 0 if it has no normal; extents (n,), the squared distance that the neighbours are nearer
    than.
    """
    for cell in range(first, last):
        _find_normals(
            coordinates, cells, cell, dimension, count, reaches, terms,
            links, normals, anchors, weights, extents,
        )  # fmt: skip


@inner
def _find_normals(
    coordinates, cells, cell, dimension, count, reaches, terms,
    links, normals, anchors, weights, extents,
):  # fmt: skip
    """Do it for the points of one cell."""
    ranges = np.empty((2, MOST_RANGES), np.int64)
    n_ranges = adjacent_ranges(cells, cell, dimension, ranges)
    room = count_points(ranges, n_ranges) + WIDTH
    candidates = np.empty((4, room))
    near = np.empty((2, room))
    nearest = np.empty((2, room))
    sums = np.empty((1, N_TERMS))
    n_candidates = collect_points(coordinates, ranges, n_ranges, candidates)
    room_for_links = links.shape[1]
    needed = max(count - 1, room_for_links)
    within = np.inf
    for i in range(cells.starts[cell], cells.starts[cell + 1]):
        reach = reaches[i] if reaches.size > 1 else reaches[0]
        within = min(within, reach)
        x = coordinates[0, i]
        y = coordinates[1, i]
        z = coordinates[2, i]
        n_near = _select_near(candidates, n_candidates, x, y, z, within, near)
        if n_near < needed and within < reach:
            within = reach
            n_near = _select_near(candidates, n_candidates, x, y, z, within, near)
        limit = _reach_of_nearest(near, n_near, count - 1, count - 1, within * within)
        extents[i] = limit
        n_nearest = _select_nearer(near, n_near, limit, nearest)
        _sum_terms(coordinates, nearest, n_nearest, terms, i, sums, normals, anchors, weights)
        if n_nearest >= room_for_links:
            _link(nearest, n_nearest, limit, i, near, links)
        else:
            limit = _link(near, n_near, within * within, i, nearest, links)
        # Neighbouring points have neighbourhoods of about the same size.
        within = 1.2 * math.sqrt(limit) if n_near >= needed else np.inf


@inner
def _select_near(candidates, n_candidates, x, y, z, reach, near):
    """Put distance and number of the candidates nearer than `reach`, itself excluded, into near.

    Returns how many there are; infinities follow them.
    """
    reach2 = reach * reach
    count = np.int64(0)
    for c in range(0, n_candidates, WIDTH):
        dx = load(candidates, 0, c) - x
        dy = load(candidates, 1, c) - y
        dz = load(candidates, 2, c) - z
        square = multiply_add(dz, dz, multiply_add(dy, dy, dx * dx))
        # Points are distinct: only the point itself is at distance 0.
        within = (square < reach2) & (square > 0.0)
        chosen = bits(within)
        if chosen != 0:
            store(near, _SQUARE, count, compress(square, within))
            store(near, _NUMBER, count, compress(load(candidates, 3, c), within))
            count += count_bits(chosen)
    for c in range(count, count + WIDTH):
        near[_SQUARE, c] = np.inf
    return count


@inner
def _reach_of_nearest(near, n_near, wanted, most, limit):
    """Squared distance that `wanted` to `most` neighbours are nearer than, or more if they tie.

    Starts from `limit`, which all n_near neighbours are nearer than.
    """
    low = 0.0
    n_low = np.int64(0)
    n_high = n_near
    for _ in range(_ATTEMPTS):
        if n_high <= most:
            break
        share = (0.5 * (wanted + most) + 0.5 - n_low) / (n_high - n_low)
        middle = low + (limit - low) * min(0.95, max(0.05, share))
        count = np.int64(0)
        for c in range(0, n_near, WIDTH):
            count += count_bits(bits(load(near, _SQUARE, c) < middle))
        if count >= wanted:
            limit = middle
            n_high = count
        else:
            low = middle
            n_low = count
    return limit


@inner
def _select_nearer(near, n_near, limit, nearest):
    """Copy the neighbours nearer than a squared distance; returns how many."""
    count = np.int64(0)
    for c in range(0, n_near, WIDTH):
        square = load(near, _SQUARE, c)
        nearer = square < limit
        store(nearest, _SQUARE, count, compress(square, nearer))
        store(nearest, _NUMBER, count, compress(load(near, _NUMBER, c), nearer))
        count += count_bits(bits(nearer))
    for c in range(count, count + WIDTH):
        nearest[_SQUARE, c] = np.inf
    return count


@inner
def _link(near, n_near, limit, i, chosen, links):
    """Note the nearest neighbours of point i, as many as there is room for or one or two fewer.

    Returns the squared distance that they are nearer than.
    """
    room = links.shape[1]
    limit = _reach_of_nearest(near, n_near, room - 2, room, limit)
    count = min(room, _select_nearer(near, n_near, limit, chosen))
    for k in range(count):
        links[i, k] = int(chosen[_NUMBER, k])
    for k in range(count, room):
        links[i, k] = links.shape[0]
    return limit


@inner
def _sum_terms(coordinates, nearest, n_nearest, terms, i, sums, normals, anchors, weights):
    """Find the normal and the anchor of point i from its own and its neighbours' terms."""
    x = coordinates[0, i]
    y = coordinates[1, i]
    z = coordinates[2, i]
    nx = ny = nz = dx = dy = dz = 0.0
    if n_nearest > 0:
        low = load(terms, i, 0)
        high = load(terms, i, N_TERMS - WIDTH)
        for k in range(n_nearest):
            j = int(nearest[_NUMBER, k])
            low = low + load(terms, j, 0)
            high = high + load(terms, j, N_TERMS - WIDTH)
        store(sums, 0, 0, low)
        store(sums, 0, N_TERMS - WIDTH, high)
        if sums[0, _VOLUME] > 0.0:  # larger balls may hide all of them
            nx, ny, nz = leading_direction(
                sums[0, 0], sums[0, 1], sums[0, 2], sums[0, 3], sums[0, 4], sums[0, 5]
            )
            dx = sums[0, _PLACE] / sums[0, _VOLUME] - x
            dy = sums[0, _PLACE + 1] / sums[0, _VOLUME] - y
            dz = sums[0, _PLACE + 2] / sums[0, _VOLUME] - z
            off = dx * nx + dy * ny + dz * nz
            dx -= off * nx
            dy -= off * ny
            dz -= off * nz
    weights[i] = terms[i, _VOLUME] if abs(nx) + abs(ny) + abs(nz) > 0.0 else 0.0
    normals[0, i] = nx
    normals[1, i] = ny
    normals[2, i] = nz
    anchors[0, i] = x + dx
    anchors[1, i] = y + dy
    anchors[2, i] = z + dz
