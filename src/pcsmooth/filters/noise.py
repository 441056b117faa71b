"""The noise of a cloud, measured from the cloud."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.design import QUADRIC_TERMS, FilterDesign
from pcsmooth.neighbors.surroundings import Surroundings


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


def measure_noise(around: Surroundings, design: FilterDesign) -> Noise:
    """Measure the standard deviation of the noise along the normals.

    Parameters
    ----------
    around : Surroundings
        What is around some of the cloud's points, by the same design.
    design : FilterDesign
        Numbers to go by.

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
    n_terms = QUADRIC_TERMS[dimension]
    most = min(known, int(design.noise_max_share * around.count))
    supports = [k for k in design.noise_supports[dimension] if k <= most]
    deviation, support = 0.0, 0
    if not supports:
        return Noise(deviation, support)
    residuals, kept = zip(*design.noise_kept[dimension], strict=True)
    for k in supports:
        support = k
        variances = residual_variances(around.positions[:, :k], n_terms)
        freedom = k - n_terms
        typical = math.sqrt(float(np.median(variances)) / (1.0 - 2.0 / (9.0 * freedom)) ** 3)
        radius = float(np.median(around.distances[:, k - 1]))
        share = typical / radius if radius > 0.0 else 0.0
        deviation = typical / float(np.interp(share, residuals, kept))
        if share <= design.noise_max_residual[dimension]:
            break
    return Noise(deviation, support)


def residual_variances(
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
