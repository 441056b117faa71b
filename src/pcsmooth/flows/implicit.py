"""Semi-implicit steps: the weights of where the points are, the points of where they will be."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.facet_laplacian import facet_laplacian
from pcsmooth.flows.conjugate_gradients import TOLERANCE, solve
from pcsmooth.flows.long_steps import start_at_means
from pcsmooth.flows.scheme import Displacement, Values
from pcsmooth.flows.state import State

Order = Literal[1, 2]

#: Automatic time step by order, in units of the noise times the spacing.
STEP_OF_NOISE = {1: 1.5, 2: 3.8}

#: The same in units of the squared spacing, where the noise is unknown: that of 0.4 spacings.
AUTOMATIC_STEP = {1: 0.6, 2: 1.5}

#: Lengths over which a step's mean falls off before it is cut: e^-14 is 1e-6.
_DECAY_LENGTHS = 20.0

#: A point's mass is at least this share of its cell's: that of its visible boundary may vanish.
_LEAST_MASS = 0.1


@dataclass(frozen=True)
class Implicit:
    """Semi-implicit steps of first or second order in space.

    Attributes
    ----------
    spacing : float
        Mean spacing of the points, L, which the automatic step is made of.
    order : {1, 2}
        1: mean curvature flow; 2: surface diffusion, which takes noise away and hardly shrinks.
    step : float, optional
        Time step tau; in units of L^2 for weighted energies. By default noise times spacing times
        1.5 for the first and 3.8 for the second order; if the energy is not weighted, divided by
        the median cell.
    tolerance : float
        Bound of the solver's error that is aimed at, as a share of the displacement.
    noise : float, optional
        Standard deviation of the noise in each coordinate, L, which the automatic step is made of.
        Where it is unknown, and with polyhedra, which turn a surface without noise too, the step
        is that of a noise of 0.4 spacings: 0.6 and 1.5 spacings^2.
    largest_mass : float, optional
        Of an energy that is not weighted, what no cell's mass is larger than.
    is_of_balls : bool
        Whether the energy is one of balls; of polyhedra the order has to be 1.

    Notes
    -----
    The gradient of a union of balls is L p, L a weighted graph Laplacian; M are the masses, under
    the boundary weight at least a tenth of the cells'. With L and M as they are at p::

        order 1:  (M + tau L) p+ = M p
        order 2:  (M + tau^2 L M^-1 L) p+ = M p,  p+ = Re[(M - i tau L)^-1 M p]

    The second form of order 2 is one complex symmetric system of the sparseness of L. Both are
    solved for the displacement, order 1 as (M + tau L) (p+ - p) = -tau gradient, long steps from
    the means of the components (see `start_at_means`). No step length is unstable: a step is a mean
    of all positions (order 1), or damps every mode of L. The equations
    of points that are held are left out, of second order also that of their velocity under mean
    curvature flow, which is taken for 0.

    The gradient of a union of polyhedra is not L p for any such L. Order 1 takes the gradient of
    the polyhedra on the right and on the left the L of the balls of the same radius, multiplied
    so that the median of its diagonal is that of the energy's stiffness. Steps of up to 2
    spacings^2 were found to decrease the energy, and to bring a sphere of 1,000 points nearer to
    a cube than Euler steps of the same total time: in 5 steps of 2 spacings^2 to a median angle
    of 7 degrees with its facets, 40 Euler steps of 0.25 spacings^2 to 11. Where bodies are
    unequal the gradient is shortened of points that would move farther than their radius, were
    all others at rest: among larger bodies next to nothing may be left of a cell, and more of the
    boundary. Points without a cell rest.

    Two automatic steps are meant, of the noise as it is measured. Below are squared Chamfer
    distances, 1e-4 of the squared radius, the means of 8 detailed models of 10,000 points with
    noise in shares of the radius; and the errors of 20,000 random points on a torus as shares of
    the noise, which 6 Euler steps take to 0.33, 0.43 and 0.77. s is the spacing::

        noise                  1 %    2 %    3 %     0.36   0.71   1.42 sqrt(area / n)
        before                 3.31   7.49  12.9     1      1      1
        order 2                2.21   3.87   5.76    0.24   0.22   0.28
        best of each model     2.12   3.74   5.68
        order 2 without noise  2.17   4.38   9.59    0.21   0.32   0.72
        order 2, 6 s^2         9.31  10.5    9.36    0.11   0.10   0.18
        order 1                2.52   4.72   7.38    0.44   0.45   0.54

    Smooth shapes bear more than detailed ones, and neither noise nor spacing tell which it is.
    The best single step of each model leaves 2.22, 4.15 and 6.67, the best three 2.10, 3.63 and
    5.38. Of 50,000 points the automatic steps are within 12 % of the best at 1 and 2 %; at 3 %
    longer ones would leave a sixth less.
    """

    spacing: float
    order: Order = 2
    step: float | None = None
    tolerance: float = TOLERANCE
    noise: float | None = None
    largest_mass: float | None = None
    is_of_balls: bool = True

    @property
    def time_scale(self) -> Values | None:
        """The cells of the points, if the energy is not weighted and the step is to be chosen."""
        return None if self.largest_mass is None or self.step is not None else cell_masses

    @property
    def balance(self) -> Values | None:
        """How stiff the energy is beside the balls, if it is one of polyhedra."""
        return None if self.is_of_balls else stiffness_ratios

    def time_step(self, median: float | None) -> float:
        """Make the step of the noise and the spacing, unless it is given."""
        if self.step is not None:
            return self.step
        if self.noise is None or not self.is_of_balls:
            step = AUTOMATIC_STEP[self.order] * self.spacing**2
        else:
            step = STEP_OF_NOISE[self.order] * self.noise * self.spacing
        return step if median is None else step / median

    def reach(self, step: float) -> float:
        """How far the solution depends on points noticeably, along an axis, L.

        The solution is a mean of positions that falls off with distance like exp(-d / l), l being
        sqrt(2 step) at most (and of second order at that rate times sqrt(1 / 2)). Of an energy
        that is not weighted the step counts times the mass of the cell.
        """
        mass = 1.0 if self.largest_mass is None else self.largest_mass
        return _DECAY_LENGTHS * math.sqrt(2.0 * step * mass)

    def displacement(self, state: State, held: npt.NDArray[np.bool_]) -> Displacement:
        """Solve the linear system of one step.

        Raises
        ------
        InvalidInputError
            The solver does not reach the tolerance.
        """
        evaluation, balls = state.evaluation, state.balls
        numbers = balls.numbers
        laplacian = facet_laplacian(balls, evaluation.quantity)
        masses = evaluation.masses
        if evaluation.weight == "boundary":
            masses = np.maximum(masses, _LEAST_MASS * cell_masses(state) / evaluation.paces)
        factor = float(state.step) * (1.0 if self.order == 1 else -1.0j)
        right_side = np.zeros((len(numbers), 3), np.result_type(factor))
        right_side[:, : balls.dimension] = -factor * evaluation.gradient[numbers]
        masses = masses[numbers]
        is_hidden = masses == 0.0  # a small ball among larger ones: it has no cell, and rests
        held = held[numbers] | is_hidden
        masses = np.where(is_hidden, masses.max(), masses)
        start, right_side_error = None, 0.0
        if evaluation.union is not balls:
            factor *= state.balance
            if evaluation.union.radii is not None:
                longest = evaluation.union.radii[numbers]
                right_side = _limited(right_side, longest * (masses + factor * laplacian.diagonal))
            right_side_error = float(np.finfo(np.float64).eps)  # no sum of differences cancels it
        elif _is_long(right_side, masses, balls.radius):
            points = state.points[numbers]
            right_side, start = start_at_means(laplacian, masses, points, right_side, held)
        solution = solve(
            laplacian, masses, factor, right_side, held, self.tolerance, start=start,
            right_side_error=right_side_error,
        )  # fmt: skip
        vectors = np.zeros_like(state.points)
        vectors[numbers] = solution.values[:, : balls.dimension]
        return Displacement(vectors, solution.iterations, solution.error)


def _limited(right_side: npt.NDArray[Any], limits: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Shorten the rows (n, 3) that are longer than their limits (n,)."""
    lengths = np.linalg.norm(right_side, axis=1)
    shares = np.ones(len(lengths))
    np.divide(limits, lengths, out=shares, where=lengths > limits)
    return np.asarray(right_side * shares[:, np.newaxis])


def _is_long(right_side: npt.NDArray[Any], masses: npt.NDArray[np.float64], radius: float) -> bool:
    """Whether an explicit step would take the points farther than the radius on average."""
    return bool(np.abs(right_side).sum() / radius > masses.sum())


def cell_masses(state: State) -> npt.NDArray[np.float64]:
    """Masses of the cell weight, (n,)."""
    union = state.evaluation.union
    is_area = state.evaluation.quantity == "area"
    return union.cell_volumes / union.radius if is_area else union.cell_volumes


def stiffness_ratios(state: State) -> npt.NDArray[np.float64]:
    """Stiffness of an energy over that of the balls', (n,), NaN where that is 0."""
    evaluation, balls = state.evaluation, state.balls
    of_balls = balls.volume_diagonal if evaluation.quantity == "volume" else balls.area_diagonal
    ratios = np.full(len(of_balls), np.nan)
    np.divide(evaluation.diagonal, of_balls, out=ratios, where=of_balls > 0.0)
    return ratios
