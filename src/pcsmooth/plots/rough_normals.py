"""Normals of a cloud as rough as it is: planes through the nearest points."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

#: Points of a neighbourhood: as few as give a plane, so that noise is seen.
_NEAREST = 8

#: Points at a time.
_BLOCK = 1 << 16


def rough_normals(points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Fit planes to the nearest points of each point.

    A smooth estimate would hide in the picture what is to be seen there: the noise.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Positions, L.

    Returns
    -------
    ndarray, shape (n, 3)
        Unit normals of either sign; zero where there are fewer than three points.
    """
    from scipy.spatial import cKDTree

    normals = np.zeros_like(points)
    if len(points) < 3:
        return normals
    tree = cKDTree(points)
    for start in range(0, len(points), _BLOCK):
        part = points[start : start + _BLOCK]
        _, nearest = tree.query(part, min(_NEAREST, len(points)))
        around = points[nearest] - points[nearest].mean(axis=1, keepdims=True)
        _, vectors = np.linalg.eigh(np.einsum("nij,nik->njk", around, around))
        normals[start : start + _BLOCK] = vectors[:, :, 0]
    return normals
