"""Normals and shape operators: how the normals of a neighbourhood turn with position.

A neighbourhood enters by its moments: sums of weights w, normals n and positions x, w n, w x,
w x x^T and w n x^T. They give the affine map of tangential position to normal that fits best.
"""

import math

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    bits,
    everywhere,
    load,
    lowest_bit,
    multiply_add,
    store,
)
from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS, MOST_RANGES, adjacent_ranges
from pcsmooth.kernels.threads import shared_out

#: Columns of moments: w, w n, w x, the upper triangle of w x x^T, rows of w n x^T.
WEIGHT = 0
NORMAL = 1
PLACE = 4
PLACES = 7
TURN = 13
N_MOMENTS = 24  # two are left over, to fill three registers

#: Columns of an estimate: normal, k1, k2, (k1 + k2) / 2, k1 k2, confidence.
PRINCIPAL = 3
MEAN = 5
GAUSSIAN = 6
CONFIDENCE = 7
N_ESTIMATES = 8

#: A neighbourhood tells nothing along a tangent if its standard deviation there is less than this
#: share of that along the other, or both are less than this share of its radius.
_THIN = 0.03


@inner
def add_place(moments, row, weight, nx, ny, nz, x, y, z):
    """Add a normal at a place."""
    moments[row, WEIGHT] += weight
    moments[row, PLACE] += weight * x
    moments[row, PLACE + 1] += weight * y
    moments[row, PLACE + 2] += weight * z
    moments[row, PLACES] += weight * x * x
    moments[row, PLACES + 1] += weight * x * y
    moments[row, PLACES + 2] += weight * x * z
    moments[row, PLACES + 3] += weight * y * y
    moments[row, PLACES + 4] += weight * y * z
    moments[row, PLACES + 5] += weight * z * z
    for axis in range(3):
        n = weight * (nx if axis == 0 else (ny if axis == 1 else nz))
        moments[row, NORMAL + axis] += n
        moments[row, TURN + 3 * axis] += n * x
        moments[row, TURN + 3 * axis + 1] += n * y
        moments[row, TURN + 3 * axis + 2] += n * z


