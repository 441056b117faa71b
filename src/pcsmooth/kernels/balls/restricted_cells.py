"""Measures of all restricted cells of a cloud, each facet and each edge computed once.

The points come in grid order. They are cut into blocks, which the threads share out; what lies
between points of one block is computed once and booked for all of them, what leaves the block is
computed by every block that it touches. Sums are therefore formed in an order that does not
depend on the number of threads.
"""

import math

from pcsmooth.kernels.balls.cells_2d import sum_cells_2d
from pcsmooth.kernels.balls.cells_3d import sum_cells_3d
from pcsmooth.kernels.balls.facet_booking import (
    AREA_DIAGONAL,
    CELL_VOLUME,
    NORMAL_TENSOR,
    VISIBLE_AREA,
    VOLUME_DIAGONAL,
)
from pcsmooth.kernels.balls.facet_booking import N_MEASURES as N_MEASURES
from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.grid.grid import CELLS
from pcsmooth.kernels.threads import shared_out


@shared_out("block_starts")
@kernel("f2 i1 cells i1 i f n f2 i i", "f2 i1 cells i1 i f f1 f2 i i", cells=CELLS)
def measure_restricted_cells(
    coordinates, order, cells, block_starts, dimension, radius, radii, measures, first, last
):  # fmt: skip
    """Measure every restricted cell V_i and B(p_i, r_i) of distinct points.

    Parameters: coordinates (3, n) in grid order (cells of side >= 2 r_i); order (n,), the original
    number of each; cells; starts of the blocks (b + 1,); d; r; radii (n,) in
    grid order, None if all are r; measures (n, N_MEASURES), which are filled in original order.
    """
    for block in range(first, last):
        start = block_starts[block]
        stop = block_starts[block + 1]
        if dimension == 3:
            sums = sum_cells_3d(coordinates, cells, radius, radii, start, stop)
        else:
            sums = sum_cells_2d(coordinates, cells, radius, radii, start, stop)
        for i in range(start, stop):
            if radii is not None:
                radius = radii[i]
            _close_cell(sums, i - start, dimension, radius, measures, order[i])


@inner
def _close_cell(sums, row, dimension, radius, out, target):
    """Turn the sums over the facets of one cell into its measures.

    With Omega the solid angles of the facets and h their heights: S = r^(d-1) (full - sum
    Omega), |C| = (r S + sum h A) / d, T = (|C| I - sum A u (x) c) / r.
    """
    for k in range(N_MEASURES):
        out[target, k] = sums[row, k]
    full = 4.0 * math.pi if dimension == 3 else 2.0 * math.pi
    sphere = radius * radius if dimension == 3 else radius
    visible = max(0.0, sphere * (full - sums[row, VISIBLE_AREA]))
    if sums[row, VOLUME_DIAGONAL] > 0.0 and sums[row, AREA_DIAGONAL] == 0.0:
        visible = 0.0  # no facet reaches the sphere: it is covered, rounding aside
    volume = (radius * visible + sums[row, CELL_VOLUME]) / dimension
    out[target, VISIBLE_AREA] = visible
    out[target, CELL_VOLUME] = volume
    for k in range(6):
        out[target, NORMAL_TENSOR + k] = (
            -sums[row, NORMAL_TENSOR + k] / radius if visible > 0.0 else 0.0
        )
    if visible > 0.0:
        out[target, NORMAL_TENSOR] += volume / radius
        out[target, NORMAL_TENSOR + 3] += volume / radius
        if dimension == 3:
            out[target, NORMAL_TENSOR + 5] += volume / radius
