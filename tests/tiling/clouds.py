"""Clouds for the tests of tiles: long ones, so that what is far apart is in tiles far apart."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.float64]

#: Where surveys lie: easting, northing, height.
MAP_COORDINATES = np.array([4e5, 5.5e6, 300.0])


def ribbon(n: int = 4000, width: float = 10.0, noise: float = 0.3, seed: int = 1) -> Points:
    """A wavy strip of spacing 1, in no spatial order."""
    rng = np.random.default_rng(seed)
    x, y = rng.random(n) * n / width, rng.random(n) * width
    height = 5.0 * np.sin(x / 40.0) * np.cos(y / 30.0)
    return np.stack([x, y, height + noise * rng.normal(size=n)], axis=1)


def sphere(n: int = 3000, noise: float = 0.3, seed: int = 2) -> Points:
    """A unit sphere with noise in units of the spacing."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1)[:, np.newaxis]
    spacing = float(np.sqrt(4.0 * np.pi / n))
    return np.asarray(points + noise * spacing * rng.normal(size=(n, 3)))


def curve(n: int = 3000, noise: float = 0.3, seed: int = 3) -> Points:
    """A wave in the plane of spacing 1, in no spatial order."""
    rng = np.random.default_rng(seed)
    x = rng.random(n) * n
    return np.stack([x, 20.0 * np.sin(x / 50.0) + noise * rng.normal(size=n)], axis=1)


def layers(rows: int = 8, columns: int = 300) -> Points:
    """Two sheets of an exact grid, one above the other: everything is equally far."""
    axes = (np.arange(float(columns)), np.arange(float(rows)), np.arange(2.0))
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def battered(points: Points, seed: int = 4) -> Points:
    """The same with points twice, far from all others, without position, and in another order."""
    rng = np.random.default_rng(seed)
    box = points.min(axis=0), np.ptp(points, axis=0)
    alone = box[0] + (3.0 * rng.random((60, points.shape[1])) - 1.0) * box[1]
    more = np.concatenate([points, points[::40], points[::200], alone])
    more[::97] = np.nan
    more[::501, 0] = np.inf
    return rng.permutation(more)
