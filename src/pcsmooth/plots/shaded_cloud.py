"""A cloud as it is seen from somewhere, in a light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.plots.shading import lit, occlusion
from pcsmooth.plots.splats import Frame, splat
from pcsmooth.plots.views import View

Floats = npt.NDArray[np.float64]

#: Share of the points left outside of the frame of a whole cloud on each side, so that a few far
#: away do not make it small.
_OUTSIDE = 0.002

#: Diameter of a point, in units of the spacing as seen; bounds in pixels. Depths are averaged over
#: so many diameters for the shadow in hollows, pixels at least.
_OVERLAP = 2.2
_DIAMETERS = (1.0, 20.0)
_SHADOW = 2.0
_LEAST_SHADOW = 6.0


@dataclass(frozen=True, eq=False)
class ShadedCloud:
    """A cloud as it is seen, and how bright its points are.

    Attributes
    ----------
    turned : ndarray, shape (n, 3)
        Positions to the right, up and towards the viewer, L.
    brightness : ndarray, shape (n,)
        From 0 to 1.
    """

    turned: Floats
    brightness: Floats

    @classmethod
    def of(cls, points: Floats, normals: Floats, view: View) -> ShadedCloud:
        """Turn points and normals to the viewer, and light them."""
        return cls(points @ view.axes.T, lit(normals @ view.axes.T))

    def frame(self, pixels: int) -> Frame:
        """Frame all but a few points, with so many pixels along the longer side."""
        low, high = np.quantile(self.turned[:, :2], [_OUTSIDE, 1.0 - _OUTSIDE], axis=0)
        extent = high - low
        longest = float(extent.max()) or 1.0
        margin = 0.5 * np.maximum(0.05 * longest - extent, 0.0) + 0.03 * longest
        low, high = low - margin, high + margin
        size = np.maximum(1, np.round(pixels * (high - low) / (high - low).max())).astype(int)
        return Frame(low, high, int(size[0]), int(size[1]))

    def spacing(self, frame: Frame) -> float:
        """Distance of neighbouring points as seen, L: of as many on the area that they cover."""
        cells = np.floor((self.turned[:, :2] - frame.low) / (8.0 * frame.pixel)).astype(np.int64)
        area = len(np.unique(cells, axis=0)) * (8.0 * frame.pixel) ** 2
        return float(np.sqrt(area / len(self.turned)))

    def seen_in(self, frame: Frame, spacing: float) -> Floats:
        """Brightness of each pixel of a frame, the lowest row first; NaN where nothing is seen."""
        diameter = float(np.clip(_OVERLAP * spacing / frame.pixel, *_DIAMETERS))
        nearest, depth = splat(self.turned, frame, diameter)
        bright = np.where(nearest >= 0, self.brightness[nearest], np.nan)
        return bright * occlusion(depth, frame.pixel, max(_SHADOW * diameter, _LEAST_SHADOW))
