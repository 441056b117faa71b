"""Where the solution of a long implicit step is looked for: at the means of the components."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.facet_laplacian import FacetLaplacian


def start_at_means(
    laplacian: FacetLaplacian,
    masses: npt.NDArray[np.float64],
    points: npt.NDArray[np.float64],
    right_side: npt.NDArray[Any],
    held: npt.NDArray[np.bool_],
) -> tuple[npt.NDArray[Any], npt.NDArray[np.float64]]:
    """Start connected components at their mean that are nearer to it than to where they are.

    Parameters
    ----------
    laplacian : FacetLaplacian
        L.
    masses : ndarray, shape (n,)
        Diagonal of M, > 0.
    points : ndarray, shape (n, d)
        p, L.
    right_side : ndarray, shape (n, 3)
        -f L p.
    held : ndarray of bool, shape (n,)
        Points that do not move; components that have any start where they are.

    Returns
    -------
    right_side : ndarray, shape (n, 3)
        What the start leaves of the equations: see `solve`.
    start : ndarray, shape (n, 3)
        Displacements, L.

    Notes
    -----
    The solution p+ of (M + f L) p+ = M p tends to the mean c of each component as f grows. Without
    a displacement -f L p is left of the equations, which grows with f and drowns c in rounding;
    with p+ = c it is M (p - c), whatever f. That is taken which is smaller, divided by the masses.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    n, dimension = points.shape
    links = csr_array((laplacian.weights, laplacian.columns, laplacian.starts), (n, n))
    count, labels = connected_components(links, directed=False)

    def sums(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.bincount(labels, values, count)

    totals = sums(masses)
    way = np.zeros((n, 3))
    for axis in range(dimension):
        way[:, axis] = points[:, axis] - (sums(masses * points[:, axis]) / totals)[labels]
    roots = np.sqrt(masses)
    left_here = sums(np.abs(right_side).sum(axis=1) / roots)
    left_there = sums(np.abs(way).sum(axis=1) * roots)
    far = ((left_here > left_there) & (sums(held) == 0.0))[labels][:, np.newaxis]
    return np.where(far, masses[:, np.newaxis] * way, right_side), np.where(far, -way, 0.0)
