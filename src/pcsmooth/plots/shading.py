"""How bright a surface is: lit from its normals, darker where it lies deep among others."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

#: Where the light comes from, to the right, up and towards the viewer: over the left shoulder.
_LIGHT = np.array([-0.45, 0.55, 0.7]) / np.linalg.norm([-0.45, 0.55, 0.7])

#: Brightness without light, and what light adds.
_AMBIENT, _DIFFUSE = 0.25, 0.75

#: How much of the light is lost where a pixel lies as deep below the mean around it as the width of
#: that neighbourhood.
_LOST = 0.6


def lit(normals: Floats) -> Floats:
    """Tell how bright points are by their normals.

    Parameters
    ----------
    normals : ndarray, shape (n, 3)
        To the right, up and towards the viewer, of either sign; zero where unknown.

    Returns
    -------
    ndarray, shape (n,)
        From 0 to 1; half bright where no normal is known.

    Examples
    --------
    >>> lit(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 0.0, 0.0]])).round(3).tolist()
    [0.776, 0.776, 0.5]
    """
    towards = np.where(normals[:, 2:] < 0.0, -normals, normals)
    bright = _AMBIENT + _DIFFUSE * np.clip(towards @ _LIGHT, 0.0, 1.0)
    return np.where(normals.any(axis=1), bright, 0.5)


def occlusion(depth: Floats, pixel: float, around: float) -> Floats:
    """Tell how much of the light from all around reaches each pixel.

    Parameters
    ----------
    depth : ndarray, shape (height, width)
        Towards the viewer, L; NaN where nothing is seen.
    pixel : float
        Side of a pixel, L.
    around : float
        Standard deviation, in pixels, over which depths are averaged.

    Returns
    -------
    ndarray, shape (height, width)
        1 where nothing around stands in front, less in hollows and beside what is nearer; NaN where
        nothing is seen.
    """
    from scipy.ndimage import gaussian_filter, grey_opening

    covered = np.isfinite(depth)
    if not covered.any():
        return np.full(depth.shape, np.nan)
    base = depth[covered].min()
    height = np.where(covered, depth - base, 0.0)
    front = grey_opening(height, int(np.ceil(around)))  # single points throw no shadow
    weights = gaussian_filter(covered.astype(np.float64), around)
    sums = gaussian_filter(front, around)
    mean = sums / np.maximum(weights, np.finfo(np.float64).tiny)
    below = np.clip((mean - height) / (around * pixel), 0.0, 1.0)
    return np.where(covered, 1.0 - _LOST * below, np.nan)
