"""Gaps between consecutive points of a curve: how uneven they are, and where the union breaks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pcsmooth_experiments.plane.ellipse import Array, fit_ellipse


@dataclass(frozen=True)
class Gaps:
    """Gaps between the consecutive points of a curve.

    Attributes
    ----------
    distances : ndarray, shape (m,)
        Straight distances, L.
    along : ndarray, shape (m,)
        Lengths along the curve that fits the points best, between the places nearest to them, L;
        a point that is off the curve makes no gap in it.
    middles : ndarray, shape (m, 2)
        Points half way between.
    """

    distances: Array
    along: Array
    middles: Array

    @property
    def variation(self) -> float:
        """Coefficient of variation of the distances, standard deviation over mean; 0 if even."""
        return float(self.distances.std() / self.distances.mean())

    @property
    def largest(self) -> float:
        """Largest distance over the mean one."""
        return float(self.distances.max() / self.distances.mean())

    @property
    def widest(self) -> Array:
        """Middle of the widest gap along the curve, (2,)."""
        return np.asarray(self.middles[self.along.argmax()])

    def holes(self, radius: float) -> int:
        """Count the gaps along the curve that are wider than the disks: the union is open there."""
        return int(np.count_nonzero(self.along > 2.0 * radius))


def gaps_around(points: Array) -> Gaps:
    """Measure the n gaps of points around a closed curve.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Points near an ellipse, in any order, L.

    Returns
    -------
    Gaps
        In the order of the places of the ellipse of best fit that are nearest to the points.
    """
    ellipse = fit_ellipse(points)
    t = ellipse.nearest(points)
    order = np.argsort(t, kind="stable")
    following = np.roll(order, -1)
    places = ellipse.lengths_to(t[order])
    along = np.diff(places, append=places[0] + ellipse.perimeter)
    return Gaps(
        np.linalg.norm(points[following] - points[order], axis=1),
        along,
        0.5 * (points[following] + points[order]),
    )


def gaps_along(points: Array) -> Gaps:
    """Measure the n - 1 gaps of points (n, 2) along the x axis, in the order of x."""
    ordered = points[np.argsort(points[:, 0], kind="stable")]
    return Gaps(
        np.linalg.norm(np.diff(ordered, axis=0), axis=1),
        np.diff(ordered[:, 0]),
        0.5 * (ordered[1:] + ordered[:-1]),
    )
