"""Means over the neighbourhood of every point, of points that face the same way.

Points weigh |n_i . n_j|^e: the other side of an edge counts little; that of a thin sheet not at all
where it is known which side of it is outside.
"""

import math

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS
from pcsmooth.kernels.grid.within_reach import (
    NUMBER,
    X,
    Y,
    Z,
    points_around,
    select_within_reach,
)
from pcsmooth.kernels.threads import shared_out

#: What a mean is taken of: heights of the neighbours over the tangent plane; a length along
#: their normals; a number.
HEIGHT = 0
ALONG_NORMAL = 1
NUMBER_OF = 2


@shared_out("cells.codes")
@kernel("f2 cells i f2 i f1 i i f1 f1 f1 i i", cells=CELLS)
def neighborhood_means(
    coordinates, cells, dimension, normals, one_sided, squares, exponent, kind,
    values, means, variances, first, last,
):  # fmt: skip
    """Average over the points nearer than a radius.

    Parameters: coordinates (3, n) in grid order; cells of side >= the radii; d; unit normals (3,
    n); one_sided: whether points whose normals look the other way do not count; squares (n,) of the radii; exponent, even; kind: HEIGHT, ALONG_NORMAL (the sign of a value
    is that of its point's normal) or NUMBER_OF; values (n,), unused for heights. Fills means (n,),
    and of heights their variances (n,); a point counts itself.
    """
    for cell in range(first, last):
        _means_of_cell(
            coordinates, cells, cell, dimension, normals, one_sided, squares,
            exponent, kind, values, means, variances,
        )  # fmt: skip


@inner
def _means_of_cell(
    coordinates, cells, cell, dimension, normals, one_sided, squares, exponent, kind,
    values, means, variances,
):  # fmt: skip
    """Do it for the points of one cell."""
    candidates, n_candidates, near = points_around(coordinates, cells, cell, dimension)
    for i in range(cells.starts[cell], cells.starts[cell + 1]):
        n_near = select_within_reach(
            candidates, n_candidates, coordinates[0, i], coordinates[1, i], coordinates[2, i],
            math.sqrt(squares[i]), near,
        )  # fmt: skip
        nx = normals[0, i]
        ny = normals[1, i]
        nz = normals[2, i]
        total = 1.0
        mean = 0.0 if kind == HEIGHT else values[i]
        mean_square = 0.0
        for k in range(n_near):
            j = int(near[NUMBER, k])
            cosine = nx * normals[0, j] + ny * normals[1, j] + nz * normals[2, j]
            if one_sided and cosine < 0.0:
                continue
            weight = _power(cosine * cosine, exponent)
            total += weight
            if kind == HEIGHT:
                height = nx * near[X, k] + ny * near[Y, k] + nz * near[Z, k]
                mean += weight * height
                mean_square += weight * height * height
            elif kind == ALONG_NORMAL:
                mean += math.copysign(weight, cosine) * values[j]
            else:
                mean += weight * values[j]
        mean /= total
        means[i] = mean
        if kind == HEIGHT:
            variances[i] = max(mean_square / total - mean * mean, 0.0)


@inner
def _power(square, exponent):
    """Return |cosine|^exponent from its square; the exponent is even."""
    weight = square
    for _ in range(exponent // 2 - 1):
        weight *= square
    return weight
