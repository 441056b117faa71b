"""The passes of the filter, and its last step."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.filters import errors_left
from pcsmooth.filters.neighborhoods import Neighborhoods, find_neighborhoods
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.filters.scales import Scales

#: Largest radii of the neighbourhoods, on end, within which a point depends on others. In a pass:
#: heights are averaged, which are means over the averaged normals around, these over those of the
#: planes, and these lie through the points around. In the last step: energies, residuals, heights,
#: planes.
PASS_REACHES = 4
LAST_REACHES = 4


def take_pass(
    start: npt.NDArray[np.float64],
    points: npt.NDArray[np.float64],
    neighborhoods: Neighborhoods,
    plan: FilterPlan,
    number: int,
    fixed: npt.NDArray[np.bool_],
    scales: Scales | None,
    left: npt.NDArray[np.float64],
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Take one of the first passes.

    Parameters
    ----------
    start : ndarray, shape (n, d)
        Where the points that take part were before the filter, L.
    points : ndarray, shape (n, d)
        Where they are, L.
    neighborhoods : Neighborhoods
        Of the points there, as wide as the plan has them for the pass.
    plan : FilterPlan
        Of the filter.
    number : int
        Which pass, from 0.
    fixed : ndarray of bool, shape (n,)
        Points that do not move.
    scales : Scales or None
        What the map of the plan has for the points.
    left : ndarray, shape (n,)
        Variance of their errors along the normal, L^2.

    Returns
    -------
    points : ndarray, shape (n, d)
        New positions. Each depends on the points within `PASS_REACHES` largest radii of it.
    sizes : ndarray, shape (n,)
        Points of the neighbourhoods.
    left : ndarray, shape (n,)
        Variance of the errors now, L^2 (see `errors_left`).
    """
    design = plan.design
    noise = plan.noise_at(scales, len(points))
    exponent = design.pass_exponents[number]
    neighborhoods = _facing_outwards(neighborhoods, points, plan)
    order = neighborhoods.grid.order
    neighborhoods = neighborhoods.with_averaged_normals(design.normals_exponent)
    heights = neighborhoods.heights(exponent)
    residuals = _residuals(neighborhoods, heights.means, exponent)
    shares = _shares(design.pass_variances[number] * noise[order] ** 2, heights.variances)
    moved = _moved(points, neighborhoods, shares * residuals, fixed)
    moved = _limited(start, moved, plan.limits_at(scales, len(points)))
    left = errors_left.after_pass(left[order], shares, heights.variances, design)
    return moved, neighborhoods.in_order(neighborhoods.sizes), neighborhoods.in_order(left)


def take_last_step(
    start: npt.NDArray[np.float64],
    points: npt.NDArray[np.float64],
    plan: FilterPlan,
    fixed: npt.NDArray[np.bool_],
    sizes: npt.NDArray[np.float64],
    scales: Scales | None,
    left: npt.NDArray[np.float64],
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Take the last step.

    Parameters
    ----------
    start, points, plan, fixed, scales, left
        As `take_pass` has them.
    sizes : ndarray, shape (n,)
        Points of the neighbourhoods in the last of the passes.

    Returns
    -------
    points : ndarray, shape (n, d)
        New positions. Each depends on the points within `LAST_REACHES` largest radii of it.
    left : ndarray, shape (n,)
        Standard deviation of the errors that are left, L (see `errors_left`).
    """
    design = plan.design
    noise = plan.noise_at(scales, len(points))
    exponent = design.last_exponent
    neighborhoods = find_neighborhoods(points, plan.last, scales, listed=False)
    neighborhoods = _facing_outwards(neighborhoods, points, plan)
    order = neighborhoods.grid.order
    heights = neighborhoods.heights(exponent)
    residuals = _residuals(neighborhoods, heights.means, exponent)
    energies = neighborhoods.means(residuals * residuals, exponent, design.energy_share)
    explained = design.residual_variance * noise[order] ** 2 / sizes[order]
    shares = _shares(explained, energies) ** 2
    moved = _moved(points, neighborhoods, shares * residuals, fixed)
    left = errors_left.after_last_step(
        left[order], noise[order], (sizes[order], neighborhoods.sizes), shares,
        heights.variances, neighborhoods.dimension, design,
    )  # fmt: skip
    return _limited(start, moved, plan.limits_at(scales, len(points))), neighborhoods.in_order(left)


def _facing_outwards(
    neighborhoods: Neighborhoods, points: npt.NDArray[np.float64], plan: FilterPlan
) -> Neighborhoods:
    """Turn normals outwards, where the plan knows which side that is."""
    if plan.winding is None:
        return neighborhoods
    return neighborhoods.facing(plan.winding.outward_at(points))


def _residuals(
    neighborhoods: Neighborhoods, heights: npt.NDArray[np.float64], exponent: int
) -> npt.NDArray[np.float64]:
    """How far along its normal each point is to move, (n,), L, from mean heights, in grid order."""
    return heights - neighborhoods.means_along_normals(heights, exponent)


def _shares(
    explained: npt.NDArray[np.float64] | float, found: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Share of each variance (n,) that noise explains, at most 1."""
    return np.divide(explained, found, out=np.ones_like(found), where=found > explained)


def _moved(
    points: npt.NDArray[np.float64],
    neighborhoods: Neighborhoods,
    lengths: npt.NDArray[np.float64],
    fixed: npt.NDArray[np.bool_],
) -> npt.NDArray[np.float64]:
    """Move points along their normals, those that are fixed not."""
    order = neighborhoods.grid.order
    lengths = np.where(fixed[order], 0.0, lengths)
    moved = points.copy()
    moved[order] += (lengths * neighborhoods.normals[: neighborhoods.dimension]).T
    return moved


def _limited(
    start: npt.NDArray[np.float64],
    points: npt.NDArray[np.float64],
    max_moves: npt.NDArray[np.float64],
) -> npt.NDArray[np.float64]:
    """Bring points (n, d) that are farther than that from their start, (n,), L, back to it."""
    way = points - start
    lengths = np.sqrt(np.einsum("ij,ij->i", way, way))
    far = lengths > max_moves
    way[far] *= (max_moves[far] / lengths[far])[:, np.newaxis]
    return start + way
