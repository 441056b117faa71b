"""A normal for every point, from the visible boundary of the cells around it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.balls import BallUnion
from pcsmooth.kernels.surface.cell_normals import N_TERMS, gather_terms, normals_from_cells
from pcsmooth.neighbors.grid import Grid
from pcsmooth.unit_of_length import power_of_two_near

#: Points whose cells give a normal, the point itself included, by dimension; the smaller number
#: is taken where the normals of the larger are smoother than the surface.
CELLS = {2: (5,), 3: (30, 8)}

#: Room for the nearest points along which the sign of a normal is handed on.
_LINKS = 10


@dataclass(frozen=True)
class CellNormals:
    """Normals of the points of a grid, in grid order.

    Attributes
    ----------
    normals : ndarray, shape (3, n)
        Unit normals of either sign (z = 0 in 2D); 0 where none is known: for a point that no
        other touches or whose neighbourhood has no visible boundary.
    anchors : ndarray, shape (3, n)
        Where they hold, L: each point moved along the surface to the centroid of the cells.
    links : ndarray of int32, shape (n, 10)
        The 8 to 10 nearest other points, n where there are no more.
    weights : ndarray, shape (n,)
        Volume of each point's cell, in a unit near that of the ball, if radii differ over the
        radius; 0 where there is no normal.
    squares : ndarray, shape (n,)
        Squared radii of the neighbourhoods, L^2.
    """

    normals: npt.NDArray[np.float64]
    anchors: npt.NDArray[np.float64]
    links: npt.NDArray[np.int32]
    weights: npt.NDArray[np.float64]
    squares: npt.NDArray[np.float64]

    @cached_property
    def extent(self) -> float:
        """Median radius of the neighbourhoods, L."""
        return float(np.sqrt(np.median(self.squares)))


def extent_of_even_points(count: int, dimension: int) -> float:
    """Radius, in spacings, of a neighbourhood of so many points on a surface or curve."""
    return math.sqrt(count / math.pi) if dimension == 3 else count / 2.0


def find_cell_normals(
    grid: Grid,
    numbers: npt.NDArray[np.int64],
    union: BallUnion,
    dimension: int,
    count: int,
    reach: float | npt.NDArray[np.float64],
) -> CellNormals:
    """Find normals from the tensors of the visible boundary, summed over the nearest cells.

    Parameters
    ----------
    grid : Grid
        The points that carry cells, in cells not smaller than their reach.
    numbers : ndarray of int, shape (n,)
        Numbers in the union of the points in grid order.
    union : BallUnion
        Its normal tensors and cell volumes.
    dimension : int
        d.
    count : int
        Points of a neighbourhood, >= 2; more if several are equally far.
    reach : float or ndarray, shape (n,)
        Points nearer than this count, L: twice the radius of the ball, of each if radii differ.

    Returns
    -------
    CellNormals

    Notes
    -----
    The normal is the leading eigenvector of sum_j T_j, T_j the integral of n n^T over the visible
    boundary of cell j, over the `count` nearest points. It errs by the random shape of the
    neighbourhood as much as by the noise; that it belongs to the neighbourhood's centroid rather
    than to the point takes most of the former away.
    """
    volumes = union.cell_volumes
    if union.radii is not None:  # of the surface a cell has its volume over its thickness
        volumes = volumes * (union.radius / union.radii)
    unit = power_of_two_near(union.radius) ** dimension  # products with lengths must not overflow
    n = len(numbers)
    terms = np.zeros((n, N_TERMS))
    gather_terms(grid.coordinates, union.tensor_entries, volumes, numbers, unit, terms)
    normals, anchors, weights, squares = (
        np.empty((3, n)),
        np.empty((3, n)),
        np.empty(n),
        np.empty(n),
    )
    links = np.empty((n, _LINKS), np.int32)
    normals_from_cells(
        grid.coordinates,
        grid.cells,
        dimension,
        count,
        np.atleast_1d(reach),
        terms,
        links,
        normals,
        anchors,
        weights,
        squares,
    )
    return CellNormals(normals, anchors, links, weights, squares)
