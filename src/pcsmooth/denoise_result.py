"""What denoising a cloud returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.estimate import CurvatureEstimate
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.methods.method import Method
from pcsmooth.methods.motion import Motion
from pcsmooth.record import Record


@dataclass(frozen=True)
class DenoiseResult:
    """A denoised cloud, row i being row i of the input.

    Attributes
    ----------
    points : ndarray, shape (n, d)
        New positions, L.
    history : tuple of Record
        States 0 (the input) to N.
    curvature : CurvatureEstimate
        Normals and curvatures at the new positions.
    displacement : ndarray, shape (n,)
        Distance from old to new position, L.
    outliers : ndarray of bool, shape (n,), or None
        Points that the filter took for outliers and left where they are; None for flows.
    sigma : ndarray, shape (n,), or None
        Standard deviation of the noise of each point of the input along its normal, L; 0 for rows
        that are not finite. None for flows, and of too few points to filter.
    sigma_after : ndarray, shape (n,), or None
        Standard deviation of the error along the normal that is left of it, L: about 0.68 of the
        errors are smaller (see `errors_left`). That of a point that stayed is its noise. What a
        whole scan is off another, or its sensor off the truth, is not in it, nor what keeping a
        volume changes. Known where sigma is.
    method : Filter, EulerFlow or ImplicitFlow
        How it was denoised, with what was left open filled in.
    motion : Motion
        How points could move, lengths in L.
    spacing, radius, step : float
        Mean spacing of the input, radius and time step used; a filter has step 0. The radius is
        the median of local ones, of which the step is that of a ball of this radius.
    radii : ndarray, shape (n,), or None
        Radius of each ball, L, if it is local; 0 for rows that are not finite.
    plan : FilterPlan or None
        What was found of the cloud's noise and density, and the filter planned for it; None for
        the scheme euler, and where there are too few points.
    stopped_early : bool
        Whether the steps had become shorter than the tolerance before the last one.
    solver_iterations : tuple of int
        Iterations of the solver of linear equations in each step; empty if the scheme has none.
    solver_error : float
        Bound of the error that it has left, as a share of the step, in the worst step.
    finite : ndarray of bool, shape (n,)
        False for rows with a NaN, an infinity or a coordinate beyond 1e150, passed through.
    """

    points: npt.NDArray[np.float64]
    history: tuple[Record, ...]
    curvature: CurvatureEstimate
    displacement: npt.NDArray[np.float64]
    outliers: npt.NDArray[np.bool_] | None
    sigma: npt.NDArray[np.float64] | None
    sigma_after: npt.NDArray[np.float64] | None
    method: Method
    motion: Motion
    spacing: float
    radius: float
    radii: npt.NDArray[np.float64] | None
    step: float
    plan: FilterPlan | None
    stopped_early: bool
    solver_iterations: tuple[int, ...]
    solver_error: float
    finite: npt.NDArray[np.bool_]

    @property
    def normals(self) -> npt.NDArray[np.float64]:
        """Unit normals at the new positions, (n, d); zero where unknown."""
        return self.curvature.normals

    @property
    def mean_curvature(self) -> npt.NDArray[np.float64]:
        """Mean curvature at the new positions, (n,), 1/L: see `CurvatureEstimate`."""
        return self.curvature.mean_curvature
