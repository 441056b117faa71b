"""What a scheme wants to do with the points of a part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.local_reach import LocalReach
from pcsmooth.energies.on_parts import evaluate
from pcsmooth.energies.protocol import Energy
from pcsmooth.flows.scheme import Scheme
from pcsmooth.flows.state import State
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part


@dataclass(frozen=True, eq=False)
class Wanted:
    """Where a scheme wants the points of a part.

    Attributes
    ----------
    state : State
        Where they are.
    vectors : ndarray, shape (m, d)
        Their displacements, L, equal for coincident points and 0 for those that are held.
    held : ndarray of bool, shape (m,)
        Those that stay: fixed ones, what coincides with one, outliers.
    iterations : int
        Iterations of the solver, if there is one.
    error : float
        What error it has left (see `Displacement`).
    """

    state: State
    vectors: npt.NDArray[np.float64]
    held: npt.NDArray[np.bool_]
    iterations: int
    error: float


class WantingStep(Protocol):
    """Something that wants to move the points of a cloud, before anything restrains it."""

    @property
    def radius(self) -> float:
        """Of the shapes, L."""

    @property
    def start(self) -> Column:
        """Positions before the first step, L."""

    @property
    def box(self) -> npt.NDArray[np.float64]:
        """Bounding box of the cloud, (2, d), L."""

    @property
    def reach(self) -> float | LocalReach:
        """How far it looks from a point, L."""

    def find(self, part: Part) -> Wanted:
        """Find where the points of a part are to go."""


@dataclass(frozen=True, eq=False)
class WantedStep:
    """A step of a scheme, before anything restrains it.

    Attributes
    ----------
    energy : Energy
        What is to decrease.
    scheme : Scheme
        How to step.
    step, balance : float
        Time step, and what the scheme has to know of the whole cloud (see `Scheme.balance`).
    start : Column
        Positions at the start, L.
    fixed : Column
        Marks of the fixed points.
    box : ndarray, shape (2, d)
        Bounding box of the cloud, L.
    """

    energy: Energy
    scheme: Scheme
    step: float
    balance: float
    start: Column
    fixed: Column
    box: npt.NDArray[np.float64]

    @property
    def radius(self) -> float:
        """Of the shapes, L."""
        return self.energy.radius

    @property
    def reach(self) -> float | LocalReach:
        """As far as energy and scheme look, one after the other."""
        return self.energy.reach(self.box.shape[1]) + self.scheme.reach(self.step)

    def find(self, part: Part) -> Wanted:
        """Find where the points of a part are to go."""
        evaluation = evaluate(part, self.energy, self.box)
        state = State(part, evaluation, self.box, self.step, self.balance)
        carriers = evaluation.union.carriers
        held = np.zeros(len(carriers), np.bool_)
        held[carriers[part.read(self.fixed)]] = True
        displacement = self.scheme.displacement(state, held)
        return Wanted(
            state, displacement.vectors[carriers], held[carriers], displacement.iterations,
            displacement.error,
        )  # fmt: skip
