"""Cubes of a lattice: the Morton codes of points, and the cells that codes stand for."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid.grid import CELLS_PER_AXIS, code_points

#: Share of a cube by which what is near is taken too far, so that rounding never parts points:
#: the number of a cube, below 2^21 with a relative error of 2^-52, errs by far less.
MARGIN = 1e-6

#: By dimension, how to close the gaps between the bits of an axis: how far each step moves them,
#: and which are in use after it.
_STEPS = {
    2: (
        (1, 0x13333333333),
        (2, 0x10F0F0F0F0F),
        (4, 0x1F00FF00FF),
        (8, 0x1F0000FFFF),
        (16, 0x1FFFFF),
    ),
    3: (
        (2, 0x10C30C30C30C30C3),
        (4, 0x100F00F00F00F00F),
        (8, 0x1F0000FF0000FF),
        (16, 0x1F00000000FFFF),
        (32, 0x1FFFFF),
    ),
}
_AXIS_BITS = {2: 0x15555555555, 3: 0x1249249249249249}

__all__ = ["CELLS_PER_AXIS", "MARGIN", "cube_cells", "cube_codes"]


def cube_codes(
    points: npt.NDArray[np.float64], corner: npt.NDArray[np.float64], width: float
) -> npt.NDArray[np.int64]:
    """Morton codes of the cubes that points lie in.

    The number of a cube along an axis, floor((x - corner) / width), is clamped to the range
    0 .. 2^21 - 1: the cubes at the ends of the range go on outwards without end.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions, L.
    corner : ndarray, shape (d,)
        Corner of cube 0, L.
    width : float
        Side of a cube, L, > 0.

    Returns
    -------
    ndarray of int, shape (n,)
        Bit b of the number along axis a is bit d b + a of the code.
    """
    pairs = np.empty((len(points), 2), np.int64)
    zero = np.zeros(len(corner))
    code_points(np.ascontiguousarray(points), corner, width, zero, pairs)
    return pairs[:, 0].copy()


def cube_cells(codes: npt.NDArray[np.int64], dimension: int) -> npt.NDArray[np.int64]:
    """Numbers of cubes along the axes, from their Morton codes.

    Parameters
    ----------
    codes : ndarray of int, shape (m,)
        As `cube_codes` gives them.
    dimension : int
        2 or 3.

    Returns
    -------
    ndarray of int, shape (m, d)
        0 .. 2^21 - 1.
    """
    cells = np.empty((len(codes), dimension), np.int64)
    for axis in range(dimension):
        numbers = codes >> axis
        numbers &= _AXIS_BITS[dimension]
        for shift, used in _STEPS[dimension]:
            numbers |= numbers >> shift
            numbers &= used
        cells[:, axis] = numbers
    return cells


def cells_within(
    cells: npt.NDArray[np.int64], targets: npt.NDArray[np.int64], reach: int
) -> npt.NDArray[np.bool_]:
    """Tell which cells differ from some target by at most `reach` along every axis.

    Parameters
    ----------
    cells : ndarray of int, shape (n, d)
        Numbers along the axes.
    targets : ndarray of int, shape (m, d)
        Numbers along the axes.
    reach : int
        >= 0.

    Returns
    -------
    ndarray of bool, shape (n,)
        True for those within reach.
    """
    from scipy.spatial import cKDTree

    found = _in_box(cells, targets, reach)
    targets = targets[_in_box(targets, cells[found], reach)]
    candidates = np.flatnonzero(found)
    if len(targets):  # so there are candidates
        # Numbers of cells and their differences are exact as floats.
        tree = cKDTree(targets, balanced_tree=False, compact_nodes=False)
        distances, _ = tree.query(cells[candidates], p=np.inf, distance_upper_bound=reach + 0.5)
        found[candidates] = np.isfinite(distances)
    else:
        found[candidates] = False
    return found


def _in_box(
    cells: npt.NDArray[np.int64], others: npt.NDArray[np.int64], reach: int
) -> npt.NDArray[np.bool_]:
    """Tell which cells (n, d) are within reach of the box around others (m, d)."""
    inside = np.full(len(cells), len(others) > 0)
    if len(others):
        for numbers, bounds in zip(cells.T, others.T, strict=True):
            inside &= (numbers >= bounds.min() - reach) & (numbers <= bounds.max() + reach)
    return inside
