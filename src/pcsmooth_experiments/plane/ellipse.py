"""Ellipses: points on them, the point nearest to another, and the ellipse of best fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Points of the ellipse among which the nearest is looked for, and Newton steps from there.
_SAMPLES = 720
_NEWTON_STEPS = 8

#: Points at which the length of the ellipse is added up.
_LENGTH_SAMPLES = 20_001


@dataclass(frozen=True)
class Ellipse:
    """The curve (a cos t, b sin t) around a centre.

    Attributes
    ----------
    a, b : float
        Semi-axes along x and y, L, > 0.
    center : tuple of float
        Its centre, L.
    """

    a: float
    b: float
    center: tuple[float, float] = (0.0, 0.0)

    def at(self, t: Array) -> Array:
        """Points at parameters, (n, 2)."""
        return np.stack([self.a * np.cos(t), self.b * np.sin(t)], axis=1) + self.center

    def normals(self, t: Array) -> Array:
        """Outward unit normals at parameters, (n, 2)."""
        normals = np.stack([self.b * np.cos(t), self.a * np.sin(t)], axis=1)
        return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))

    def curvatures(self, t: Array) -> Array:
        """Curvatures at parameters, (n,), 1/L."""
        speed = (self.a * np.sin(t)) ** 2 + (self.b * np.cos(t)) ** 2
        return np.asarray(self.a * self.b / speed**1.5)

    def lengths_to(self, t: Array) -> Array:
        """Lengths of the curve from parameter 0 to parameters in [0, 2 pi], (n,), L."""
        samples, along = self._lengths()
        return np.interp(t, samples, along)

    @property
    def perimeter(self) -> float:
        """Length of the whole curve, L."""
        return float(self._lengths()[1][-1])

    def even_parameters(self, n: int) -> Array:
        """Parameters of n points that are evenly spaced along the curve, from t = 0."""
        samples, along = self._lengths()
        return np.asarray(np.interp(np.arange(n) * (along[-1] / n), along, samples))

    def _lengths(self) -> tuple[Array, Array]:
        """Parameters around the curve, and its lengths up to there."""
        samples = np.linspace(0.0, 2.0 * np.pi, _LENGTH_SAMPLES)
        lengths = np.linalg.norm(np.diff(self.at(samples), axis=0), axis=1)
        return samples, np.concatenate([[0.0], np.cumsum(lengths)])

    def nearest(self, points: Array) -> Array:
        """Parameters in [0, 2 pi) of the points of the curve nearest to points, (n,)."""
        local = points - np.asarray(self.center)
        samples = np.linspace(0.0, 2.0 * np.pi, _SAMPLES, endpoint=False)
        curve = np.stack([self.a * np.cos(samples), self.b * np.sin(samples)], axis=1)
        t = samples[np.linalg.norm(local[:, np.newaxis] - curve, axis=2).argmin(axis=1)]
        x, y = local.T
        stretch = self.a**2 - self.b**2
        for _ in range(_NEWTON_STEPS):
            # half the derivative of the squared distance, and its derivative
            slope = -stretch * np.cos(t) * np.sin(t) + self.a * x * np.sin(t)
            slope -= self.b * y * np.cos(t)
            bend = -stretch * np.cos(2.0 * t) + self.a * x * np.cos(t) + self.b * y * np.sin(t)
            move = np.divide(slope, bend, out=np.zeros_like(t), where=bend > 0.0)
            t = t - np.clip(move, -np.pi / _SAMPLES, np.pi / _SAMPLES)
        return np.asarray(t % (2.0 * np.pi))

    def distances(self, points: Array) -> Array:
        """Signed distances of points from the curve, positive outside, (n,), L."""
        t = self.nearest(points)
        return np.asarray(np.sum((points - self.at(t)) * self.normals(t), axis=1))


#: The thesis' ellipse, Section 2.3.2.
REPORT_ELLIPSE = Ellipse(180.0, 120.0)

#: The radius of its disks, and the number of its points in the author's files.
REPORT_RADIUS = 15.0
REPORT_POINTS = 100


def sampling_parameters(n: int) -> Array:
    """Sample parameters as the thesis does, t = 2 pi k / n (Section 2.3.2)."""
    return 2.0 * np.pi * np.arange(n) / n


def fit_ellipse(points: Array) -> Ellipse:
    """Fit an ellipse with axes along x and y to points (n, 2), by least squares of distances."""
    from scipy.optimize import least_squares

    def ellipse_of(values: Array) -> Ellipse:
        x, y, a, b = values.tolist()
        return Ellipse(a, b, (x, y))

    def slopes(values: Array) -> Array:
        """Differentiate the distances; that the nearest point moves along does not count."""
        ellipse = ellipse_of(values)
        t = ellipse.nearest(points)
        normals = ellipse.normals(t)
        return -np.column_stack([normals, normals * np.stack([np.cos(t), np.sin(t)], axis=1)])

    spreads = np.sqrt(2.0) * points.std(axis=0)
    fit = least_squares(
        lambda values: ellipse_of(values).distances(points),
        np.concatenate([points.mean(axis=0), spreads]),
        slopes,
        bounds=([-np.inf, -np.inf, 1e-9 * spreads.max(), 1e-9 * spreads.max()], np.inf),
    )
    return ellipse_of(fit.x)
