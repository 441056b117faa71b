"""The energies of a flow over its steps: a figure of matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pcsmooth.plots.figures import new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pcsmooth.record import Record

#: Names of the measure of the union and of that of its boundary, by dimension.
MEASURES = {2: ("area", "perimeter"), 3: ("volume", "area")}

_SIZE = (11.0, 3.4)
_COLOR = "#1f4e79"

#: States beyond which they get no dot each.
_MOST_DOTS = 50


def energy_figure(history: Sequence[Record], dimension: int) -> Figure:
    """Draw volume and area (2D: area and perimeter) of every state.

    Parameters
    ----------
    history : sequence of Record
        States 0 to N.
    dimension : int
        Of the points, 2 or 3.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    PcsmoothError
        If matplotlib is not installed.
    """
    figure = new_figure(*_SIZE)
    steps = [record.iteration for record in history]
    curves = (
        [record.volume for record in history],
        [record.area for record in history],
    )
    powers = (dimension, dimension - 1)
    for place, (values, name, power) in enumerate(
        zip(curves, MEASURES[dimension], powers, strict=True), 1
    ):
        axes = figure.add_subplot(1, 2, place)
        axes.plot(steps, values, color=_COLOR, marker="o" if len(steps) <= _MOST_DOTS else "", ms=4)
        axes.set_xlabel("iteration")
        unit = "coordinate units" if power == 1 else f"coordinate units$^{power}$"
        axes.set_ylabel(f"{name}, {unit}")
        axes.locator_params(axis="x", integer=True)
        axes.spines[["top", "right"]].set_visible(False)
    return figure
