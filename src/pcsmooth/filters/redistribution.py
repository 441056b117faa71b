"""Tangential redistribution: points spread evenly over their surface."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.neighbor_lists import MOST_KEPT, NeighborLists
from pcsmooth.filters.neighborhoods import Neighborhoods, find_neighborhoods
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.filters.scales import Scales
from pcsmooth.kernels.surface.neighbor_lists import list_neighbors
from pcsmooth.kernels.surface.tangential_repulsion import REACH, repel

#: What rounding may add to the way of a point, as a share.
_ROUNDING = 1e-9


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
    neighborhoods = find_neighborhoods(points, width, scales, listed=False)
    max_moves = design.redistribution_max_move * noise[neighborhoods.grid.order]
    grid, dimension = neighborhoods.grid, neighborhoods.dimension
    widths = design.redistribution_width * neighborhoods.spacings()
    widths = np.minimum(widths, neighborhoods.farthest / REACH)
    start = grid.coordinates
    still = fixed[grid.order] | (neighborhoods.offsets > design.border_offset)
    now = start
    reaches = REACH * widths
    kept = _felt_on_the_way(neighborhoods, reaches, max_moves)
    # The cells are those of the start: much wider than what is felt, they serve for all steps.
    for _ in range(design.redistribution_steps):
        lists = _within(neighborhoods, now, reaches) if kept is None else kept
        moved = np.empty_like(now)
        repel(
            now, neighborhoods.normals, widths, lists.numbers, lists.ends,
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


def _felt_on_the_way(
    neighborhoods: Neighborhoods,
    reaches: npt.NDArray[np.float64],
    max_moves: npt.NDArray[np.float64],
) -> NeighborLists | None:
    """List the points that may push each point in any step, if there are few."""
    # Two points come nearer to each other by no more than what both move.
    farthest = (reaches + max_moves + max_moves.max()) * (1.0 + _ROUNDING)
    wider = farthest / np.sqrt(neighborhoods.squares)
    expected = neighborhoods.sizes * wider ** (neighborhoods.dimension - 1)
    if np.mean(expected) > MOST_KEPT:
        return None
    return _within(neighborhoods, neighborhoods.grid.coordinates, farthest)


def _within(
    neighborhoods: Neighborhoods,
    coordinates: npt.NDArray[np.float64],
    reaches: npt.NDArray[np.float64],
) -> NeighborLists:
    """List the points that are within reach of each point at some coordinates (3, n), L."""
    ends = np.empty(len(reaches), np.int64)
    blocks = list_neighbors(
        coordinates, neighborhoods.grid.cells, neighborhoods.dimension, reaches * reaches, ends
    )
    return NeighborLists.of_blocks(blocks, ends)
