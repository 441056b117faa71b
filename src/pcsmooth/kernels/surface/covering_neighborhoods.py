"""The spacing around each point, from the least neighbourhood that covers the surface."""

import math

import numpy as np

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.box_tree import LEAF, STACK, collect_around, find_among, find_nearest
from pcsmooth.kernels.grid.within_reach import N_ROWS
from pcsmooth.kernels.threads import shared_out

#: Points of the neighbourhood that is looked at first, and then smaller ones as long as they cover
#: the surface: the noise of a scan line spreads six points of it as if they did, not so many.
SEEN_FIRST = 24

#: Points of the largest neighbourhood that is looked at: it reaches lines that are sixty times
#: farther apart than the points on them. Beyond that points lie on curves.
LARGEST = 128

#: By what factor, or else by one point, the next neighbourhood is larger or smaller.
LARGER = 1.2

#: Points that are found when more are needed than were, as a multiple.
_MORE = 3

#: Nearest points are looked for together for those of a leaf: as far as they were for the leaf
#: before, times this, and among no more than so many.
_FARTHER = 1.3
_TRIED = 1.05
_ROOM = 1024

#: Least second eigenvalue of the moments of offsets that cover a surface, as a share of the first.
COVERED = 0.22

#: How far points on either side of one on a plane curve reach, at least, as a share of how far
#: those on the other side do.
_BALANCED = 0.3

#: Distance of scan lines as a share of the radius of the least neighbourhood that gets hold of the
#: next ones.
NEXT_LINE = 0.95


@shared_out("spacings", 64)
@kernel("f2 f2 i i i1 f1 j2 f1 i i")
def measure_spacings(
    coordinates, boxes, dimension, least, numbers, spacings, neighbors, reaches, first, last
):  # fmt: skip
    """Measure how far points are apart along the surface, at each point by itself.

    Parameters: coordinates (3, n) of distinct points in Morton order; boxes of their tree (2 m, 6);
    d; points of the least neighbourhood, 1 <= least < n. numbers
    of some points (s,). Fills, of these, spacings (s,), neighbors (s, k): numbers of the nearest,
    by distance, k <= SEEN_FIRST, and reaches (s,): how far the points are that this depends on.

    The spacing is the mean distance in the least neighbourhood if that, and the larger ones, cover
    the surface: if points lie on all sides. In a larger one it is more and more the distance of
    scan lines, which is next to its radius. Where none covers a surface it is that of the least.
    """
    largest = min(LARGEST, coordinates.shape[1] - 1)
    seen_first = max(min(SEEN_FIRST, largest), least)
    sizes = _sizes_up_to(seen_first, least)
    moments = np.empty((sizes.size, 6))
    found = np.empty(largest, np.int64)
    squares = np.empty(largest)
    stack = np.empty(STACK, np.int64)
    candidates = np.empty((4, _ROOM))
    near = np.empty((N_ROWS, _ROOM))
    spare = np.empty((N_ROWS, _ROOM))
    leaf = np.int64(-1)
    n_candidates = np.int64(0)
    reach = farthest = before = 0.0
    likely = np.int64(seen_first)  # what the point before needed: neighbours need as much
    for row in range(first, last):
        i = numbers[row]
        x = coordinates[0, i]
        y = coordinates[1, i]
        z = coordinates[2, i]
        if i // LEAF != leaf:
            leaf = i // LEAF
            reach = _FARTHER * farthest
            farthest = 0.0
            n_candidates = collect_around(coordinates, boxes, leaf, reach, candidates, stack)
        n_found = likely
        is_found = False
        for length in (min(_TRIED * before, reach), reach):
            if not is_found:
                is_found = find_among(
                    candidates, n_candidates, x, y, z, i, length, n_found, near, spare, found,
                    squares,
                )  # fmt: skip
        if not is_found:
            find_nearest(coordinates, boxes, x, y, z, i, n_found, found, squares, stack)
        before = math.sqrt(squares[n_found - 1])
        farthest = max(farthest, before)
        for k in range(neighbors.shape[1]):
            neighbors[row, k] = found[k]
        _sum_moments(coordinates, i, found, sizes, moments)
        place = sizes.size - 1
        covered = _covers(moments[place], coordinates, dimension, i, found, sizes[place])
        while (
            covered
            and place > 0
            and _covers(moments[place - 1], coordinates, dimension, i, found, sizes[place - 1])
        ):
            place -= 1
        size = sizes[place]
        total = moments[place]
        while not covered and size < largest:
            larger = _enlarged(size, largest)
            if larger > n_found:
                n_found = min(_MORE * n_found, largest)
                find_nearest(coordinates, boxes, x, y, z, i, n_found, found, squares, stack)
            _add_moments(coordinates, i, found, size, larger, total)
            size = larger
            covered = _covers(total, coordinates, dimension, i, found, size)
        likely = max(_enlarged(size, largest), np.int64(seen_first))
        spacing = _mean_distance(squares, least)
        if covered:
            share = (least / size) ** 2
            spacing = share * _mean_distance(squares, size)
            spacing += (1.0 - share) * NEXT_LINE * math.sqrt(squares[size - 1])
        spacings[row] = spacing
        reaches[row] = math.sqrt(squares[max(size, seen_first) - 1])


