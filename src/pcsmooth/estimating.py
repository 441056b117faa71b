"""Estimate normals and curvatures of a cloud where it is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.estimate import CurvatureEstimate
from pcsmooth.curvature.fitted_cloud import FittedCloud, fit_cloud
from pcsmooth.curvature.orientation import Orientation, parse_orientation
from pcsmooth.curvature.single_gradient import Estimator, estimate_by_gradients
from pcsmooth.curvature.support import Support, check_support
from pcsmooth.energies.balls import BallEnergy
from pcsmooth.energies.protocol import Quantity
from pcsmooth.errors import InvalidInputError
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.lengths import check_radius
from pcsmooth.measured import measure_cloud
from pcsmooth.neighbors.local_radii import LocalRadii
from pcsmooth.parts.cloud_state import CloudState
from pcsmooth.parts.part import Parts
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.positions import LARGEST, as_positions, usable_rows
from pcsmooth.progress import Callback, ignore
from pcsmooth.real_numbers import real_array


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
    callback: Callback = ignore,
) -> CurvatureEstimate:
    """Estimate normals and curvatures of the surface under a cloud; no point moves.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3)
        Positions, L. Rows with a NaN, an infinity or a masked coordinate take no part.
    radius : float or str
        Radius of the balls: a length, ``"3x"`` the spacing, ``"2%"`` of the bounding box's
        diagonal, ``"auto"``, twice the spacing, or for each ball its own: ``"local"``, twice the
        local spacing (see `local_spacings`), ``"local:3x"`` three times. ``"auto"`` is ``"local"``
        where that radius would be too small for much of a surface in space.
    support : int or "auto"
        Points of the neighbourhood to which normal and shape operator are fitted, >= 3, and of
        that whose cells give a normal, if it is less than 30 (2D: 5); chosen from the noise
        measured in the cloud by default (see `choose_supports`).
    estimator : {"cells", "gradient"}
        Fit to the normals of the cells, or, as in the thesis, gradient over visible boundary.
    energy : {"volume", "area"}
        Whose gradient, for the estimator ``gradient``.
    orient : str
        Where normals point: ``"auto"``, ``"outward"``, ``"propagate"``, ``"input"``,
        ``"viewpoint=X,Y,Z"`` or ``"direction=X,Y,Z"`` (see `find_oriented_normals`).
    normals : array_like, shape (n, d), optional
        Normals of the input, whose signs ``"input"`` and ``"auto"`` take over.
    threads : int, optional
        Threads to use, all by default. The result does not depend on it.
    callback : callable, optional
        Called with a `Progress` when a stage begins and ends.

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
    if estimator not in ("cells", "gradient"):
        raise InvalidInputError(f"estimator is {estimator!r}; it must be cells or report")
    if energy not in ("volume", "area"):
        raise InvalidInputError(f"energy is {energy!r}; it must be volume or area")
    orientation = parse_orientation(orient)
    given = given_normals(normals, positions.shape, orientation)
    finite = usable_rows(positions)
    with thread_limit(threads):
        cloud = WholeCloud.of(positions, finite, given=given, callback=callback)
        found = estimate_parts(
            cloud, radius=radius, support=support, estimator=estimator, quantity=energy,
            orientation=orientation,
        )  # fmt: skip
    estimates = found.fitted.estimates.read(0, cloud.count)
    return found.of_rows(estimates, cloud.input_rows, finite)


@dataclass(frozen=True, eq=False)
class EstimatedParts:
    """A cloud in parts with normals and curvatures.

    Attributes
    ----------
    parts : Parts
        The cloud.
    fitted : FittedCloud
        These.
    radius, spacing : float
        Radius of the balls, of local ones the median, and mean spacing, L.
    local : LocalRadii or None
        Radii of the balls, if each has its own.
    """

    parts: Parts
    fitted: FittedCloud
    radius: float
    spacing: float
    local: LocalRadii | None = None

    @property
    def radius_range(self) -> list[float] | None:
        """Least and largest radius, in the unit of the input, if they are local."""
        if self.local is None:
            return None
        return [self.local.least * self.parts.unit, self.local.largest * self.parts.unit]

    @property
    def sparse_share(self) -> float | None:
        """Share of the surface for which one radius would be too small, if that is why."""
        return None if self.local is None else self.local.sparse_share

    def of_rows(
        self,
        estimates: npt.NDArray[np.float64],
        places: npt.NDArray[np.int64],
        finite: npt.NDArray[np.bool_],
    ) -> CurvatureEstimate:
        """Give the estimates of some rows of the input: see `CurvatureEstimate.of`."""
        return CurvatureEstimate.of(
            self.fitted, estimates, places, finite, dimension=self.parts.dimension,
            unit=self.parts.unit, radius=self.radius, spacing=self.spacing,
        )  # fmt: skip

    def all(self) -> Iterator[CurvatureEstimate]:
        """Give those of all points, in the cloud's order, in parts."""
        return CurvatureEstimate.in_chunks(
            self.fitted, dimension=self.parts.dimension, unit=self.parts.unit,
            radius=self.radius, spacing=self.spacing,
        )  # fmt: skip


def estimate_parts(
    parts: Parts,
    *,
    radius: float | str,
    support: Support,
    estimator: Estimator,
    quantity: Quantity,
    orientation: Orientation,
) -> EstimatedParts:
    """Estimate normals and curvatures of a cloud in parts, at the start: see `estimate_curvature`.

    The viewpoint of the orientation is in the unit of the input.
    """
    measured = measure_cloud(parts)
    local = measured.local_radii(radius, parts, may_choose=True)
    length = measured.radius(radius) if local is None else local.median
    parts.check_width(parts.box, 2.0 * length, "the diameter of the balls")
    state = CloudState.at_start(parts)
    energy = BallEnergy(length, quantity, local=local)
    fitted = fit_cloud(
        parts, state, energy, support=support,
        orientation=orientation.seen_from(parts.origin, parts.unit),
    )  # fmt: skip
    if estimator == "gradient":
        fitted = estimate_by_gradients(parts, state, energy, fitted)
    return EstimatedParts(parts, fitted, length, measured.spacing, local)


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
