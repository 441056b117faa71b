"""The centres of a union's shapes, checked, without repetitions, and in a grid."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.kernels.grid.grid import bounding_box
from pcsmooth.neighbors.coincident import first_coincident_in
from pcsmooth.neighbors.grid import Grid, build_grid, levels_of, see_what_touches
from pcsmooth.neighbors.local_radii import UnequalRadii
from pcsmooth.positions import LARGEST, as_positions, local_origin, usable_rows

#: Coordinates below this, in units of the radius, are 0: their differences vanish when squared.
_SMALLEST = 1e-60

#: Halvings of the cells of the largest of unequal balls: of one a thousand times as large as the
#: others there is room for all of these in a cell.
_MOST_LEVELS = 12


@dataclass(frozen=True)
class Centers:
    """Distinct positions among n points.

    Attributes
    ----------
    grid : Grid
        The distinct positions, numbered among themselves.
    carriers : ndarray of int, shape (n,)
        Number of the first point at the same position, if radii differ of the first of the largest.
    distinct : ndarray of int
        Numbers of the points that carry their position.
    dimension : int
        d.
    """

    grid: Grid
    carriers: npt.NDArray[np.int64]
    distinct: npt.NDArray[np.int64]
    dimension: int

    def spread(self, measures: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Put rows of the distinct positions into rows of all points; the others get zeros."""
        if len(self.distinct) == len(self.carriers):
            return measures
        rows = np.zeros((len(self.carriers), *measures.shape[1:]))
        rows[self.distinct] = measures
        return rows


def place_centers(
    points: npt.ArrayLike,
    radius: float,
    reach: float,
    *,
    radii: UnequalRadii | None = None,
    unit: float = 1.0,
    digits: int | None = None,
    box: npt.NDArray[np.float64] | None = None,
) -> Centers:
    """Check the centres and radius of a union of shapes, and sort the centres into a grid.

    Parameters
    ----------
    points : array_like of float, shape (n, 2) or (n, 3)
        Centres, L.
    radius : float
        Radius, L.
    reach : float
        Largest distance of a point of a shape from its centre, L.
    radii : UnequalRadii, optional
        Of unequal shapes; the radius and the reach are then those of the largest.
    unit : float
        What the coordinates of the grid are multiples of, L; a power of two.
    digits : int, optional
        Round coordinates, seen from an origin nearby, to so many binary digits of the largest.
    box : ndarray, shape (2, d), optional
        Bounding box, L, at whose corner cells begin and that gives the origin and the largest
        coordinate: that of the whole cloud, if the points are a part of one.

    Returns
    -------
    Centers
        Shapes that touch have their centres in the same cell of the grid or in adjoining ones.

    Raises
    ------
    InvalidInputError
        If the points have another shape, there are none, a coordinate is not finite (the first
        such row is named), or the radius is not finite and positive.
    """
    positions = as_positions(points)
    if len(positions) == 0:
        raise InvalidInputError("there are no points; a union needs at least one")
    sizes = np.abs(positions)
    if not sizes.max() <= LARGEST:  # also if it is NaN
        bad_rows = np.flatnonzero(~usable_rows(positions))
        raise InvalidInputError(
            f"point {bad_rows[0]} is not finite (or beyond {LARGEST:g}); remove such rows first"
        )
    if not (math.isfinite(radius) and radius > 0.0):
        raise InvalidInputError(f"radius is {radius}; it must be finite and positive")
    positions[sizes < _SMALLEST * radius] = 0.0
    positions /= unit
    if box is None:
        box = np.array(bounding_box(positions))[:, : positions.shape[1]] * unit
    box = box / unit
    if digits is not None:
        origin = local_origin(box)
        largest = max(np.abs(box - origin).max(), radius / unit)
        step = 2.0 ** (math.frexp(largest)[1] - digits)
        positions, box = (np.round((part - origin) / step) * step for part in (positions, box))
    # Cells begin where the cloud does, so that it may lie anywhere.
    cell_size, corner, levels = 2.0 * reach / unit, box[0], None
    if radii is not None:
        # The largest fill their cells, the smallest theirs up to half of the width.
        cell_size *= 0.5 ** min(math.ceil(math.log2(radius / radii.least)), _MOST_LEVELS)
        reaches = radii.values * (reach / radius)
        levels = levels_of(2.0 * reaches / unit, cell_size)
    grid = build_grid(positions, cell_size, corner, levels)
    carriers = first_coincident_in(grid)
    distinct = np.flatnonzero(carriers == np.arange(len(positions)))
    if len(distinct) < len(positions):
        if radii is not None:
            carriers = _largest_coincident(carriers, radii.values)
            distinct = np.flatnonzero(carriers == np.arange(len(positions)))
        levels = None if levels is None else levels[distinct]
        grid = build_grid(positions[distinct], cell_size, corner, levels)
    if radii is not None:
        reaches = reaches[distinct][grid.order] / unit
        grid = see_what_touches(grid, reaches, cell_size, positions.shape[1])
    return Centers(grid, carriers, distinct, positions.shape[1])


def _largest_coincident(
    carriers: npt.NDArray[np.int64], radii: npt.NDArray[np.float64]
) -> npt.NDArray[np.int64]:
    """For each point the first of the largest radius at its position; carriers: just the first."""
    ordered = np.lexsort((-radii, carriers))
    positions = carriers[ordered]
    begins = np.r_[True, positions[1:] != positions[:-1]]
    largest = np.empty_like(carriers)
    largest[positions[begins]] = ordered[begins]
    return largest[carriers]
