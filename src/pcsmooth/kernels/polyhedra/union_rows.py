"""Layout of the rows that the kernels of polyhedra write, and what goes to rows of other blocks."""

import numpy as np

from pcsmooth.kernels.compiled import inner, kernel

#: Columns of a point's row. Of VOLUME_SHARE only the sum is meant: the union's volume. In the rows
#: of restricted cells it is the volume of the cell.
VISIBLE_AREA = 0
VOLUME_SHARE = 1
VOLUME_GRADIENT = 2
AREA_GRADIENT = 5
VOLUME_DIAGONAL = 8
AREA_DIAGONAL = 9
N_COLUMNS = 10


@inner
def spill_arrays(room):
    """Make room for rows that other blocks' points get: numbers of the points, and the rows."""
    return np.empty(room, np.int64), np.zeros((room, N_COLUMNS))


@inner
def grown_spill(spilled, spilled_rows, n_spilled, wanted):
    """Make larger arrays and copy the spilled rows into them."""
    more, more_rows = spill_arrays(2 * wanted)
    for s in range(n_spilled):
        more[s] = spilled[s]
        for column in range(N_COLUMNS):
            more_rows[s, column] = spilled_rows[s, column]
    return more, more_rows


@inner
def row_of(target, start, stop, rows, spilled, spilled_rows, n_spilled):
    """Find the row to add to for a point: its own in this block, or a new one to be spilled.

    Returns the array, the row in it, and the number of spilled rows.
    """
    if start <= target < stop:
        return rows, target - start, n_spilled
    spilled[n_spilled] = target
    return spilled_rows, n_spilled, n_spilled + 1


@kernel("f2 i1 f2")
def add_spilled(rows, spilled, spilled_rows):
    """Add spilled rows to the rows of all points, in their order."""
    for s in range(spilled.size):
        for column in range(N_COLUMNS):
            rows[spilled[s], column] += spilled_rows[s, column]
