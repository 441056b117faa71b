"""Which points of a halo are within reach of a tile."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.tiling.cubes import CELLS_PER_AXIS, MARGIN, cells_within, cube_cells, cube_codes
from pcsmooth.tiling.runs import equal_starts

#: Cells of half the reach: points within it are at most two cells apart, and points two cells
#: apart are within three halves of it.
_CELLS = 2

#: Points whose median is the middle of the lattice.
_SAMPLES = 1000


def within_reach(
    own: npt.NDArray[np.float64], others: npt.NDArray[np.float64], reach: float
) -> npt.NDArray[np.bool_]:
    """Find out which points are within reach of some of a tile's own.

    Parameters
    ----------
    own : ndarray, shape (n, d)
        Points of the tile, L.
    others : ndarray, shape (m, d)
        Points around it, L.
    reach : float
        L, > 0.

    Returns
    -------
    ndarray of bool, shape (m,)
        True for every point within `reach` of an own point along every axis, false for every
        one farther from them than 1.5 (and a millionth) times that along some axis; but far from
        the tile, by a million times that, points may be taken for near that are not.

    Raises
    ------
    InvalidInputError
        The reach is not positive and finite.
    """
    if not 0.0 < reach < math.inf:
        raise InvalidInputError(f"the reach is {reach}; it must be positive and finite")
    dimension = own.shape[1]
    if len(own) == 0 or len(others) == 0:
        return np.zeros(len(others), np.bool_)
    width = reach / _CELLS * (1.0 + MARGIN)
    # The median, not the least coordinates: far outliers shall not push the tile off the lattice.
    middle = np.median(own[:: -(-len(own) // _SAMPLES)], axis=0)
    corner = middle - CELLS_PER_AXIS // 2 * width
    codes = cube_codes(others, corner, width)
    occupied = _distinct(codes)
    near = cells_within(
        cube_cells(occupied, dimension),
        cube_cells(_distinct(cube_codes(own, corner, width)), dimension),
        _CELLS,
    )
    # Only the near codes are searched: they are few, as most points around are far.
    wanted = occupied[near]
    if len(wanted) == 0:
        return np.zeros(len(others), np.bool_)
    places = np.minimum(np.searchsorted(wanted, codes), len(wanted) - 1)
    return np.asarray(wanted[places] == codes)


def _distinct(codes: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Sort out the distinct codes; faster than the hashing of `numpy.unique`."""
    ordered = np.sort(codes)
    return ordered[equal_starts(ordered)]
