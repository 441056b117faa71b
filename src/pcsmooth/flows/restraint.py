"""What restrains the motion of points, whatever the scheme that moves them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import CELLS, CellNormals, find_cell_normals
from pcsmooth.energies.balls import BallUnion
from pcsmooth.flows.state import State

#: Cells that the normals of a step reach beyond the cells of its points.
_CELLS_OF_NORMALS = 2


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
        The mean normal displacement of each connected component is taken out (see `keep_volume`).
    longest : float
        Most that a point may end up away from its start, L.
    """

    along_normals: bool = False
    keeps_volume: bool = False
    longest: float = math.inf

    def reach(self, radius: float) -> float:
        """How far it looks beyond the scheme, along an axis, L, by the radius of the balls."""
        needs_normals = self.along_normals or self.keeps_volume
        return 2.0 * radius * _CELLS_OF_NORMALS if needs_normals else 0.0

    def restrain(
        self,
        state: State,
        vectors: npt.NDArray[np.float64],
        held: npt.NDArray[np.bool_],
        start: npt.NDArray[np.float64],
    ) -> npt.NDArray[np.float64]:
        """Take from displacements what is not allowed, whatever the volume.

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
        if self.along_normals:
            vectors = self.along(vectors, state.balls, self.normals_of(state.balls))
        return self.shorten(state.points, vectors, held, start)

    def normals_of(self, union: BallUnion) -> CellNormals:
        """Find the normals along which points may go."""
        dimension = union.dimension
        count, reach = CELLS[dimension][0], union.grid_reaches
        return find_cell_normals(union.grid, union.numbers, union, dimension, count, reach)

    def along(
        self, vectors: npt.NDArray[np.float64], union: BallUnion, found: CellNormals
    ) -> npt.NDArray[np.float64]:
        """Leave of displacements (n, d) what goes along the normals, if only that is allowed."""
        if not self.along_normals:
            return vectors
        normals = found.normals[: union.dimension]
        lengths = np.einsum("ij,ij->j", vectors[union.numbers].T, normals)
        kept = np.zeros_like(vectors)
        kept[union.numbers] = (lengths * normals).T
        return kept[union.carriers]

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


#: Points go where the scheme takes them.
FREE = Restraint()
