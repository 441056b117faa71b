"""Estimate normals and curvatures of a cloud in parts, where it is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.estimate import CurvatureEstimate
from pcsmooth.curvature.fitted_cloud import FittedCloud, fit_cloud
from pcsmooth.curvature.orientation import Orientation
from pcsmooth.curvature.single_gradient import Estimator, estimate_by_gradients
from pcsmooth.curvature.support import Support
from pcsmooth.energies.balls import BallEnergy
from pcsmooth.energies.protocol import Quantity
from pcsmooth.errors import InvalidInputError
from pcsmooth.measured import measure_cloud
from pcsmooth.neighbors.local_radii import LocalRadii
from pcsmooth.parts.cloud_state import CloudState
from pcsmooth.parts.part import Parts
from pcsmooth.positions import LARGEST
from pcsmooth.real_numbers import real_array

STAGES = 9
"""Stages of an estimate, at most."""


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
