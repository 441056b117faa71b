"""The thesis' two flows in the plane, with constant steps, at one pace."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.balls import BallEnergy, measure_balls
from pcsmooth.energies.protocol import Quantity, Weight
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import FlowState, run_flow
from pcsmooth.kernels.threads import thread_limit

#: Step of the perimeter flow, L: the author's own.
PERIMETER_STEP = 1.0


@dataclass(frozen=True)
class Descent:
    """Constant steps down a gradient (report, Eq. 2.4).

    Attributes
    ----------
    quantity : {"volume", "area"}
        What decreases; in the plane the area of the union of disks and its perimeter.
    radius : float
        Of the disks, L.
    step : float
        What the gradient, divided by the weights, is multiplied by.
    weight : {"none", "cell", "boundary"}
        What the gradient of each point is divided by.
    """

    quantity: Quantity
    radius: float
    step: float
    weight: Weight = "none"

    def states(
        self,
        points: npt.NDArray[np.float64],
        iterations: int,
        fixed: npt.NDArray[np.bool_] | None = None,
    ) -> list[FlowState]:
        """All states of the flow of points (n, 2), from 0 to `iterations`."""
        energy = BallEnergy(self.radius, self.quantity, self.weight)
        with thread_limit(1):  # of a few hundred points, threads cost more than they give
            return list(run_flow(energy, points, Euler(self.step), iterations, fixed=fixed))

    def end(
        self,
        points: npt.NDArray[np.float64],
        iterations: int,
        fixed: npt.NDArray[np.bool_] | None = None,
    ) -> npt.NDArray[np.float64]:
        """Where the flow takes points (n, 2)."""
        return self.states(points, iterations, fixed)[-1].points


def perimeter_descent(radius: float) -> Descent:
    """Make the perimeter flow with the author's step."""
    return Descent("area", radius, PERIMETER_STEP)


def area_descent(radius: float) -> Descent:
    """Make the area flow that goes as fast as the perimeter flow.

    On dense points the gradient of the area is r times that of the perimeter (report, Prop. 6),
    so the step is 1/r of that one's.
    """
    return Descent("volume", radius, PERIMETER_STEP / radius)


def weighted_area_descent(points: npt.NDArray[np.float64], radius: float) -> Descent:
    """Make the area flow weighted by cells that is as fast: the mean cell takes the same step."""
    mean_cell = measure_balls(points, radius).volume / len(points)
    return Descent("volume", radius, PERIMETER_STEP / radius * mean_cell, "cell")


def before_and_after(
    points: npt.NDArray[np.float64],
    radius: float,
    iterations: int,
    fixed: npt.NDArray[np.bool_] | None = None,
) -> dict[str, npt.NDArray[np.float64]]:
    """Points (n, 2) "before", and after the "area" and the "perimeter" flow."""
    return {
        "before": points,
        "area": area_descent(radius).end(points, iterations, fixed),
        "perimeter": perimeter_descent(radius).end(points, iterations, fixed),
    }
