"""An energy made of a measured union: its volume or its boundary's measure, plain or weighted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.protocol import Evaluation, Quantity, UnionMeasures, Weight

#: Visible share of a sphere below which rounding hides it: the point counts as covered.
_COVERED = 1e-12


def power_of_step(quantity: Quantity, weight: Weight, dimension: int) -> int:
    """Power of length in the time step of a flow: in L^2 if it is weighted."""
    if weight != "none":
        return 2
    return (2 if quantity == "volume" else 3) - dimension


def weigh(
    union: UnionMeasures,
    quantity: Quantity,
    weight: Weight,
    radii: npt.NDArray[np.float64] | None = None,
) -> Evaluation:
    """Evaluate the energy of a union that has been measured.

    Parameters
    ----------
    union : UnionMeasures
        The union.
    quantity : {"volume", "area"}
        What is measured; in 2D area and perimeter.
    weight : {"none", "cell", "boundary"}
        What the gradient of point i is divided by: 1; |C_i| (for the area |C_i| / r); r S_i (for
        the area S_i).
    radii : ndarray, shape (n,), optional
        Of unequal shapes the r of each.

    Returns
    -------
    Evaluation
    """
    radius = union.radius if radii is None else radii
    if quantity == "volume":
        value, gradient, diagonal = union.volume, union.volume_gradient, union.volume_diagonal
        unit: float | npt.NDArray[np.float64] = 1.0
    else:
        value, gradient, diagonal = union.area, union.area_gradient, union.area_diagonal
        unit = 1.0 / radius
    if weight == "none":
        masses = np.ones(len(union.carriers))
    elif weight == "cell":
        masses = union.cell_volumes * unit
    else:
        sphere = radius ** (gradient.shape[1] - 1)
        visible = union.visible_areas
        masses = np.where(visible > _COVERED * sphere, visible * radius * unit, 0.0)
    return Evaluation(union, value, gradient, diagonal, masses, quantity, weight)


def weigh_at_own_pace(
    union: UnionMeasures, quantity: Quantity, weight: Weight, radius: float
) -> Evaluation:
    """Evaluate the energy of a union whose shapes may be unequal, each in a time of its own.

    A step smooths over as many radii everywhere: where the radius is r_i it is (r_i / radius)^2
    times as long (not weighted, the power that time has of length in place of 2), by which the
    masses are divided.

    Parameters
    ----------
    union, quantity, weight
        As `weigh` takes them.
    radius : float
        Of which shapes a step is as long as it is said to be, L.
    """
    evaluation = weigh(union, quantity, weight, union.radii)
    if union.radii is None:
        return evaluation
    power = power_of_step(quantity, weight, evaluation.gradient.shape[1])
    paces = (union.radii / radius) ** power
    return replace(evaluation, masses=evaluation.masses / paces, paces=paces)
