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


def solid_clump(n_points: int, seed: int = 0) -> npt.NDArray[np.float64]:
    """Sample a solid ball, (n, 3), all of whose points are within a distance of 1."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(n_points, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return 0.5 * directions * np.cbrt(rng.uniform(size=(n_points, 1)))


def room_with_clump(n_points: int, share: float = 0.2, seed: int = 0) -> npt.NDArray[np.float64]:
    """Sample the walls of a room of 20 x 14 x 3 m, with noise of 3 mm, and a clump in its midst.

    Parameters
    ----------
    n_points : int
        Number of points.
    share : float
        Share of them in the clump, a Gaussian of 35 x 30 x 12 mm, much smaller than the mean
        spacing suggests: as around the place where a scanner stood.
    seed : int
        Seed of the random numbers.
    """
    rng = np.random.default_rng(seed)
    in_clump = round(share * n_points)
    half = np.array([10.0, 7.0, 1.5])
    walls = rng.uniform(-half, half, (n_points - in_clump, 3))
    rows, axes = np.arange(len(walls)), rng.integers(0, 3, len(walls))
    walls[rows, axes] = np.copysign(half[axes], walls[rows, axes])
    walls += 0.003 * rng.normal(size=walls.shape)
    return np.concatenate([walls, rng.normal(size=(in_clump, 3)) * [0.035, 0.030, 0.012]])


def spread_plane(n_points: int, noise: float, variation: float) -> npt.NDArray[np.float64]:
    """Sample the unit square with a spacing that grows so many times, >= 1, along x: (n, 3).

    With noise in units of the spacing where each point is.
    """
    contrast = max(variation**2, 1.0 + 1e-9)
    return graded_plane(n_points, noise, contrast)[0]
