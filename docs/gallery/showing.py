"""Figures that pcsmooth draws, which are made without pyplot, shown by pyplot."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt

from pcsmooth.plots.figures import png_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def show(figure: Figure) -> None:
    """Show a figure as the picture that pcsmooth writes of it."""
    axis = plt.figure(figsize=figure.get_size_inches()).add_axes((0.0, 0.0, 1.0, 1.0))
    axis.imshow(plt.imread(BytesIO(png_of(figure))))
    axis.set_axis_off()
