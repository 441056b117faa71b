"""Clouds drawn beside one another, each over what it was before."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from pcsmooth.plots.figures import new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BEFORE = "#9aa7b0"
AFTER = "#c0392b"
AREA = "#1f6fb2"
PERIMETER = "#d1710b"


@dataclass(frozen=True)
class Panel:
    """A cloud as it was and as it became.

    Attributes
    ----------
    title : str
        What was done to it.
    before, after : ndarray, shape (n, 2)
        The points.
    """

    title: str
    before: npt.NDArray[np.float64]
    after: npt.NDArray[np.float64]


def draw_panels(
    panels: Sequence[Panel], columns: int, width: float = 3.9, height: float = 3.3
) -> Figure:
    """Draw panels in rows of `columns`, each of a size in inches, one legend for all."""
    rows = -(-len(panels) // columns)
    figure = new_figure(width * columns, height * rows + 0.4)
    for number, panel in enumerate(panels, 1):
        axes = figure.add_subplot(rows, columns, number)
        axes.plot(*panel.before.T, ".", color=BEFORE, markersize=3.5, label="before")
        axes.plot(*panel.after.T, ".", color=AFTER, markersize=5.0, label="after")
        axes.set_aspect("equal")
        axes.set_title(panel.title, fontsize=10)
        axes.tick_params(labelsize=8)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, markerscale=2)
    return figure
