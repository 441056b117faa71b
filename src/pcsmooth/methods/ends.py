"""Points that end elsewhere than where a method has moved them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.errors_left import where_held_back
from pcsmooth.methods.method import Moved
from pcsmooth.parts.cloud_state import CloudState, Moves, next_state
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts

Floats = npt.NDArray[np.float64]

#: Gives, from starts and ways (n, d), other ways (n, d) and the shares (n,) of what was wanted
#: along the normals that they go.
Rule = Callable[[Floats, Floats], tuple[Floats, Floats]]


def end_elsewhere(parts: Parts, moved: Moved, rule: Rule, stage: str) -> Moved:
    """Send points other ways than a method has moved them.

    Parameters
    ----------
    parts : Parts
        The cloud.
    moved : Moved
        Where the method has taken it.
    rule : callable
        Which ways, and what share of the wanted motion along the normals they go; a function that
        other processes can import.
    stage : str
        What is said of it on the way.

    Returns
    -------
    Moved
        What is left of their errors is that of the shares, too.
    """
    state = moved.state
    target = parts.create("other_ends", parts.start.dtype)
    left = None if moved.left is None else parts.create("left_there", np.float64)
    step = _Step(parts.start, parts.fixed, moved, rule, target, left)
    moves = list(parts.map(stage, step, state.points, state.drift))
    parts.forget()
    reached = next_state(parts, CloudState.at_start(parts), target, moves)
    reached = replace(
        reached, iteration=state.iteration, converged=state.converged,
        solver_iterations=state.solver_iterations, solver_error=state.solver_error,
    )  # fmt: skip
    return replace(moved, state=reached, left=left)


@dataclass(frozen=True, eq=False)
class _Step:
    """Go other ways from the start."""

    start: Column
    fixed: Column
    moved: Moved
    rule: Rule
    target: Column
    left: Column | None
    reach: float = 0.0

    def __call__(self, part: Part) -> Moves:
        start = part.read(self.start)
        way = part.points - start
        vectors, shares = self.rule(start, way)
        reached = start + vectors
        part.write(self.target, reached)
        if self.left is not None and self.moved.left is not None:
            part.write(self.left, self._left(part, way.any(axis=1), shares))
        return Moves.of(part, start, reached, vectors, part.read(self.fixed))

    def _left(self, part: Part, went: npt.NDArray[np.bool_], shares: Floats) -> Floats:
        """Find what is left of the errors; that of points that stayed is what it was."""
        moved = self.moved
        assert moved.left is not None
        assert moved.plan is not None
        left = part.read(moved.left)
        if moved.noise is None:
            noise = np.full(len(left), moved.plan.noise.deviation)
        else:
            noise = part.read(moved.noise)
        return np.where(went, where_held_back(left, noise, shares), left)
