"""Cell normals of a cloud, found as the estimates find them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oracles import Array
from pcsmooth.curvature.cell_normals import CELLS, CellNormals, find_cell_normals
from pcsmooth.energies.balls import BallUnion, measure_balls


@dataclass(frozen=True)
class Found:
    """Cell normals of distinct points in the order of a grid."""

    points: Array  # (3, n)
    order: npt.NDArray[np.int64]
    union: BallUnion
    cells: CellNormals


def find(points: Array, radius: float, count: int | None = None) -> Found:
    union = measure_balls(points, radius)
    grid = union.grid
    dimension = points.shape[1]
    members = count or CELLS[dimension][0]
    cells = find_cell_normals(grid, grid.order, union, dimension, members, 2.0 * radius)
    return Found(grid.coordinates, grid.order, union, cells)


def facing(found: Found, outward: Array) -> Found:
    """The same with the signs of known normals (n, d), by the points' own numbers."""
    normals = found.cells.normals
    dimension = outward.shape[1]
    normals *= np.sign(np.einsum("ij,ij->j", normals[:dimension], outward[found.order].T))
    return found
