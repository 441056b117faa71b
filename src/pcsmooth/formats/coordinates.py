"""Points of two coordinates in formats that always have three."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.formats.number_text import is_value, parsed

Floats = npt.NDArray[np.float64]


def split_coordinates(xyz: Floats, dim: int | None) -> tuple[Floats, dict[str, npt.NDArray[Any]]]:
    """Part coordinates into positions and a column, if there is to be one.

    Parameters
    ----------
    xyz : ndarray, shape (n, 3)
        Coordinates of the file.
    dim : {2, 3} or None
        Number of coordinates of a position; None is 3.

    Returns
    -------
    points : ndarray, shape (n, d)
        Positions.
    columns : dict of str to ndarray
        The third coordinate as ``z`` where positions have two.
    """
    if dim != 2:
        return xyz, {}
    return np.ascontiguousarray(xyz[:, :2]), {"z": np.ascontiguousarray(xyz[:, 2])}


def three_coordinates(cloud: PointCloud) -> Floats:
    """Coordinates in space of every point, shape (n, 3).

    Of a plane cloud the third is the column ``z``, NaN where that holds words, or else 0.
    """
    if cloud.dimension == 3:
        return cloud.points
    z = cloud.columns.get("z", np.zeros(len(cloud)))
    if z.dtype.kind == "U":
        z = parsed([word if is_value(word) else "nan" for word in z.tolist()])
    return np.column_stack([cloud.points, z.astype(np.float64)])
