"""Whether a cloud shows a surface, or fills a volume (in the plane, an area)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.design import FilterDesign
from pcsmooth.neighbors.k_nearest import k_nearest
from pcsmooth.neighbors.surroundings import Surroundings


def shows_surface(around: Surroundings, design: FilterDesign) -> bool:
    """Whether a cloud shows a surface at any scale.

    Parameters
    ----------
    around : Surroundings
        What is around some of the cloud's points.
    design : FilterDesign
        Numbers to go by.

    Returns
    -------
    bool
        False for volume noise, solid lattices and blobs; true if there are too few points to tell.

    Notes
    -----
    The flatness of a neighbourhood is the ratio of the least to the largest variance along its
    principal axes. A surface is flat at some scale: beyond its noise and below its features. A
    volume is not, from the points nearest to each other to a quarter of all. The small scales are
    those of the nearest points, the large ones those of the samples among themselves. A surface
    is seen if at any scale the median flatness is a surface's, or if a quarter of the samples
    have a scale at which they are flat without doubt: mixed clouds are no volumes.
    """
    samples = around.positions[:, 0]  # each is the nearest to itself
    dimension = samples.shape[1]
    scales = [
        flatness(around.positions[:, :support])
        for support in _supports(design, dimension, around.count, around.positions.shape[1])
    ]
    among = _supports(design, dimension, len(samples), len(samples))
    if among and len(samples) < around.count:
        _, nearest = k_nearest(samples, samples, among[-1])
        scales += [flatness(samples[nearest[:, :support]]) for support in among]
    if not scales:
        return True
    found = np.stack(scales)
    is_solid = np.median(found, axis=1).min() > design.solid_flatness[dimension]
    is_flat = found.min(axis=0) < design.surface_flatness
    return bool(not is_solid or np.count_nonzero(is_flat) >= design.surface_share * len(samples))


def _supports(design: FilterDesign, dimension: int, count: int, known: int) -> list[int]:
    """Sizes of neighbourhoods of so many points, of which so many of the nearest are known."""
    most = min(known, int(design.flatness_max_share * count))
    return [support for support in design.flatness_supports[dimension] if support <= most]


def flatness(neighborhoods: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Least over largest variance along the principal axes, (m,); neighbourhoods (m, k, d)."""
    offsets = neighborhoods - neighborhoods.mean(axis=1, keepdims=True)
    variances = np.linalg.eigvalsh(offsets.transpose(0, 2, 1) @ offsets)
    largest = np.maximum(variances[:, -1], np.finfo(np.float64).tiny)
    return np.asarray(np.maximum(variances[:, 0], 0.0) / largest)


def thicknesses(neighborhoods: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Flatness, (m,), of neighbourhoods (m, k, d), or how far the first point lies off the others.

    That is the square of its distance from their plane (line in 2D), over their largest variance.
    """
    others = neighborhoods[:, 1:]
    centers = others.mean(axis=1)
    offsets = others - centers[:, np.newaxis]
    moments = offsets.transpose(0, 2, 1) @ offsets / others.shape[1]
    variances, directions = np.linalg.eigh(moments)
    heights = np.einsum("md,md->m", neighborhoods[:, 0] - centers, directions[:, :, 0])
    across = np.maximum(variances[:, 0], heights**2)
    return np.asarray(across / np.maximum(variances[:, -1], np.finfo(np.float64).tiny))
