"""Points that go a share of their way."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.errors_left import where_held_back
from pcsmooth.methods.method import Moved
from pcsmooth.parts.cloud_state import CloudState, Moves, next_state
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts


def go_a_share(parts: Parts, moved: Moved, share: float) -> Moved:
    """Take points back to a share of the way that a method has moved them.

    Parameters
    ----------
    parts : Parts
        The cloud.
    moved : Moved
        Where the method has taken it.
    share : float
        From 0, where all are at their start to the last bit, to 1.

    Returns
    -------
    Moved
        What is left of their errors is that of the share, too.
    """
    if share == 1.0:
        return moved
    state = moved.state
    target = parts.create("shared", parts.start.dtype)
    left = None if moved.left is None else parts.create("left_shared", np.float64)
    step = _Share(parts.start, parts.fixed, moved, share, target, left)
    moves = list(parts.map("share of the way", step, state.points, state.drift))
    parts.forget()
    reached = next_state(parts, CloudState.at_start(parts), target, moves)
    reached = replace(
        reached, iteration=state.iteration, converged=state.converged,
        solver_iterations=state.solver_iterations, solver_error=state.solver_error,
    )  # fmt: skip
    return replace(moved, state=reached, left=left)


@dataclass(frozen=True, eq=False)
class _Share:
    """Go a share of the way from the start."""

    start: Column
    fixed: Column
    moved: Moved
    share: float
    target: Column
    left: Column | None
    reach: float = 0.0

    def __call__(self, part: Part) -> Moves:
        start = part.read(self.start)
        way = part.points - start
        vectors = self.share * way
        reached = start + vectors
        part.write(self.target, reached)
        if self.left is not None and self.moved.left is not None:
            part.write(self.left, self._left(part, way.any(axis=1)))
        return Moves.of(part, start, reached, vectors, part.read(self.fixed))

    def _left(self, part: Part, went: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
        """Find what is left of the errors; that of points that stayed is what it was."""
        moved = self.moved
        assert moved.left is not None
        assert moved.plan is not None
        left = part.read(moved.left)
        if moved.noise is None:
            noise = np.full(len(left), moved.plan.noise.deviation)
        else:
            noise = part.read(moved.noise)
        return np.where(went, where_held_back(left, noise, np.full(len(left), self.share)), left)
