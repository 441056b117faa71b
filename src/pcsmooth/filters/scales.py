"""Noise and spacing as they differ from place to place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.neighbors.k_nearest import k_nearest

#: Spacing that the distances of the samples show at least, in units of what they would show if
#: they were around the point as around each other: of random points 2 % are farther.
_FARTHEST = 0.7

#: Weight of the farthest of the samples around a point, so that some is left if all are as far.
_LEAST_WEIGHT = 1e-3


@dataclass(frozen=True, eq=False)
class Scales:
    """Noise and spacing at some points.

    Attributes
    ----------
    noise : ndarray, shape (n,)
        Standard deviation of the noise along the normal, L.
    spacing : ndarray, shape (n,)
        Spacing of the points as if on a square lattice, sqrt(area / number), L.
    cover : ndarray, shape (n,)
        Radius of the least neighbourhood that extends in both directions along the surface, L: more
        than the distance of the lines of a scan.
    taken : ndarray, shape (n,)
        Noise that may be taken out, L: all of it, or none on cables, which have no surface.
    """

    noise: npt.NDArray[np.float64]
    spacing: npt.NDArray[np.float64]
    cover: npt.NDArray[np.float64]
    taken: npt.NDArray[np.float64]

    def of(self, chosen: npt.NDArray[np.int64]) -> Scales:
        """Give those of some of the points."""
        return Scales(*(values[chosen] for values in vars(self).values()))

    def extreme(self, which: Callable[..., Any]) -> Scales:
        """Give the least or the largest of each, (1,): which is `np.min` or `np.max`."""
        return Scales(*(which(values, keepdims=True) for values in vars(self).values()))

    def scaled(self, factor: float) -> Scales:
        """Return the same of a cloud times a factor."""
        return Scales(*(values * factor for values in vars(self).values()))


@dataclass(frozen=True, eq=False)
class ScaleMap:
    """Noise and spacing at samples of a cloud, from which those of all its points follow.

    Attributes
    ----------
    samples : ndarray, shape (m, d)
        Where it is known, L.
    scales : Scales
        What it is there.
    neighbors : int
        Nearest samples that tell what it is elsewhere.
    share : float
        Of the cloud's points that are samples.
    """

    samples: npt.NDArray[np.float64]
    scales: Scales
    neighbors: int
    share: float

    def __eq__(self, other: object) -> bool:
        """Whether the other tells the same of all points."""
        return isinstance(other, ScaleMap) and all(
            np.array_equal(a, b) for a, b in zip(self._values(), other._values(), strict=True)
        )

    __hash__ = None  # type: ignore[assignment]

    def _values(self) -> tuple[npt.NDArray[np.float64] | float, ...]:
        return (self.samples, *vars(self.scales).values(), self.neighbors, self.share)

    def at(self, points: npt.NDArray[np.float64]) -> Scales:
        """Interpolate at points (n, d) between the samples around each.

        What is found for a point depends on no other. Where the samples are farther away than their
        spacing lets expect, as from a sparse part's points next to a dense one, spacing and cover
        are larger, but no larger than anywhere among the samples.
        """
        distances, nearest = k_nearest(self.samples, points, min(self.neighbors, len(self.samples)))
        weights = 1.0 - (distances / distances[:, -1:]) ** 2
        weights += _LEAST_WEIGHT
        weights /= weights.sum(axis=1, keepdims=True)

        def mean(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
            return np.asarray(np.einsum("ij,ij->i", weights, values[nearest]))

        noise, spacing, cover, taken = (mean(values) for values in vars(self.scales).values())
        count = distances.shape[1] / self.share
        least = _FARTHEST * lattice_spacing(distances[:, -1], count, points.shape[1])
        wider = np.maximum(1.0, least / np.maximum(spacing, np.finfo(np.float64).tiny))
        largest = self.scales.spacing.max(), self.scales.cover.max()
        spacing, cover = (
            np.minimum(wider * values, most)
            for values, most in zip((spacing, cover), largest, strict=True)
        )
        return Scales(noise, spacing, cover, taken)

    def nearest_spacing(self, points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Spacing at the sample that is nearest to each of some points (n, d), (n,), L."""
        _, nearest = k_nearest(self.samples, points, 2)
        return self.scales.spacing[nearest[:, 0]]

    def with_noise(self, noise: float) -> ScaleMap:
        """Return the same for one noise, L, that is told."""
        told = np.full(len(self.samples), noise)
        taken = np.where(self.scales.taken > 0.0, told, 0.0)
        return replace(self, scales=replace(self.scales, noise=told, taken=taken))

    def scaled(self, factor: float) -> ScaleMap:
        """Return the same of a cloud times a factor."""
        return replace(self, samples=self.samples * factor, scales=self.scales.scaled(factor))


def lattice_spacing(
    radii: npt.NDArray[np.float64], sizes: npt.NDArray[Any] | float, dimension: int
) -> npt.NDArray[np.float64]:
    """Spacing, as if on a square lattice, of so many points within each radius, (n,), L."""
    if dimension == 2:
        return np.asarray(2.0 * radii / sizes)
    return np.asarray(radii * np.sqrt(np.pi / sizes))
