"""The plane through the neighbourhood of every point: how large it is, and its normal."""

import math

import numpy as np

from pcsmooth.kernels.arithmetic.leading_direction import leading_direction
from pcsmooth.kernels.arithmetic.simd import WIDTH, bits, count_bits, load
from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS
from pcsmooth.kernels.grid.within_reach import (
    SQUARE,
    X,
    Y,
    Z,
    pad_neighbors,
    points_around,
    select_within_reach,
)
from pcsmooth.kernels.threads import shared_out

#: Halvings of the interval in which the radius of a neighbourhood is looked for.
_HALVINGS = 12

#: Radius within which the neighbourhood of a point is looked for first, in units of that of the
#: point before it.
_LARGER = 1.25


@shared_out("cells.codes")
@kernel("f2 cells i f f1 f1 f1 f2 f1 f1 f1 i i", cells=CELLS)
def fit_planes(
    coordinates, cells, dimension, count, thickness, min_radii, max_radii, normals, squares,
    sizes, offsets, first, last,
):  # fmt: skip
    """Fit a plane (a line in 2D) to the neighbourhood of every point.

    Parameters: coordinates (3, n) of distinct points in grid order (cells of side >= max_radius);
    d; count and thickness: the radius R of
    a neighbourhood of N points is the least for which N (1 - (thickness / R)^(d - 1)) >= count,
    but not more than max_radius. Filled: normals (3, n), of either sign, 0 where there is none;
    squares (n,) of the radii; sizes (n,), the number of points, itself included; offsets (n,),
    the distance to their centroid over the radius.
    """
    for cell in range(first, last):
        _fit_planes_of_cell(
            coordinates, cells, cell, dimension, count, thickness,
            min_radii, max_radii, normals, squares, sizes, offsets,
        )  # fmt: skip


@inner
def _fit_planes_of_cell(
    coordinates, cells, cell, dimension, count, thicknesses, min_radii, max_radii, normals,
    squares, sizes, offsets,
):  # fmt: skip
    """Do it for the points of one cell."""
    candidates, n_candidates, near = points_around(coordinates, cells, cell, dimension)
    within = np.inf
    for i in range(cells.starts[cell], cells.starts[cell + 1]):
        thickness = thicknesses[i]
        min_radius = min_radii[i]
        max_radius = max_radii[i]
        within = min(max_radius, max(within, min_radius))
        x = coordinates[0, i]
        y = coordinates[1, i]
        z = coordinates[2, i]
        n_near = select_within_reach(candidates, n_candidates, x, y, z, within, near)
        is_wide = _covered(n_near + 1, within * within, dimension, thickness) >= count
        if within < max_radius and not is_wide:
            within = max_radius
            n_near = select_within_reach(candidates, n_candidates, x, y, z, within, near)
        pad_neighbors(near, n_near)
        limit = _neighborhood(
            near, n_near, within, dimension, count, thickness, min_radius, max_radius
        )
        # Neighbouring points have neighbourhoods of about the same size.
        within = _LARGER * math.sqrt(limit)
        mx = my = mz = xx = xy = xz = yy = yz = zz = 0.0
        size = 1.0
        for k in range(n_near):
            if near[SQUARE, k] < limit:
                x = near[X, k]
                y = near[Y, k]
                z = near[Z, k]
                size += 1.0
                mx += x
                my += y
                mz += z
                xx += x * x
                xy += x * y
                xz += x * z
                yy += y * y
                yz += y * z
                zz += z * z
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
def _neighborhood(near, n_near, within, dimension, count, thickness, min_radius, max_radius):
    """Squared radius of a neighbourhood: see `fit_planes`.

    near holds the neighbours nearer than `within`, which is max_radius or wide enough.
    """
    low = max(thickness, min_radius) ** 2
    high = max_radius * max_radius
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if within < max_radius and middle >= within * within:
            high = middle
            continue
        size = np.int64(1)
        for c in range(0, n_near, WIDTH):
            size += count_bits(bits(load(near, SQUARE, c) < middle))
        if _covered(size, middle, dimension, thickness) >= count:
            high = middle
        else:
            low = middle
    return high


@inner
def _covered(size, square, dimension, thickness):
    """Points of a neighbourhood of a squared radius less those that its thickness takes up."""
    share = thickness * thickness / square
    if dimension == 2:
        share = math.sqrt(share)
    return size * (1.0 - share)
