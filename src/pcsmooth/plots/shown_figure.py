"""Figures that show themselves in notebooks."""

from __future__ import annotations

from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A figure of matplotlib that a notebook shows, without pyplot or a setting."""

    def _repr_png_(self) -> bytes:
        """Draw it."""
        from pcsmooth.plots.figures import png_of

        return png_of(self)
