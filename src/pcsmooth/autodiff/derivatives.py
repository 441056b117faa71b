"""Volume and boundary of a union, and their gradients by dual numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.autodiff.dual import seed, value_of
from pcsmooth.autodiff.edge_sums import Edges, parts_of, whole_ball
from pcsmooth.autodiff.shape import Shape

#: Edges that are differentiated at a time, to bound the memory.
_BLOCK = 16384


@dataclass(frozen=True)
class Derivatives:
    """Measures of a union of n equal shapes in d dimensions, point by point.

    Attributes
    ----------
    volumes : ndarray, shape (n,)
        Volume of each cell, L^d.
    areas : ndarray, shape (n,)
        Visible boundary of each shape, L^(d-1).
    volume_gradient : ndarray, shape (n, d)
        Gradient of the sum of the volumes, L^(d-1).
    area_gradient : ndarray, shape (n, d)
        Gradient of the sum of the areas, L^(d-2).
    """

    volumes: npt.NDArray[np.float64]
    areas: npt.NDArray[np.float64]
    volume_gradient: npt.NDArray[np.float64]
    area_gradient: npt.NDArray[np.float64]


def differentiate(points: npt.NDArray[np.float64], shape: Shape, edges: Edges) -> Derivatives:
    """Add up what the edges of a union add to its measures, in dual numbers.

    An edge depends on d + 2 points at most, so that each is differentiated along d (d + 2)
    directions, however many points there are.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Distinct points, L.
    shape : Shape
        The ball or polyhedron.
    edges : Edges
        The union's.

    Returns
    -------
    Derivatives
    """
    n, dimension = points.shape
    ball_volume, ball_area = (0.0, 0.0) if shape.ball is None else whole_ball(shape.ball, dimension)
    volumes, areas = np.full(n, ball_volume), np.full(n, ball_area)
    gradients = np.zeros((2, n, dimension))
    for first in range(0, len(edges), _BLOCK):
        block = edges[first : first + _BLOCK]
        slots = block.slots
        parts = parts_of(block, seed(points[slots]), shape)
        np.add.at(volumes, block.cells, value_of(parts.volumes))
        np.add.at(areas, block.owners, value_of(parts.areas))
        for gradient, part in zip(gradients, parts, strict=True):
            np.add.at(gradient, slots, part.derivatives.reshape(*slots.shape, dimension))
    return Derivatives(volumes, areas, *gradients)
