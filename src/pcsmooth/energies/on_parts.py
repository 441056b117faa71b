"""The energy of a cloud in parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.balls import (
    BallEnergy,
    BallUnion,
    measure_balls,
    measure_balls_in_part,
)
from pcsmooth.energies.protocol import Energy, Evaluation
from pcsmooth.parts.exact_sums import exact_sum, total_of
from pcsmooth.parts.part import Part, Reach

#: Names under which parts remember the energy, and the union of balls if it is one of other
#: shapes.
EVALUATION = "evaluation"
BALLS = "balls"


@dataclass(frozen=True)
class Totals:
    """Volume of the union and measure of its boundary, as far as some points share in them.

    Attributes
    ----------
    volume, area : tuple of float
        L^d and L^(d-1), summed up by `exact_sum`.
    """

    volume: tuple[float, ...]
    area: tuple[float, ...]

    @classmethod
    def of(cls, part: Part, evaluation: Evaluation) -> Totals:
        """Sum up over a part's own points."""
        union = evaluation.union
        return cls(
            exact_sum(union.volume_shares[part.own]), exact_sum(union.visible_areas[part.own])
        )


def evaluate(part: Part, energy: Energy, box: npt.NDArray[np.float64]) -> Evaluation:
    """Evaluate an energy at the points of a part; the box, (2, d), L, is that of the cloud."""

    def make() -> Evaluation:
        if isinstance(energy, BallEnergy) and energy.local is not None:
            radii = energy.local.in_part(part)
            return energy.of_union(measure_balls_in_part(part.points, radii, box))
        return energy.evaluate(part.points, box)

    return part.remember(EVALUATION, make)


def balls_of(part: Part, evaluation: Evaluation, box: npt.NDArray[np.float64]) -> BallUnion:
    """Give the union of balls of an energy's radii, whatever the shapes of the energy."""
    union = evaluation.union
    if isinstance(union, BallUnion):
        return union
    radius = union.radius if union.radii is None else union.radii
    return part.remember(BALLS, lambda: measure_balls(part.points, radius, box))


@dataclass(frozen=True, eq=False)
class EnergyStep:
    """What all steps have that look no farther than an energy.

    Attributes
    ----------
    energy : Energy
        What is evaluated.
    box : ndarray, shape (2, d)
        Bounding box of the cloud, L.
    """

    energy: Energy
    box: npt.NDArray[np.float64]

    @property
    def reach(self) -> float | Reach:
        """As far as the energy looks."""
        return self.energy.reach(self.box.shape[1])


class Measure(EnergyStep):
    """Evaluate an energy where no step is taken."""

    def __call__(self, part: Part) -> Totals:
        """Sum up over the own points."""
        return Totals.of(part, evaluate(part, self.energy, self.box))


def sum_of(totals: list[Totals]) -> tuple[float, float]:
    """Add up volume and area of all parts, L^d and L^(d-1)."""
    return total_of(total.volume for total in totals), total_of(total.area for total in totals)
