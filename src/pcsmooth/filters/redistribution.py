"""Tangential redistribution: points spread evenly over their surface."""

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
MAX_MOVE = 1.0

#: Points farther than this from the centroid of their neighbourhood, in units of its radius, are
#: taken for points of a border.
_BORDER = 0.3


def redistribution_reach(width: Width, noise: float) -> float:
    """How far the result of `redistribute` at a point may depend on others, L.

    The points that push it in a step were at most the largest radius away at the start, and what
    both had moved; normals and local spacings depend on the points within that radius.
    """
    return width.max_radius + _STEPS * (width.max_radius + 2.0 * MAX_MOVE * noise)


def redistribute(
    points: npt.NDArray[np.float64],
    width: Width,
    noise: float,
    fixed: npt.NDArray[np.bool_],
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
    fixed : ndarray of bool, shape (n,)
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
    neighborhoods = find_neighborhoods(points, width)
    grid, dimension = neighborhoods.grid, neighborhoods.dimension
    widths = np.minimum(_WIDTH * neighborhoods.spacings(), width.max_radius / REACH)
    start = grid.coordinates
    still = fixed[grid.order] | (neighborhoods.offsets > _BORDER)
    now = start
    # The cells are those of the start: much wider than what is felt, they serve for all steps.
    for _ in range(_STEPS):
        moved = np.empty_like(now)
        repel(
            now, grid.cell_codes, grid.cell_starts, dimension, neighborhoods.normals, widths,
            _STRENGTH, moved,
        )  # fmt: skip
        way = moved - start
        lengths = np.sqrt(np.einsum("ij,ij->j", way, way))
        max_move = MAX_MOVE * noise
        way *= np.divide(max_move, lengths, out=np.ones_like(lengths), where=lengths > max_move)
        way[:, still] = 0.0
        now = start + way
    redistributed = np.empty_like(points)
    redistributed[grid.order] = now[:dimension].T
    return redistributed
