"""The shape whose translates form a union: a ball, or a convex polyhedron."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

#: Half the side of the cube around a ball, in radii; above 1, lest they touch.
_CUBE = 2.0


@dataclass(frozen=True)
class Shape:
    """A ball, or a polyhedron {x : normals x <= offsets}, around the origin.

    Attributes
    ----------
    normals : ndarray, shape (F, d)
        Unit normals; for a ball those of a cube around it, so that its cells are polyhedra too.
    offsets : ndarray, shape (F,)
        Distances of the facets, L, > 0.
    ball : float or None
        Radius of the ball, L.
    """

    normals: npt.NDArray[np.float64]
    offsets: npt.NDArray[np.float64]
    ball: float | None = None

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return int(self.normals.shape[1])


def ball_shape(radius: float, dimension: int) -> Shape:
    """Make a ball, in a cube that does not touch it."""
    axes = np.eye(dimension)
    return Shape(np.r_[axes, -axes], np.full(2 * dimension, _CUBE * radius), radius)
