"""How large a neighbourhood should be: the noise in the normals against the surface's change."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import CellNormals
from pcsmooth.errors import InvalidInputError
from pcsmooth.kernels.surface.nested_supports import fit_nested_supports
from pcsmooth.neighbors.grid import build_grid, levels_of
from pcsmooth.point_order import scattered_ranks

Support = int | Literal["auto"]

#: Fewest points of a neighbourhood.
_SMALLEST_SUPPORT = 3

#: Points at which supports are compared.
_SAMPLES = 400

#: Radii compared, in units of the cell normals' own: from 1 to 8 in steps of sqrt(2); on curves,
#: where neighbourhoods grow more slowly, to 16.
_RATIOS = {2: 2.0 ** (np.arange(9) / 2), 3: 2.0 ** (np.arange(7) / 2)}

#: How the variance of normals and shape operators falls with the radius R, in units of what it
#: is at R = 1: R^-a (c + 1) / (c + R^b), as (a, b, c) by dimension. It falls slowly at first
#: because neighbouring cell normals come from the same cells. Measured on spheres and circles
#: with noise of 0.1 to 0.7 spacings.
_NORMAL_NOISE = {2: (2.0, 0.0, 0.0), 3: (2.5, 0.0, 0.0)}
_SHAPE_NOISE = {2: (1.0, 3.5, 5.0), 3: (2.0, 4.0, 30.0)}

#: Most that the radius for curvature may be larger than that for normals: both are sums over the
#: same clusters. Where they would be farther apart, both give way.
_MOST_APART = 2.0

#: A best radius for normals below this, in units of the cell normals' own, is near it.
_COARSE = 1.5

#: Changes below this, squared, are rounding.
_EXACT = 1e-24

#: Changes used of those from the least on.
_BIASED = 3

#: Largest share of the points that a neighbourhood may have.
_LARGEST_SHARE = 0.25


@dataclass(frozen=True)
class Supports:
    """Radii of neighbourhoods.

    Attributes
    ----------
    normal_radius, curvature_radius : float
        In the unit of the extent; the second once to twice the first.
    normal_error : float
        Median error of the normals that is to be expected, as the length of a difference.
    may_be_finer : bool
        Whether the best radius is so near that of the cell normals that these may be smoother
        than the surface.
    """

    normal_radius: float
    curvature_radius: float
    normal_error: float
    may_be_finer: bool


@dataclass(frozen=True)
class NestedFits:
    """What normal and shape operator come out as in neighbourhoods of growing radius.

    Attributes
    ----------
    ratios : ndarray, shape (k,)
        Radii in units of the cell normals' own.
    normals, shapes : ndarray, shape (s, k, 3)
        Of each sample at each radius, without a unit.
    """

    ratios: npt.NDArray[np.float64]
    normals: npt.NDArray[np.float64]
    shapes: npt.NDArray[np.float64]


def sample_ranks(n: int) -> npt.NDArray[np.int64]:
    """Which of n points are looked at, in the order of their numbers."""
    return scattered_ranks(n, _SAMPLES)


def ratios_of_supports(n: int, dimension: int, count: int) -> npt.NDArray[np.float64]:
    """Radii to compare for a cloud of n points, in units of the cell normals' own."""
    largest = max(1.0, (_LARGEST_SHARE * n / count) ** (1.0 / (dimension - 1)))
    ratios = _RATIOS[dimension]
    return ratios[: max(2, int(np.searchsorted(ratios, largest, side="right")))]


def fit_supports(
    cell_normals: CellNormals,
    points: npt.NDArray[np.float64],
    dimension: int,
    samples: npt.NDArray[np.int64],
    extent: float | npt.NDArray[np.float64],
    ratios: npt.NDArray[np.float64],
    least_extent: float | None = None,
) -> NestedFits:
    """Fit normal and shape operator to the neighbourhoods of some points.

    Parameters
    ----------
    cell_normals : CellNormals
        Oriented normals.
    points : ndarray, shape (3, n)
        The points, in the same order.
    dimension : int
        d.
    samples : ndarray of int, shape (s,)
        Which points.
    extent : float or ndarray, shape (n,)
        Radius of the cell normals' own neighbourhoods, L: of all or of each point.
    ratios : ndarray, shape (k,)
        Radii in units of that.
    least_extent : float, optional
        Least of these radii of the whole cloud, L; by default that of these points.

    Returns
    -------
    NestedFits
    """
    extents = np.broadcast_to(extent, len(cell_normals.weights))
    least = np.min(extent) if least_extent is None else least_extent
    cell_size = float(least * ratios[-1])
    levels = None if np.ndim(extent) == 0 else levels_of(extents * ratios[-1], cell_size)
    grid = build_grid(cell_normals.anchors[:dimension].T, cell_size, levels=levels)
    places = np.empty(len(grid.order), np.int64)
    places[grid.order] = np.arange(len(grid.order))
    normals, shapes = fit_nested_supports(
        grid.coordinates,
        grid.order,
        grid.cells,
        points,
        cell_normals.normals,
        cell_normals.weights,
        dimension,
        places[samples],
        extents[samples],
        ratios,
    )
    # Without a unit, and so that squares add up to the Frobenius norm's.
    shapes *= extents[samples, np.newaxis, np.newaxis] * np.sqrt([1.0, 1.0, 2.0])
    return NestedFits(ratios, normals, shapes)


