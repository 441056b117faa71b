"""Outliers: points that belong to no surface."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.clumps import clump_reach, mark_clumps
from pcsmooth.filters.flatness import thicknesses
from pcsmooth.filters.neighborhoods import Neighborhoods
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.filters.scales import Scales
from pcsmooth.neighbors.grid import levels_of
from pcsmooth.neighbors.k_nearest import k_nearest

#: Largest radii within which points may show a sheet, and on which a point depends: more than the
#: three of the heights around it, the normals around these, and the points around those.
_REACHES = 6

#: How many times as far away as the one before it the next point of a sheet is at most, from the
#: third on: where it is farther, the points are clumps in a row.
_JUMP = 2.5

#: Nearest points that are looked for, in units of those that may show a sheet: so that which of
#: several equally far ones are among these is no matter of chance.
_BEYOND = 1.25


@dataclass(frozen=True)
class OutlierCandidates:
    """Points that may be outliers.

    Attributes
    ----------
    off_surface : ndarray of bool, shape (n,)
        Points far from the surface of those around.
    isolated : ndarray of bool, shape (n,)
        Points far from all others, alone or a few together, which are outliers if there are not
        too many of them.
    """

    off_surface: npt.NDArray[np.bool_]
    isolated: npt.NDArray[np.bool_]


def few_are_isolated(isolated: int, count: int, plan: FilterPlan) -> bool:
    """Whether so few points are isolated that they are outliers."""
    return isolated <= (plan.design.isolated_max_share + plan.stray_share) * count


def search_reach(plan: FilterPlan, dimension: int) -> float:
    """How far, along an axis, what `find_candidates` finds of a point depends on others, L."""
    width = plan.passes[0]
    radius = plan.largest_radius(width)
    cell_size = radius
    if plan.scale_map is not None:
        cell_size = width.cell_size * 2.0 ** int(levels_of(np.array([radius]), width.cell_size)[0])
    return max(_REACHES * radius, clump_reach(cell_size, dimension))


def find_candidates(
    points: npt.NDArray[np.float64],
    neighborhoods: Neighborhoods,
    plan: FilterPlan,
    scales: Scales | None,
) -> OutlierCandidates:
    """Find points that are far from all others, or from the surface of those around them.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite, distinct positions, L.
    neighborhoods : Neighborhoods
        Those of the first pass.
    plan : FilterPlan
        Of the filter: weights are those of the first pass.
    scales : Scales or None
        What the map of the plan has for the points.

    Returns
    -------
    OutlierCandidates
        Each point depends on those within `search_reach` of it.

    Notes
    -----
    The isolated have fewer than 4 others (2D: none) within the largest radius, or less than 0.4
    (2D: 0.25) of the points that `Width` wants there; where noise and spacing are known place by
    place, among many strays, those are, too, whose neighbourhood is more than twice as sparse as at
    the nearest sample of a surface. So are clumps, groups of up to 20 points with a radius at least
    between them and all others (see `mark_clumps`).

    Those are not isolated that lie on a sheet or line with the 12 (2D: 8) nearest others, as in the
    sparse parts of scans. In a cloud of one spacing the others must have fewer around them than
    `Width` wants, as on a wall that was seen from above, and the sheet must be thin.

    Those off the surface have a mean height of their neighbours over the tangent plane of more
    than the local spacing and more than 5 deviations, of the whole cloud's noise and of the heights
    around, of which each counts up to 4 of the noise: where a region is noisier than the rest it is
    no crowd of outliers. More are found in a second round, without those found around them.
    """
    design, width = plan.design, plan.passes[0]
    exponent, dimension = design.pass_exponents[0], points.shape[1]
    noise = plan.noise_at(scales, len(points))[neighborhoods.grid.order]
    heights = np.abs(neighborhoods.heights(exponent).means)
    limited = np.minimum(heights, design.outlier_max_height * noise)
    around = neighborhoods.means(limited * limited, exponent, 1.0)
    far = heights > design.outlier_deviations * np.sqrt(np.maximum(around, noise * noise))
    far &= heights > neighborhoods.spacings()
    shares = np.minimum(1.0, width.deviations * noise / neighborhoods.farthest)
    covered = 1.0 - shares ** (dimension - 1)
    wanted = np.full(len(points), width.count)
    wanted = np.divide(wanted, covered, out=np.zeros_like(wanted), where=covered > 0.0)
    fewest = design.isolated_share[dimension] * wanted
    alone = neighborhoods.sizes < np.maximum(fewest, design.isolated_count[dimension])
    others = alone | (neighborhoods.sizes < wanted)
    cell_size, thickness = width.max_radius, design.clear_sheet_thickness
    if plan.scale_map is not None:
        cell_size, thickness = width.cell_size, design.sheet_thickness
        others = np.ones(len(points), np.bool_)
        if plan.stray_share > 0.0:
            spacing = plan.scale_map.nearest_spacing(points)[neighborhoods.grid.order]
            alone |= neighborhoods.spacings() > design.stray_distance * spacing
    alone |= mark_clumps(neighborhoods.grid, cell_size, design.clump_size, dimension)
    alone &= ~_lie_on_sheets(
        neighborhoods, alone, alone | others, thickness[dimension], design.sheet_count[dimension]
    )
    return OutlierCandidates(neighborhoods.in_order(far), neighborhoods.in_order(alone))


def _lie_on_sheets(
    neighborhoods: Neighborhoods,
    suspects: npt.NDArray[np.bool_],
    others: npt.NDArray[np.bool_],
    thickness: float,
    count: int,
) -> npt.NDArray[np.bool_]:
    """Which of the suspects lie on a sheet or line with the nearest of some others, (n,).

    Suspects (n,) are among the others (n,), and all in grid order.
    """
    dimension = neighborhoods.dimension
    found = np.zeros(len(suspects), np.bool_)
    if np.count_nonzero(others) < count or not suspects.any():
        return found
    points = np.ascontiguousarray(neighborhoods.grid.coordinates[:dimension].T)
    asked, points = points[suspects], points[others]
    distances, nearest = k_nearest(points, asked, math.ceil(_BEYOND * count))
    within = distances[:, count - 1] <= _REACHES * neighborhoods.farthest[suspects]
    within &= np.all(distances[:, 4:count] <= _JUMP * distances[:, 3 : count - 1], axis=1)
    seen = thicknesses(points[nearest[within, :count]])
    found[np.flatnonzero(suspects)[within]] = seen <= thickness
    return found
