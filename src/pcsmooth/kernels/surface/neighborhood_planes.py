"""The plane through the neighbourhood of every point: how large it is, and its normal."""

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
    store_numbers,
)
from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS
from pcsmooth.kernels.grid.within_reach import collect_around
from pcsmooth.kernels.surface.neighbor_lists import no_candidates, with_room
from pcsmooth.kernels.threads import shared_out

#: Rows of what is known of neighbours: squared distance, number of the point in grid order.
_SQUARE, _NUMBER = 0, 1

#: Halvings of the interval in which the radius of a neighbourhood is looked for.
_HALVINGS = 12

#: Radius within which the neighbourhood of a point is looked for first, in units of that of the
#: point before it.
_LARGER = 1.25


@shared_out("cells.codes")
@kernel("f2 cells i f f1 f1 f1 i f2 f1 f1 f1 i1 i i", cells=CELLS)
def fit_planes(
    coordinates, cells, dimension, count, thickness, min_radii, max_radii, most, normals, squares,
    sizes, offsets, ends, first, last,
):  # fmt: skip
    """Fit a plane (a line in 2D) to the neighbourhood of every point.

    Parameters: coordinates (3, n) of distinct points in grid order (cells of side >= max_radius);
    d; count and thickness: the radius R of a neighbourhood of N points is the least for which
    N (1 - (thickness / R)^(d - 1)) >= count, but not more than max_radius; most: neighbours of a
    point in the mean, in lists that are kept. Filled: normals (3, n), of either sign, 0 where there
    is none; squares (n,) of the radii; sizes (n,), the number of points, itself included; offsets
    (n,), the distance to their centroid over the radius; ends (n,) of the lists, if they are kept,
    as `list_neighbors` has them.

    Returns the first point of the block, the one after its last, their list, and whether it is
    kept.
    """
    start = cells.starts[first]
    stop = cells.starts[last]
    ranges, candidates = no_candidates()
    near = np.empty((2, 0))
    longest = most * (stop - start)
    numbers = np.empty(longest + WIDTH, np.int32)
    keeps = most > 0
    place = 0
    within = np.inf
    for cell in range(first, last):
        candidates, n_candidates = collect_around(
            coordinates, cells, cell, dimension, ranges, candidates
        )
        if near.shape[1] < candidates.shape[1]:
            near = np.empty((2, candidates.shape[1]))
        numbers = with_room(numbers, longest, n_candidates)
        for i in range(cells.starts[cell], cells.starts[cell + 1]):
            n_near, limit = _neighborhood(
                coordinates, i, candidates, n_candidates, near, within, dimension, count,
                thickness[i], min_radii[i], max_radii[i],
            )  # fmt: skip
            # Neighbouring points have neighbourhoods of about the same size.
            within = _LARGER * math.sqrt(limit)
            if place > longest:
                keeps = False
            if not keeps:
                place = 0
            begin = place
            for c in range(0, n_near, WIDTH):
                inside = load(near, _SQUARE, c) < limit
                store_numbers(numbers, place, compress(load(near, _NUMBER, c), inside))
                place += count_bits(bits(inside))
            if keeps:
                ends[i] = place
            _fit_plane(
                coordinates, i, numbers, begin, place, limit, dimension, normals, squares, sizes,
                offsets,
            )  # fmt: skip
    return start, stop, numbers, keeps and place <= longest


@inner
def _fit_plane(
    coordinates, i, numbers, begin, end, limit, dimension, normals, squares, sizes, offsets
):  # fmt: skip
    """Fit the plane of point i to the neighbours that are listed from begin to end."""
    mx = my = mz = xx = xy = xz = yy = yz = zz = 0.0
    for k in range(begin, end):
        j = numbers[k]
        x = coordinates[0, j] - coordinates[0, i]
        y = coordinates[1, j] - coordinates[1, i]
        z = coordinates[2, j] - coordinates[2, i]
        mx += x
        my += y
        mz += z
        xx += x * x
        xy += x * y
        xz += x * z
        yy += y * y
        yz += y * z
        zz += z * z
    size = end - begin + 1.0
    share = 1.0 / size
    offsets[i] = share * math.sqrt((mx * mx + my * my + mz * mz) / limit)
    xx -= mx * mx * share
    xy -= mx * my * share
    xz -= mx * mz * share
    yy -= my * my * share
    yz -= my * mz * share
    zz -= mz * mz * share
    # The least direction of the covariance is the leading one of its trace minus itself.
    trace = xx + yy + zz
    nx, ny, nz = leading_direction(
        trace - xx, -xy, -xz, trace - yy, -yz, trace - zz if dimension == 3 else 0.0
    )
    normals[0, i] = nx
    normals[1, i] = ny
    normals[2, i] = nz
    squares[i] = limit
    sizes[i] = size


@inner
def _neighborhood(
    coordinates, i, candidates, n_candidates, near, within, dimension, count, thickness,
    min_radius, max_radius,
):  # fmt: skip
    """Find the squared radius of the neighbourhood of point i: see `fit_planes`.

    Looks within a radius first, and where that does not do, as far as it may. Returns how many
    candidates near holds then, and the square.
    """
    x = coordinates[0, i]
    y = coordinates[1, i]
    z = coordinates[2, i]
    within = min(max_radius, max(within, min_radius))
    n_near = 0
    for _ in range(2):
        n_near = _select(candidates, n_candidates, x, y, z, within * within, near)
        covered = _covered(n_near + 1, within * within, dimension, thickness)
        if within >= max_radius or covered >= count:
            break
        within = max_radius
    for c in range(n_near, n_near + WIDTH):
        near[_SQUARE, c] = np.inf
    low = max(thickness, min_radius) ** 2
    high = max_radius * max_radius
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if within < max_radius and middle >= within * within:
            high = middle
            continue
        size = np.int64(1)
        for c in range(0, n_near, WIDTH):
            size += count_bits(bits(load(near, _SQUARE, c) < middle))
        if _covered(size, middle, dimension, thickness) >= count:
            high = middle
        else:
            low = middle
    return n_near, high


@inner
def _select(candidates, n_candidates, x, y, z, square, near):
    """Put what is to be known of the candidates nearer to (x, y, z), itself excluded, into near.

    Returns how many there are; near has room for WIDTH more.
    """
    count = 0
    for c in range(0, n_candidates, WIDTH):
        dx = load(candidates, 0, c) - x
        dy = load(candidates, 1, c) - y
        dz = load(candidates, 2, c) - z
        found = multiply_add(dz, dz, multiply_add(dy, dy, dx * dx))
        within = (found < square) & (found > 0.0)
        store(near, _SQUARE, count, compress(found, within))
        store(near, _NUMBER, count, compress(load(candidates, 3, c), within))
        count += count_bits(bits(within))
    return count


@inner
def _covered(size, square, dimension, thickness):
    """Points of a neighbourhood of a squared radius less those that its thickness takes up."""
    share = thickness * thickness / square
    if dimension == 2:
        share = math.sqrt(share)
    return size * (1.0 - share)
