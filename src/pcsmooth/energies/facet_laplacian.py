"""The weighted graph Laplacians that the gradients of a union of balls are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.balls import BallUnion
from pcsmooth.energies.protocol import Quantity
from pcsmooth.kernels.balls.facet_weights import mirror_rows, upper_weights
from pcsmooth.kernels.threads import map_blocks
from pcsmooth.neighbors.grid import cube_starts


@dataclass(frozen=True)
class FacetLaplacian:
    """Symmetric sparse rows w_ij of L = diag(sum_j w_ij) - W, one weight >= 0 for each facet.

    Attributes
    ----------
    starts : ndarray of int, shape (n + 1,)
        Where the weights of each point begin; the points are those that carry a cell, in the
        order of the union's grid (see `BallUnion.numbers`).
    columns : ndarray of int32, shape (m,)
        The other point of each facet, in the same order.
    weights : ndarray, shape (m,)
        w_ij = w_ji to the last bit, L^(d-2) for the volume, L^(d-3) for the area.
    diagonal : ndarray, shape (n,)
        Sums of the rows.
    """

    starts: npt.NDArray[np.int64]
    columns: npt.NDArray[np.int32]
    weights: npt.NDArray[np.float64]
    diagonal: npt.NDArray[np.float64]


def facet_laplacian(union: BallUnion, quantity: Quantity) -> FacetLaplacian:
    """Find the weights w_ij of which the gradient is sum_j w_ij (p_i - p_j).

    Parameters
    ----------
    union : BallUnion
        The union.
    quantity : {"volume", "area"}
        Whose gradient.

    Returns
    -------
    FacetLaplacian
        For the volume w_ij = A_ij / abs(p_i - p_j), A_ij the measure of the facet; for the area
        r phi_ij / abs(p_i - p_j), phi_ij the visible angle of the facet's circle, in 2D
        m_ij r / (rho abs(p_i - p_j)), m_ij of the two points at the distance rho being visible. If
        radii are unequal, (r_i h_ji + r_j h_ij) / abs(p_i - p_j) takes the place of r, and the
        area's gradient has a part across p_i - p_j, too, which is left out.

    Notes
    -----
    The formulas are those of `measure_balls`. All facets are measured once more, which takes
    about twice as long as measuring the union.
    """
    grid = union.grid
    blocks = map_blocks(
        upper_weights,
        cube_starts(grid, union.dimension, are_unequal=union.radii is not None),
        grid.coordinates,
        grid.cells,
        union.dimension,
        union.radius,
        union.grid_radii,
        quantity == "area",
    )
    counts, columns, weights = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    return FacetLaplacian(*mirror_rows(counts, columns, weights))
