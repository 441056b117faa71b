"""The shape operator of the surface at every point: how its normal turns with position."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import CellNormals
from pcsmooth.kernels.grid.grid import mark_adjacent
from pcsmooth.kernels.surface.shape_operators import (
    N_ESTIMATES,
    cluster_moments,
    fit_shape_operators,
)
from pcsmooth.neighbors.grid import Grid, build_grid, cells_of_one_size

#: Clusters along the radius of a neighbourhood, by dimension, and the power of two that is not
#: less: so many make a block.
CLUSTERS = {2: 16, 3: 3}
_BLOCK_BITS = {2: 4, 3: 2}

#: Bands of radii in an octave: clusters are a fourth to 0.36 of a radius.
_BANDS = 2


def find_shape_operators(
    cell_normals: CellNormals,
    points: npt.NDArray[np.float64],
    numbers: npt.NDArray[np.int64],
    count: int,
    dimension: int,
    normal_radius: float | npt.NDArray[np.float64],
    curvature_radius: float | npt.NDArray[np.float64],
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
    normal_radius, curvature_radius : float or ndarray, shape (n,)
        Radii of the neighbourhoods, L, of all or of each point; the first not the larger.
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
    sixteenth), so that the time does not depend on the size of the neighbourhood. If each point
    has its own R, points are taken by half octaves of R, together with all around them that they
    reach, in cubes of a fourth of the largest (2D: a sixteenth).
    """
    if corner is None:
        corner = points[:dimension].min(axis=1)
    # The kernel fills the rows of the points, those of others stay as they are.
    make = np.empty if count == len(numbers) else np.zeros
    estimates = make((count, N_ESTIMATES))
    normal_radii, curvature_radii = np.atleast_1d(normal_radius), np.atleast_1d(curvature_radius)
    if len(curvature_radii) == 1:
        cluster = float(curvature_radii[0]) / CLUSTERS[dimension]
        _fit(
            cell_normals, points, numbers, dimension, normal_radii, curvature_radii, cluster,
            corner, estimates,
        )  # fmt: skip
        return estimates
    bands = np.floor(_BANDS * np.log2(curvature_radii / curvature_radii.min()))
    least = float(curvature_radii.min())
    grid = build_grid(cell_normals.anchors[:dimension].T, least)
    for band in np.unique(bands):
        wanted = bands == band
        reach = float(curvature_radii[wanted].max())
        chosen = _around(grid, wanted, math.ceil(math.log2(reach / least)), dimension)
        _fit(
            cell_normals.of(chosen), points[:, chosen],
            np.where(wanted[chosen], numbers[chosen], -1), dimension,
            normal_radii[chosen], curvature_radii[chosen], reach / (1 << _BLOCK_BITS[dimension]),
            corner, estimates,
        )  # fmt: skip
    return estimates


def _around(
    grid: Grid, wanted: npt.NDArray[np.bool_], level: int, dimension: int
) -> npt.NDArray[np.int64]:
    """Give the numbers of all points in and around the cubes of a level that hold wanted ones."""
    codes = grid.cells.codes >> (dimension * level)
    cubes = np.flatnonzero(np.r_[True, codes[1:] != codes[:-1]])
    starts = grid.cells.starts[:-1][cubes]
    marks = np.empty(len(cubes), np.bool_)
    has_wanted = np.logical_or.reduceat(wanted[grid.order], starts)
    mark_adjacent(codes[cubes], has_wanted, dimension, marks)
    sizes = np.diff(np.append(starts, len(grid.order)))
    return np.sort(grid.order[np.repeat(marks, sizes)])


def _fit(
    cell_normals: CellNormals,
    points: npt.NDArray[np.float64],
    numbers: npt.NDArray[np.int64],
    dimension: int,
    normal_radii: npt.NDArray[np.float64],
    curvature_radii: npt.NDArray[np.float64],
    cluster: float,
    corner: npt.NDArray[np.float64],
    estimates: npt.NDArray[np.float64],
) -> None:
    """Fill the rows that are numbered with fits to clusters of some size."""
    # What reaches a point lies in the blocks around its own, of 4^3 cells each (16^2 in 2D).
    anchors = cell_normals.anchors[:dimension].T
    grid = build_grid(anchors, cluster, corner)
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
        normal_radii,
        curvature_radii,
        estimates,
    )
