"""Errors in logarithmic axes: marks that can be read, and lines of known slope."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_slope(axes: Axes, sizes: npt.ArrayLike, order: int, level: float) -> None:
    """Draw a dotted power law over the range of some sizes, and name its order.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        With logarithmic axes.
    sizes : array_like
        What is along the horizontal axis.
    order : int
        Exponent.
    level : float
        Height at the largest size.
    """
    x = np.array([np.min(sizes), np.max(sizes)])
    y = level * (x / x[1]) ** order
    axes.plot(x, y, ":", color="0.45", lw=1.0, zorder=0)
    axes.annotate(
        f"order {order}",
        (x[0], y[0]),
        xytext=(2, 3),
        textcoords="offset points",
        color="0.35",
        fontsize=7,
    )


def mark_decades(axes: Axes) -> None:
    """Label 1, 2 and 5 of every decade along the horizontal axis."""
    from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.xaxis.set_minor_formatter(NullFormatter())
