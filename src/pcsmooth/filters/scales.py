"""Noise and spacing as they differ from place to place."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.design import QUADRIC_TERMS, FilterDesign
from pcsmooth.filters.surroundings import Surroundings
from pcsmooth.neighbors.k_nearest import k_nearest

#: Samples whose median stands for a place, and those from which a point takes its scales.
_GROUP = 16
_AROUND = 6

#: Points of the neighbourhoods that may cover a surface.
_COVERS = (6, 9, 13, 16, 24, 36, 54, 80, 120, 180, 256)

#: Ratio of second to largest variance from which on a neighbourhood covers both directions.
_COVERED = 0.25


@dataclass(frozen=True)
class Scales:
    """Noise and spacing at some points.

    Attributes
    ----------
    noise : ndarray, shape (n,)
        Standard deviation of the noise, L.
    spacing : ndarray, shape (n,)
        As if on a square lattice, L.
    cover : ndarray, shape (n,)
        Radius of the least neighbourhood that covers both directions along the surface, L.
    """

    noise: npt.NDArray[np.float64]
    spacing: npt.NDArray[np.float64]
    cover: npt.NDArray[np.float64]

    def of(self, chosen: npt.NDArray[np.int64]) -> Scales:
        """Those of some of the points."""
        return Scales(self.noise[chosen], self.spacing[chosen], self.cover[chosen])


@dataclass(frozen=True)
class ScaleMap:
    """Noise and spacing at samples of a cloud, from which those of all points follow.

    Attributes
    ----------
    positions : ndarray, shape (m, d)
        Of the samples, L.
    scales : Scales
        There.
    """

    positions: npt.NDArray[np.float64]
    scales: Scales

    def scaled(self, factor: float) -> ScaleMap:
        """Return the same of a cloud times a factor."""
        s = self.scales
        return ScaleMap(
            self.positions * factor,
            Scales(s.noise * factor, s.spacing * factor, s.cover * factor),
        )

    def at(self, points: npt.NDArray[np.float64]) -> Scales:
        """Interpolate between the samples nearest to points (n, d)."""
        count = min(_AROUND, len(self.positions))
        distances, nearest = k_nearest(self.positions, points, count)
        weights = 1.0 - (distances / distances[:, -1:]) ** 2
        weights += 1e-3
        weights /= weights.sum(axis=1, keepdims=True)

        def mean(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
            logs = np.log(np.maximum(values, np.finfo(float).tiny))
            return np.exp(np.einsum("ij,ij->i", weights, logs[nearest]))

        s = self.scales
        return Scales(mean(s.noise), mean(s.spacing), mean(s.cover))


def measure_scales(around: Surroundings, design: FilterDesign) -> ScaleMap:
    """Measure noise and spacing at samples."""
    positions = around.positions
    m, known, dimension = positions.shape
    samples = np.ascontiguousarray(positions[:, 0])
    _, group = k_nearest(samples, samples, min(_GROUP, m))
    most = min(known, int(0.25 * around.count))

    def median(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        return np.asarray(np.median(values[group], axis=1))

    radii = around.distances
    cover = np.full(m, np.nan)
    spacing = np.full(m, np.nan)
    left = np.ones(m, np.bool_)
    covers = [k for k in _COVERS if k <= most] or [most]
    for k in covers:
        hoods = positions[:, :k]
        offsets = hoods - hoods.mean(axis=1, keepdims=True)
        spread = np.linalg.eigvalsh(offsets.transpose(0, 2, 1) @ offsets)
        ratio = spread[:, -2] / np.maximum(spread[:, -1], np.finfo(float).tiny)
        now = left & ((ratio >= _COVERED) if dimension == 3 else (k >= 6))
        cover[now] = radii[now, k - 1]
        spacing[now] = (
            radii[now, k - 1] * math.sqrt(math.pi / k) if dimension == 3 else 2 * radii[now, k - 1] / k
        )
        left &= ~now
    if left.any():
        k = min(16, most)
        cover[left] = radii[left, k - 1]
        spacing[left] = (
            radii[left, k - 1] * math.sqrt(math.pi / k) if dimension == 3 else 2 * radii[left, k - 1] / k
        )
    covering_k = cover
    cover, spacing = median(cover), median(spacing)
    n_terms = QUADRIC_TERMS[dimension]
    residuals, kept = zip(*design.noise_kept[dimension], strict=True)
    supports = [k for k in design.noise_supports[dimension] if k <= most] or [most]
    from pcsmooth.filters.noise import _residual_variances

    _, wide = k_nearest(samples, samples, min(NOISE_GROUP, m))
    noise = np.full(m, np.nan)
    left = np.ones(m, np.bool_)
    for k in supports:
        variances = _residual_variances(positions[:, :k], n_terms)
        freedom = k - n_terms
        typical = np.sqrt(np.quantile(variances[wide], NQ, axis=1) / (chi2.ppf(NQ, freedom) / freedom))
        radius = median(radii[:, k - 1])
        share = np.divide(typical, radius, out=np.zeros_like(typical), where=radius > 0.0)
        deviation = typical / np.interp(share, residuals, kept)
        covers = radius >= cover
        noise[left] = deviation[left]
        left &= ~covers
        if not left.any() and np.median(share) <= design.noise_max_residual[dimension]:
            break
        left |= np.median(share[covers]) > design.noise_max_residual[dimension] if covers.any() else False
    return ScaleMap(samples, Scales(noise, spacing, cover))


import os
NQ = float(os.environ.get('NQ', '.5'))
from scipy.stats import chi2
NOISE_GROUP = int(os.environ.get('NG', '48'))
