"""Radii of balls that follow how far the points of a cloud are apart around each of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

#: How many times the least spacing the largest may be, and the median: the cells of one grid are
#: as small as the least ball, whatever the largest (see `place_centers`).
_WIDEST_RANGE = 4096.0


@dataclass(frozen=True, eq=False)
class LocalRadii:
    """A multiple of the local spacing for each point: see `local_spacings`.

    Attributes
    ----------
    spacings : ndarray, shape (n,)
        Of all points of a cloud where it was when they were measured, L, > 0.
    multiple : float
        Radius of a ball in units of that.
    """

    spacings: npt.NDArray[np.float64]
    multiple: float

    @classmethod
    def of(cls, spacings: npt.NDArray[np.float64], multiple: float) -> LocalRadii:
        """Make them of spacings (n,), L, > 0, of which one grid may not have room for all."""
        least = max(float(spacings.min()), float(np.median(spacings)) / _WIDEST_RANGE)
        return cls(np.clip(spacings, least, least * _WIDEST_RANGE), multiple)

    @cached_property
    def values(self) -> npt.NDArray[np.float64]:
        """Radius of each ball, (n,), L."""
        return self.multiple * self.spacings

    @cached_property
    def median(self) -> float:
        """Median radius, L."""
        return float(np.median(self.values))
