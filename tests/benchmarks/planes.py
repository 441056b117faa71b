"""Planes in a cloud: found by random sampling (RANSAC), and how flat their points are."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]

_TRIALS = 2000


def find_planes(points: Array, count: int, tolerance: float, seed: int = 0) -> Iterator[Numbers]:
    """Yield the numbers of the points of the plane with most points, then among the rest."""
    rng = np.random.default_rng(seed)
    left = np.arange(len(points))
    for _ in range(count):
        cloud = points[left]
        corners = cloud[rng.integers(len(cloud), size=(_TRIALS, 3))]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1)
        usable = lengths > 0.0
        normals, origins = normals[usable] / lengths[usable, np.newaxis], corners[usable, 0]
        within = [
            np.count_nonzero(np.abs((cloud - origin) @ normal) < tolerance)
            for origin, normal in zip(origins, normals, strict=True)
        ]
        best = int(np.argmax(within))
        chosen = np.abs((cloud - origins[best]) @ normals[best]) < tolerance
        origin, normal = fit_plane(cloud[chosen])
        chosen = np.abs((cloud - origin) @ normal) < tolerance
        yield left[chosen]
        left = left[~chosen]


def fit_plane(points: Array) -> tuple[Array, Array]:
    """Return the centroid and the unit normal of the plane of least squares."""
    center = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - center, full_matrices=False)
    return center, np.asarray(axes[-1])


def flatness(points: Array) -> float:
    """RMS distance of points to their plane of least squares."""
    center, normal = fit_plane(points)
    return float(np.sqrt(np.mean(((points - center) @ normal) ** 2)))
