"""Noise and spacing, measured at samples of a cloud, each from the samples around it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import numpy.typing as npt
from scipy.special import gammaincinv

from pcsmooth.filters.cables import on_cables
from pcsmooth.filters.design import QUADRIC_TERMS, FilterDesign
from pcsmooth.filters.noise import residual_variances
from pcsmooth.filters.scales import ScaleMap, Scales, lattice_spacing
from pcsmooth.filters.steps import radii_over_steps
from pcsmooth.neighbors.k_nearest import k_nearest
from pcsmooth.neighbors.surroundings import Surroundings


def measure_scales(around: Surroundings, design: FilterDesign) -> ScaleMap:
    """Measure noise and spacing as they differ from place to place.

    Parameters
    ----------
    around : Surroundings
        What is around samples of the cloud, of which there are as many as a group has, or more.
    design : FilterDesign
        Numbers to go by.

    Returns
    -------
    ScaleMap

    Notes
    -----
    The neighbourhood of a sample grows until it covers the surface in both directions: the second
    largest variance of its points is 0.4 of the largest or more. Where it never does, as on
    a line that is far from all others, it is the smallest. Its radius and the spacing within it
    are taken as the median over the samples around.

    The noise is measured as for the whole cloud (see `measure_noise`), in neighbourhoods that cover
    the surface, but over a group of samples: not by the median of the residuals' variances but by
    their second decile, because up to more than half of the samples may lie at edges and detail.
    Sometimes all of a group do: so none has more than 1.25 times the noise of a larger one around
    the same place. Where half of the samples around lie on cables (see `on_cables`) none is to be
    taken: there is no surface to move points to.
    """
    samples = np.ascontiguousarray(around.positions[:, 0])
    dimension = samples.shape[1]
    few = design.noise_group[dimension]
    many = max(few, math.ceil(design.noise_wide_group[dimension] * len(samples)))
    _, nearest = k_nearest(samples, samples, max(many, design.cover_group))
    covers, spacings = _covering_neighborhoods(around, design)
    covers = np.maximum(covers, radii_over_steps(around, design))
    is_cable = on_cables(around, design)
    group = nearest[:, : design.cover_group]
    cover, spacing, cables = (
        np.median(values[group], axis=1) for values in (covers, spacings, is_cable)
    )
    noise = _noise_by_place(around, design, nearest[:, :many], covers, cover)
    noise, spacing, cover = (
        np.minimum(values, design.scale_limit * np.quantile(values, design.scale_quantile))
        for values in (noise, spacing, cover)
    )
    taken = np.where(cables < 0.5, noise, 0.0)
    share = len(samples) / around.count
    return ScaleMap(samples, Scales(noise, spacing, cover, taken), design.map_neighbors, share)


def are_uneven(scales: Scales, dimension: int, design: FilterDesign) -> bool:
    """Whether one noise and one spacing do not do for the whole cloud, of so many dimensions."""
    low, high = design.uneven_quantiles

    def vary(values: npt.NDArray[np.float64], ratio: float) -> bool:
        return bool(np.quantile(values, high) > ratio * np.quantile(values, low))

    return (
        vary(scales.spacing, design.uneven_spacing[dimension])
        or vary(scales.noise, design.uneven_noise[dimension])
        or bool(np.median(scales.cover / scales.spacing) > design.uneven_cover[dimension])
    )


def _most(around: Surroundings, design: FilterDesign) -> int:
    """Points that a neighbourhood may have."""
    _, known, dimension = around.positions.shape
    fewest = design.noise_supports[dimension][0]
    return int(min(known, max(fewest, design.noise_max_share * around.count)))


def _covering_neighborhoods(
    around: Surroundings, design: FilterDesign
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Radii of the neighbourhoods that cover the surface, and the spacings in them, (m,) each."""
    dimension = around.positions.shape[2]
    most = _most(around, design)
    supports = [k for k in design.cover_supports[dimension] if k <= most] or [most]
    chosen = np.full(len(around.positions), supports[0])
    left = np.arange(len(chosen))
    for support in supports:
        neighborhoods = around.positions[left, :support]
        offsets = neighborhoods - neighborhoods.mean(axis=1, keepdims=True)
        variances = np.linalg.eigvalsh(offsets.transpose(0, 2, 1) @ offsets)
        covers = variances[:, 1 - dimension] >= design.cover_ratio * variances[:, -1]
        chosen[left[covers]] = support
        left = left[~covers]
    radii = np.take_along_axis(around.distances, chosen[:, np.newaxis] - 1, axis=1)[:, 0]
    spacings = lattice_spacing(radii, chosen, dimension)
    # On a curve the points next to one do.
    return (spacings if dimension == 2 else radii), spacings


