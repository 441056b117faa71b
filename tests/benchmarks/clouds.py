"""Synthetic clouds with known surfaces, made from a seed."""

import numpy as np
import numpy.typing as npt


def noisy_torus(
    n_points: int, noise: float, seed: int = 0, major: float = 1.0, minor: float = 0.4
) -> tuple[npt.NDArray[np.float64], float]:
    """Sample a torus uniformly by area, with Gaussian noise along its normals.

    Parameters
    ----------
    n_points : int
        Number of points.
    noise : float
        Standard deviation of the noise in units of the spacing sqrt(area / n).
    seed : int
        Seed of the random numbers.
    major, minor : float
        Radii of the torus.

    Returns
    -------
    points : ndarray, shape (n, 3)
    spacing : float
    """
    rng = np.random.default_rng(seed)
    around = rng.uniform(0.0, 2.0 * np.pi, n_points)
    tube = np.empty(0)
    while tube.size < n_points:  # rejection: the outside of the tube has more area
        angle = rng.uniform(0.0, 2.0 * np.pi, 2 * n_points)
        keep = rng.uniform(0.0, major + minor, angle.size) < major + minor * np.cos(angle)
        tube = np.concatenate([tube, angle[keep]])
    tube = tube[:n_points]
    spacing = float(np.sqrt(4.0 * np.pi**2 * major * minor / n_points))
    height = minor + noise * spacing * rng.standard_normal(n_points)
    ring = major + height * np.cos(tube)
    points = np.stack([ring * np.cos(around), ring * np.sin(around), height * np.sin(tube)], axis=1)
    return points, spacing


def noisy_ellipse(
    n_points: int, noise: float, seed: int = 0
) -> tuple[npt.NDArray[np.float64], float]:
    """Sample the ellipse with semi-axes 1.5 and 1 at random, with noise in both coordinates.

    Returns the points, shape (n, 2), and the mean spacing along the curve.
    """
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0.0, 2.0 * np.pi, n_points)
    spacing = 7.9327 / n_points  # perimeter over count
    curve = np.stack([1.5 * np.cos(angle), np.sin(angle)], axis=1)
    return curve + noise * spacing * rng.standard_normal(curve.shape), spacing


def graded_plane(
    n_points: int, noise: float, contrast: float = 1000.0, seed: int = 0
) -> tuple[npt.NDArray[np.float64], float]:
    """Sample the unit square with a density that falls exponentially along x.

    Parameters
    ----------
    n_points : int
        Number of points.
    noise : float
        Standard deviation of the noise along z, in units of the spacing where the point is.
    contrast : float
        Density at x = 0 over that at x = 1, > 1.
    seed : int
        Seed of the random numbers.

    Returns
    -------
    points : ndarray, shape (n, 3)
    spacing : float
        Spacing where it is smallest, at x = 0.
    """
    rng = np.random.default_rng(seed)
    rate = np.log(contrast)
    share = 1.0 - 1.0 / contrast
    x = -np.log1p(-share * rng.uniform(size=n_points)) / rate
    spacing = float(np.sqrt(share / (rate * n_points)))
    height = noise * spacing * np.exp(0.5 * rate * x) * rng.standard_normal(n_points)
    return np.stack([x, rng.uniform(size=n_points), height], axis=1), spacing
