"""Outliers: points that belong to no surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.design import FilterDesign
from pcsmooth.filters.neighborhoods import find_neighborhoods
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.filters.scales import Scales

#: Largest radii of the neighbourhoods, on end, within which a point depends on others: it depends
#: on the heights around it, these on the normals around them, these on the points around them.
REACHES = 3


@dataclass(frozen=True)
class OutlierCandidates:
    """Points that may be outliers.

    Attributes
    ----------
    off_surface : ndarray of bool, shape (n,)
        Points far from the surface of those around.
    isolated : ndarray of bool, shape (n,)
        Points far from all others, which are outliers if there are not too many of them.
    """

    off_surface: npt.NDArray[np.bool_]
    isolated: npt.NDArray[np.bool_]


def few_are_isolated(isolated: int, count: int, design: FilterDesign) -> bool:
    """Whether so few points are isolated that they are outliers."""
    return isolated <= design.isolated_max_share * count


def find_candidates(
    points: npt.NDArray[np.float64], plan: FilterPlan, scales: Scales | None
) -> OutlierCandidates:
    """Find points that are far from all others, or from the surface of those around them.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite, distinct positions, L.
    plan : FilterPlan
        Of the filter: neighbourhoods and weights are those of the first pass.
    scales : Scales or None
        What the map of the plan has for the points.

    Returns
    -------
    OutlierCandidates
        Each point depends on those within `REACHES` largest radii of it.

    Notes
    -----
    The isolated have fewer than 4 others (2D: none) within the largest radius, or less than 0.4
    (2D: 0.25) of the points that `Width` wants there. Those off the surface have a mean height of
    their neighbours over the tangent plane of more than the local spacing and more than 5
    deviations, of the whole cloud's noise and of the heights around, of which each counts up to 4
    of the noise: where a region is noisier than the rest it is no crowd of outliers. Clumps of a
    few outliers are found in a second round, without the ones found around them. Clumps of more
    points than a neighbourhood has are taken for surfaces, and of more than one outlier in twenty,
    which is the share of the points that the radius leaves out, some are missed.
    """
    design, width = plan.design, plan.passes[0]
    exponent, dimension = design.pass_exponents[0], points.shape[1]
    neighborhoods = find_neighborhoods(points, width, scales)
    noise = plan.noise_at(scales, len(points))[neighborhoods.grid.order]
    heights = np.abs(neighborhoods.heights(exponent).means)
    limited = np.minimum(heights, design.outlier_max_height * noise)
    around = neighborhoods.means(limited * limited, exponent, 1.0)
    far = heights > design.outlier_deviations * np.sqrt(np.maximum(around, noise * noise))
    far &= heights > neighborhoods.spacings()
    shares = np.minimum(1.0, width.deviations * noise / neighborhoods.farthest)
    covered = 1.0 - shares ** (dimension - 1)
    wanted = np.full(len(points), design.isolated_share[dimension] * width.count)
    fewest = np.divide(wanted, covered, out=np.zeros_like(wanted), where=covered > 0.0)
    fewest = np.maximum(fewest, design.isolated_count[dimension])
    return OutlierCandidates(
        neighborhoods.in_order(far), neighborhoods.in_order(neighborhoods.sizes < fewest)
    )
