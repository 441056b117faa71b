"""The positions that a cloud had before it was denoised."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.files.output_columns import ways_back_of, without_estimates


def undone(cloud: PointCloud, path: str) -> PointCloud:
    """Take a denoised cloud back to where its points were.

    Parameters
    ----------
    cloud : PointCloud
        What was read of a file that was written with its displacement (see `Writing`).
    path : str
        The file, for messages.

    Returns
    -------
    PointCloud
        Positions of the input, without the columns and comments that the run added. They are
        exact: the difference of a coordinate and one within half and twice of it has no rounding
        (Sterbenz). Where a coordinate was smaller than its own displacement, it comes back to
        10^-16 of that, which is exact, too, but where positions are double.

    Raises
    ------
    CloudFileError
        It was not written so.
    """
    ways_back = ways_back_of(cloud)
    if ways_back is None:
        columns = " ".join(("dx", "dy", "dz")[: cloud.dimension])
        raise CloudFileError(
            path,
            f"it has no columns {columns} by which its points find back",
            "they are written by denoise --write-displacement",
        )
    points = np.where(ways_back == 0.0, cloud.points, cloud.points + ways_back)  # keeps -0.0
    return replace(without_estimates(cloud), points=points)
