"""Noise and spacing as they differ from place to place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.neighbors.k_nearest import k_nearest


@dataclass(frozen=True)
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
    """

    noise: npt.NDArray[np.float64]
    spacing: npt.NDArray[np.float64]
    cover: npt.NDArray[np.float64]

    def of(self, chosen: npt.NDArray[np.int64]) -> Scales:
        """Give those of some of the points."""
        return Scales(self.noise[chosen], self.spacing[chosen], self.cover[chosen])

    def scaled(self, factor: float) -> Scales:
        """Return the same of a cloud times a factor."""
        return Scales(self.noise * factor, self.spacing * factor, self.cover * factor)


@dataclass(frozen=True)
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
    """

    samples: npt.NDArray[np.float64]
    scales: Scales
    neighbors: int

    def at(self, points: npt.NDArray[np.float64]) -> Scales:
        """Interpolate at points (n, d) between the samples around each.

        What is found for a point depends on no other; it lies within what the samples have.
        """
        distances, nearest = k_nearest(self.samples, points, min(self.neighbors, len(self.samples)))
        weights = 1.0 - (distances / distances[:, -1:]) ** 2
        weights += _LEAST_WEIGHT
        weights /= weights.sum(axis=1, keepdims=True)

        def mean(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
            return np.asarray(np.einsum("ij,ij->i", weights, values[nearest]))

        return Scales(*(mean(values) for values in vars(self.scales).values()))

    def scaled(self, factor: float) -> ScaleMap:
        """Return the same of a cloud times a factor."""
        return ScaleMap(self.samples * factor, self.scales.scaled(factor), self.neighbors)


#: Weight of the farthest of the samples around a point, so that some is left if all are as far.
_LEAST_WEIGHT = 1e-3
