"""Coordinates that come in steps: how wide neighbourhoods are that hold several of these."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.design import FilterDesign
from pcsmooth.neighbors.k_nearest import k_nearest
from pcsmooth.neighbors.surroundings import Surroundings

#: Layers that tell steps from two sheets.
_LAYERS = 3


def radii_over_steps(around: Surroundings, design: FilterDesign) -> npt.NDArray[np.float64]:
    """Find the radii of neighbourhoods that hold three layers of points, one step apart.

    Parameters
    ----------
    around : Surroundings
        What is around some of the cloud's points.
    design : FilterDesign
        Numbers to go by.

    Returns
    -------
    ndarray, shape (m,)
        L; 0 where there are none. Curves in the plane have none. Where so many have some that the
        whole cloud comes in steps, the others get those of the nearest that have.

    Notes
    -----
    Depths from disparities, coarse coordinates and voxels lie in layers that are exactly flat,
    parallel, and hold several rows of points each; where the surface is slanted there are many side
    by side. In smaller neighbourhoods the surface seems to be flat, and without noise. Noise blurs
    layers, lattices of points on a surface have layers of one row, and two sheets are two.
    """
    samples, known, dimension = around.positions.shape
    radii = np.zeros(samples)
    if dimension == 2 or known < design.layer_count:
        return radii
    normals, is_flat = _flat_normals(around.positions[:, : design.layer_count], design)
    if np.count_nonzero(is_flat) < max(2.0, design.layer_share * samples):
        return radii
    # Where the nearest points lie in two layers the normal is that of the next place.
    centers = around.positions[:, 0]
    _, nearest = k_nearest(centers[is_flat], centers, 2)
    normals = normals[is_flat][nearest[:, 0]]
    offsets = around.positions - centers[:, np.newaxis]
    heights = np.einsum("mkd,md->mk", offsets, normals)
    for support in design.cover_supports[dimension] + design.layer_supports:
        if support <= known:
            left = np.flatnonzero(radii == 0.0)
            widths = around.distances[left, support - 1]
            rows = np.sqrt(4.0 / np.pi * support)  # of points across the neighbourhood
            within = heights[left, :support]
            # Lines of a scan are layers, too, but across the surface.
            spread = np.var(offsets[left, :support], axis=1).sum(axis=1)
            is_along = np.var(within, axis=1) < design.layer_slant * spread
            found = is_along & _holds_layers(
                within, design.layer_thickness * widths, design.layer_rows * rows
            )
            radii[left[found]] = widths[found]
    has_layers = radii > 0.0
    if np.count_nonzero(has_layers) > max(2.0, design.stepped_share * samples):
        _, nearest = k_nearest(centers[has_layers], centers[~has_layers], 2)
        radii[~has_layers] = radii[has_layers][nearest[:, 0]]
    return radii


def has_steps(around: Surroundings, design: FilterDesign) -> bool:
    """Whether the coordinates of a whole cloud come in steps."""
    return bool(radii_over_steps(around, design).all())


def _flat_normals(
    neighborhoods: npt.NDArray[np.float64], design: FilterDesign
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """Fit planes to neighbourhoods (m, k, 3): their normals, and whether they are exactly flat."""
    offsets = neighborhoods - neighborhoods.mean(axis=1, keepdims=True)
    variances, directions = np.linalg.eigh(offsets.transpose(0, 2, 1) @ offsets)
    thin, middle, wide = variances.T
    flat = design.layer_thickness**2 * wide
    return directions[:, :, 0], (thin <= flat) & (middle > design.cable_width * wide)


def _holds_layers(
    heights: npt.NDArray[np.float64],
    thicknesses: npt.NDArray[np.float64],
    fewest: float,
) -> npt.NDArray[np.bool_]:
    """Tell which heights (m, k) fall into three layers and more that have so many points each.

    Layers end where there are no points over more than a thickness, (m,), L.
    """
    ordered = np.sort(heights, axis=1)
    ends = np.diff(ordered, axis=1) > thicknesses[:, np.newaxis]
    layers = np.zeros(heights.shape, np.int64)
    np.cumsum(ends, axis=1, out=layers[:, 1:])
    rows, count = heights.shape
    numbers = layers + count * np.arange(rows)[:, np.newaxis]
    sizes = np.bincount(numbers.ravel(), minlength=rows * count).reshape(rows, count)
    return np.asarray(np.partition(sizes, -_LAYERS, axis=1)[:, -_LAYERS] >= fewest)
