"""How wide the cubes should be that a cloud is sorted by."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.point_order import HALVINGS, least_width
from pcsmooth.tiling.cubes import cube_codes
from pcsmooth.tiling.runs import equal_starts

#: Points of the sample that an occupied cube should hold in the mean: with fewer, the sample no
#: longer tells how full the fullest is, and cubes cost more than they save.
_SAMPLES_PER_CUBE = 4


def choose_width(
    sample: npt.NDArray[np.float64],
    count: int,
    corner: npt.NDArray[np.float64],
    extent: float,
    most: int,
) -> float:
    """Choose the widest cubes of which the fullest is expected to hold at most `most` points.

    Where no width brings that about (many points at one place), it is the widest at which the
    fullest cube is no fuller than at the least width tried. No smaller cubes are tried once they
    hold fewer than four points of the sample in the mean.

    Parameters
    ----------
    sample : ndarray, shape (s, d)
        Points taken evenly from the cloud, s >= 1, L.
    count : int
        Points of the cloud.
    corner : ndarray, shape (d,)
        Least coordinates of the cloud, L.
    extent : float
        Side of the cube around the cloud, L, >= 0.
    most : int
        Points of a cube, >= 1.

    Returns
    -------
    float
        extent / 2^k for a k of 0 .. 20, L; 1.0 if all points are at one place.

    Raises
    ------
    InvalidInputError
        The extent is negative or not finite, the sample is empty, or `most` is not positive.
    """
    if not (0.0 <= extent < np.inf and len(sample) and most >= 1):
        raise InvalidInputError(
            f"no width of cubes for {len(sample)} points, extent {extent} and {most} in a cube"
        )
    least = least_width(extent)
    if least > extent:  # all points are at one place
        return least
    # Halving is exact, so that the codes of wider cubes are those of the least without low bits.
    codes = np.sort(cube_codes(sample, corner, least))
    fullest = []
    for halvings in range(HALVINGS + 1):
        wider = codes >> sample.shape[1] * (HALVINGS - halvings)
        sizes = np.diff(equal_starts(wider), append=len(wider))
        fullest.append(int(sizes.max()))
        if fullest[-1] * count <= most * len(sample):
            break
        if len(sizes) * _SAMPLES_PER_CUBE > len(sample):
            break
    return float(extent / 2 ** fullest.index(min(fullest)))
