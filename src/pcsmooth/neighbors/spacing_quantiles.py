"""How far the points of a cloud in parts are apart where it is dense and where it is sparse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid.box_tree import build_box_tree
from pcsmooth.kernels.surface.covering_neighborhoods import measure_spacings
from pcsmooth.neighbors.coincident import Distinct
from pcsmooth.neighbors.local_spacing import LEAST
from pcsmooth.neighbors.surroundings import look_around
from pcsmooth.parts.part import Parts

#: Points at which the spacing is sampled.
_SAMPLES = 500

#: Nearest points of a sample among which those that it is measured with are looked for, and of
#: whose spacings it has the median: as many as a local spacing is smoothed over. More are searched
#: for, so that it is no matter of chance which of several equally far ones are among these.
_AROUND = 256
_SEARCHED = 320
_SMOOTHED = 60


@dataclass(frozen=True)
class SpacingQuantiles:
    """Local spacings that 5, 50 and 95 % of the points have at most, L."""

    dense: float
    median: float
    sparse: float

    @property
    def variation(self) -> float | None:
        """How many times farther points are apart where they are sparse; None at one place."""
        return self.sparse / self.dense if self.dense > 0.0 else None


def spacing_quantiles(parts: Parts, distinct: Distinct) -> SpacingQuantiles:
    """Sample the local spacing of a cloud at its start: see `local_spacings`.

    Parameters
    ----------
    parts : Parts
        The cloud.
    distinct : Distinct
        Its points that are the first at their position.

    Returns
    -------
    SpacingQuantiles
        0 if there are fewer than two distinct points.

    Notes
    -----
    Each of up to 500 samples has the median of what is measured at it and at the 60 nearest
    points, with nothing but the 256 nearest: these are found part by part.
    """
    if distinct.count < 2:
        return SpacingQuantiles(0.0, 0.0, 0.0)
    around = look_around(parts, distinct, "local spacing", _SAMPLES, _SEARCHED, _AROUND)
    spacings = [_spacing_at_first(points) for points in around.positions]
    dense, median, sparse = np.quantile(spacings, (0.05, 0.5, 0.95)).tolist()
    return SpacingQuantiles(dense, median, sparse)


def _spacing_at_first(points: npt.NDArray[np.float64]) -> float:
    """Find the spacing at the first of some distinct points (m, d), the others by distance."""
    n, dimension = points.shape
    coordinates = np.zeros((3, n))
    coordinates[:dimension] = points.T
    spacings = np.empty(min(_SMOOTHED + 1, n))
    none = np.empty((len(spacings), 0), np.int32)
    least = min(LEAST[dimension], n - 1)
    boxes, reaches = build_box_tree(coordinates), np.empty(len(spacings))
    some = np.arange(len(spacings))
    measure_spacings(coordinates, boxes, dimension, least, some, spacings, none, reaches)
    return float(np.median(spacings))
