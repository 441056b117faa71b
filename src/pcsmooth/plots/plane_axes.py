"""Axes for curves in the plane: equal scales, and room for the numbers on both."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = npt.NDArray[np.float64]

#: Least length of the shorter side, as a share of the longer one, so that numbers fit.
_NARROWEST = 0.2

#: Inches that a number takes along each axis.
_NUMBER = (0.9, 0.4)


def frame_of(points: Floats, margin: float) -> tuple[Floats, Floats]:
    """Corners around points, with a margin that is a share of the longer side, not too narrow."""
    low, high = points.min(axis=0), points.max(axis=0)
    extent = high - low
    longest = float(extent.max()) or 1.0
    around = 0.5 * np.maximum(_NARROWEST * longest - extent, 0.0) + margin * longest
    return low - around, high + around


def set_plane(axes: Axes, low: Floats, high: Floats, size: tuple[float, float]) -> None:
    """Show a rectangle of the plane with the same scale along x and y, and label the axes.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What is drawn on.
    low, high : ndarray, shape (2,)
        Corners, L.
    size : tuple of float
        Width and height that there is for it, inches.
    """
    from matplotlib.ticker import MaxNLocator

    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    extent = high - low
    sides = extent * float((np.asarray(size) / extent).min())
    for axis, name, side, number in zip(
        (axes.xaxis, axes.yaxis), "xy", sides, _NUMBER, strict=True
    ):
        axis.set_major_locator(MaxNLocator(int(np.clip(side / number, 1, 9)), steps=[1, 2, 5, 10]))
        axis.set_label_text(f"{name}, coordinate units")
