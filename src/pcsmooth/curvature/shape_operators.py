"""The shape operator of the surface at every point: how its normal turns with position."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import CellNormals
from pcsmooth.kernels.surface.shape_operators import (
    N_ESTIMATES,
    cluster_moments,
    fit_shape_operators,
)
from pcsmooth.neighbors.grid import build_grid, cells_of_one_size

#: Clusters along the radius of a neighbourhood, by dimension, and the power of two that is not
#: less: so many make a block.
CLUSTERS = {2: 16, 3: 3}
_BLOCK_BITS = {2: 4, 3: 2}


def find_shape_operators(
    cell_normals: CellNormals,
    points: npt.NDArray[np.float64],
    numbers: npt.NDArray[np.int64],
    count: int,
    dimension: int,
    normal_radius: float,
    curvature_radius: float,
    corner: npt.NDArray[np.float64] | None = None,
) -> npt.NDArray[np.float64]:
    """Fit how normals turn with position in the neighbourhood of every point.

    Parameters
    ----------
    cell_normals : CellNormals
        Oriented normals.
    points : ndarray, shape (3, n)
        The points, in the same order.
    numbers : ndarray of int, shape (n,)
        Their rows in the result.
    count : int
        Rows of the result; those without a point are 0.
    dimension : int
        d.
    normal_radius, curvature_radius : float
        Radii of the neighbourhoods, L; the first not the larger.
    corner : ndarray, shape (d,), optional
        Where the clusters begin, L: lowest coordinates of the whole cloud, if the points are a
        part of one; by default theirs.

    Returns
    -------
    ndarray, shape (count, N_ESTIMATES)
        Normals and curvatures, by the columns of `kernels.surface.shape_operators`. Where the
        neighbourhood is empty or too thin, curvatures and confidence are 0.

    Notes
    -----
    With x_j where the cell normal n_j holds, E two unit vectors of the tangent plane, means and
    covariances weighted by |C_j| (1 - |x_j - x_i|^2 / R^2), the best affine map from E x to n
    has the derivative L = cov(n, E x) cov(E x)^-1. The normal at p_i is mean(n) + L E (p_i -
    mean(x)), and the symmetric part of E L is the shape operator, half its trace the mean
    curvature and its determinant the Gaussian. On a sphere n is proportional to x, whatever the
    size of the neighbourhood, so the fit is exact there; height functions fitted by polynomials
    are not. Normals that face the other way are left out, as of the other side of a sheet.

    The sums are taken over clusters, the points in cubes of a third of R (2D: squares of a
    sixteenth), so that the time does not depend on the size of the neighbourhood.
    """
    # What reaches a point lies in the blocks around its own, of 4^3 cells each (16^2 in 2D).
    if corner is None:
        corner = points[:dimension].min(axis=1)
    anchors = cell_normals.anchors[:dimension].T
    grid = build_grid(anchors, curvature_radius / CLUSTERS[dimension], corner)
    cluster_starts, moments = cluster_moments(
        grid.coordinates,
        grid.order,
        grid.cells.starts,
        cell_normals.normals,
        cell_normals.weights,
    )
    codes = grid.cells.codes >> (_BLOCK_BITS[dimension] * dimension)
    starts = np.flatnonzero(np.r_[True, codes[1:] != codes[:-1]])
    blocks = cells_of_one_size(codes[starts], np.append(starts, len(codes)))
    # The kernel fills the rows of the points, those of others stay as they are.
    make = np.empty if count == len(numbers) else np.zeros
    estimates = make((count, N_ESTIMATES))
    fit_shape_operators(
        grid.coordinates,
        grid.order,
        grid.cells.starts,
        cluster_starts,
        moments,
        blocks,
        points,
        cell_normals.normals,
        numbers,
        dimension,
        normal_radius,
        curvature_radius,
        estimates,
    )
    return estimates