def _noise_by_place(
    around: Surroundings,
    design: FilterDesign,
    nearest: npt.NDArray[np.int64],
    covers: npt.NDArray[np.float64],
    cover: npt.NDArray[np.float64],
) -> npt.NDArray[np.float64]:
    """Noise at each sample, from the neighbourhoods of those around that cover the surface, (m,).

    nearest: samples around each (m, k), nearest first; covers: radii that do at the samples; cover:
    the same in the median around them.
    """
    dimension = around.positions.shape[2]

    @cache
    def variances_left(support: int) -> npt.NDArray[np.float64]:
        variances = residual_variances(around.positions[:, :support], QUADRIC_TERMS[dimension])
        variances[around.distances[:, support - 1] < covers] = np.nan
        return variances

    def noise_of(groups: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        return _noise_of_groups(around, design, groups, variances_left, cover)

    few = design.noise_group[dimension]
    noise = noise_of(nearest[:, :few])
    if nearest.shape[1] == few:
        return noise
    return np.minimum(noise, design.noise_wide_limit * noise_of(nearest))


def _noise_of_groups(
    around: Surroundings,
    design: FilterDesign,
    groups: npt.NDArray[np.int64],
    variances_left: Callable[[int], npt.NDArray[np.float64]],
    cover: npt.NDArray[np.float64],
) -> npt.NDArray[np.float64]:
    """Noise of groups of samples (m, k), (m,), in neighbourhoods as wide as `cover` (m,), L.

    variances_left: gives what quadrics leave in neighbourhoods of so many points, (m,), NaN where
    they do not cover the surface.
    """
    dimension = around.positions.shape[2]
    supports = [k for k in design.noise_supports[dimension] if k <= _most(around, design)]
    residuals, kept = zip(*design.noise_kept[dimension], strict=True)
    share = design.noise_quantile
    noise = np.zeros(len(groups))
    left = np.ones(len(groups), np.bool_)
    for support in supports:
        freedom = support - QUADRIC_TERMS[dimension]
        typical = _quantile_of_known(variances_left(support)[groups], share)
        typical = np.sqrt(typical * freedom / (2.0 * gammaincinv(0.5 * freedom, share)))
        radius = np.median(around.distances[:, support - 1][groups], axis=1)
        ratio = np.divide(typical, radius, out=np.zeros_like(typical), where=radius > 0.0)
        found = np.isfinite(typical)
        noise[left & found] = (typical / np.interp(ratio, residuals, kept))[left & found]
        is_wide = found & (radius >= cover)
        # The whole cloud decides if neighbourhoods hold the noise: a few would by chance.
        if is_wide.any() and np.median(ratio[is_wide]) <= design.noise_max_residual[dimension]:
            left &= ~is_wide
        if not left.any():
            break
    return noise


def _quantile_of_known(values: npt.NDArray[np.float64], share: float) -> npt.NDArray[np.float64]:
    """Quantile of the values (m, k) of each row that are known, NaN where none is."""
    ordered = np.sort(values, axis=1)  # NaN comes last
    known = np.count_nonzero(np.isfinite(ordered), axis=1)
    ranks = np.maximum(known - 1, 0) * share
    low = ranks.astype(np.int64)
    high = np.minimum(low + 1, np.maximum(known - 1, 0))
    rows = np.arange(len(ordered))
    part = ranks - low
    return np.asarray((1.0 - part) * ordered[rows, low] + part * ordered[rows, high])
