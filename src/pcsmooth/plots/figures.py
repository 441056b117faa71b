"""Figures of matplotlib, without a display and without its global state."""

from __future__ import annotations

import warnings
from io import BytesIO
from typing import TYPE_CHECKING

from pcsmooth.errors import PcsmoothError
from pcsmooth.printable import printable, shortened

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Pixels per inch.
_RESOLUTION = 110

#: Letters of a name that fit above one of two panels.
_LETTERS = 48


def check_matplotlib() -> None:
    """Raise `PcsmoothError` if matplotlib is not installed."""
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError as error:
        raise PcsmoothError(
            "pictures need matplotlib, which is not installed; pip install 'pcsmooth[plot]'"
        ) from error


def new_figure(width: float, height: float) -> Figure:
    """Make an empty figure.

    Parameters
    ----------
    width, height : float
        Size, inches.

    Returns
    -------
    matplotlib.figure.Figure
        With room for all labels (constrained layout); notebooks show it.

    Raises
    ------
    PcsmoothError
        If matplotlib is not installed.
    """
    check_matplotlib()

    from pcsmooth.plots.shown_figure import ShownFigure

    return ShownFigure(figsize=(width, height), layout="constrained")


def panel_title(name: str) -> str:
    """Spell the name of a cloud so that it fits above one of two panels."""
    return shortened(printable(name), _LETTERS)


def png_of(figure: Figure) -> bytes:
    """Draw a figure as PNG; the same figure gives the same bytes.

    Letters that the font lacks are drawn as boxes, without a warning.
    """
    drawn = BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph \d+ .* missing from")
        figure.savefig(drawn, format="png", dpi=_RESOLUTION, metadata={"Software": None})
    return drawn.getvalue()
