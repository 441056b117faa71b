"""A shape as of computer-aided design whose normals are known: a third of a thick ring."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

_INNER, _OUTER, _HEIGHT, _ANGLE = 0.4, 1.0, 0.5, 2.0 * np.pi / 3.0

#: Orthogonal, so that no face is along an axis.
_TURN = np.linalg.qr(np.array([[2.0, 1.0, 0.5], [-1.0, 2.0, 0.7], [0.3, -0.9, 2.0]]))[0]


def sample_ring_sector(spacing: float) -> tuple[Array, Array]:
    """Take even points of two flat sides, two caps, a convex and a concave cylinder.

    Parameters
    ----------
    spacing : float
        Distance between neighbours, L; the ring's outer radius is 1. The rows nearest to an edge
        are half a spacing from it.

    Returns
    -------
    points, normals : ndarray, shape (n, 3)
        Positions and outward unit normals.
    """
    places, normals = [], []

    def add(x: Array, y: Array, z: Array, *normal: Array | float) -> None:
        places.append(np.stack(np.broadcast_arrays(x, y, z), axis=-1).reshape(-1, 3))
        directions = np.stack(np.broadcast_arrays(*normal, np.zeros(x.shape)), axis=-1)
        normals.append(np.broadcast_to(directions[..., :3], (*x.shape, 3)).reshape(-1, 3))

    heights = _rows(_HEIGHT, spacing)
    for radius, sign in ((_OUTER, 1.0), (_INNER, -1.0)):
        angles, z = np.meshgrid(_rows(_ANGLE, spacing / radius), heights)
        x, y = np.cos(angles), np.sin(angles)
        add(radius * x, radius * y, z, sign * x, sign * y, 0.0)
    radii = _INNER + _rows(_OUTER - _INNER, spacing)
    for angle, sign in ((0.0, -1.0), (_ANGLE, 1.0)):
        along, z = np.meshgrid(radii, heights)
        x, y = np.cos(angle), np.sin(angle)
        add(along * x, along * y, z, -sign * y, sign * x, 0.0)
    for radius in radii:
        angles = _rows(_ANGLE, spacing / radius)
        for height, sign in ((0.0, -1.0), (_HEIGHT, 1.0)):
            z = np.full(angles.shape, height)
            add(radius * np.cos(angles), radius * np.sin(angles), z, 0.0, 0.0, sign)
    return np.concatenate(places) @ _TURN.T, np.concatenate(normals) @ _TURN.T


def _rows(length: float, spacing: float) -> Array:
    """Middles of equal pieces of about one spacing."""
    count = max(1, round(length / spacing))
    return np.asarray((np.arange(count) + 0.5) * (length / count))
