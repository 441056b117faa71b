"""The report's own estimates of curvature: one gradient over one visible boundary each."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.balls import BallEnergy, BallUnion
from pcsmooth.energies.protocol import Quantity


def curvature_vectors(union: BallUnion, quantity: Quantity) -> npt.NDArray[np.float64]:
    """Mean curvature vectors of the points of a union, as the report estimates them.

    Parameters
    ----------
    union : BallUnion
        Measures of the union of balls.
    quantity : {"volume", "area"}
        Whose gradient.

    Returns
    -------
    ndarray, shape (n, d)
        (k1 + k2) / 2 (in 2D k) times the outward normal, 1/L; 0 for a point without visible
        boundary.

    Notes
    -----
    k1 + k2 is the gradient of the volume over r S_i (report, Prop. 6), or that of the boundary's
    area over S_i: what the flows weighted by the boundary move points by. Both hold in the limit
    of dense, even points.
    """
    evaluation = BallEnergy(union.radius, quantity, "boundary").of_union(union)
    masses = evaluation.masses * (union.dimension - 1)
    share = np.divide(1.0, masses, out=np.zeros(len(masses)), where=masses > 0.0)
    return evaluation.gradient * share[:, np.newaxis]
