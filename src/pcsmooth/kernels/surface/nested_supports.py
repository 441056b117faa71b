"""Normals and shape operators of a few points, from neighbourhoods of growing radius."""

import numpy as np

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS, MOST_RANGES, adjacent_ranges, cell_of_point
from pcsmooth.kernels.surface.shape_operators import (
    N_MOMENTS,
    add_place,
    fit_normal,
    fit_shape,
)


@kernel("f2 i1 cells f2 f2 f1 i i1 f1 f1", cells=CELLS)
def fit_nested_supports(
    coordinates, order, cells, points, normals, weights, dimension, samples, extents, ratios
):
    """Fit normal and shape operator to all neighbourhoods of some points.

    Parameters: coordinates (3, n) of the anchors in grid order (cells of samples of side >= their
    largest radius), numbers (n,); points (3, n), normals (3, n) and weights (n,) by number; d;
    places of the samples in grid order (s,); their radii as extents (s,) times increasing ratios
    (k,). Returns normals (s, k, 3) and shape operators W_ee, W_ff, W_ef (s, k, 3), those of
    a sample all in the frame of its own normal.
    """
    fitted_normals = np.empty((samples.size, ratios.size, 3))
    shapes = np.empty((samples.size, ratios.size, 3))
    for s in range(samples.size):
        _fit_sample(
            coordinates, order, cells, points, normals, weights, dimension,
            samples[s], extents[s] * ratios, fitted_normals[s], shapes[s],
        )  # fmt: skip
    return fitted_normals, shapes


@inner
def _fit_sample(
    coordinates, order, cells, points, normals, weights, dimension,
    sample, radii, fitted_normals, shapes,
):  # fmt: skip
    """Do it for one point: moments of the rings between the radii, then their running sums."""
    ranges = np.empty((2, MOST_RANGES), np.int64)
    cell = cell_of_point(cells, sample)
    n_ranges = adjacent_ranges(cells, cell, dimension, ranges)
    i = order[sample]
    nx = normals[0, i]
    ny = normals[1, i]
    nz = normals[2, i]
    x = coordinates[0, sample]
    y = coordinates[1, sample]
    z = coordinates[2, sample]
    plain = np.zeros((radii.size, N_MOMENTS))
    squared = np.zeros((radii.size, N_MOMENTS))  # weighted by squared distances
    sums = np.empty((1, N_MOMENTS))
    inverse = 1.0 / radii[radii.size - 1]  # in units of the largest nothing overflows
    for r in range(n_ranges):
        for k in range(ranges[0, r], ranges[1, r]):
            j = order[k]
            dx = (coordinates[0, k] - x) * inverse
            dy = (coordinates[1, k] - y) * inverse
            dz = (coordinates[2, k] - z) * inverse
            square = dx * dx + dy * dy + dz * dz
            facing = nx * normals[0, j] + ny * normals[1, j] + nz * normals[2, j]
            if square < 1.0 and facing > 0.0:
                ring = 0
                while ring < radii.size - 1 and square >= (radii[ring] * inverse) ** 2:
                    ring += 1
                w = weights[j]
                ux = normals[0, j]
                uy = normals[1, j]
                uz = normals[2, j]
                add_place(plain, ring, w, ux, uy, uz, dx, dy, dz)
                add_place(squared, ring, w * square, ux, uy, uz, dx, dy, dz)
    for ring in range(radii.size):
        radius = radii[ring] * inverse
        for c in range(N_MOMENTS):
            if ring > 0:
                plain[ring, c] += plain[ring - 1, c]
                squared[ring, c] += squared[ring - 1, c]
            sums[0, c] = plain[ring, c] - squared[ring, c] / (radius * radius)
        ee, ff, ef, _residual = fit_shape(sums, 0, nx, ny, nz, dimension, radius)
        shapes[ring, 0] = ee * inverse
        shapes[ring, 1] = ff * inverse
        shapes[ring, 2] = ef * inverse
        ux, uy, uz = fit_normal(
            sums,
            0,
            nx,
            ny,
            nz,
            (points[0, i] - x) * inverse,
            (points[1, i] - y) * inverse,
            (points[2, i] - z) * inverse,
            dimension,
            radius,
        )
        fitted_normals[ring, 0] = ux
        fitted_normals[ring, 1] = uy
        fitted_normals[ring, 2] = uz
