"""What denoising a cloud returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.estimate import CurvatureEstimate
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.flows.state import State
from pcsmooth.methods.method import Method
from pcsmooth.methods.motion import Motion


@dataclass(frozen=True)
class Record:
    """One state of a cloud that is denoised.

    Attributes
    ----------
    iteration : int
        Steps taken before it.
    volume, area : float
        Volume of the union, L^d, and measure of its boundary, L^(d-1), of this state.
    mean_move, max_move : float
        Mean and largest length of the step that led here, L; 0 at the start.
    """

    iteration: int
    volume: float
    area: float
    mean_move: float
    max_move: float

    def scaled(self, factor: float, dimension: int) -> Record:
        """Return the same of a cloud of d dimensions times a factor."""
        return Record(
            self.iteration,
            self.volume * factor**dimension,
            self.area * factor ** (dimension - 1),
            self.mean_move * factor,
            self.max_move * factor,
        )

    def in_words(self) -> str:
        """Say all of it on a line."""
        return (
            f"  {self.iteration:4d}  volume {self.volume:.8g}  area {self.area:.8g}"
            f"  moved {self.mean_move:.3g} (at most {self.max_move:.3g})"
        )


def record_of(state: State) -> Record:
    """Take down a state."""
    return Record(
        state.iteration,
        state.evaluation.union.volume,
        state.evaluation.union.area,
        float(state.moves.mean()),
        float(state.moves.max()),
    )


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
    method : Filter, EulerFlow or ImplicitFlow
        How it was denoised, with what was left open filled in.
    motion : Motion
        How points could move.
    spacing, radius, step : float
        Mean spacing of the input, radius and time step used; a filter has step 0.
    plan : FilterPlan or None
        What was found of the cloud's noise and density, and the filter planned for it; None for
        the scheme euler, and where there are too few points.
    max_move : float or None
        Most that a point could move, L.
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
    method: Method
    motion: Motion
    spacing: float
    radius: float
    step: float
    plan: FilterPlan | None
    max_move: float | None
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
