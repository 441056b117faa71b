"""Osculating jets: local polynomial heights fitted by least squares, for comparison.

They do what CGAL's Monge_via_jet_fitting does, which its Python package lacks: the height above
the plane of a principal component analysis of the k nearest points is fitted with all monomials
up to a degree, unweighted, and normal and curvatures are those of its graph at the point.
"""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: Numbers in the largest array.
_ROOM = 8_000_000


def plane_normals(neighborhoods: Array) -> Array:
    """Directions of least variance of neighbourhoods (n, k, 3)."""
    offsets = neighborhoods - neighborhoods.mean(axis=1, keepdims=True)
    return np.asarray(np.linalg.eigh(offsets.transpose(0, 2, 1) @ offsets)[1][:, :, 0])


def fit_jets(
    points: Array,
    centers: npt.NDArray[np.intp],
    nearest: npt.NDArray[np.intp],
    outward: Array,
    degree: int,
) -> tuple[Array, Array, Array]:
    """Fit jets at some points.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        The cloud.
    centers : ndarray of int, shape (m,)
        Where to fit.
    nearest : ndarray of int, shape (m, k)
        The neighbourhoods.
    outward : ndarray, shape (m, 3)
        Vectors that give the normals their signs.
    degree : int
        Of the polynomial, >= 2.

    Returns
    -------
    normals : ndarray, shape (m, 3)
    mean, gauss : ndarray, shape (m,)
    """
    n_terms = (degree + 1) * (degree + 2) // 2
    n_chunks = -(-nearest.size * n_terms // _ROOM)
    chunks = np.array_split(np.arange(len(centers)), n_chunks)
    parts = [
        _fit(points[centers[rows]], points[nearest[rows]], outward[rows], degree) for rows in chunks
    ]
    normals, mean, gauss = (np.concatenate(part) for part in zip(*parts, strict=True))
    return normals, mean, gauss


def _fit(
    centers: Array, neighborhoods: Array, outward: Array, degree: int
) -> tuple[Array, Array, Array]:
    up = plane_normals(neighborhoods)
    up *= np.where(np.sum(up * outward, axis=1) < 0.0, -1.0, 1.0)[:, np.newaxis]
    helper = np.eye(3)[np.argmin(np.abs(up), axis=1)]
    first = np.cross(helper, up)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    frames = np.stack([first, np.cross(up, first), up], axis=1)
    local = (neighborhoods - centers[:, np.newaxis]) @ frames.transpose(0, 2, 1)
    size = np.sqrt(np.max(np.sum(local**2, axis=2), axis=1))
    x, y, z = np.moveaxis(local / size[:, np.newaxis, np.newaxis], 2, 0)
    powers = [(total - j, j) for total in range(degree + 1) for j in range(total + 1)]
    terms = np.stack([x**i * y**j for i, j in powers], axis=2)
    transposed = terms.transpose(0, 2, 1)
    heights = transposed @ z[:, :, np.newaxis]
    _, p, q, xx, xy, yy = np.linalg.solve(transposed @ terms, heights)[:, :6, 0].T
    r, s, t = 2.0 * xx, xy, 2.0 * yy
    slope = np.sqrt(1.0 + p**2 + q**2)
    mean = -((1.0 + p**2) * t - 2.0 * p * q * s + (1.0 + q**2) * r) / (2.0 * slope**3) / size
    gauss = (r * t - s**2) / slope**4 / size**2
    normals = np.stack([-p, -q, np.ones_like(p)], axis=1) / slope[:, np.newaxis]
    return (normals[:, np.newaxis] @ frames)[:, 0], mean, gauss
