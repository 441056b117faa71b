"""The radii of a union's shapes, if they differ."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.positions import as_positions
from pcsmooth.real_numbers import real_array


def unequal_radii(points: npt.ArrayLike, radius: npt.ArrayLike) -> npt.NDArray[np.float64] | None:
    """Check the radii of n points, (n,); None if there is but one, or all are the same.

    Raises
    ------
    InvalidInputError
        If there are not as many as points, or one is not finite and positive; but a single one
        for all points is not looked at.
    """
    if np.ndim(radius) == 0:
        return None
    radii = real_array(radius, "radii")
    n = len(as_positions(points))
    if radii.shape != (n,):
        raise InvalidInputError(
            f"radii have shape {radii.shape}; there must be one for all points, or {n}"
        )
    bad = np.flatnonzero(~((radii > 0.0) & (radii < np.inf)))
    if bad.size:
        raise InvalidInputError(
            f"the radius of point {bad[0]} is {radii[bad[0]]}; it must be finite and positive"
        )
    return radii if radii.min(initial=np.inf) < radii.max(initial=0.0) else None
