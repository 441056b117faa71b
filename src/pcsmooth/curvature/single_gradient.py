"""The thesis' own estimates of curvature: one gradient over one visible boundary each."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.fitted_cloud import FittedCloud
from pcsmooth.energies.balls import BallEnergy, BallUnion
from pcsmooth.energies.on_parts import BALLS, EVALUATION, EnergyStep, balls_of, evaluate
from pcsmooth.energies.protocol import Quantity
from pcsmooth.energies.weighting import weigh
from pcsmooth.kernels.surface import shape_operators as columns
from pcsmooth.parts.cloud_state import CloudState
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts

Estimator = Literal["cells", "gradient"]


def curvature_vectors(union: BallUnion, quantity: Quantity) -> npt.NDArray[np.float64]:
    """Mean curvature vectors of the points of a union, as the thesis estimates them.

    Parameters
    ----------
    union : BallUnion
        Measures of the union of balls.
    quantity : {"volume", "area"}
        Whose gradient.

    Returns
    -------
    ndarray, shape (n, d)
        (k1 + k2) / 2 (in 2D k) times the outward normal, 1/L; 0 for a point without visible
        boundary.

    Notes
    -----
    k1 + k2 is the gradient of the volume over r S_i (report, Prop. 6), or that of the boundary's
    area over S_i: what the flows weighted by the boundary move points by. Both hold in the limit
    of dense, even points.
    """
    evaluation = weigh(union, quantity, "boundary", union.radii)
    masses = evaluation.masses * (union.dimension - 1)
    share = np.divide(1.0, masses, out=np.zeros(len(masses)), where=masses > 0.0)
    return evaluation.gradient * share[:, np.newaxis]


def estimate_by_gradients(
    parts: Parts, state: CloudState, energy: BallEnergy, fitted: FittedCloud
) -> FittedCloud:
    """Replace curvatures by those of single gradients; confidence is how normal these are.

    Parameters
    ----------
    parts : Parts
        The cloud.
    state : CloudState
        Where it is.
    energy : BallEnergy
        Whose gradient.
    fitted : FittedCloud
        Whose normals the curvatures are set along.
    """
    estimates = parts.create("reported", fitted.estimates.dtype)
    step = _ByReport(energy, state.box, fitted.estimates, estimates)
    for _ in parts.map("gradients", step, state.points, state.drift):
        pass
    parts.forget(EVALUATION, BALLS)
    return replace(fitted, estimates=estimates, has_principal=parts.dimension == 2)


@dataclass(frozen=True, eq=False)
class _ByReport(EnergyStep):
    """Replace the curvatures of a part's own points, from one column to another."""

    fitted: Column
    estimates: Column

    def __call__(self, part: Part) -> None:
        evaluation = evaluate(part, self.energy, self.box)
        union = balls_of(part, evaluation, self.box)
        dimension = union.dimension
        vectors = curvature_vectors(union, evaluation.quantity)[union.carriers]
        rows = np.array(part.read(self.fitted))
        along = np.einsum("ij,ij->i", vectors, rows[:, :dimension])
        lengths = np.linalg.norm(vectors, axis=1)
        mean = np.copysign(lengths, along)
        rows[:, columns.MEAN] = mean
        unknown = mean if dimension == 2 else np.full_like(mean, np.nan)
        rows[:, columns.GAUSSIAN] = unknown
        for axis in range(dimension - 1):
            rows[:, columns.PRINCIPAL + axis] = unknown
        rows[:, columns.CONFIDENCE] = np.divide(
            np.abs(along), lengths, out=np.zeros_like(lengths), where=lengths > 0.0
        )
        part.write(self.estimates, rows)
