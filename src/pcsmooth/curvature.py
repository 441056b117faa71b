"""Normals and mean curvature of the surface under a cloud, from the measures of a union.

Conventions: mean curvature is H = (k1 + k2) / 2 in 3D and the curvature k in 2D, in 1/L,
positive where the surface bends away from the normal (a sphere of radius R with outward normals
has +1/R).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.protocol import UnionMeasures
from pcsmooth.kernels.neighbor_sums import sum_over_neighbors
from pcsmooth.neighbors import build_grid, nearest_neighbors
from pcsmooth.orientation import orient_normals

#: Points of a neighbourhood, the point itself included, by dimension.
SUPPORT = {2: 7, 3: 30}

#: Tensors summed and taken apart at a time, to bound memory.
_CHUNK = 1 << 16


def estimate_normals_and_curvature(
    points: npt.NDArray[np.float64],
    union: UnionMeasures,
    radius: float,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Estimate the normal and the mean curvature at every point.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions.
    union : UnionMeasures
        Measures of the union of balls or polyhedra of this radius centred there.
    radius : float
        Radius of the shapes, L; neighbourhoods reach 2 radius at most.

    Returns
    -------
    normals : ndarray, shape (n, d)
        Unit normals; outward on closed shapes (see `orient_normals`). Zero for a point that no
        other touches, where the data say nothing.
    mean_curvature : ndarray, shape (n,)
        H, 1/L; zero where the normal is.

    Notes
    -----
    The normal is the leading eigenvector of the visible-boundary tensors, summed over the 30
    nearest points (7 in 2D). Mean curvature is a measure: H = sum_j (volume_gradient_j . n_j) /
    sum_j |C_j|, over the same points, is k1 + k2 (report, Prop. 6, with the cell in place of the
    boundary and sums in place of points).
    """
    dimension = points.shape[1]
    carries = np.flatnonzero(union.carriers == np.arange(len(points)))
    grid = build_grid(points[carries], 2.0 * radius)
    carries = carries[grid.order]  # in grid order neighbours are close in memory too
    neighbors = nearest_neighbors(grid, dimension, SUPPORT[dimension], 2.0 * radius)
    is_alone = neighbors[:, 1] == len(carries)

    normals = _leading_directions(union.normal_tensors[carries], neighbors)
    normals[is_alone] = 0.0  # every direction is as good
    places = grid.coordinates[:dimension].T
    orient_normals(places, normals, union.visible_areas[carries], neighbors)

    bending = np.einsum("ij,ij->i", union.volume_gradient[carries], normals)
    sums = sum_over_neighbors(np.stack([bending, union.cell_volumes[carries]], axis=1), neighbors)
    has_cell = ~is_alone & (sums[:, 1] > 0.0)
    total_curvature = np.divide(sums[:, 0], sums[:, 1], out=np.zeros(len(sums)), where=has_cell)

    rank = np.empty(len(points), np.int32)
    rank[carries] = np.arange(len(carries))
    of_point = rank[union.carriers]
    return normals[of_point], total_curvature[of_point] / (dimension - 1)


def _leading_directions(
    tensors: npt.NDArray[np.float64], neighbors: npt.NDArray[np.int32]
) -> npt.NDArray[np.float64]:
    """Leading unit eigenvector of each sum of tensors over neighbours, (n, d)."""
    n, dimension, _ = tensors.shape
    rows = tensors.reshape(n, -1)
    directions = np.empty((n, dimension))
    for start in range(0, n, _CHUNK):
        chunk = slice(start, start + _CHUNK)
        summed = sum_over_neighbors(rows, neighbors[chunk]).reshape(-1, dimension, dimension)
        directions[chunk] = np.linalg.eigh(summed)[1][:, :, -1]
    return directions
