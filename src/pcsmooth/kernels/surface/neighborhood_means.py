"""Means over the neighbourhood of every point, of points that face the same way.

Points weigh |n_i . n_j|^e: the other side of an edge counts little; that of a thin sheet not at all
where it is known which side of it is outside.
"""

import math

import numpy as np

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS
from pcsmooth.kernels.grid.within_reach import collect_around, list_within_reach
from pcsmooth.kernels.surface.neighbor_lists import no_candidates, with_room
from pcsmooth.kernels.threads import shared_out

#: What a mean is taken of: heights of the neighbours over the tangent plane; a length along
#: their normals; a number; the normals themselves, whatever their signs.
HEIGHT = 0
ALONG_NORMAL = 1
NUMBER_OF = 2
NORMAL = 3


@shared_out("cells.codes")
@kernel("f2 cells i f2 i f1 j1 i1 i i f1 f2 f1 i i", cells=CELLS)
def neighborhood_means(
    coordinates, cells, dimension, normals, one_sided, squares, numbers, ends, exponent, kind,
    values, means, variances, first, last,
):  # fmt: skip
    """Average over the points nearer than a radius.

    Parameters: coordinates (3, n) in grid order; cells of side >= the radii; d; unit normals (3,
    n); whether points whose normals show the other way do not count; squares (n,) of the radii;
    numbers of the neighbours of all points, and the ends (n,) of each one's, or nothing if they are
    to be looked for: of those that are listed within wider radii only NUMBER_OF leaves any out;
    exponent, even; kind: HEIGHT, ALONG_NORMAL (the sign of a value is that of its point's normal),
    NUMBER_OF or NORMAL; values (n,), unused for heights and normals. Fills means (1, n), of normals
    (3, n), and of heights their variances (n,); a point counts itself.
    """
    is_listed = ends.size > 0
    ranges, candidates = no_candidates()
    found = numbers if is_listed else np.empty(0, np.int32)
    for cell in range(first, last):
        n_candidates = 0
        if not is_listed:
            candidates, n_candidates = collect_around(
                coordinates, cells, cell, dimension, ranges, candidates
            )
            found = with_room(found, 0, n_candidates)
        for i in range(cells.starts[cell], cells.starts[cell + 1]):
            begin = 0
            if is_listed:
                begin = ends[i - 1] if i > 0 else 0
                end = ends[i]
            else:
                end = list_within_reach(
                    candidates, n_candidates, coordinates[0, i], coordinates[1, i],
                    coordinates[2, i], squares[i], found, 0,
                )  # fmt: skip
            _average(
                coordinates, normals, one_sided, squares, i, found, begin, end, exponent, kind,
                values, means, variances,
            )  # fmt: skip


@inner
def _average(
    coordinates, normals, one_sided, squares, i, numbers, start, end, exponent, kind, values, means,
    variances,
):  # fmt: skip  # fmt: skip
    """Do it for one point."""
    nx = normals[0, i]
    ny = normals[1, i]
    nz = normals[2, i]
    total = 1.0
    mean = mean_y = mean_z = mean_square = 0.0
    if kind == NORMAL:
        mean = nx
        mean_y = ny
        mean_z = nz
    elif kind != HEIGHT:
        mean = values[i]
    for k in range(start, end):
        j = numbers[k]
        mx = normals[0, j]
        my = normals[1, j]
        mz = normals[2, j]
        cosine = nx * mx + ny * my + nz * mz
        if one_sided and cosine < 0.0:
            continue
        weight = _power(cosine * cosine, exponent)
        if kind == ALONG_NORMAL:
            mean += math.copysign(weight, cosine) * values[j]
        elif kind == NORMAL:
            signed = math.copysign(weight, cosine)
            mean += signed * mx
            mean_y += signed * my
            mean_z += signed * mz
        else:
            x = coordinates[0, j] - coordinates[0, i]
            y = coordinates[1, j] - coordinates[1, i]
            z = coordinates[2, j] - coordinates[2, i]
            if kind == HEIGHT:
                height = nx * x + ny * y + nz * z
                mean += weight * height
                mean_square += weight * height * height
            elif x * x + y * y + z * z < squares[i]:
                mean += weight * values[j]
            else:
                continue
        total += weight
    mean /= total
    means[0, i] = mean
    if kind == HEIGHT:
        variances[i] = max(mean_square / total - mean * mean, 0.0)
    elif kind == NORMAL:
        means[1, i] = mean_y / total
        means[2, i] = mean_z / total


@inner
def _power(square, exponent):
    """Return |cosine|^exponent from its square; the exponent is even."""
    weight = square
    if exponent > 2:  # a loop for the usual ones would take a tenth of the time of a mean
        weight *= square
    if exponent > 4:
        weight *= square
    if exponent > 6:
        weight *= square
    for _ in range(exponent // 2 - 4):
        weight *= square
    return weight