def choose_supports(fits: NestedFits, extent: float, dimension: int) -> Supports:
    """Choose the radii of the neighbourhoods for normals and for curvature.

    Parameters
    ----------
    fits : NestedFits
        What comes out at a sample of the points.
    extent : float
        Radius of the cell normals' own neighbourhoods, L, or in local spacings.
    dimension : int
        d.

    Returns
    -------
    Supports

    Notes
    -----
    At up to 400 points normal and shape operator are fitted to neighbourhoods of radius R = 1,
    sqrt(2), 2 ... 8 times that of the cell normals. What the estimate changes from one to the
    next is noise that the larger one lacks and bias that it adds: the median of its square is
    A (V(R) - V(R')) + B (R'^2 - R^2)^2. How noise falls with R, V, is the same for all clouds; the
    bias of a local fit grows with R^2. A and B are fitted, neither below 0, and the R is taken
    that makes A V(R) + B R^4 least. Nothing is assumed of the noise but that it differs from
    point to point.
    """
    normal_ratio, normal_error = _least_error(fits.ratios, fits.normals, _NORMAL_NOISE[dimension])
    shape_ratio, _ = _least_error(fits.ratios, fits.shapes, _SHAPE_NOISE[dimension])
    shape_ratio = max(normal_ratio, shape_ratio)
    may_be_finer = normal_ratio < _COARSE
    excess = max(1.0, shape_ratio / (_MOST_APART * normal_ratio))
    normal_ratio *= excess**0.5
    shape_ratio /= excess**0.5
    return Supports(normal_ratio * extent, shape_ratio * extent, normal_error, may_be_finer)


def _least_error(
    ratios: npt.NDArray[np.float64],
    fits: npt.NDArray[np.float64],
    noise: tuple[float, float, float],
) -> tuple[float, float]:
    """Ratio at which noise and bias together are least, and how large they are then.

    Fits (samples, ratios, components).
    """
    squares = np.sum(np.diff(fits, axis=1) ** 2, axis=2)
    squares = squares[np.isfinite(squares).all(axis=1)]
    if len(squares) == 0:
        return float(ratios[0]), math.inf
    changes = np.median(squares, axis=0)
    if not changes.min() > _EXACT:  # a plane, say: whatever the radius
        return float(ratios[0]), 0.0
    # Beyond the least change bias takes over; farther on it no longer grows as it does at first.
    changes = changes[: int(changes.argmin()) + _BIASED]
    near = ratios[: len(changes) + 1]
    parts = np.stack([-np.diff(_variance(near, noise)), np.diff(near**2) ** 2], axis=1)
    parts /= changes[:, np.newaxis]  # what matters is the relative error of the fit
    scales = parts.max(axis=0)
    parts /= scales
    weights = np.linalg.lstsq(parts, np.ones(len(changes)))[0]
    if weights.min() < 0.0:  # the other alone fits best then
        part = parts[:, weights.argmax()]
        weights = np.where(weights < 0.0, 0.0, part.sum() / (part @ part))
    fine = np.geomspace(ratios[0], ratios[-1], 200)
    errors = np.stack([_variance(fine, noise), fine**4], axis=1) @ (weights / scales)
    return float(fine[errors.argmin()]), math.sqrt(errors.min())


def _variance(
    ratios: npt.NDArray[np.float64], noise: tuple[float, float, float]
) -> npt.NDArray[np.float64]:
    a, b, c = noise
    return np.asarray(ratios**-a * (c + 1.0) / (c + ratios**b))


def limited_support(support: int, n: int) -> int:
    """Points that the neighbourhoods of n distinct points have, if so many are wanted."""
    return min(support, max(n, _SMALLEST_SUPPORT))


def radius_of_support(wanted: int, count: int, extent: float, dimension: int) -> float:
    """Radius of neighbourhoods of so many points, L, `count` points having the radius `extent`."""
    return float(extent * (wanted / count) ** (1.0 / (dimension - 1)))


def check_support(support: object) -> None:
    """Raise `InvalidInputError` unless it is "auto" or a number of points, 3 or more."""
    if isinstance(support, int | np.integer) and not isinstance(support, bool):
        is_usable = bool(support >= _SMALLEST_SUPPORT)
    else:
        is_usable = isinstance(support, str) and support == "auto"
    if not is_usable:
        raise InvalidInputError(
            f"support is {support!r}; it must be a number of points, "
            f"{_SMALLEST_SUPPORT} or more, or auto"
        )
