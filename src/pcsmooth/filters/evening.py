"""Points spread evenly over their surface: noise taken out along it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.neighborhoods import Width, find_neighborhoods
from pcsmooth.kernels.surface.tangential_repulsion import REACH, repel

#: Width of the Gaussian in units of the local spacing, steps, and their strength.
_WIDTH = 0.65
_STEPS = 6
_STRENGTH = 0.3

#: Most that a point may move, in units of the noise: the clean positions are no farther away.
LONGEST = 1.0

#: Points farther than this from the centroid of their neighbourhood, in units of its radius, are
#: taken for points of a border.
_BORDER = 0.3


def evening_reach(width: Width, noise: float) -> float:
    """How far the result of `even_out` at a point may depend on others, L.

    The points that push it in a step were at most the reach away at the start, and what both had
    moved; normals and local spacings depend on the points within the reach.
    """
    return width.reach + _STEPS * (width.reach + 2.0 * LONGEST * noise)


def even_out(
    points: npt.NDArray[np.float64],
    width: Width,
    noise: float,
    held: npt.NDArray[np.bool_],
) -> npt.NDArray[np.float64]:
    """Let points repel each other within their tangent planes.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite, distinct positions near a surface, L.
    width : Width
        Of the neighbourhoods that give normals and local spacings.
    noise : float
        Standard deviation of the noise that the points had, L; none moves farther.
    held : ndarray of bool, shape (n,)
        Points that do not move.

    Returns
    -------
    ndarray, shape (n, d)
        New positions.

    Notes
    -----
    Noise moves points along the surface as it moves them off it; what it does there are clumps
    and holes. Every step goes down the gradient of the density, sum_j exp(-|p_j - p_i|^2 / h^2)
    with h 0.65 local spacings, within the tangent plane. Points on the border of an open
    surface stay.
    """
    hoods = find_neighborhoods(points, width)
    grid, dimension = hoods.grid, hoods.dimension
    widths = np.minimum(_WIDTH * hoods.spacings(), width.reach / REACH)
    start = grid.coordinates
    still = held[grid.order] | (hoods.offsets > _BORDER)
    now = start
    # The cells are those of the start: much wider than what is felt, they serve for all steps.
    for _ in range(_STEPS):
        moved = np.empty_like(now)
        repel(
            now, grid.cell_codes, grid.cell_starts, dimension, hoods.normals, widths, _STRENGTH,
            moved,
        )  # fmt: skip
        way = moved - start
        lengths = np.sqrt(np.einsum("ij,ij->j", way, way))
        farthest = LONGEST * noise
        way *= np.divide(farthest, lengths, out=np.ones_like(lengths), where=lengths > farthest)
        way[:, still] = 0.0
        now = start + way
    evened = np.empty_like(points)
    evened[grid.order] = now[:dimension].T
    return evened
