"""The columns in which estimates are written, by the names that other programs know.

MeshLab takes nx ny nz and `quality`, CloudCompare nx ny nz and what contains `scalar`, PCL and
PDAL nx ny nz and `curvature`; files of text get one column of each kind.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import NORMALS, PointCloud

#: Names of the mean curvature and of the displacement, in PLY and in text.
_CURVATURE_NAMES = {
    True: ("quality", "scalar_mean_curvature", "curvature"),
    False: ("mean_curvature",),
}
_DISPLACEMENT_NAMES = {True: "scalar_displacement", False: "displacement"}

#: How every comment of pcsmooth begins, and the one that lists the columns it wrote.
_SIGNATURE = "pcsmooth "
_COLUMNS = _SIGNATURE + "columns: "

_UNITS = "units: radius, spacing and displacement in coordinate units, curvature in 1/unit"
_SIGNS = {
    2: "signs: curvature k of the curve, positive where it bends away from the normal "
    "(+1/R on a circle with outward normals)",
    3: "signs: mean curvature H=(k1+k2)/2, positive where the surface bends away from the normal "
    "(+1/R on a sphere with outward normals)",
}


def with_estimates(
    cloud: PointCloud,
    points: npt.NDArray[np.float64],
    normals: npt.NDArray[np.float64],
    mean_curvature: npt.NDArray[np.float64],
    displacement: npt.NDArray[np.float64],
    *,
    is_ply: bool,
    provenance: str,
) -> tuple[PointCloud, list[str]]:
    """Put new positions and estimates into a cloud.

    Parameters
    ----------
    cloud : PointCloud
        What was read; its other columns and comments are kept.
    points, normals : ndarray, shape (n, d)
        New positions and unit normals.
    mean_curvature, displacement : ndarray, shape (n,)
        Estimates, written as float32.
    is_ply : bool
        Whether the names are for PLY or for text.
    provenance : str
        What was done with which values; becomes a comment, together with units and signs.

    Returns
    -------
    cloud : PointCloud
        The new cloud. Columns that exist keep their place.
    kept : list of str
        Names of estimates left out because the file uses the name for something else.
    """
    values: dict[str, npt.NDArray[Any]] = {}
    for axis, name in enumerate(NORMALS):
        if axis < cloud.dimension:
            values[name] = _as_float(normals[:, axis])
        elif is_ply:
            values[name] = np.zeros(len(cloud), np.float32)
    for name in _CURVATURE_NAMES[is_ply]:
        values[name] = _as_float(mean_curvature)
    values[_DISPLACEMENT_NAMES[is_ply]] = _as_float(displacement)

    kept = []
    if is_ply:  # text has no comments to tell whose a column is; its names are plain enough
        own = {*NORMALS, *_own_columns(cloud.comments)}
        kept = [name for name in values if name in cloud.columns and name not in own]
    for name in kept:
        del values[name]
    columns = {**cloud.columns, **values}
    lines = [
        _COLUMNS + " ".join(values),
        *(_SIGNATURE + text for text in (_UNITS, _SIGNS[cloud.dimension])),
    ]
    comments = [
        comment
        for comment in cloud.comments
        if comment not in lines and not comment.startswith(_COLUMNS)
    ]
    comments += [_SIGNATURE + provenance, *lines]
    return replace(cloud, points=points, columns=columns, comments=tuple(comments)), kept


def _as_float(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """Turn into float32; what is too large for it becomes its largest number, not infinity."""
    largest = np.finfo(np.float32).max
    return np.clip(values, -largest, largest).astype(np.float32)


def _own_columns(comments: Iterable[str]) -> list[str]:
    """Columns that an earlier run says it wrote."""
    return [
        name
        for comment in comments
        if comment.startswith(_COLUMNS)
        for name in comment.removeprefix(_COLUMNS).split()
    ]
