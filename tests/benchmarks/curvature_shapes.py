"""Clouds on surfaces whose normals and curvatures are known, made from a seed.

Curvatures are positive where the surface bends away from its outward normal.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Surface:
    """Points near a surface, and the truth where they are nearest to it.

    Attributes
    ----------
    points, normals : ndarray, shape (n, d)
        Positions, L, and unit outward normals.
    mean, gauss : ndarray, shape (n,)
        (k1 + k2) / 2 (in 2D k), 1/L, and k1 k2, 1/L^2.
    spacing : float
        Square root of the area per point, in 2D the length per point, L.
    """

    points: Array
    normals: Array
    mean: Array
    gauss: Array
    spacing: float

    def __len__(self) -> int:
        return len(self.points)


def principal(mean: Array, gauss: Array) -> tuple[Array, Array]:
    """Return k1 >= k2 that have a mean and a product (the mean twice where there are none)."""
    half = np.sqrt(np.maximum(mean**2 - gauss, 0.0))
    return mean + half, mean - half


def ellipse(n_points: int, a: float, b: float) -> tuple[Surface, Array]:
    """Sample an ellipse at equal steps of its parameter t, which is returned too.

    With x = a cos t and y = b sin t the curvature is a b / (a² sin² t + b² cos² t)^(3/2).
    """
    t = 2.0 * np.pi * np.arange(n_points) / n_points
    normals = np.stack([b * np.cos(t), a * np.sin(t)], axis=1)
    speed = np.linalg.norm(normals, axis=1)
    points = np.stack([a * np.cos(t), b * np.sin(t)], axis=1)
    curvature = a * b / speed**3
    spacing = float(2.0 * np.pi * speed.mean() / n_points)
    return Surface(points, normals / speed[:, np.newaxis], curvature, curvature, spacing), t


def sphere(n_points: int, radius: float, even: bool, noise: float = 0.0, seed: int = 0) -> Surface:
    """Sample a sphere along a Fibonacci spiral or uniformly at random."""
    rng = np.random.default_rng(seed)
    if even:
        place = np.arange(n_points) + 0.5
        height = 1.0 - 2.0 * place / n_points
        angle = np.pi * (1.0 + np.sqrt(5.0)) * place
        ring = np.sqrt(1.0 - height**2)
        normals = np.stack([ring * np.cos(angle), ring * np.sin(angle), height], axis=1)
    else:
        normals = _directions(rng, n_points)
    spacing = float(np.sqrt(4.0 * np.pi / n_points) * radius)
    away = radius + noise * spacing * rng.standard_normal((n_points, 1))
    curvature = np.full(n_points, 1.0 / radius)
    return Surface(away * normals, normals, curvature, curvature**2, spacing)


def torus(n_points: int, noise: float, isotropic: bool = False, seed: int = 0) -> Surface:
    """Sample the torus with radii 1 and 0.4 uniformly by area.

    The noise is Gaussian, in units of the spacing, along the normals or in all coordinates.
    """
    rng = np.random.default_rng(seed)
    minor = 0.4
    around = rng.uniform(0.0, 2.0 * np.pi, n_points)
    angle = rng.uniform(0.0, 2.0 * np.pi, 4 * n_points)  # the outside of the tube has more area
    keep = rng.uniform(0.0, 1.0 + minor, angle.size) < 1.0 + minor * np.cos(angle)
    tube = angle[keep][:n_points]
    spacing = float(np.sqrt(4.0 * np.pi**2 * minor / n_points))
    center = np.stack([np.cos(around), np.sin(around), np.zeros(n_points)], axis=1)

    def outward(tube: Array) -> Array:
        up = np.array([0.0, 0.0, 1.0])
        return np.asarray(np.outer(np.sin(tube), up) + np.cos(tube)[:, np.newaxis] * center)

    points = center + minor * outward(tube)
    if isotropic:
        points += noise * spacing * rng.standard_normal(points.shape)
        center[:, :2] = points[:, :2] / np.linalg.norm(points[:, :2], axis=1, keepdims=True)
        tube = np.arctan2(points[:, 2], np.linalg.norm(points[:, :2], axis=1) - 1.0)
    else:
        points += noise * spacing * rng.standard_normal((n_points, 1)) * outward(tube)
    second = np.cos(tube) / (1.0 + minor * np.cos(tube))
    return Surface(points, outward(tube), 0.5 * (1.0 / minor + second), second / minor, spacing)


def ellipsoid(n_points: int, noise: float, seed: int = 0) -> Surface:
    """Sample the ellipsoid with semi-axes 1, 0.7 and 0.5 uniformly by area, noise as above."""
    rng = np.random.default_rng(seed)
    axes = np.array([1.0, 0.7, 0.5])
    directions = _directions(rng, 4 * n_points)
    stretch = np.linalg.norm(directions / axes, axis=1)  # of area, but for a factor
    keep = rng.uniform(0.0, 1.0 / axes.min(), len(stretch)) < stretch
    on_sphere = directions[keep][:n_points]
    area = 4.0 * np.pi * axes.prod() * stretch.mean()
    spacing = float(np.sqrt(area / n_points))
    gradient = on_sphere / axes  # of half of sum (x / axis)²
    slope = np.linalg.norm(gradient, axis=1)
    normals = gradient / slope[:, np.newaxis]
    bend = axes**-2.0
    mean = (bend.sum() - normals**2 @ bend) / (2.0 * slope)
    gauss = (axes.prod() * slope**2) ** -2.0
    points = on_sphere * axes + noise * spacing * rng.standard_normal((n_points, 1)) * normals
    return Surface(points, normals, mean, gauss, spacing)


def _directions(rng: np.random.Generator, n_points: int) -> Array:
    vectors = rng.standard_normal((n_points, 3))
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))
