"""Which outliers lie above the surface around them, as birds do, and which below or within it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.neighbors.k_nearest import build_tree
from pcsmooth.parts.column import Column

#: Points that are the surroundings of an outlier.
_NEAREST = 12

#: Points that have a plane, and how little of its normal is upwards if it is upright (6 degrees).
_FEWEST, _UPRIGHT = 3, 0.1

#: By how much farther points may be than the last of these, lest it matters which of several at
#: one distance is taken for it.
_TIES = 1.0 + 1e-9


def high_outliers(points: Column, outliers: Column) -> npt.NDArray[np.bool_]:
    """Tell which outliers lie above the plane of the points that are nearest to them.

    Parameters
    ----------
    points : Column
        Positions, (d,).
    outliers : Column
        Marks of outliers, which are nobody's surroundings.

    Returns
    -------
    ndarray of bool, shape (m,)
        Of each outlier in the order of the rows; none is high in the plane.

    Notes
    -----
    The nearest points surround the foot of the perpendicular from the outlier to the surface, so
    that they tell its slope there. The result is the same however the columns are divided into
    chunks.
    """
    asked = np.concatenate(
        [chunk[marks != 0] for chunk, marks in zip(points.chunks(), outliers.chunks(), strict=True)]
    )
    count = len(asked)
    if count == 0 or asked.shape[1] == 2:
        return np.zeros(count, np.bool_)
    distances = np.full((count, _NEAREST), np.inf)
    for chunk, marks in zip(points.chunks(), outliers.chunks(), strict=True):
        if not marks.all():
            found, _ = build_tree(chunk[marks == 0]).query(asked, _NEAREST)
            distances = np.sort(np.hstack([distances, found]), axis=1)[:, :_NEAREST]
    known = np.isfinite(distances)
    reach = _TIES * np.max(distances, axis=1, initial=0.0, where=known)
    near: list[list[npt.NDArray[np.float64]]] = [[] for _ in range(count)]
    for chunk, marks in zip(points.chunks(), outliers.chunks(), strict=True):
        if marks.all():
            continue
        others = chunk[marks == 0]
        for row, found in enumerate(build_tree(others).query_ball_point(asked, reach)):
            near[row].append(others[found])
    return np.array([_is_above(point, around) for point, around in zip(asked, near, strict=True)])


def _is_above(point: npt.NDArray[np.float64], around: list[npt.NDArray[np.float64]]) -> bool:
    """Tell whether a point lies above the plane that fits others best, of which there may be none.

    Where that is upright it says nothing, and the point has to be higher than their mean.
    """
    others = np.concatenate([np.empty((0, 3)), *around])
    if len(others) == 0:
        return False
    others = others[np.lexsort(others.T)]  # sums are the same in whatever order they came
    center = others.mean(axis=0)
    normal = np.linalg.svd(others - center)[2][-1]
    if len(others) < _FEWEST or abs(normal[2]) < _UPRIGHT:
        return bool(point[2] > center[2])
    return bool((point - center) @ normal * normal[2] > 0.0)
