"""The planes that bound the convex hull of points."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull, QhullError

from pcsmooth.bodies.unit_normals import unit_normals
from pcsmooth.errors import InvalidInputError


def hull_planes(
    points: npt.NDArray[np.float64], tolerance: float
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Find the half-spaces whose intersection is the convex hull of points.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite, d = 2 or 3; those inside the hull do not matter.
    tolerance : float
        Points nearer than this to the plane of a facet, in units of the points' extent, are on it.

    Returns
    -------
    normals : ndarray, shape (F, d)
        Unit normals of the facets, outward, one for each set of coplanar points.
    offsets : ndarray, shape (F,)
        normals x = offsets on the facets.

    Raises
    ------
    InvalidInputError
        If the points lie in a plane (on a line in 2D).
    """
    flat = "lie in a plane" if points.shape[1] == 3 else "lie on a line"
    too_flat = InvalidInputError(f"the vertices {flat}; add others beside it")
    try:
        hull = ConvexHull(points)
    except QhullError as error:
        raise too_flat from error
    near = tolerance * np.ptp(points, axis=0).max()
    used, numbers = np.unique(hull.simplices, return_inverse=True)
    corners, simplices = points[used], numbers.reshape(hull.simplices.shape)

    # The largest simplex has the most reliable plane; what lies in that belongs to its facet.
    edges = np.diff(corners[simplices], axis=1)
    squared_sizes = np.linalg.det(edges @ edges.transpose(0, 2, 1))
    waiting = np.ones(len(simplices), np.bool_)
    normals, offsets = [], []
    for first in np.argsort(-squared_sizes, kind="stable"):
        if not waiting[first]:
            continue
        equation = hull.equations[first]
        on_plane = np.abs(corners @ equation[:-1] + equation[-1]) <= near
        on_plane[simplices[first]] = True
        waiting &= ~on_plane[simplices].all(axis=1)
        center = corners[on_plane].mean(axis=0)
        axis = np.linalg.svd(corners[on_plane] - center, full_matrices=False)[2][-1]
        (normal,), _ = unit_normals((np.sign(axis @ equation[:-1]) * axis)[None])
        normals.append(normal)
        offsets.append(normal @ center)
        if (offsets[-1] - corners @ normal <= near).all():
            raise too_flat
    return np.array(normals), np.array(offsets)
