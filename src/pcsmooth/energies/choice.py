"""The energy that a choice of shapes and weights stands for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from pcsmooth.energies.balls import BallEnergy
from pcsmooth.energies.protocol import Energy, Quantity, Weight

if TYPE_CHECKING:
    from pcsmooth.bodies.convex_body import ConvexBody
    from pcsmooth.energies.polyhedra.union import PolyhedronEnergy, Union


GradientName = Literal["analytic", "autodiff"]


def choose_energy(
    radius: float,
    quantity: Quantity,
    weight: Weight,
    body: ConvexBody | None,
    union: Union,
    gradient: GradientName = "analytic",
) -> Energy:
    """Make the energy of a union of balls, or of bodies if one is given.

    Parameters
    ----------
    radius : float
        Radius of the shapes, L.
    quantity, weight
        What is measured, and what gradients are divided by (see `weigh`).
    body : ConvexBody or None
        The shape of radius 1 in place of the unit ball.
    union : {"naive", "inclusion-exclusion", "exact"}
        How the union of bodies is computed.
    gradient : {"analytic", "autodiff"}
        Closed forms, or automatic differentiation of a slow reference.
    """
    energy: BallEnergy | PolyhedronEnergy
    if body is None:
        energy = BallEnergy(radius, quantity, weight)
    else:
        from pcsmooth.energies.polyhedra.union import PolyhedronEnergy

        energy = PolyhedronEnergy(radius, body, union, quantity, weight)
    if gradient == "analytic":
        return energy

    from pcsmooth.energies.by_autodiff import AutodiffEnergy

    return AutodiffEnergy(energy)
