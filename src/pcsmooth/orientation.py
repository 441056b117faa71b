"""Consistent signs for normals."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.neighbor_sums import signs_along_tree

#: Neighbours along which a sign is handed on.
_LINKS = 8

#: A component is closed if its mean normal is shorter than this, and bulges if its normals' flux
#: exceeds this share of the largest possible.
_SHARE = 0.25

#: Added to every weight: scipy takes an edge of weight 0 for none.
_LEAST_WEIGHT = 1e-9


def orient_normals(
    points: npt.NDArray[np.float64],
    normals: npt.NDArray[np.float64],
    areas: npt.NDArray[np.float64],
    neighbors: npt.NDArray[np.int32],
) -> npt.NDArray[np.float64]:
    """Choose the sign of each normal so that neighbours agree and closed shapes look outward.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Positions, n >= 1.
    normals : ndarray, shape (n, d)
        Unit normals of either sign, or zero where there is none.
    areas : ndarray, shape (n,)
        Weight of each point in its component's flux, such as its visible boundary.
    neighbors : ndarray of int32, shape (n, k)
        Numbers of the nearest points, the point itself first, n for none
        (`nearest_neighbors`); the first 8 others hand on the sign.

    Returns
    -------
    ndarray, shape (n, d)
        Normals or their opposites.

    Notes
    -----
    Signs are handed on along a minimum spanning tree of the 8-neighbour graph with weights
    1 - abs(n_i . n_j) (Hoppe et al. 1992), in each connected component on its own. A component
    then gets the sign for which the flux sum a_i (p_i - c) . n_i, c its centroid, is positive:
    by the divergence theorem that is outward. But where the normals' mean is longer than a
    quarter and the flux is below a quarter of sum a_i abs(p_i - c), the component is an open
    sheet, such as a terrain: its normals point along the positive direction of the axis that
    their mean is nearest to.
    """
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import (
        breadth_first_order,
        connected_components,
        minimum_spanning_tree,
    )

    n, dimension = points.shape
    targets = neighbors[:, 1 : _LINKS + 1]
    turns = np.empty(targets.shape)
    for column, others in enumerate(np.minimum(targets, n - 1).T):
        turns[:, column] = 1.0 - np.abs(np.einsum("ij,ij->i", normals, normals[others]))
    turns = np.maximum(turns, 0.0) + _LEAST_WEIGHT
    links = targets < n
    graph = csr_matrix(
        (turns[links], targets[links], np.r_[0, np.cumsum(links.sum(axis=1))]), shape=(n, n)
    )
    del turns, links
    tree = minimum_spanning_tree(graph)
    count, labels = connected_components(tree, directed=False)

    # One root joined to the first point of each component makes a single tree.
    roots = np.full(count, n)
    np.minimum.at(roots, labels, np.arange(n))
    rooted = csr_matrix(
        (
            np.r_[tree.data, np.ones(count)],
            (np.r_[tree.tocoo().row, np.full(count, n)], np.r_[tree.tocoo().col, roots]),
        ),
        shape=(n + 1, n + 1),
    )
    order, parents = breadth_first_order(rooted, n, directed=False)
    parents = np.where(parents[:n] == n, -1, parents[:n])
    oriented = normals * signs_along_tree(order[1:], parents, normals)[:, np.newaxis]

    total = np.maximum(np.bincount(labels, areas, count), np.finfo(float).tiny)
    centers = np.stack(
        [np.bincount(labels, areas * points[:, axis], count) / total for axis in range(dimension)],
        axis=1,
    )
    arms = points - centers[labels]
    flux = np.bincount(labels, areas * np.einsum("ij,ij->i", arms, oriented), count)
    possible = np.bincount(labels, areas * np.linalg.norm(arms, axis=1), count)
    means = np.stack(
        [np.bincount(labels, areas * oriented[:, axis], count) for axis in range(dimension)],
        axis=1,
    )
    leading = means[np.arange(count), np.abs(means).argmax(axis=1)]
    is_sheet = np.linalg.norm(means, axis=1) > _SHARE * total
    is_sheet &= np.abs(flux) <= _SHARE * possible
    outward = np.where(is_sheet, leading, flux)
    signs = np.where(outward < 0.0, -1.0, 1.0)
    return np.asarray(oriented * signs[labels, np.newaxis])
