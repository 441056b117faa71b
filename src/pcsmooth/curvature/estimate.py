"""Normals and curvatures of a cloud: from positions as they come to one estimate per point.

Conventions: H = (k1 + k2) / 2 in 3D and the curvature k in 2D, in 1/L, positive where the surface
bends away from the normal (a sphere of radius R with outward normals has +1/R).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import CELLS, CellNormals, find_cell_normals
from pcsmooth.curvature.orientation import Orientation, parse_orientation
from pcsmooth.curvature.oriented_normals import orient_normals
from pcsmooth.curvature.report import curvature_vectors
from pcsmooth.curvature.shape_operators import find_shape_operators
from pcsmooth.curvature.support import (
    Supports,
    choose_supports,
    fit_supports,
    ratios_of_supports,
    sample_ranks,
)
from pcsmooth.energies.balls import BallUnion, measure_balls
from pcsmooth.energies.protocol import Quantity
from pcsmooth.errors import InvalidInputError
from pcsmooth.kernels.surface import shape_operators as columns
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.lengths import check_radius, resolve_radius
from pcsmooth.neighbors import cube_starts, mean_spacing
from pcsmooth.point_order import take_in_order
from pcsmooth.positions import LARGEST, as_positions, usable_rows
from pcsmooth.real_numbers import real_array
from pcsmooth.unit_of_length import unit_for, unit_near

Estimator = Literal["cells", "report"]
Support = int | Literal["auto"]

#: What an estimate consists of.
STAGES = ("spacing", "cells", "curvature")

#: Fewest points of a neighbourhood.
_SMALLEST_SUPPORT = 3


@dataclass(frozen=True)
class CurvatureEstimate:
    """Normals and curvatures at the points of a cloud, row i being row i of the input.

    Attributes
    ----------
    normals : ndarray, shape (n, d)
        Unit normals; zero where unknown: for a point that no other touches or that is not
        finite. Curvatures and confidence are zero there.
    mean_curvature : ndarray, shape (n,)
        (k1 + k2) / 2, in 2D k, 1/L, positive where the surface bends away from the normal.
    gaussian_curvature : ndarray, shape (n,)
        k1 k2, 1/L^2; in 2D k, 1/L.
    principal_curvatures : ndarray, shape (n, d - 1)
        k1 >= k2, in 2D k, 1/L.
    confidence : ndarray, shape (n,)
        From 0 to 1: 1 minus the RMS distance between the cell normals of the neighbourhood and
        the fitted ones. Near 1 on a smooth surface; noise, edges and thin neighbourhoods lower
        it.
    radius, spacing : float
        Radius of the balls and mean spacing, L.
    normal_support, curvature_support : float
        Points of a neighbourhood for normals and for curvature, on average where points are
        even.
    orientation : mapping of str to int
        How many connected components got the sign of their normals for which reason: outward,
        axis (open sheets: along the positive leading axis), input, viewpoint, direction,
        propagate.
    finite : ndarray of bool, shape (n,)
        False for rows with a NaN, an infinity or a coordinate beyond 1e150.

    Notes
    -----
    The estimator ``report`` gives no Gaussian and principal curvatures: in 3D they are NaN. Its
    mean curvature has the length of the report's vector and is set along the fitted normal; its
    confidence is the share of that vector that is normal.
    """

    normals: npt.NDArray[np.float64]
    mean_curvature: npt.NDArray[np.float64]
    gaussian_curvature: npt.NDArray[np.float64]
    principal_curvatures: npt.NDArray[np.float64]
    confidence: npt.NDArray[np.float64]
    radius: float
    spacing: float
    normal_support: float
    curvature_support: float
    orientation: Mapping[str, int]
    finite: npt.NDArray[np.bool_]

    @property
    def mean_curvature_vectors(self) -> npt.NDArray[np.float64]:
        """Mean curvature times normal, (n, d), 1/L, whatever its sign: the way area grows."""
        return self.mean_curvature[:, np.newaxis] * self.normals

    def scaled(self, factor: float) -> CurvatureEstimate:
        """Return the same of a cloud times a factor."""
        dimension = self.normals.shape[1]
        return replace(
            self,
            mean_curvature=self.mean_curvature / factor,
            gaussian_curvature=self.gaussian_curvature / factor ** (dimension - 1),
            principal_curvatures=self.principal_curvatures / factor,
            radius=self.radius * factor,
            spacing=self.spacing * factor,
        )


def estimate_curvature(
    points: npt.ArrayLike,
    *,
    radius: float | str = "auto",
    support: Support = "auto",
    estimator: Estimator = "cells",
    energy: Quantity = "volume",
    orient: str = "auto",
    normals: npt.ArrayLike | None = None,
    threads: int | None = None,
    on_stage: Callable[[str], None] | None = None,
) -> CurvatureEstimate:
    """Estimate normals and curvatures of the surface under a cloud; no point moves.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3)
        Positions, L. Rows with a NaN, an infinity or a masked coordinate take no part.
    radius : float or str
        Radius of the balls: a length, ``"3x"`` the spacing, ``"2%"`` of the bounding box's
        diagonal, or ``"auto"``, twice the spacing.
    support : int or "auto"
        Points of the neighbourhood to which normal and shape operator are fitted, >= 3, and of
        that whose cells give a normal, if it is less than 30 (2D: 5); chosen from the noise
        measured in the cloud by default (see `choose_supports`).
    estimator : {"cells", "report"}
        Fit to the normals of the cells, or the report's gradient over visible boundary.
    energy : {"volume", "area"}
        Whose gradient, for the estimator ``report``.
    orient : str
        Where normals point: ``"auto"``, ``"outward"``, ``"propagate"``, ``"input"``,
        ``"viewpoint=X,Y,Z"`` or ``"direction=X,Y,Z"`` (see `orient_normals`).
    normals : array_like, shape (n, d), optional
        Normals of the input, whose signs ``"input"`` and ``"auto"`` take over.
    threads : int, optional
        Threads to use, all by default. The result does not depend on it.
    on_stage : callable, optional
        Called with the name of each of the `STAGES` as it begins.

    Returns
    -------
    CurvatureEstimate

    Raises
    ------
    InvalidInputError
        Wrong shapes or option values, no finite point, or a radius that cannot be derived.

    Notes
    -----
    Permuted rows give the permuted result, to the last bit, as in `denoise`.

    Examples
    --------
    >>> angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    >>> estimate = estimate_curvature(2 * np.c_[np.cos(angle), np.sin(angle)])
    >>> bool(np.allclose(estimate.mean_curvature, 0.5, rtol=0.01))
    True
    """
    positions = as_positions(points)
    check_radius(radius)
    check_support(support)
    if estimator not in ("cells", "report"):
        raise InvalidInputError(f"estimator is {estimator!r}; it must be cells or report")
    if energy not in ("volume", "area"):
        raise InvalidInputError(f"energy is {energy!r}; it must be volume or area")
    orientation = parse_orientation(orient)
    given = given_normals(normals, positions.shape, orientation)
    finite = usable_rows(positions)
    if not finite.any():
        raise InvalidInputError("there is no point with finite coordinates; nothing to estimate")

    tell = on_stage if on_stage is not None else lambda _stage: None
    with thread_limit(threads) as n_threads:
        tell(STAGES[0])
        taken = take_in_order(positions, finite, given)
        local, rows = taken.points, taken.rows
        spacing = mean_spacing(local, n_threads)
        unit = unit_for(local, spacing)
        local, spacing = local / unit, spacing / unit
        length = resolve_radius(radius, local, spacing, unit)
        tell(STAGES[1])
        union = measure_balls(local, length)
        tell(STAGES[2])
        estimate = estimate_on_union(
            local,
            union,
            length,
            spacing,
            support=support,
            orientation=orientation.seen_from(taken.origin, unit),
            given=None if given is None else given[rows],
        )
        if estimator == "report":
            estimate = _by_report(estimate, union, energy)
    return spread_over(rows, finite, estimate.scaled(unit))


def estimate_on_union(
    points: npt.NDArray[np.float64],
    union: BallUnion,
    radius: float,
    spacing: float,
    *,
    support: Support,
    orientation: Orientation,
    given: npt.NDArray[np.float64] | None,
    is_smoothed: bool = False,
) -> CurvatureEstimate:
    """Estimate normals and curvatures from the measures of the union around finite points.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Finite positions, L.
    union : BallUnion
        Measures of the union of balls centred there.
    radius, spacing : float
        Radius of the balls and mean spacing, L.
    support : int or "auto"
        Points of a neighbourhood.
    orientation : Orientation
        Where normals point, in the frame of the points.
    given : ndarray, shape (n, d), optional
        Normals of the input.
    is_smoothed : bool
        Whether a flow has gone over the points. What noise is left is smooth then, and would
        pass for shape in the finest neighbourhoods: they are not tried.

    Returns
    -------
    CurvatureEstimate
    """
    dimension = points.shape[1]
    grid = union.grid
    numbers = union.numbers  # in grid order neighbours are close in memory too
    # Only their shares matter.
    areas = union.visible_areas[numbers] / unit_near(radius) ** (dimension - 1)

    def oriented_normals(count: int) -> tuple[CellNormals, Mapping[str, int]]:
        found = find_cell_normals(grid, numbers, union, dimension, count, 2.0 * radius)
        reasons = orient_normals(
            grid.coordinates[:dimension],
            found.normals[:dimension],
            areas,
            found.links,
            orientation,
            None if given is None else given[numbers].T,
            numbers,
            cube_starts(grid, dimension),
        )
        return found, reasons

    def supports_for(found: CellNormals, count: int) -> Supports:
        samples = np.argsort(numbers, kind="stable")[sample_ranks(len(numbers))]
        ratios = ratios_of_supports(len(numbers), dimension, count)
        fits = fit_supports(found, grid.coordinates, dimension, samples, found.extent, ratios)
        return choose_supports(fits, found.extent, dimension)

    if support == "auto":
        (count, *smaller) = CELLS[dimension]
        found, reasons = oriented_normals(count)
        supports = supports_for(found, count)
        for fewer in smaller:
            if supports.may_be_finer and not is_smoothed:
                finer, finer_reasons = oriented_normals(fewer)
                others = supports_for(finer, fewer)
                if others.normal_error < supports.normal_error:
                    count, found, reasons, supports = fewer, finer, finer_reasons, others
        radii = (supports.normal_radius, supports.curvature_radius)
    else:
        wanted = limited_support(support, len(numbers))
        count = min(wanted, CELLS[dimension][0])
        found, reasons = oriented_normals(count)
        radii = (radius_of_support(wanted, count, found.extent, dimension),) * 2
    estimates = find_shape_operators(
        found, grid.coordinates, numbers, len(points), dimension, *radii
    )
    if len(numbers) < len(points):
        estimates = estimates[union.carriers]
    points_of = [count * (length / found.extent) ** (dimension - 1) for length in radii]
    return CurvatureEstimate(
        normals=estimates[:, :dimension],
        mean_curvature=estimates[:, columns.MEAN],
        gaussian_curvature=estimates[:, columns.GAUSSIAN],
        principal_curvatures=estimates[:, columns.PRINCIPAL : columns.PRINCIPAL + dimension - 1],
        confidence=estimates[:, columns.CONFIDENCE],
        radius=radius,
        spacing=spacing,
        normal_support=points_of[0],
        curvature_support=points_of[1],
        orientation=reasons,
        finite=np.ones(len(points), np.bool_),
    )


def limited_support(support: int, n: int) -> int:
    """Points that the neighbourhoods of n distinct points have, if so many are wanted."""
    return min(support, max(n, _SMALLEST_SUPPORT))


def radius_of_support(wanted: int, count: int, extent: float, dimension: int) -> float:
    """Radius of neighbourhoods of so many points, L, `count` points having the radius `extent`."""
    return float(extent * (wanted / count) ** (1.0 / (dimension - 1)))


def spread_over(
    rows: npt.NDArray[np.int64], finite: npt.NDArray[np.bool_], estimate: CurvatureEstimate
) -> CurvatureEstimate:
    """Put the estimates of the finite points into their rows of all; the others get zeros."""

    def spread(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        spread_values = np.zeros((len(finite), *values.shape[1:]))
        spread_values[rows] = values
        return spread_values

    return replace(
        estimate,
        normals=spread(estimate.normals),
        mean_curvature=spread(estimate.mean_curvature),
        gaussian_curvature=spread(estimate.gaussian_curvature),
        principal_curvatures=spread(estimate.principal_curvatures),
        confidence=spread(estimate.confidence),
        finite=finite,
    )


def _by_report(
    estimate: CurvatureEstimate, union: BallUnion, energy: Quantity
) -> CurvatureEstimate:
    """Replace curvatures by the report's; confidence is how much of the vector is normal."""
    vectors = curvature_vectors(union, energy)[union.carriers]
    along = np.einsum("ij,ij->i", vectors, estimate.normals)
    lengths = np.linalg.norm(vectors, axis=1)
    unknown = np.full_like(lengths, np.nan)
    principal = np.full_like(estimate.principal_curvatures, np.nan)
    mean = np.copysign(lengths, along)
    if union.dimension == 2:
        unknown, principal = mean, mean[:, np.newaxis]
    return replace(
        estimate,
        mean_curvature=mean,
        gaussian_curvature=unknown,
        principal_curvatures=principal,
        confidence=np.divide(
            np.abs(along), lengths, out=np.zeros_like(lengths), where=lengths > 0.0
        ),
    )


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


def given_normals(
    normals: npt.ArrayLike | None, shape: tuple[int, ...], orientation: Orientation
) -> npt.NDArray[np.float64] | None:
    """Turn normals of the input into an array (n, d), zero where not finite, or masked.

    Raises
    ------
    InvalidInputError
        If they are not real numbers, have another shape than the points, or are missing where
        the rule wants them.
    """
    if normals is None:
        if orientation.rule == "input":
            raise InvalidInputError("orientation is input, but the input has no normals")
        return None
    given = real_array(normals, "normals")
    if given.shape != shape:
        raise InvalidInputError(f"normals have shape {given.shape}; the points have {shape}")
    given[~np.isfinite(given).all(axis=1)] = 0.0
    return np.clip(given, -LARGEST, LARGEST)
