"""Radii of balls that follow how far the points of a cloud are apart around each of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Around, Part, Parts
from pcsmooth.parts.streamed_median import streamed_median
from pcsmooth.parts.whole_cloud import WholeCloud

#: How many times the least spacing the largest may be, and the median: the cells of one grid are
#: as small as the least ball, whatever the largest (see `place_centers`).
_WIDEST_RANGE = 4096.0


@dataclass(frozen=True, eq=False)
class UnequalRadii:
    """Radii of balls of a union, or of a part of it.

    Attributes
    ----------
    values : ndarray, shape (n,)
        Of each ball, L, > 0.
    least, largest : float
        Of all balls of the union, L.
    """

    values: npt.NDArray[np.float64]
    least: float
    largest: float


@dataclass(frozen=True, eq=False)
class LocalRadii:
    """A multiple of the local spacing for each point: see `local_spacings`.

    Attributes
    ----------
    spacings : Column
        Of all points of a cloud where it was when they were measured, L, > 0.
    multiple : float
        Radius of a ball in units of that.
    least_spacing, median_spacing, largest_spacing : float
        L.
    around : Around
        How large the spacings are around each part of the cloud, L.
    sparse_share : float, optional
        If they were chosen, the share of the surface for which one radius would be too small.
    """

    spacings: Column
    multiple: float
    least_spacing: float
    median_spacing: float
    largest_spacing: float
    around: Around
    sparse_share: float | None = None

    @classmethod
    def of(cls, spacings: npt.NDArray[np.float64], multiple: float) -> LocalRadii:
        """Make them of spacings in memory, (n,), L, > 0: see `of_parts`."""
        cloud = WholeCloud.as_it_is(np.zeros((len(spacings), 2)))
        column = cloud.create("local spacings", np.float64)
        column.write(0, spacings)
        return cls.of_parts(cloud, column, multiple)

    @classmethod
    def of_parts(cls, parts: Parts, spacings: Column, multiple: float) -> LocalRadii:
        """Make them of the spacings of a cloud in parts, of which one grid may not have room.

        Those that are too small or too large are brought into range, in a column of their own.
        """
        median = streamed_median(spacings.chunks)
        least = max(min(float(chunk.min()) for chunk in spacings.chunks()), median / _WIDEST_RANGE)
        largest = max(float(chunk.max()) for chunk in spacings.chunks())
        largest = min(max(largest, least), least * _WIDEST_RANGE)
        within = parts.create("local radii", np.float64)
        start = 0
        for chunk in spacings.chunks():
            within.write(start, np.clip(chunk, least, largest))
            start += len(chunk)
        median = min(max(median, least), largest)
        return cls(within, multiple, least, median, largest, parts.largest_around(within))

    @property
    def least(self) -> float:
        """Least radius, L."""
        return self.multiple * self.least_spacing

    @property
    def median(self) -> float:
        """Median radius, L."""
        return self.multiple * self.median_spacing

    @property
    def largest(self) -> float:
        """Largest radius, L."""
        return self.multiple * self.largest_spacing

    @cached_property
    def values(self) -> npt.NDArray[np.float64]:
        """Radius of each ball, (n,), L, of a cloud in memory."""
        return np.asarray(self.multiple * self.spacings.read(0, self.spacings.rows))

    def in_part(self, part: Part) -> UnequalRadii:
        """Give the radii of the balls around the points of a part."""
        return UnequalRadii(self.multiple * part.read(self.spacings), self.least, self.largest)
