"""The thesis' clouds, and what tests compute of them by themselves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from pcsmooth_experiments.experiment import Inputs

Array = npt.NDArray[np.float64]

REPORT = Path(__file__).parents[2] / "data" / "report"
INPUTS = Inputs(REPORT)

A, B, RADIUS = 180.0, 120.0, 15.0


def ellipse_points(t: Array) -> Array:
    return np.stack([A * np.cos(t), B * np.sin(t)], axis=1)


def distances_to_curve(points: Array, curve: Array) -> Array:
    """Distances from points to the nearest vertices of a dense curve."""
    return np.array([np.hypot(*(curve - point).T).min() for point in points])


def polar_angles(points: Array) -> Array:
    """Angles around the centroid, sorted, radians."""
    x, y = (points - points.mean(axis=0)).T
    return np.sort(np.arctan2(y, x))


def widest_angle(points: Array) -> tuple[float, float]:
    """Width and middle of the widest gap between the points' polar angles, radians."""
    angles = polar_angles(points)
    widths = np.diff(angles, append=angles[0] + 2 * np.pi)
    widest = widths.argmax()
    return float(widths[widest]), float(angles[widest] + widths[widest] / 2)
