"""The radii of a union's shapes, if they differ."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.neighbors.local_radii import UnequalRadii
from pcsmooth.positions import as_positions
from pcsmooth.real_numbers import real_array


def unequal_radii(points: npt.ArrayLike, radius: npt.ArrayLike) -> UnequalRadii | None:
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
    least, largest = float(radii.min(initial=np.inf)), float(radii.max(initial=0.0))
    return UnequalRadii(radii, least, largest) if least < largest else None
