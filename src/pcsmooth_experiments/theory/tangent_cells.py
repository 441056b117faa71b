"""Voronoi cells of a sampled surface, seen in the tangent planes of its points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import Voronoi, cKDTree

from pcsmooth_experiments.sampled_shapes import SampledShape

#: Neighbours among which a cell's own are.
_NEIGHBORS = 32


@dataclass(frozen=True)
class TangentCells:
    """The plane cells of m points of a surface of revolution.

    Attributes
    ----------
    centroids : ndarray, shape (m, 3)
        Centres of mass of the cells, from their points, L.
    edge_shares : ndarray, shape (m, 2)
        Sum over the edges of length times distance times the square of the cosine between the
        edge's normal and the meridian, and the same for the parallel, over the area of the
        cell; both are 1 on average, and exactly on rectangles and regular hexagons.
    """

    centroids: npt.NDArray[np.float64]
    edge_shares: npt.NDArray[np.float64]


def tangent_cells(sample: SampledShape, numbers: npt.NDArray[np.int64]) -> TangentCells:
    """Find the cells of some points among the projections of their nearest ones.

    Parameters
    ----------
    sample : SampledShape
        Points of a surface around the z axis, dense compared with its curvature.
    numbers : ndarray of int, shape (m,)
        Which of them.

    Returns
    -------
    TangentCells
    """
    near = cKDTree(sample.points).query(sample.points[numbers], _NEIGHBORS)[1]
    parallels = np.cross([0.0, 0.0, 1.0], sample.points[numbers])
    parallels /= np.linalg.norm(parallels, axis=1, keepdims=True)
    frames = np.stack([np.cross(sample.normals[numbers], parallels), parallels], axis=1)
    arms = sample.points[near] - sample.points[numbers][:, np.newaxis]
    flat = np.einsum("mka,mfa->mkf", arms, frames)
    centroids, shares = np.empty((len(numbers), 2)), np.empty((len(numbers), 2))
    for i, places in enumerate(flat):
        diagram = Voronoi(places)
        ridges = np.flatnonzero((diagram.ridge_points == 0).any(axis=1))
        ends = diagram.vertices[np.array([diagram.ridge_vertices[ridge] for ridge in ridges])]
        others = places[diagram.ridge_points[ridges].max(axis=1)]  # the site is number 0
        distances = np.linalg.norm(others, axis=1) / 2.0
        weights = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) * distances
        area = weights.sum() / 2.0
        centroids[i] = (weights / 2.0) @ ends.sum(axis=1) / 3.0 / area
        shares[i] = weights @ (others / (2.0 * distances[:, np.newaxis])) ** 2 / area
    return TangentCells(np.einsum("mf,mfa->ma", centroids, frames), shares)
