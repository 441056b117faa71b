"""Consistent signs for normals."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.spanning_forest import signs_along_forest

#: Neighbours along which a sign is handed on.
_LINKS = 8

#: A component is closed if its mean normal is shorter than this, and bulges if its normals' flux
#: exceeds this share of the largest possible.
_SHARE = 0.25


def orient_normals(
    points: npt.NDArray[np.float64],
    normals: npt.NDArray[np.float64],
    areas: npt.NDArray[np.float64],
    neighbors: npt.NDArray[np.int32],
) -> None:
    """Turn each normal so that neighbours agree and closed shapes look outward.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Positions, n >= 1.
    normals : ndarray, shape (n, d)
        Unit normals of either sign, or zero where there is none; they get their sign in place.
    areas : ndarray, shape (n,)
        Weight of each point in its component's flux, such as its visible boundary.
    neighbors : ndarray of int32, shape (n, k)
        Numbers of the nearest points, the point itself first, n for none
        (`nearest_neighbors`); the first 8 others hand on the sign.

    Notes
    -----
    Signs are handed on along a minimum spanning forest of the 8-neighbour graph with weights
    1 - abs(n_i . n_j) (Hoppe et al. 1992), one tree in each connected component. A component
    then gets the sign for which the flux sum a_i (p_i - c) . n_i, c its centroid, is positive:
    by the divergence theorem that is outward. But where the normals' mean is longer than a
    quarter and the flux is below a quarter of sum a_i abs(p_i - c), the component is an open
    sheet, such as a terrain: its normals point along the positive direction of the axis that
    their mean is nearest to.
    """
    signs, roots = signs_along_forest(normals, neighbors, _LINKS)
    normals *= signs[:, np.newaxis]
    is_root = roots == np.arange(len(roots))
    labels = (np.cumsum(is_root) - 1)[roots]  # components, numbered from 0
    count = int(is_root.sum())

    def sums(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Sum over each component, its points weighted by their areas."""
        return np.asarray(np.bincount(labels, areas * values, count), np.float64)

    total = np.maximum(np.bincount(labels, areas, count), np.finfo(float).tiny)
    arms = np.empty_like(normals)
    for axis, coordinates in enumerate(points.T):
        arms[:, axis] = coordinates - (sums(coordinates) / total)[labels]
    flux = sums(np.einsum("ij,ij->i", arms, normals))
    possible = sums(np.linalg.norm(arms, axis=1))
    means = np.stack([sums(component) for component in normals.T], axis=1)
    leading = means[np.arange(count), np.abs(means).argmax(axis=1)]
    is_sheet = np.linalg.norm(means, axis=1) > _SHARE * total
    is_sheet &= np.abs(flux) <= _SHARE * possible
    outward = np.where(is_sheet, leading, flux)
    normals *= np.where(outward < 0.0, -1.0, 1.0)[labels, np.newaxis]
