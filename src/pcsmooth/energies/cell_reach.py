"""How far the restricted cells of a union depend on points."""

from __future__ import annotations

from pcsmooth.neighbors.grid import CUBE_LEVEL

#: Cells around a cube that what happens in it depends on: two for the cells of its points, and two
#: for those of the points that share a facet with them.
_CELLS_AROUND = 4


def cell_reach(size: float, dimension: int) -> float:
    """How far the measures of a point's cell may depend on points, along an axis, L.

    Parameters
    ----------
    size : float
        Largest distance of a point of a shape from its centre, L: cells of the grid are twice
        as wide. Those of a cube are found together.
    dimension : int
        d.
    """
    return 2.0 * size * ((1 << CUBE_LEVEL[dimension]) + _CELLS_AROUND)
