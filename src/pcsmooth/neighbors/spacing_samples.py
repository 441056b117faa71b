"""Whether the points of a surface are farther apart than a length, seen at samples of a cloud."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.surface.covering_neighborhoods import (
    COVERED,
    LARGER,
    LARGEST,
    NEXT_LINE,
    SEEN_FIRST,
)
from pcsmooth.neighbors.coincident import Distinct
from pcsmooth.neighbors.k_nearest import k_nearest
from pcsmooth.neighbors.local_spacing import LEAST
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
    found, nearest = spacings_of_samples(points, numbers.ravel())
    spacings = np.median(found.reshape(numbers.shape), axis=1)
    offsets = nearest[_AMID // 2 :: _AMID, :SEEN_FIRST]
    variances = np.linalg.eigvalsh(offsets.transpose(0, 2, 1) @ offsets)
    is_flat = variances[:, 0] <= _FLAT * variances[:, -1]
    if np.count_nonzero(is_flat) < _SURFACE * len(is_flat):
        return 0.0
    return float(np.mean(spacings[is_flat] > length))


def spacings_of_samples(
    points: npt.NDArray[np.float64], numbers: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Measure the spacing at a few points of a surface as `measure_spacings` does.

    That kernel would have to be compiled in every first run, for a few points.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Distinct positions, L, n > 128.
    numbers : ndarray of int, shape (s,)
        Which of them.

    Returns
    -------
    spacings : ndarray, shape (s,)
        L.
    offsets : ndarray, shape (s, 128, 3)
        To the nearest other points, L, by distance.
    """
    distances, nearest = k_nearest(points, points[numbers], LARGEST + 1)
    distances = distances[:, 1:]
    offsets = points[nearest[:, 1:]] - points[numbers, np.newaxis]
    least = LEAST[3]
    smaller, larger = [SEEN_FIRST], [SEEN_FIRST]
    while smaller[-1] > least:
        smaller.append(max(int(smaller[-1] / LARGER), least))
    while larger[-1] < LARGEST:
        larger.append(min(max(int(LARGER * larger[-1]), larger[-1] + 1), LARGEST))
    sizes = np.array([*smaller, *larger[1:]])
    covered = _cover(offsets, sizes)
    n_smaller = len(smaller)
    # Smaller ones as long as they cover the surface, else the first larger one that does.
    n_covered = np.cumprod(covered[:, :n_smaller], axis=1).sum(axis=1)
    first = covered[:, n_smaller:].argmax(axis=1) + n_smaller
    ever = covered[:, n_smaller:].any(axis=1)
    place = np.where(n_covered > 0, n_covered - 1, np.where(ever, first, 0))
    size = sizes[place]
    spacings = distances[:, :least].mean(axis=1)
    sums = np.cumsum(distances, axis=1)
    each = np.arange(len(numbers))
    share = (least / size) ** 2
    wide = share * sums[each, size - 1] / size
    wide += (1.0 - share) * NEXT_LINE * distances[each, size - 1]
    return np.where((n_covered > 0) | ever, wide, spacings), offsets


def _cover(offsets: npt.NDArray[np.float64], sizes: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Tell whether the first so many offsets (s, k, 3) of each point cover a surface, (s, sizes).

    They do if the second eigenvalue of their moments is not far below the first.
    """
    products = offsets[:, :, [0, 0, 0, 1, 1, 2]] * offsets[:, :, [0, 1, 2, 1, 2, 2]]
    moments = np.cumsum(products, axis=1)[:, sizes - 1]
    variances = np.linalg.eigvalsh(moments[..., [[0, 1, 2], [1, 3, 4], [2, 4, 5]]])
    return np.asarray(variances[..., 1] >= COVERED * variances[..., 2])


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
