"""The spacing around each point, from the least neighbourhood that covers the surface."""

import math

import numpy as np

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.box_tree import STACK, find_nearest
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
    found = np.empty(largest, np.int64)
    squares = np.empty(largest)
    stack = np.empty(STACK, np.int64)
    likely = np.int64(seen_first)  # what the point before needed: neighbours need as much
    for row in range(first, last):
        i = numbers[row]
        x = coordinates[0, i]
        y = coordinates[1, i]
        z = coordinates[2, i]
        n_found = likely
        find_nearest(coordinates, boxes, x, y, z, i, n_found, found, squares, stack)
        for k in range(neighbors.shape[1]):
            neighbors[row, k] = found[k]
        size = np.int64(seen_first)
        covered = _covers(coordinates, dimension, i, found, size)
        shrinks = covered and size > least
        while shrinks:
            smaller = max(np.int64(size / LARGER), least)
            shrinks = _covers(coordinates, dimension, i, found, smaller)
            if shrinks:
                size = smaller
                shrinks = size > least
        while not covered and size < largest:
            size = _enlarged(size, largest)
            if size > n_found:
                n_found = min(_MORE * n_found, largest)
                find_nearest(coordinates, boxes, x, y, z, i, n_found, found, squares, stack)
            covered = _covers(coordinates, dimension, i, found, size)
        likely = max(_enlarged(size, largest), np.int64(seen_first))
        spacing = _mean_distance(squares, least)
        if covered:
            share = (least / size) ** 2
            spacing = share * _mean_distance(squares, size)
            spacing += (1.0 - share) * NEXT_LINE * math.sqrt(squares[size - 1])
        spacings[row] = spacing
        reaches[row] = math.sqrt(squares[max(size, seen_first) - 1])


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
def _covers(coordinates, dimension, i, found, count):
    """Tell whether neighbours lie on all sides of point i along the surface, or on its border."""
    xx = xy = xz = yy = yz = zz = 0.0
    for k in range(count):
        j = found[k]
        x = coordinates[0, j] - coordinates[0, i]
        y = coordinates[1, j] - coordinates[1, i]
        z = coordinates[2, j] - coordinates[2, i]
        xx += x * x
        xy += x * y
        xz += x * z
        yy += y * y
        yz += y * z
        zz += z * z
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
