"""Which point is seen at each pixel of a picture: disks drawn with a depth buffer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

#: Pixels of disks that are drawn at a time.
_AT_A_TIME = 1 << 21


@dataclass(frozen=True, eq=False)
class Frame:
    """A rectangle of what is seen, and its pixels.

    Attributes
    ----------
    low, high : ndarray, shape (2,)
        Corners, to the right and up, L.
    width, height : int
        Pixels.
    """

    low: Floats
    high: Floats
    width: int
    height: int

    @property
    def pixel(self) -> float:
        """Side of a pixel, L."""
        return float((self.high[0] - self.low[0]) / self.width)


def splat(turned: Floats, frame: Frame, diameter: float) -> tuple[npt.NDArray[np.int64], Floats]:
    """Draw points as disks that face the viewer, the nearest in front.

    Parameters
    ----------
    turned : ndarray, shape (n, 3)
        Positions to the right, up and towards the viewer, L.
    frame : Frame
        What is drawn; the first row of pixels is the lowest.
    diameter : float
        Of a disk, in pixels.

    Returns
    -------
    nearest : ndarray of int, shape (height, width)
        The point that is seen at each pixel; -1 for none.
    depth : ndarray, shape (height, width)
        How far it is towards the viewer, L; NaN for none.
    """
    radius = 0.5 * diameter
    reach = int(radius)
    size = np.array([frame.width, frame.height])
    pixels = np.floor((turned[:, :2] - frame.low) / (frame.high - frame.low) * size)
    inside = ((pixels >= -reach) & (pixels < size + reach)).all(axis=1)
    rows = np.flatnonzero(inside)
    rows = rows[np.argsort(turned[rows, 2], kind="stable")]  # of those at a pixel the last stays
    steps = np.arange(-reach, reach + 1)
    offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    offsets = offsets[np.hypot(*offsets.T) <= radius]
    nearest = np.full((frame.height, frame.width), -1)
    block = max(1, _AT_A_TIME // len(offsets))
    for start in range(0, len(rows), block):
        part = rows[start : start + block]
        x, y = np.moveaxis(pixels[part, np.newaxis].astype(np.int64) + offsets, -1, 0)
        shown = (x >= 0) & (x < frame.width) & (y >= 0) & (y < frame.height)
        nearest[y[shown], x[shown]] = np.broadcast_to(part[:, np.newaxis], x.shape)[shown]
    return nearest, np.where(nearest >= 0, turned[nearest, 2], np.nan)
