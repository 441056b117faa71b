"""Connected components of a cloud in parts, and normals that agree within them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import CellNormals
from pcsmooth.energies.balls import BallUnion
from pcsmooth.kernels.surface.forest_pieces import EDGE, exit_edges, span, thin
from pcsmooth.kernels.surface.parity_union_find import refer_to_lowest
from pcsmooth.kernels.surface.spanning_forest import join_alike
from pcsmooth.neighbors.grid import CUBE_LEVEL, cube_starts
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part

#: Cells around a cube of points that their normals and links depend on.
_CELLS_AROUND = 3


def links_reach(radius: float, dimension: int) -> float:
    """How far beyond the cells of balls it is looked to join the points of a part, L."""
    return 2.0 * radius * ((1 << CUBE_LEVEL[dimension]) + _CELLS_AROUND)


@dataclass(frozen=True, eq=False)
class Joined:
    """What could be joined within a part.

    Attributes
    ----------
    names : ndarray of int, shape (k,)
        Of each point that carries a cell, in the order of the union's grid, the lowest row among
        the points it has been joined to.
    signs : ndarray of int8, shape (k,)
        Sign of its normal relative to that point's.
    edges : ndarray of `EDGE`
        The lightest links between what has been joined.
    """

    names: npt.NDArray[np.int64]
    signs: npt.NDArray[np.int8]
    edges: npt.NDArray[np.void]


def join_in_part(part: Part, union: BallUnion, found: CellNormals) -> Joined:
    """Join the points of a part that are alike, and find the links from the own ones on."""
    numbers, dimension = union.numbers, union.dimension
    normals = found.normals[:dimension]
    cubes = cube_starts(union.grid, dimension, are_unequal=union.radii is not None)
    roots, signs = join_alike(normals, found.links, cubes)
    rows = part.rows[numbers]
    names, signs = refer_to_lowest(roots, signs, rows)
    is_own = np.zeros(len(part.rows), np.bool_)
    is_own[part.own] = True
    edges = exit_edges(normals, found.links, rows, names, signs, is_own[numbers])
    return Joined(names, signs, thin(edges))


@dataclass(frozen=True, eq=False)
class Components:
    """The component of every name that points were given in their parts.

    Attributes
    ----------
    names : ndarray of int, shape (k,)
        Increasing.
    labels : ndarray of int, shape (k,)
        Components, from 0.
    signs : ndarray of int8, shape (k,)
        Sign relative to the component's lowest row.
    count : int
        Number of components.
    """

    names: npt.NDArray[np.int64]
    labels: npt.NDArray[np.int64]
    signs: npt.NDArray[np.int8]
    count: int

    def look_up(
        self, names: npt.NDArray[np.int64]
    ) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int8]]:
        """Find component and sign of some names, (m,) each."""
        places = np.searchsorted(self.names, names)
        return self.labels[places], self.signs[places]


def join_parts(names: Column, edges: Iterable[npt.NDArray[np.void]]) -> Components:
    """Join what was joined in parts.

    Parameters
    ----------
    names : Column
        The name of each point, -1 for one that carries no cell.
    edges : iterable of ndarray of `EDGE`
        Of the parts.

    Returns
    -------
    Components

    Notes
    -----
    Signs are handed on along a minimum spanning forest of the graph of neighbours with weights
    1 - abs(n_i . n_j) (Hoppe et al. 1992), one tree in each connected component. The normal of the
    lowest row in a component stays as it is.
    """
    lightest = np.empty(0, EDGE)
    for more in edges:
        lightest = thin(np.concatenate([lightest, more])) if len(lightest) else more
    own, start = [], 0
    for chunk in names.chunks():
        own.append(chunk[chunk == np.arange(start, start + len(chunk))])
        start += len(chunk)
    known = np.concatenate(own)
    lowest = known.copy()
    signs = np.ones(len(known), np.int8)
    joined, root_of, sign_of = span(lightest)
    places = np.searchsorted(known, joined)
    lowest[places] = root_of
    signs[places] = sign_of
    components, labels = np.unique(lowest, return_inverse=True)
    return Components(known, labels, signs, len(components))
