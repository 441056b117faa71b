"""The alpha-complex of a cloud: simplices of the Delaunay triangulation, up to a radius."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.energies.centers import Centers, place_centers
from pcsmooth.energies.polyhedra.body_tables import body_tables
from pcsmooth.errors import PcsmoothError
from pcsmooth.kernels.polyhedra.polyhedron_intersections import list_simplices
from pcsmooth.kernels.threads import map_blocks
from pcsmooth.neighbors.grid import cube_starts
from pcsmooth.unit_of_length import unit_near

#: Digits to which coordinates are rounded, so that their differences are exact.
DIGITS = 51

#: Largest weight of a point, in units of r^2: far below what coordinates can tell, far above what
#: pairs of floats can. A point nearer to others than 1e-12 r may be left without a cell.
_LARGEST_WEIGHT = 1e-24

#: Box that stars are cut from, in units of r; its edges are no multiples of each other, lest it
#: share corners with a grid.
_BOX = ConvexBody(np.vstack([np.eye(3), -np.eye(3)]), [4.13, 3.97, 4.29, 4.21, 4.07, 4.33])


def find_simplices(
    points: npt.ArrayLike, radius: float
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Find the alpha-complex of a cloud, alpha being the radius (report, Definition 2).

    A simplex of the Delaunay triangulation belongs to it if the Voronoi face that its points
    share comes as near to them as the radius. Ties, of points that are cospherical, on a grid or
    coplanar, are decided by the positions alone, as if every point had a tiny weight.

    Parameters
    ----------
    points : array_like of float, shape (n, 2) or (n, 3)
        Finite positions, L, n >= 1; coincident points count as the first of them.
    radius : float
        Radius, L, > 0.

    Returns
    -------
    edges, triangles, tetrahedra : ndarray of int, shapes (e, 2), (t, 3), (q, 4)
        Numbers of points, each row increasing, the rows in lexicographic order.

    Raises
    ------
    InvalidInputError
        As `measure_polyhedra` does.
    """
    unit = unit_near(radius)
    centers = place_centers(points, radius, radius, unit=unit, digits=DIGITS)
    numbers = centers.distinct[centers.grid.order]
    list_block = AlphaComplex(centers, radius / unit).list_block
    starts = cube_starts(centers.grid, centers.dimension)
    rows = np.concatenate(list(map_blocks(list_block, starts)))
    simplices = np.where(rows >= 0, numbers[rows], -1)
    sizes = (simplices >= 0).sum(axis=1)
    by_size = []
    for size in (2, 3, 4):
        chosen = np.sort(simplices[sizes == size, :size], axis=1)
        by_size.append(chosen[np.lexsort(chosen.T[::-1])])
    return by_size[0], by_size[1], by_size[2]


class AlphaComplex:
    """The simplices of a cloud, listed block by block as they are asked for.

    Parameters
    ----------
    centers : Centers
        Positions with coordinates of `DIGITS` digits, and a reach of the radius or more.
    radius : float
        Radius, in the unit of the positions.
    """

    def __init__(self, centers: Centers, radius: float) -> None:
        grid = centers.grid
        box = body_tables(_BOX, radius)
        weights = _LARGEST_WEIGHT * radius**2 * _scattered(grid.coordinates)
        self._arguments = (
            grid.coordinates, grid.cells, centers.dimension, radius,
            weights, box.polyhedron, box.normals, box.offsets,
        )  # fmt: skip

    def list_block(self, start: int, stop: int) -> npt.NDArray[np.int64]:
        """List the simplices whose lowest point in grid order is one of a block, (s, 4).

        Points have their numbers in grid order; -1 fills up. Single points are simplices too.

        Raises
        ------
        PcsmoothError
            If the star of a point contradicts itself.
        """
        simplices, n_torn = list_simplices(*self._arguments, start, stop)
        if n_torn > 0:
            raise PcsmoothError(
                f"the Delaunay triangulation is not clear at {n_torn} points; use another radius "
                "or the exact union"
            )
        return np.asarray(simplices)


def _scattered(coordinates: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Numbers from 0 to 1 that look random and depend on nothing but a position, (n,)."""
    hashes = np.zeros(coordinates.shape[1], np.uint64)
    for column in (coordinates + 0.0).view(np.uint64):  # + 0.0 turns -0.0 into 0.0
        hashes ^= column
        for shift in (30, 27, 31):
            hashes ^= hashes >> np.uint64(shift)
            hashes *= np.uint64(0x9E3779B97F4A7C15)
    return np.ldexp((hashes >> np.uint64(11)).astype(np.float64), -53)