@inner
def _sizes_up_to(largest, least):
    """Sizes of the neighbourhoods that are looked at from the first one down, increasing."""
    sizes = np.empty(largest, np.int64)
    size = largest
    count = np.int64(0)
    while True:
        count += 1
        sizes[largest - count] = size
        if size <= least:
            break
        size = max(np.int64(size / LARGER), least)
    return sizes[largest - count :]


@inner
def _enlarged(size, largest):
    """Size of the neighbourhood that is looked at next."""
    return min(max(np.int64(LARGER * size), size + 1), largest)


@inner
def _mean_distance(squares, count):
    """Mean distance to the nearest points."""
    total = 0.0
    for k in range(count):
        total += math.sqrt(squares[k])
    return total / count


@inner
def _sum_moments(coordinates, i, found, sizes, moments):
    """Sum the moments of the offsets of so many nearest points, for all sizes: (s, 6)."""
    size = np.int64(0)
    total = moments[sizes.size - 1]
    total[:] = 0.0
    for place in range(sizes.size):
        _add_moments(coordinates, i, found, size, sizes[place], total)
        size = sizes[place]
        for k in range(6):
            moments[place, k] = total[k]


@inner
def _add_moments(coordinates, i, found, first, last, total):
    """Add xx, xy, xz, yy, yz, zz of the offsets of points first..last-1 of those found."""
    for k in range(first, last):
        j = found[k]
        x = coordinates[0, j] - coordinates[0, i]
        y = coordinates[1, j] - coordinates[1, i]
        z = coordinates[2, j] - coordinates[2, i]
        total[0] += x * x
        total[1] += x * y
        total[2] += x * z
        total[3] += y * y
        total[4] += y * z
        total[5] += z * z


@inner
def _covers(moments, coordinates, dimension, i, found, count):
    """Tell whether neighbours lie on all sides of point i along the surface, or on its border."""
    xx = moments[0]
    xy = moments[1]
    xz = moments[2]
    yy = moments[3]
    yz = moments[4]
    zz = moments[5]
    if dimension == 2:
        return _covers_curve(coordinates, i, found, count, 0.5 * math.atan2(2.0 * xy, xx - yy))
    return _covers_surface(xx, xy, xz, yy, yz, zz)


@inner
def _covers_surface(xx, xy, xz, yy, yz, zz):
    """Tell whether the second eigenvalue of moments is not far below the first.

    Eigenvalues are the roots of the characteristic polynomial in trigonometric form.
    """
    share = 3.0 / (xx + yy + zz)
    ax = xx * share - 1.0
    ay = yy * share - 1.0
    az = zz * share - 1.0
    xy *= share
    xz *= share
    yz *= share
    scale = math.sqrt((ax * ax + ay * ay + az * az + 2.0 * (xy * xy + xz * xz + yz * yz)) / 6.0)
    if not scale > 0.0:
        return True
    determinant = ax * (ay * az - yz * yz) - xy * (xy * az - yz * xz) + xz * (xy * yz - ay * xz)
    # Nearly always a bound of the first is enough: below it the characteristic polynomial is
    # positive between the third and the second.
    limit = COVERED * (1.0 + 2.0 * scale) - 1.0
    if limit * (limit * limit - 3.0 * scale * scale) > determinant:
        return True
    angle = math.acos(min(1.0, max(-1.0, 0.5 * determinant / scale**3))) / 3.0
    largest = 1.0 + 2.0 * scale * math.cos(angle)
    least = 1.0 + 2.0 * scale * math.cos(angle + 2.0 * math.pi / 3.0)
    return 3.0 - largest - least >= COVERED * largest


@inner
def _covers_curve(coordinates, i, found, count, angle):
    """Tell whether neighbours lie to both sides along the direction in which they spread most."""
    along_x = math.cos(angle)
    along_y = math.sin(angle)
    ahead = 0.0
    behind = 0.0
    for k in range(count):
        j = found[k]
        along = along_x * (coordinates[0, j] - coordinates[0, i])
        along += along_y * (coordinates[1, j] - coordinates[1, i])
        ahead = max(ahead, along)
        behind = max(behind, -along)
    return min(ahead, behind) >= _BALANCED * max(ahead, behind)
