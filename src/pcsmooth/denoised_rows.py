"""Some rows of a denoised cloud."""

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
class DenoisedRows:
    """Some rows of a denoised cloud; its fields are those of `DenoiseResult`."""

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
