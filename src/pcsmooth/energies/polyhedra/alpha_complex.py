"""The alpha-complex of a cloud: simplices of the Delaunay triangulation, up to a radius.

Of points with radii of their own it is that of the power diagram of their balls.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.energies.centers import Centers, place_centers
from pcsmooth.energies.polyhedra.body_tables import body_tables
from pcsmooth.energies.unequal_radii import unequal_radii
from pcsmooth.errors import PcsmoothError
from pcsmooth.kernels.polyhedra.polyhedron_intersections import list_simplices
from pcsmooth.kernels.threads import map_blocks
from pcsmooth.neighbors.grid import cube_starts
from pcsmooth.unit_of_length import unit_near

#: Digits to which coordinates are rounded, so that their differences are exact.
DIGITS = 51

#: Largest weight of a point beside its r^2, in units of the largest r^2: far below what coordinates
#: can tell, far above what pairs of floats can. A point nearer to others than 1e-12 r may be left
#: without a cell.
_LARGEST_WEIGHT = 1e-24

#: Box that stars are cut from, in units of r; its edges are no multiples of each other, lest it
#: share corners with a grid.
_BOX = ConvexBody(np.vstack([np.eye(3), -np.eye(3)]), [4.13, 3.97, 4.29, 4.21, 4.07, 4.33])


def find_simplices(
    points: npt.ArrayLike, radius: npt.ArrayLike
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Find the alpha-complex of a cloud, alpha being the radius (report, Definition 2).

    A simplex of the Delaunay triangulation belongs to it if the Voronoi face that its points
    share comes as near to them as the radius. Where each point has a radius of its own, power cells
    take the place of Voronoi cells, and each point's distance from the face is compared with
    its radius, which all of a simplex exceed or none; points whose cell does not come as near are
    in no simplex. Ties, of points that are cospherical, on a grid or
    coplanar, are decided by the positions alone, as if every point had a tiny weight.

    Parameters
    ----------
    points : array_like of float, shape (n, 2) or (n, 3)
        Finite positions, L, n >= 1; coincident points count as the first of them.
    radius : float or array_like of float, shape (n,)
        Radius, or radius of each point, L, > 0.

    Returns
    -------
    edges, triangles, tetrahedra : ndarray of int, shapes (e, 2), (t, 3), (q, 4)
        Numbers of points, each row increasing, the rows in lexicographic order.

    Raises
    ------
    InvalidInputError
        As `measure_polyhedra` does.
    """
    radii = unequal_radii(points, radius)
    largest = float(np.max(radius))
    unit = unit_near(largest)
    centers = place_centers(points, largest, largest, radii=radii, unit=unit, digits=DIGITS)
    numbers = centers.distinct[centers.grid.order]
    sizes = np.ones(len(numbers)) if radii is None else radii.values[numbers] / largest
    list_block = AlphaComplex(centers, largest / unit, sizes).list_block
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
        Largest radius, in the unit of the positions.
    sizes : ndarray, shape (n,)
        Radii of the points in grid order, in units of that.
    """

    def __init__(self, centers: Centers, radius: float, sizes: npt.NDArray[np.float64]) -> None:
        grid = centers.grid
        box = body_tables(_BOX, radius)
        scattered = _LARGEST_WEIGHT * radius**2 * _scattered(grid.coordinates)
        weights = np.stack([(radius * sizes) ** 2, scattered])
        self._arguments = (
            grid.coordinates, grid.cells, centers.dimension, radius, sizes,
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
