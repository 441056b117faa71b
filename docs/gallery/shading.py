"""Clouds drawn as surfaces: every point is a small disc, lit by its normal."""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter

Array = npt.NDArray[np.float64]

LIGHT = np.array([-0.35, 0.45, 0.82])  #: to the right, upwards, towards the eye
AMBIENT = 0.25  #: share of the light that comes from everywhere
CLAY = (0.93, 0.90, 0.85)
FINER = 2  #: the picture is drawn so many times finer, and averaged


def shaded(
    points: Array,
    normals: Array,
    *,
    view: npt.ArrayLike,
    up: npt.ArrayLike,
    disc: float,
    width: int,
    frame: Array | None = None,
    colors: npt.ArrayLike = CLAY,
) -> Array:
    """Draw a cloud as seen from far away.

    Parameters
    ----------
    points, normals : ndarray, shape (n, 3)
        The signs of the normals do not matter.
    view, up : array_like, shape (3,)
        Towards the eye, and what is upwards in the picture.
    disc : float
        Radius of the discs, in the unit of the points: about the spacing.
    width : int
        Of the picture, pixels; the height follows.
    frame : ndarray, shape (m, 3), optional
        Points that set what is shown, so that two clouds are seen alike; by default the cloud.
    colors : array_like, shape (3,) or (n, 3)
        Red, green and blue from 0 to 1.

    Returns
    -------
    ndarray, shape (height, width, 4)
        Red, green, blue and opacity from 0 to 1.
    """
    axes = camera(view, up)
    framed = (points if frame is None else frame) @ axes.T
    start, size = framed.min(axis=0) - disc, np.ptp(framed, axis=0) + 2.0 * disc
    pixel = size[0] / (FINER * width)
    height = round(size[1] / (FINER * pixel))
    placed = (points @ axes.T - start) / pixel
    turned = normals @ axes.T
    turned *= np.where(turned[:, 2:] < 0.0, -1.0, 1.0)
    values = np.ones((len(points), 7))
    values[:, :3], values[:, 3:6] = turned, colors
    depths, sums = _lay_discs(placed, values, disc / pixel, FINER * height, FINER * width)
    weight = np.maximum(sums[..., 6:], 1e-12)
    facing = sums[..., :3] / np.maximum(np.linalg.norm(sums[..., :3], axis=2)[..., None], 1e-12)
    lit = np.clip(facing @ (LIGHT / np.linalg.norm(LIGHT)), 0.0, 1.0)
    light = (AMBIENT + (1.0 - AMBIENT) * lit) * openness(depths)
    seen = np.isfinite(depths)[..., None]
    picture = np.concatenate([sums[..., 3:6] / weight * light[..., None], seen], axis=2)
    picture[..., :3] *= seen
    coarse = picture.reshape(height, FINER, width, FINER, 4).mean(axis=(1, 3))[::-1]
    coarse[..., :3] /= np.maximum(coarse[..., 3:], 1e-12)
    return np.clip(coarse, 0.0, 1.0)


def camera(view: npt.ArrayLike, up: npt.ArrayLike) -> Array:
    """Directions to the right, upwards and towards the eye, one a row."""
    eye = np.asarray(view, dtype=float) / np.linalg.norm(view)
    right = np.cross(up, eye)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(eye, right), eye])


@numba.njit(cache=True)
def _lay_discs(placed, values, radius, height, width):  # type: ignore[no-untyped-def]
    """Depth of what is in front in each pixel, and weighted sums of the values there."""
    depths = np.full((height, width), -np.inf)
    sums = np.zeros((height, width, values.shape[1]))
    reach = int(np.ceil(radius))
    for summing in (False, True):
        for i in range(len(placed)):
            x, y, z = placed[i, 0], placed[i, 1], placed[i, 2]
            if values[i, 2] < 0.1 or not 0.0 <= x < width or not 0.0 <= y < height:
                continue  # seen from its edge, or outside
            steepness = max(values[i, 2], 0.35)
            tilt_x, tilt_y = -values[i, 0] / steepness, -values[i, 1] / steepness
            for row in range(max(int(y) - reach, 0), min(int(y) + reach + 1, height)):
                for column in range(max(int(x) - reach, 0), min(int(x) + reach + 1, width)):
                    dx, dy = column + 0.5 - x, row + 0.5 - y
                    far = (dx * dx + dy * dy) / radius**2
                    depth = z + tilt_x * dx + tilt_y * dy
                    if far >= 1.0:
                        continue
                    if not summing:
                        depths[row, column] = max(depths[row, column], depth)
                    elif depth > depths[row, column] - radius:
                        for k in range(values.shape[1]):
                            sums[row, column, k] += np.exp(-3.0 * far) * values[i, k]
    return depths, sums


def openness(depths: Array) -> Array:
    """How little of the light is kept off by what lies in front and around, from 0 to 1."""
    seen = np.isfinite(depths)
    filled = np.where(seen, depths, 0.0)
    result = np.ones(depths.shape)
    for width in (depths.shape[1] / 150, depths.shape[1] / 50):
        share = gaussian_filter(seen.astype(float), width, truncate=2.5)
        around = gaussian_filter(filled, width, truncate=2.5) / np.maximum(share, 1e-12)
        result -= 0.25 * np.clip((around - filled) / (2.0 * width), 0.0, 1.0)
    return result
