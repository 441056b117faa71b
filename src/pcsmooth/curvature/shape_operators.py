"""The shape operator of the surface at every point: how its normal turns with position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import CellNormals
from pcsmooth.kernels.grid.grid import mark_adjacent
from pcsmooth.kernels.surface.shape_operators import (
    N_ESTIMATES,
    cluster_moments,
    fit_shape_operators,
)
from pcsmooth.neighbors.grid import build_grid, cells_of_one_size, is_in_range

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
    least_radius: float | None = None,
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
    least_radius : float, optional
        Least curvature radius of the whole cloud, L; by default that of these points.

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
    fit = _Fit(
        cell_normals, points, dimension, np.atleast_1d(normal_radius),
        np.atleast_1d(curvature_radius), estimates,
    )  # fmt: skip
    anchors = cell_normals.anchors[:dimension].T
    if np.ndim(curvature_radius) == 0:
        grid = build_grid(anchors, float(curvature_radius) / CLUSTERS[dimension], corner)
        fit.to_clusters(grid.coordinates, grid.order, grid.cells.codes, grid.cells.starts, numbers)
        return estimates
    # Bands are cut, and clusters begin, where they do in every part of a cloud.
    if least_radius is None:
        least_radius = float(np.min(curvature_radius))
    octaves = np.log2(np.maximum(curvature_radius / least_radius, 1.0))
    bands = np.floor(_BANDS * octaves).astype(np.int64)
    present = np.unique(bands).tolist()
    finest = finest_cluster(least_radius, dimension)
    box = np.stack([anchors.min(axis=0), anchors.max(axis=0)])
    # Clusters of two bands an octave apart are cells of one grid and their families.
    families = (
        [(first, [band for band in present if band % _BANDS == first]) for first in range(_BANDS)]
        if is_in_range(box, finest, corner)
        else [(band, [band]) for band in present]
    )
    for first, members in families:
        if members:
            grid = build_grid(anchors, finest * 2.0 ** (first / _BANDS), corner)
            codes = np.repeat(grid.cells.codes, np.diff(grid.cells.starts))
        for band in members:
            clusters = codes >> (dimension * ((band - first) // _BANDS))
            wanted = bands == band
            chosen = _around(clusters, wanted[grid.order], dimension)
            clusters = clusters[chosen]
            starts = np.flatnonzero(np.r_[True, clusters[1:] != clusters[:-1]])
            fit.to_clusters(
                grid.coordinates[:, chosen], grid.order[chosen], clusters[starts],
                np.append(starts, len(clusters)), np.where(wanted, numbers, -1),
            )  # fmt: skip
    return estimates


def finest_cluster(least_radius: float, dimension: int) -> float:
    """Side of the smallest clusters, L, if radii differ, the least of which is given, L."""
    return float(least_radius * 2.0 ** (1.0 / _BANDS) / (1 << _BLOCK_BITS[dimension]))


def _around(
    clusters: npt.NDArray[np.int64], wanted: npt.NDArray[np.bool_], dimension: int
) -> npt.NDArray[np.int64]:
    """Give the places of all points in and around the blocks that hold wanted ones.

    By the codes of the clusters of points, (n,), increasing.
    """
    codes = clusters >> (dimension * _BLOCK_BITS[dimension])
    starts = np.flatnonzero(np.r_[True, codes[1:] != codes[:-1]])
    marks = np.empty(len(starts), np.bool_)
    has_wanted = np.logical_or.reduceat(wanted, starts)
    mark_adjacent(codes[starts], has_wanted, dimension, marks)
    return np.flatnonzero(np.repeat(marks, np.diff(np.append(starts, len(codes)))))


@dataclass(frozen=True, eq=False)
class _Fit:
    """Fits at points: see `find_shape_operators`."""

    cell_normals: CellNormals
    points: npt.NDArray[np.float64]
    dimension: int
    normal_radii: npt.NDArray[np.float64]
    curvature_radii: npt.NDArray[np.float64]
    estimates: npt.NDArray[np.float64]

    def to_clusters(
        self,
        coordinates: npt.NDArray[np.float64],
        order: npt.NDArray[np.int64],
        codes: npt.NDArray[np.int64],
        starts: npt.NDArray[np.int64],
        numbers: npt.NDArray[np.int64],
    ) -> None:
        """Fill the rows that are numbered, (n,), from the points of clusters.

        Coordinates of these, (3, k), and their numbers, (k,), in the order of the clusters, codes
        (m,) and starts (m + 1,) of these.
        """
        cluster_starts, moments = cluster_moments(
            coordinates, order, starts, self.cell_normals.normals, self.cell_normals.weights
        )
        # What reaches a point lies in the blocks around its own, of 4^3 cells each (16^2 in 2D).
        block_codes = codes >> (_BLOCK_BITS[self.dimension] * self.dimension)
        begins = np.flatnonzero(np.r_[True, block_codes[1:] != block_codes[:-1]])
        fit_shape_operators(
            coordinates, order, starts, cluster_starts, moments,
            cells_of_one_size(block_codes[begins], np.append(begins, len(block_codes))),
            self.points, self.cell_normals.normals, numbers, self.dimension, self.normal_radii,
            self.curvature_radii, self.estimates,
        )  # fmt: skip
