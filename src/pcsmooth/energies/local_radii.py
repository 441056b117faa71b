"""Radii of balls that follow how far the points of a cloud are apart around each of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

#: How many times the least radius the largest may be, and the median: the cells of one grid are
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

    @cached_property
    def values(self) -> npt.NDArray[np.float64]:
        """Radius of each ball, (n,), L."""
        radii = self.multiple * self.spacings
        least = max(float(radii.min()), self.median / _WIDEST_RANGE)
        return np.clip(radii, least, least * _WIDEST_RANGE)

    @cached_property
    def median(self) -> float:
        """Median radius, L."""
        return self.multiple * float(np.median(self.spacings))

    def scaled(self, factor: float) -> LocalRadii:
        """Give those of a cloud times a factor."""
        return LocalRadii(self.spacings * factor, self.multiple)
