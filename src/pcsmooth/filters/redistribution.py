"""Tangential redistribution: points spread evenly over their surface."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.neighborhoods import find_neighborhoods
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.filters.scales import Scales
from pcsmooth.kernels.surface.tangential_repulsion import REACH, repel


def redistribution_reach(plan: FilterPlan) -> float:
    """How far the result of `redistribute` at a point may depend on others, L.

    The points that push it in a step were at most the largest radius away at the start, and what
    both had moved; normals and local spacings depend on the points within that radius.
    """
    design, max_radius = plan.design, plan.largest_radius(plan.passes[-1])
    max_move = design.redistribution_max_move * plan.largest_noise
    return max_radius + design.redistribution_steps * (max_radius + 2.0 * max_move)


def redistribute(
    points: npt.NDArray[np.float64],
    plan: FilterPlan,
    fixed: npt.NDArray[np.bool_],
    scales: Scales | None,
) -> npt.NDArray[np.float64]:
    """Let points repel each other within their tangent planes.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite, distinct positions near a surface, L.
    plan : FilterPlan
        Of the filter: neighbourhoods of the last pass give normals and local spacings.
    fixed : ndarray of bool, shape (n,)
        Points that do not move.
    scales : Scales or None
        What the map of the plan has for the points.

    Returns
    -------
    ndarray, shape (n, d)
        New positions.

    Notes
    -----
    Noise moves points along the surface as it moves them off it; what it does there are clumps
    and holes. Every step goes down the gradient of the density, sum_j exp(-|p_j - p_i|^2 / h^2)
    with h 0.65 local spacings, within the tangent plane. No point moves farther than the noise,
    and points on the border of an open surface stay.
    """
    design, width = plan.design, plan.passes[-1]
    noise = plan.noise_at(scales, len(points))
    neighborhoods = find_neighborhoods(points, width, scales)
    max_moves = design.redistribution_max_move * noise[neighborhoods.grid.order]
    grid, dimension = neighborhoods.grid, neighborhoods.dimension
    widths = design.redistribution_width * neighborhoods.spacings()
    widths = np.minimum(widths, neighborhoods.farthest / REACH)
    start = grid.coordinates
    still = fixed[grid.order] | (neighborhoods.offsets > design.border_offset)
    now = start
    # The cells are those of the start: much wider than what is felt, they serve for all steps.
    for _ in range(design.redistribution_steps):
        moved = np.empty_like(now)
        repel(
            now, grid.cells, dimension, neighborhoods.normals, widths,
            design.redistribution_strength, moved,
        )  # fmt: skip
        way = moved - start
        lengths = np.sqrt(np.einsum("ij,ij->j", way, way))
        way *= np.divide(max_moves, lengths, out=np.ones_like(lengths), where=lengths > max_moves)
        way[:, still] = 0.0
        now = start + way
    redistributed = np.empty_like(points)
    redistributed[grid.order] = now[:dimension].T
    return redistributed
