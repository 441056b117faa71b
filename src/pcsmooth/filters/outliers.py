"""Outliers: points that belong to no surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.neighborhoods import Width, find_neighborhoods

#: Fewest points of a neighbourhood, by dimension, and as a share of what is wanted within the
#: largest radius; with fewer a point is isolated. Gaps between random points of a curve can be
#: wide.
_FEWEST = {2: 2.0, 3: 5.0}
_FEWEST_SHARE = {2: 0.25, 3: 0.4}

#: Largest share of the points that may be isolated. If there are more, the largest radius is less
#: than their spacing: they are the sparse part of a cloud, not outliers.
_MOST_ISOLATED = 0.1

#: Times that is looked for outliers, each without those found before, which stand by each other.
ROUNDS = 2

#: Largest radii of the neighbourhoods, on end, within which a point depends on others: it depends
#: on the heights around it, these on the normals around them, these on the points around them.
REACHES = 3

#: Heights beyond so many deviations are outliers', if they are beyond the spacing too.
_DEVIATIONS = 5.0

#: Heights count for the deviation around them up to this many units of the noise.
_LARGEST = 4.0


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


def few_are_isolated(isolated: int, count: int) -> bool:
    """Whether so few points are isolated that they are outliers."""
    return isolated <= _MOST_ISOLATED * count


def find_candidates(
    points: npt.NDArray[np.float64], width: Width, noise: float, exponent: int
) -> OutlierCandidates:
    """Find points that are far from all others, or from the surface of those around them.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite, distinct positions, L.
    width : Width
        Of the neighbourhoods.
    noise : float
        Standard deviation of the noise, L.
    exponent : int
        Of the neighbours' weights.

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
    neighborhoods = find_neighborhoods(points, width)
    heights = np.abs(neighborhoods.heights(exponent))
    limited = np.minimum(heights, _LARGEST * noise)
    around = neighborhoods.means(limited * limited, exponent, 1.0)
    far = heights > _DEVIATIONS * np.sqrt(np.maximum(around, noise * noise))
    far &= heights > neighborhoods.spacings()
    covered = 1.0 - min(1.0, width.thickness / width.max_radius) ** (neighborhoods.dimension - 1)
    fewest = _FEWEST[neighborhoods.dimension]
    if covered > 0.0:
        fewest = max(fewest, _FEWEST_SHARE[neighborhoods.dimension] * width.count / covered)
    return OutlierCandidates(
        neighborhoods.in_order(far), neighborhoods.in_order(neighborhoods.sizes < fewest)
    )