def cluster_moments(
    coordinates: npt.NDArray[np.float64],
    order: npt.NDArray[np.int64],
    cell_starts: npt.NDArray[np.int64],
    normals: npt.NDArray[np.float64],
    weights: npt.NDArray[np.float64],
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Moments of the clusters: the points of a cell, those that face the other way apart.

    Parameters: coordinates (3, n) in the order of the cells, numbers (n,) and starts (m + 1,);
    normals (3, n) and weights (n,) by number. Returns the starts of the cells' clusters (m + 1,),
    the moments of each cluster about its centroid (c, N_MOMENTS), which in the columns PLACE have
    the centroid itself.
    """
    faces = np.empty(order.size, np.bool_)
    counts = np.empty(cell_starts.size - 1, np.int64)
    _count_clusters(order, cell_starts, normals, faces, counts)
    cluster_starts = np.concatenate([[0], np.cumsum(counts)])
    moments = np.zeros((cluster_starts[-1], N_MOMENTS))
    _sum_clusters(coordinates, order, cell_starts, normals, weights, faces, cluster_starts, moments)
    return cluster_starts, moments


@shared_out("counts")
@kernel("i1 i1 f2 b1 i1 i i")
def _count_clusters(order, cell_starts, normals, faces, counts, first, last):
    """Find which points face as the first of their cell does (n,); count clusters by cell (m,)."""
    for cell in range(first, last):
        counts[cell] = 1
        begin = order[cell_starts[cell]]
        for k in range(cell_starts[cell], cell_starts[cell + 1]):
            i = order[k]
            faces[k] = (
                normals[0, begin] * normals[0, i]
                + normals[1, begin] * normals[1, i]
                + normals[2, begin] * normals[2, i]
                >= 0.0
            )
            if not faces[k]:
                counts[cell] = 2


@shared_out("cell_starts")
@kernel("f2 i1 i1 f2 f1 b1 i1 f2 i i")
def _sum_clusters(
    coordinates, order, cell_starts, normals, weights, faces, cluster_starts, moments, first, last
):  # fmt: skip
    """Fill in the moments of the clusters of some cells."""
    for cell in range(first, last):
        for side in range(cluster_starts[cell + 1] - cluster_starts[cell]):
            row = cluster_starts[cell] + side
            total = x = y = z = 0.0
            for k in range(cell_starts[cell], cell_starts[cell + 1]):
                if faces[k] == (side == 0):
                    weight = weights[order[k]]
                    total += weight
                    x += weight * coordinates[0, k]
                    y += weight * coordinates[1, k]
                    z += weight * coordinates[2, k]
            if total > 0.0:
                x /= total
                y /= total
                z /= total
            else:
                x = np.inf  # beyond any reach
            for k in range(cell_starts[cell], cell_starts[cell + 1]):
                if faces[k] == (side == 0) and total > 0.0:
                    i = order[k]
                    add_place(
                        moments, row, weights[i], normals[0, i], normals[1, i], normals[2, i],
                        coordinates[0, k] - x, coordinates[1, k] - y, coordinates[2, k] - z,
                    )  # fmt: skip
            moments[row, PLACE] = x
            moments[row, PLACE + 1] = y
            moments[row, PLACE + 2] = z


@inner
def _move(source, row, ox, oy, oz, target, place):
    """Copy a cluster's moments, taken about another origin."""
    weight = source[row, WEIGHT]
    x = source[row, PLACE] - ox
    y = source[row, PLACE + 1] - oy
    z = source[row, PLACE + 2] - oz
    target[place, WEIGHT] = weight
    target[place, PLACE] = weight * x
    target[place, PLACE + 1] = weight * y
    target[place, PLACE + 2] = weight * z
    target[place, PLACES] = source[row, PLACES] + weight * x * x
    target[place, PLACES + 1] = source[row, PLACES + 1] + weight * x * y
    target[place, PLACES + 2] = source[row, PLACES + 2] + weight * x * z
    target[place, PLACES + 3] = source[row, PLACES + 3] + weight * y * y
    target[place, PLACES + 4] = source[row, PLACES + 4] + weight * y * z
    target[place, PLACES + 5] = source[row, PLACES + 5] + weight * z * z
    for axis in range(3):
        n = source[row, NORMAL + axis]
        target[place, NORMAL + axis] = n
        target[place, TURN + 3 * axis] = source[row, TURN + 3 * axis] + n * x
        target[place, TURN + 3 * axis + 1] = source[row, TURN + 3 * axis + 1] + n * y
        target[place, TURN + 3 * axis + 2] = source[row, TURN + 3 * axis + 2] + n * z
    target[place, 22] = 0.0
    target[place, 23] = 0.0


@shared_out("blocks.codes")
@kernel("f2 i1 i1 i1 f2 cells f2 f2 i1 i f1 f1 f2 i i", cells=CELLS)
def fit_shape_operators(
    coordinates, order, cell_starts, cluster_starts, moments, blocks, points, normals, numbers,
    dimension, normal_radii, curvature_radii, estimates, first, last,
):  # fmt: skip
    """Fit normal and shape operator at every point to the clusters around its anchor.

    Parameters: coordinates (3, n) of the anchors in the order of their cells, numbers (n,), starts
    of the cells (m + 1,) and of their clusters (m + 1,), moments of the clusters; blocks of cells,
    of side >= the radii; points (3, n) and normals (3, n) by number; rows of estimates by number
    (n,), negative where there is nothing to fit; d; radii of the neighbourhoods for the normal and
    for the shape operator, (n,) by number or, if all are the same, (1,), the first not the larger.
    Fills these rows of estimates (m, N_ESTIMATES).
    """
    for block in range(first, last):
        is_wanted = False
        for k in range(cell_starts[blocks.starts[block]], cell_starts[blocks.starts[block + 1]]):
            is_wanted |= numbers[order[k]] >= 0
        if is_wanted:
            _fit_block(
                coordinates, order, cell_starts, cluster_starts, moments, blocks, block, points,
                normals, numbers, dimension, normal_radii, curvature_radii, estimates,
            )  # fmt: skip


@inner
def _fit_block(
    coordinates, order, cell_starts, cluster_starts, moments, blocks, block, points, normals,
    numbers, dimension, normal_radii, curvature_radii, estimates,
):  # fmt: skip
    """Do it for the anchors in one block of cells."""
    ranges = np.empty((2, MOST_RANGES), np.int64)
    n_ranges = adjacent_ranges(blocks, block, dimension, ranges)
    count = np.int64(0)
    for r in range(n_ranges):
        count += cluster_starts[ranges[1, r]] - cluster_starts[ranges[0, r]]
    own = cell_starts[blocks.starts[block]]
    ox = coordinates[0, own]
    oy = coordinates[1, own]
    oz = coordinates[2, own]
    near = np.empty((count, N_MOMENTS))
    sides = np.empty((6, count + WIDTH))  # centroid and mean normal of each cluster
    place = np.int64(0)
    for r in range(n_ranges):
        for row in range(cluster_starts[ranges[0, r]], cluster_starts[ranges[1, r]]):
            _move(moments, row, ox, oy, oz, near, place)
            for axis in range(3):
                sides[axis, place] = near[place, PLACE + axis] / near[place, WEIGHT]
                sides[3 + axis, place] = near[place, NORMAL + axis]
            place += 1
    for place in range(count, count + WIDTH):
        for row in range(6):
            sides[row, place] = np.inf

    sums = np.empty((2, N_MOMENTS))
    taper = np.empty((2, WIDTH))
    for k in range(own, cell_starts[blocks.starts[block + 1]]):
        i = order[k]
        if numbers[i] < 0:
            continue
        normal_radius = normal_radii[i] if normal_radii.size > 1 else normal_radii[0]
        curvature_radius = curvature_radii[i] if curvature_radii.size > 1 else curvature_radii[0]
        normal_radius2 = normal_radius * normal_radius
        curvature_radius2 = curvature_radius * curvature_radius
        nx = normals[0, i]
        ny = normals[1, i]
        nz = normals[2, i]
        x = coordinates[0, k] - ox
        y = coordinates[1, k] - oy
        z = coordinates[2, k] - oz
        inner_a = inner_b = inner_c = outer_a = outer_b = outer_c = everywhere(0.0)
        for c in range(0, count, WIDTH):
            dx = load(sides, 0, c) - x
            dy = load(sides, 1, c) - y
            dz = load(sides, 2, c) - z
            square = multiply_add(dz, dz, multiply_add(dy, dy, dx * dx))
            facing = load(sides, 3, c) * nx + load(sides, 4, c) * ny + load(sides, 5, c) * nz
            alike = facing > 0.0
            left = bits((square < curvature_radius2) & alike)
            inner = bits((square < normal_radius2) & alike)
            store(taper, 0, 0, 1.0 - square / curvature_radius2)
            store(taper, 1, 0, 1.0 - square / normal_radius2)
            while left != 0:
                lane = lowest_bit(left)
                left &= left - 1
                a = load(near, c + lane, 0)
                b = load(near, c + lane, 8)
                d = load(near, c + lane, 16)
                outer = taper[0, lane]
                outer_a = multiply_add(a, outer, outer_a)
                outer_b = multiply_add(b, outer, outer_b)
                outer_c = multiply_add(d, outer, outer_c)
                if (inner >> lane) & 1:
                    near_weight = taper[1, lane]
                    inner_a = multiply_add(a, near_weight, inner_a)
                    inner_b = multiply_add(b, near_weight, inner_b)
                    inner_c = multiply_add(d, near_weight, inner_c)
        store(sums, 0, 0, inner_a)
        store(sums, 0, 8, inner_b)
        store(sums, 0, 16, inner_c)
        store(sums, 1, 0, outer_a)
        store(sums, 1, 8, outer_b)
        store(sums, 1, 16, outer_c)
        px = points[0, i] - ox
        py = points[1, i] - oy
        pz = points[2, i] - oz
        nx, ny, nz = fit_normal(sums, 0, nx, ny, nz, px, py, pz, dimension, normal_radius)
        ee, ff, ef, residual = fit_shape(sums, 1, nx, ny, nz, dimension, curvature_radius)
        _write(nx, ny, nz, ee, ff, ef, residual, dimension, estimates, numbers[i])


@inner
def tangents(nx, ny, nz, dimension):
    """Two unit vectors perpendicular to a unit normal and each other; in 2D the second is z."""
    if dimension == 2:
        return -ny, nx, 0.0, 0.0, 0.0, 1.0
    # Duff et al. (2017): no case where the normal is near an axis.
    sign = math.copysign(1.0, nz)
    a = -1.0 / (sign + nz)
    b = nx * ny * a
    return 1.0 + sign * nx * nx * a, sign * b, -sign * nx, b, sign + ny * ny * a, -ny


@inner
def _turning(sums, row, ex, ey, ez, fx, fy, fz, dimension, radius):
    """Fit the derivatives of the normal along two tangents, by least squares.

    Returns d_e n, d_f n, and the variance of the normals that they explain, -1 where the
    neighbourhood has no extent along a tangent.
    """
    weight = sums[row, WEIGHT]
    x = sums[row, PLACE] / weight
    y = sums[row, PLACE + 1] / weight
    z = sums[row, PLACE + 2] / weight
    xx = sums[row, PLACES] / weight - x * x
    xy = sums[row, PLACES + 1] / weight - x * y
    xz = sums[row, PLACES + 2] / weight - x * z
    yy = sums[row, PLACES + 3] / weight - y * y
    yz = sums[row, PLACES + 4] / weight - y * z
    zz = sums[row, PLACES + 5] / weight - z * z
    # Covariance of the tangential positions.
    gx = xx * ex + xy * ey + xz * ez
    gy = xy * ex + yy * ey + yz * ez
    gz = xz * ex + yz * ey + zz * ez
    ee = gx * ex + gy * ey + gz * ez
    ef = gx * fx + gy * fy + gz * fz
    ff = (
        (xx * fx + xy * fy + xz * fz) * fx
        + (xy * fx + yy * fy + yz * fz) * fy
        + (xz * fx + yz * fy + zz * fz) * fz
    )
    inverse = 1.0 / radius  # in units of the radius nothing overflows
    ee *= inverse * inverse
    ef *= inverse * inverse
    ff *= inverse * inverse
    if dimension == 2:
        if not ee > _THIN * _THIN:
            return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0
        a = 1.0 / ee
        b = c = 0.0
    else:
        determinant = ee * ff - ef * ef
        spread = ee + ff
        if not (spread > _THIN * _THIN and determinant > _THIN * _THIN * spread * spread):
            return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0
        a = ff / determinant
        b = -ef / determinant
        c = ee / determinant
    # Covariance of normal and tangential position, a column for each tangent.
    n = sums[row, NORMAL] / weight
    t = TURN
    hx = sums[row, t] / weight - n * x
    hy = sums[row, t + 1] / weight - n * y
    hz = sums[row, t + 2] / weight - n * z
    xe = (hx * ex + hy * ey + hz * ez) * inverse
    xf = (hx * fx + hy * fy + hz * fz) * inverse
    n = sums[row, NORMAL + 1] / weight
    hx = sums[row, t + 3] / weight - n * x
    hy = sums[row, t + 4] / weight - n * y
    hz = sums[row, t + 5] / weight - n * z
    ye = (hx * ex + hy * ey + hz * ez) * inverse
    yf = (hx * fx + hy * fy + hz * fz) * inverse
    n = sums[row, NORMAL + 2] / weight
    hx = sums[row, t + 6] / weight - n * x
    hy = sums[row, t + 7] / weight - n * y
    hz = sums[row, t + 8] / weight - n * z
    ze = (hx * ex + hy * ey + hz * ez) * inverse
    zf = (hx * fx + hy * fy + hz * fz) * inverse
    ax = a * xe + b * xf
    ay = a * ye + b * yf
    az = a * ze + b * zf
    bx = b * xe + c * xf
    by = b * ye + c * yf
    bz = b * ze + c * zf
    explained = ax * xe + ay * ye + az * ze + bx * xf + by * yf + bz * zf
    return (
        ax * inverse, ay * inverse, az * inverse,
        bx * inverse, by * inverse, bz * inverse,
        explained,
    )  # fmt: skip


@inner
def fit_normal(sums, row, nx, ny, nz, px, py, pz, dimension, radius):
    """Find the unit normal at p that fits the moments in a row, starting from a first one."""
    weight = sums[row, WEIGHT]
    if not weight > 0.0:
        return nx, ny, nz
    dx = px - sums[row, PLACE] / weight
    dy = py - sums[row, PLACE + 1] / weight
    dz = pz - sums[row, PLACE + 2] / weight
    ex, ey, ez, fx, fy, fz = tangents(nx, ny, nz, dimension)
    ax, ay, az, bx, by, bz, _explained = _turning(
        sums, row, ex, ey, ez, fx, fy, fz, dimension, radius
    )
    e = dx * ex + dy * ey + dz * ez
    f = dx * fx + dy * fy + dz * fz
    x = sums[row, NORMAL] / weight + ax * e + bx * f
    y = sums[row, NORMAL + 1] / weight + ay * e + by * f
    z = sums[row, NORMAL + 2] / weight + az * e + bz * f
    length = math.sqrt(x * x + y * y + z * z)
    if not length > 0.0:
        return nx, ny, nz
    return x / length, y / length, z / length


@inner
def fit_shape(sums, row, nx, ny, nz, dimension, radius):
    """Fit the shape operator in the tangents' frame to the moments in a row.

    Returns W_ee, W_ff, W_ef and the variance of the normals that the fit leaves; that is 1 where
    there is no neighbourhood or it is too thin.
    """
    weight = sums[row, WEIGHT]
    if not weight > 0.0:
        return 0.0, 0.0, 0.0, 1.0
    ex, ey, ez, fx, fy, fz = tangents(nx, ny, nz, dimension)
    ax, ay, az, bx, by, bz, explained = _turning(
        sums, row, ex, ey, ez, fx, fy, fz, dimension, radius
    )
    if explained < 0.0:
        return 0.0, 0.0, 0.0, 1.0
    ee = ax * ex + ay * ey + az * ez
    ff = bx * fx + by * fy + bz * fz
    ef = 0.5 * (ax * fx + ay * fy + az * fz + bx * ex + by * ey + bz * ez)
    x = sums[row, NORMAL] / weight
    y = sums[row, NORMAL + 1] / weight
    z = sums[row, NORMAL + 2] / weight
    return ee, ff, ef, max(0.0, 1.0 - x * x - y * y - z * z - explained)


@inner
def _write(nx, ny, nz, ee, ff, ef, residual, dimension, estimates, row):
    """Put an estimate into its row."""
    estimates[row, 0] = nx
    estimates[row, 1] = ny
    estimates[row, 2] = nz
    mean = ee
    spread = 0.0
    if dimension == 3:
        mean = 0.5 * (ee + ff)
        spread = math.sqrt(0.25 * (ee - ff) * (ee - ff) + ef * ef)
    estimates[row, PRINCIPAL] = mean + spread
    estimates[row, PRINCIPAL + 1] = mean - spread
    estimates[row, MEAN] = mean
    estimates[row, GAUSSIAN] = (mean + spread) * (mean - spread) if dimension == 3 else mean
    estimates[row, CONFIDENCE] = max(0.0, 1.0 - math.sqrt(residual))
