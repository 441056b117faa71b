"""What restrains the motion of points, whatever the scheme that moves them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import CELLS, CellNormals, find_cell_normals
from pcsmooth.curvature.oriented_normals import agree_in_components
from pcsmooth.flows.state import State
from pcsmooth.neighbors import cube_starts


@dataclass(frozen=True)
class Restraint:
    """How points may move in a step.

    Attributes
    ----------
    along_normals : bool
        Only the normal component of each displacement is taken: nothing slides along the surface,
        so that no holes open and borders do not creep inwards. The normals are those of the
        visible boundary, summed over the 30 nearest cells (2D: 5); points that have none rest.
    keeps_volume : bool
        The mean normal displacement of each connected component is taken out, each point weighted
        by its share of the surface, the mean cell of its 8 to 10 nearest: its own is larger for
        points that noise has moved to the outside of a bend, which are those to move in. The
        volume that a closed component encloses then changes only by terms of second order.
    longest : float
        Most that a point may end up away from its start, L.
    """

    along_normals: bool = False
    keeps_volume: bool = False
    longest: float = math.inf

    def restrain(
        self,
        state: State,
        vectors: npt.NDArray[np.float64],
        held: npt.NDArray[np.bool_],
        start: npt.NDArray[np.float64],
    ) -> npt.NDArray[np.float64]:
        """Take from displacements what is not allowed.

        Parameters
        ----------
        state : State
            Where the points are.
        vectors : ndarray, shape (n, d)
            Their displacements, L, equal for coincident points and 0 for those that are held.
        held : ndarray of bool, shape (n,)
            Points that do not move.
        start : ndarray, shape (n, d)
            Where the points were before the first step, L.

        Returns
        -------
        ndarray, shape (n, d)
            The displacements that are left, 0 for the points that are held.
        """
        if self.along_normals or self.keeps_volume:
            vectors = self._restrain_along_normals(state, vectors, held)
        return self.shorten(state.points, vectors, held, start)

    def shorten(
        self,
        points: npt.NDArray[np.float64],
        vectors: npt.NDArray[np.float64],
        held: npt.NDArray[np.bool_],
        start: npt.NDArray[np.float64],
    ) -> npt.NDArray[np.float64]:
        """Let no point end up farther from its start than it may: see `restrain`."""
        if self.longest < math.inf:
            way = points + vectors - start
            lengths = np.linalg.norm(way, axis=1)
            far = (lengths > self.longest) & ~held
            vectors = vectors.copy()
            shares = self.longest / lengths[far]
            vectors[far] = start[far] + shares[:, np.newaxis] * way[far] - points[far]
        return vectors

    def _restrain_along_normals(
        self,
        state: State,
        vectors: npt.NDArray[np.float64],
        held: npt.NDArray[np.bool_],
    ) -> npt.NDArray[np.float64]:
        union = state.balls
        numbers, dimension = union.numbers, union.dimension
        found = find_cell_normals(
            union.grid, numbers, union, dimension, CELLS[dimension][0], 2.0 * union.radius
        )
        normals = found.normals[:dimension]
        kept = vectors[numbers].T
        if self.keeps_volume:
            blocks = cube_starts(union.grid, dimension)
            labels, count = agree_in_components(normals, found.links, numbers, blocks)
        along = np.einsum("ij,ij->j", kept, normals)
        if self.along_normals:
            kept = along * normals
        if self.keeps_volume:
            shares = np.where(held[numbers], 0.0, _mean_over_links(found))
            totals = np.bincount(labels, shares, count)
            means = np.bincount(labels, shares * along, count)
            np.divide(means, totals, out=means, where=totals > 0.0)
            kept = kept - np.where(held[numbers], 0.0, means[labels]) * normals
        restrained = np.zeros_like(vectors)
        restrained[numbers] = kept.T
        return restrained[union.carriers]


def _mean_over_links(found: CellNormals) -> npt.NDArray[np.float64]:
    """Mean of the cells' volumes over each point and the nearest others, (n,)."""
    weights = np.append(found.weights, 0.0)  # there is no point n
    count = 1 + np.count_nonzero(found.links < len(found.links), axis=1)
    return np.asarray((found.weights + weights[found.links].sum(axis=1)) / count)


#: Points go where the scheme takes them.
FREE = Restraint()
