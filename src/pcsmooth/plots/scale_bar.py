"""A length for scale, and the directions of the axes, below a picture in space."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from pcsmooth.plots.views import View

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = npt.NDArray[np.float64]

SCALE_MARGIN = 0.16
"""Share of the longer side that is left free below."""

#: Share of it that is left free on the left.
_MARGIN = 0.04

#: Share of its length below which an axis points at the viewer and has no name.
_FORESHORTENED = 0.2

_INK = "0.25"


def draw_scale(axes: Axes, view: View, low: Floats, high: Floats) -> None:
    """Draw a length for scale, and where x, y and z point.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What is drawn on.
    view : View
        From where the cloud is seen.
    low, high : ndarray, shape (2,)
        Corners of what is drawn, with a margin below of `SCALE_MARGIN` times the longer side, L.
    """
    extent = (high - low).max()
    length = round_length(0.25 * (high - low)[0])
    height = low[1] + 0.4 * SCALE_MARGIN * extent
    left = low[0] + _MARGIN * extent
    axes.plot([left, left + length], [height, height], color=_INK, lw=2, solid_capstyle="butt")
    axes.annotate(
        f"{length:g} coordinate units", (left, height), xytext=(0, -4),
        textcoords="offset points", va="top", color=_INK, fontsize=9,
    )  # fmt: skip
    reach = 0.4 * SCALE_MARGIN * extent
    tips = reach * view.axes[:2].T
    middle = 0.5 * (np.maximum(tips.max(axis=0), 0.0) + np.minimum(tips.min(axis=0), 0.0))
    origin = np.array([high[0] - 2.0 * reach, height]) - middle
    for name, tip in zip("xyz", tips, strict=True):
        axes.plot(*np.stack([origin, origin + tip]).T, color=_INK, lw=1)
        if np.linalg.norm(tip) > _FORESHORTENED * reach:
            axes.annotate(
                name, origin + 1.35 * tip, ha="center", va="center", color=_INK, fontsize=9
            )


def round_length(length: float) -> float:
    """Round a length down to 1, 2 or 5 times a power of ten.

    Examples
    --------
    >>> round_length(0.49), round_length(7.0), round_length(1.0)
    (0.2, 5.0, 1.0)
    """
    power = 10.0 ** np.floor(np.log10(length))
    fitting = (factor for factor in (1.0, 2.0, 5.0) if factor * power <= length)
    factor = max(fitting, default=1.0)  # none where the power was rounded up
    return float(f"{factor * power:.1g}")
