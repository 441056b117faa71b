"""The number type in which the positions of a cloud are written."""

from __future__ import annotations

from typing import Any

import numpy as np

from pcsmooth.cloud import PointCloud


def written_position_type(cloud: PointCloud) -> np.dtype[Any]:
    """Type that the positions of a cloud get in a file.

    Parameters
    ----------
    cloud : PointCloud
        The cloud to be written.

    Returns
    -------
    numpy.dtype
        ``cloud.position_type`` if it is float32 or float64; otherwise float64, because whole
        numbers cannot hold points that have moved.

    Examples
    --------
    >>> written_position_type(PointCloud(np.zeros((1, 3)), position_type=np.dtype(np.int16)))
    dtype('float64')
    """
    if cloud.position_type in (np.float32, np.float64):
        return cloud.position_type.newbyteorder("=")
    return np.dtype(np.float64)
