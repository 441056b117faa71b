"""Whether the points of a surface are farther apart than a length, seen at samples of a cloud."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.surface.covering_neighborhoods import SEEN_FIRST
from pcsmooth.neighbors.coincident import Distinct
from pcsmooth.neighbors.local_spacing import BoxedPoints
from pcsmooth.parts.part import Parts

#: Samples, rows between two of them at least, consecutive points that are seen around one, and
#: points amid these of whose spacings it has the median.
_SAMPLES = 200
_LEAST_APART = 32
_LENGTH = 512
_AMID = 9

#: Largest share that the least variance of the offsets to nearest points has of the largest where
#: they lie on a surface, noise included.
_FLAT = 0.15

#: Least share of the samples that have to lie on a surface for them to tell about one.
_SURFACE = 0.3


def share_apart(parts: Parts, distinct: Distinct, length: float) -> float:
    """Tell at which share of a surface points are farther apart than a length, L.

    Parameters
    ----------
    parts : Parts
        The cloud.
    distinct : Distinct
        Its points that are the first at their position.
    length : float
        L.

    Returns
    -------
    float
        From 0 to 1, at up to 200 samples: of those around which points lie on a surface, the share
        whose local spacing is larger. 0 in the plane, and if there are few of them: points that
        fill space, stray ones and sheets nearer to each other than their points tell nothing.

    Notes
    -----
    Points follow each other along a Morton curve, so that most of those nearest to one are among
    the 512 around it. Nothing else is looked at: it takes some hundredths of a second, whatever
    the size of the cloud, and is the same in parts. It is no exact local spacing (see
    `local_spacings`): the median over nine points, of which some may be at the rim of what is seen.
    """
    if parts.dimension == 2 or distinct.count < _LENGTH:
        return 0.0
    every = max(parts.count // _SAMPLES, _LEAST_APART)
    amid = np.arange(every // 2, parts.count, every)
    rows, points = _read_around(parts, distinct, amid)
    numbers = np.searchsorted(rows, amid)[:, np.newaxis] + np.arange(_AMID) - _AMID // 2
    numbers = np.clip(numbers, 0, len(rows) - 1)
    found = BoxedPoints.of(points).spacings_at(numbers.ravel(), SEEN_FIRST)
    spacings = np.median(found.spacings.reshape(numbers.shape), axis=1)
    middle = _AMID // 2
    offsets = points[found.neighbors[middle::_AMID]] - points[numbers[:, middle], np.newaxis]
    variances = np.linalg.eigvalsh(offsets.transpose(0, 2, 1) @ offsets)
    is_flat = variances[:, 0] <= _FLAT * variances[:, -1]
    if np.count_nonzero(is_flat) < _SURFACE * len(is_flat):
        return 0.0
    return float(np.mean(spacings[is_flat] > length))


def _read_around(
    parts: Parts, distinct: Distinct, amid: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Read the distinct points of the stretches around some rows: rows (k,) and points (k, d)."""
    rows, points = [], []
    done = 0
    for row in amid.tolist():
        first = max(done, row - _LENGTH // 2)
        done = max(done, min(row + _LENGTH // 2, parts.count))
        marks = distinct.marks.read(first, done)
        rows.append(first + np.flatnonzero(marks))
        points.append(parts.start.read(first, done)[marks])
    return np.concatenate(rows), np.concatenate(points)
