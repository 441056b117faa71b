"""The report's own estimates of curvature: one gradient over one visible boundary each."""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.balls import BallUnion

#: Visible share of a sphere below which rounding hides it: the point counts as covered.
_COVERED = 1e-12


def curvature_vectors(
    union: BallUnion, quantity: Literal["volume", "area"]
) -> npt.NDArray[np.float64]:
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
    area over S_i: the gradients of two layers around the surface, whose thickness r and number 2
    cancel. Both hold in the limit of dense, even points.
    """
    if quantity == "volume":
        gradient, unit = union.volume_gradient, union.radius
    else:
        gradient, unit = union.area_gradient, 1.0
    areas = union.visible_areas
    is_visible = areas > _COVERED * union.radius ** (union.dimension - 1)
    share = np.divide(1.0, unit * areas, out=np.zeros(len(areas)), where=is_visible)
    return gradient * (share / (union.dimension - 1))[:, np.newaxis]
