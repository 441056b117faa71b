"""Where a cloud in parts is on its way."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.grid.grid import bounding_box
from pcsmooth.parts.column import Column
from pcsmooth.parts.exact_sums import exact_sum, total_of
from pcsmooth.parts.part import Part, Parts


@dataclass(frozen=True, eq=False)
class CloudState:
    """A cloud on its way.

    Attributes
    ----------
    iteration : int
        Steps taken.
    points : Column
        Positions, L.
    box : ndarray, shape (2, d)
        Their bounding box, L.
    drift : float
        Most that a point is away from its start along an axis, L.
    mean_move, max_move : float
        Of the last step, L.
    converged : bool
        Whether the points that are not fixed moved less than the tolerance in the last step.
    solver_iterations : int
        Iterations of the solver of linear equations in the last step, most of any part.
    solver_error : float
        Bound of the error that it has left, of the worst part: see `Displacement.error`.
    """

    iteration: int
    points: Column
    box: npt.NDArray[np.float64]
    drift: float = 0.0
    mean_move: float = 0.0
    max_move: float = 0.0
    converged: bool = False
    solver_iterations: int = 0
    solver_error: float = 0.0

    @classmethod
    def at_start(cls, parts: Parts) -> CloudState:
        """Tell where a cloud is that has not moved."""
        return cls(0, parts.start, parts.box)


@dataclass(frozen=True, eq=False)
class Moves:
    """What a step did to the own points of a part.

    Attributes
    ----------
    low, high : ndarray, shape (d,)
        Corners of their bounding box, L.
    drift : float
        Most that one is away from its start along an axis, L.
    total, free_total : tuple of float
        Lengths of the displacements of all of them, and of those that are not fixed, L, summed up
        by `exact_sum`.
    largest : float
        Largest of them, L.
    free : int
        Points that are not fixed.
    solver_iterations, solver_error
        See `Displacement`.
    """

    low: npt.NDArray[np.float64]
    high: npt.NDArray[np.float64]
    drift: float
    total: tuple[float, ...]
    free_total: tuple[float, ...]
    largest: float
    free: int
    solver_iterations: int = 0
    solver_error: float = 0.0

    @classmethod
    def of(
        cls,
        part: Part,
        start: npt.NDArray[np.float64],
        moved: npt.NDArray[np.float64],
        vectors: npt.NDArray[np.float64],
        held: npt.NDArray[np.bool_],
    ) -> Moves:
        """Sum up from starts, ends and displacements (m, d), L, and who is held, (m,)."""
        own = part.own
        lengths = np.linalg.norm(vectors[own], axis=1)
        total = exact_sum(lengths)
        free = ~held[own]
        low, high = np.array(bounding_box(moved[own]))[:, : moved.shape[1]]
        return cls(
            low,
            high,
            float(np.abs(moved[own] - start[own]).max()),
            total,
            total if free.all() else exact_sum(lengths[free]),
            float(lengths.max()),
            int(np.count_nonzero(free)),
        )

    def solved(self, iterations: int, error: float) -> Moves:
        """Add what a solver did."""
        return replace(self, solver_iterations=iterations, solver_error=error)


def next_state(
    parts: Parts, state: CloudState, points: Column, moves: list[Moves], least_move: float = 0.0
) -> CloudState:
    """Tell where a step has taken a cloud.

    Parameters
    ----------
    parts : Parts
        The cloud.
    state : CloudState
        Where it was.
    points : Column
        Positions now, L.
    moves : list of Moves
        Of the parts.
    least_move : float
        Mean move of the points that are not fixed, L, below which the cloud has converged.
    """
    free = sum(move.free for move in moves)
    lows, highs = [move.low for move in moves], [move.high for move in moves]
    return CloudState(
        state.iteration + 1,
        points,
        np.stack([np.min(lows, axis=0), np.max(highs, axis=0)]),
        max(move.drift for move in moves),
        total_of(move.total for move in moves) / parts.count,
        max(move.largest for move in moves),
        total_of(move.free_total for move in moves) < least_move * free,
        max(move.solver_iterations for move in moves),
        max(move.solver_error for move in moves),
    )
