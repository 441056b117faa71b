"""Several scans, each moved to its place, as one cloud."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.formats.coordinates import split_coordinates

Columns = dict[str, npt.NDArray[Any]]

_SCAN = "scan"


class Scan(NamedTuple):
    """What was measured from one station.

    Attributes
    ----------
    points : ndarray of float64, shape (n, 3)
        Positions in the system of all scans, L; NaN where nothing was measured.
    columns : dict of str to ndarray, each of shape (n,)
        What else there is.
    """

    points: npt.NDArray[np.float64]
    columns: Columns


def cloud_of_scans(scans: Sequence[Scan], dim: int | None, comments: Sequence[str]) -> PointCloud:
    """Put scans into one cloud, one after the other.

    Parameters
    ----------
    scans : sequence of Scan
        Those of a file, in its order.
    dim : {2, 3} or None
        Number of coordinates; with 2 the third is a column.
    comments : sequence of str
        What the file says.

    Returns
    -------
    PointCloud
        The column ``scan`` counts scans from 0; columns that a scan lacks are NaN, or 0 where
        they are whole numbers.
    """
    xyz = np.concatenate([np.empty((0, 3)), *(scan.points for scan in scans)])
    points, height = split_coordinates(xyz, dim)
    numbers = np.arange(len(scans), dtype=np.min_scalar_type(max(len(scans), 1 << 16) - 1))
    numbers = np.repeat(numbers, [len(scan.points) for scan in scans])
    own = {_SCAN: numbers} if scans else {}
    return PointCloud(points, {**height, **own, **_joined(scans)}, comments=tuple(comments))


def _joined(scans: Sequence[Scan]) -> Columns:
    names = list(dict.fromkeys(name for scan in scans for name in scan.columns))
    joined: Columns = {}
    for name in names:
        found = [scan.columns.get(name) for scan in scans]
        kind = np.result_type(*(values for values in found if values is not None))
        missing = np.nan if kind.kind == "f" else 0
        joined[name] = np.concatenate(
            [
                np.full(len(scan.points), missing, kind) if values is None else values.astype(kind)
                for scan, values in zip(scans, found, strict=True)
            ]
        )
    return joined
