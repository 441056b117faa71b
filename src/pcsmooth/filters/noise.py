"""The noise of a cloud, measured from the cloud."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.surroundings import Surroundings

#: Points of the neighbourhoods tried, by dimension, the smallest first.
_SUPPORTS = {
    2: (6, 8, 11, 16, 22, 32, 45, 64, 90, 128),
    3: (16, 24, 36, 54, 80, 120, 180, 270, 400),
}

#: Points of the largest neighbourhood, by dimension.
LARGEST_SUPPORT = {dimension: sizes[-1] for dimension, sizes in _SUPPORTS.items()}

#: A neighbourhood is wide enough if the residuals are below this share of its radius, by
#: dimension: then it holds nearly all the noise along its normal, on a surface. Curves bring
#: their own detail, and other parts of themselves, into neighbourhoods that wide.
_WIDE = {2: 0.34, 3: 0.27}

#: The residual that Gaussian noise of 1 leaves, by residual / radius of the neighbourhood: less
#: than 1 because the neighbourhood, a ball, cuts the noise off. Measured on random points of a
#: plane and of a line.
_SHARES = {
    2: ((0.0, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35), (1.0, 0.995, 0.985, 0.97, 0.925, 0.86, 0.75)),
    3: ((0.0, 0.1, 0.15, 0.19, 0.22, 0.25, 0.28), (1.0, 0.99, 0.973, 0.945, 0.917, 0.885, 0.82)),
}

#: Largest share of the points that a neighbourhood may have: of a shape that is no more than a
#: few neighbourhoods, everything is detail.
_LARGEST_SHARE = 0.25


@dataclass(frozen=True)
class Noise:
    """What is known of the noise of a cloud.

    Attributes
    ----------
    deviation : float
        Standard deviation of the distance of the points from their surface, L.
    support : int
        Points of the neighbourhoods in which it was measured; 0 if there are too few points.
    """

    deviation: float
    support: int

    def scaled(self, factor: float) -> Noise:
        """Return the same of a cloud times a factor."""
        return replace(self, deviation=self.deviation * factor)


def measure_noise(around: Surroundings) -> Noise:
    """Measure the standard deviation of the noise along the normals.

    Parameters
    ----------
    around : Surroundings
        What is around some of the cloud's points; of the nearest, `LARGEST_SUPPORT` with their
        positions if there are as many.

    Returns
    -------
    Noise

    Notes
    -----
    Around every sample a quadratic polynomial is fitted, by least squares, to the heights of the
    k nearest points over their principal plane (line in 2D). The sum of the squared residuals
    over its degrees of freedom is an unbiased estimate of the variance where the surface is a
    quadric; the median over the samples, corrected for the skewness of chi-squared
    (Wilson-Hilferty), stays with the bulk of the cloud whatever edges and outliers do. k is the
    smallest for which neighbourhoods are wide enough to hold the noise, which matters where
    noise is as large as the spacing; what their borders still cut off is put back by a
    correction measured on planes and lines. Detail of the surface that a quadric does not follow
    counts as noise: by 4 to 20 % on the benchmark's models. No neighbourhood has more than a
    quarter of the points; of clouds with less than four of the smallest nothing is known.
    """
    _, known, dimension = around.positions.shape
    n_terms = 3 if dimension == 2 else 6
    most = min(known, int(_LARGEST_SHARE * around.count))
    supports = [k for k in _SUPPORTS[dimension] if k <= most]
    deviation, support = 0.0, 0
    if not supports:
        return Noise(deviation, support)
    shares = _SHARES[dimension]
    for k in supports:
        support = k
        variances = _residual_variances(around.positions[:, :k], n_terms)
        freedom = k - n_terms
        typical = math.sqrt(float(np.median(variances)) / (1.0 - 2.0 / (9.0 * freedom)) ** 3)
        radius = float(np.median(around.distances[:, k - 1]))
        share = typical / radius if radius > 0.0 else 0.0
        deviation = typical / float(np.interp(share, *shares))
        if share <= _WIDE[dimension]:
            break
    return Noise(deviation, support)


def _residual_variances(
    neighborhoods: npt.NDArray[np.float64], n_terms: int
) -> npt.NDArray[np.float64]:
    """Variance that quadratic heights leave, (m,); neighbourhoods (m, k, d)."""
    offsets = neighborhoods - neighborhoods.mean(axis=1, keepdims=True)
    spreads, directions = np.linalg.eigh(offsets.transpose(0, 2, 1) @ offsets)
    count = offsets.shape[1]
    widths = np.sqrt(np.maximum(spreads[:, -1] / count, np.finfo(float).tiny))
    local = (offsets @ directions) / widths[:, np.newaxis, np.newaxis]
    height, *along = np.moveaxis(local, 2, 0)
    terms = [np.ones_like(height), *along]
    terms += [a * b for i, a in enumerate(along) for b in along[i:]]
    basis = np.stack(terms, axis=2)
    # Orthonormal columns, so that collinear neighbourhoods are no exception.
    columns, _ = np.linalg.qr(basis)
    fitted = np.einsum("mkt,mk->mt", columns, height)
    squares = np.sum(height**2, axis=1) - np.sum(fitted**2, axis=1)
    return np.asarray(np.maximum(squares, 0.0) / (count - n_terms) * widths**2)
