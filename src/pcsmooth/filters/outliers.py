"""Outliers: points that belong to no surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.neighborhoods import Width, find_neighborhoods

#: Fewest points of a neighbourhood, by dimension, and as a share of what is wanted within reach;
#: with fewer a point is on its own. Gaps between random points of a curve can be wide.
_FEWEST = {2: 2.0, 3: 5.0}
_FEWEST_SHARE = {2: 0.25, 3: 0.4}

#: Largest share of the points that may be on their own. If there are more, the reach is less than
#: their spacing: they are the sparse part of a cloud, not outliers.
_MOST_ALONE = 0.1

#: Times that is looked for outliers, each without those found before, which stand by each other.
ROUNDS = 2

#: Reaches of the neighbourhoods, on end, within which a point depends on others: it depends on
#: the heights around it, these on the normals around them, these on the points around them.
REACHES = 3

#: Heights beyond so many deviations are outliers', if they are beyond the spacing too.
_DEVIATIONS = 5.0

#: Heights count for the deviation around them up to this many units of the noise.
_LARGEST = 4.0


@dataclass(frozen=True)
class Suspects:
    """Points that may be outliers.

    Attributes
    ----------
    off : ndarray of bool, shape (n,)
        Points far from the surface of those around.
    alone : ndarray of bool, shape (n,)
        Points on their own, which are outliers if there are not too many of them.
    """

    off: npt.NDArray[np.bool_]
    alone: npt.NDArray[np.bool_]


def few_are_alone(alone: int, count: int) -> bool:
    """Whether so few points are on their own that they are outliers."""
    return alone <= _MOST_ALONE * count


def find_suspects(
    points: npt.NDArray[np.float64], width: Width, noise: float, exponent: int
) -> Suspects:
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
    Suspects
        Each point depends on those within `REACHES` reaches of it.

    Notes
    -----
    The first have fewer than 4 others (2D: none) within reach, or less than 0.4 (2D: 0.25) of the
    points that `Width` wants there. The second have a mean height of their neighbours over the
    tangent plane of more than the local spacing and more than 5 deviations, of the whole cloud's
    noise and of the heights around, of which each counts up to 4 of the noise: where a region is
    noisier than the rest it is no crowd of outliers. Clumps of a few outliers are found in a
    second round, without the ones found around them. Clumps of more points than a neighbourhood
    has are taken for surfaces, and of more than one outlier in twenty, which is the share of the
    points that the reach leaves out, some are missed.
    """
    hoods = find_neighborhoods(points, width)
    heights = np.abs(hoods.heights(exponent))
    limited = np.minimum(heights, _LARGEST * noise)
    around = hoods.means(limited * limited, exponent, 1.0)
    far = heights > _DEVIATIONS * np.sqrt(np.maximum(around, noise * noise))
    far &= heights > hoods.spacings()
    covered = 1.0 - min(1.0, width.thickness / width.reach) ** (hoods.dimension - 1)
    fewest = _FEWEST[hoods.dimension]
    if covered > 0.0:
        fewest = max(fewest, _FEWEST_SHARE[hoods.dimension] * width.count / covered)
    return Suspects(hoods.in_order(far), hoods.in_order(hoods.sizes < fewest))
