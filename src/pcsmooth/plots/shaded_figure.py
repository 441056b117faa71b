"""A surface before and after, shaded from its normals: whole, a part of it, and a thin slice."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.plots.cloud_figure import LINE_COLORS
from pcsmooth.plots.figures import new_figure, panel_title
from pcsmooth.plots.finite_rows import finite_rows
from pcsmooth.plots.rough_normals import rough_normals
from pcsmooth.plots.scale_bar import SCALE_MARGIN, draw_scale
from pcsmooth.plots.shaded_cloud import ShadedCloud
from pcsmooth.plots.splats import Frame
from pcsmooth.plots.views import View, thinned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]

MOST_SHADED = 500_000
"""Points of a cloud beyond which only some are drawn."""

#: Pixels along the longer side of a panel, and of that of the part.
_PIXELS = 700
_PART_PIXELS = 400

#: Side of the part that is shown larger, as a share of the longer side of the whole, and places
#: per axis where it may be.
_PART = 0.2
_PLACES = 12

#: Share of the pixels of the part that must show something.
_COVERED = 0.6

#: Half the thickness of the slice, in units of the spacing of the points as seen, and half its
#: length, as a share of the part's side.
_SLICE = 0.7
_LENGTH = 0.2


def shaded_figure(
    before: Floats,
    after: Floats,
    normals: Floats | None,
    view: View,
    titles: Sequence[str] = ("before", "after"),
) -> Figure:
    """Draw a surface before and after from the same side, with the same light.

    The points after are lit by the normals given, those before by planes through the few nearest
    points, so that their noise is seen as roughness.

    Parameters
    ----------
    before, after : ndarray, shape (n, 3)
        Positions, L; row i is the same point in both. Rows that are not finite in both are left
        out.
    normals : ndarray, shape (n, 3), or None
        Unit normals after, zero or NaN where unknown; None if those points are to be lit as those
        before.
    view : View
        From where, without perspective.
    titles : sequence of str
        What the clouds are.

    Returns
    -------
    matplotlib.figure.Figure
        Both as a whole, a part of both where most is to be seen, and a thin slice through it.

    Raises
    ------
    InvalidInputError
        If the clouds differ in shape, are no surfaces in space, or no point is left.
    PcsmoothError
        If matplotlib is not installed.
    """
    if before.shape != after.shape or before.shape[1] != 3:
        raise InvalidInputError(
            "only the same points before and after in space can be shaded; choose --color-by "
            "displacement or distance"
        )
    usable = finite_rows(before, after)
    rows = usable[thinned(len(usable), MOST_SHADED)]
    found = [rough_normals(before[rows])]
    found.append(rough_normals(after[rows]) if normals is None else np.nan_to_num(normals[rows]))
    clouds = [
        ShadedCloud.of(points[rows], own, view)
        for points, own in zip((before, after), found, strict=True)
    ]
    whole = clouds[1].frame(_PIXELS)
    spacing = clouds[1].spacing(whole)
    part = _part_of(clouds[1], whole, spacing)
    aspect = whole.height / whole.width
    figure = new_figure(12.0, float(np.clip(6.0 * aspect, 2.5, 9.0)) + 10.4)
    grid = figure.add_gridspec(3, 2, height_ratios=[max(6.0 * aspect, 2.5) + 1.0, 6.4, 2.5])
    for row, frame in enumerate((whole, part)):
        for column, (cloud, title) in enumerate(zip(clouds, titles, strict=True)):
            axes = figure.add_subplot(grid[row, column])
            _draw(axes, cloud, frame, spacing, view)
            words = panel_title(title) if row == 0 else "a part of it"
            axes.set_title(words, fontsize=10, parse_math=False)
            if row == 0:
                _draw_border(axes, part)
    _draw_slice(figure.add_subplot(grid[2, :]), clouds, part, spacing)
    return figure


def _part_of(cloud: ShadedCloud, whole: Frame, spacing: float) -> Frame:
    """Choose the part in which brightness varies most, of those that are well covered."""
    bright = cloud.seen_in(whole, spacing)
    side = max(2, int(_PART * max(bright.shape)))
    best, place = -1.0, (0, 0)
    for up in np.linspace(0, max(0, whole.height - side), _PLACES).astype(int):
        for across in np.linspace(0, max(0, whole.width - side), _PLACES).astype(int):
            seen = bright[up : up + side, across : across + side]
            known = seen[np.isfinite(seen)]
            share = len(known) / seen.size
            score = float(known.std()) + 1.0 if share >= _COVERED else share
            if score > best:
                best, place = score, (up, across)
    low = whole.low + whole.pixel * np.array([place[1], place[0]])
    return Frame(low, low + whole.pixel * side, _PART_PIXELS, _PART_PIXELS)


def _draw(axes: Axes, cloud: ShadedCloud, frame: Frame, spacing: float, view: View) -> None:
    axes.imshow(
        cloud.seen_in(frame, spacing), cmap="gray", vmin=0.0, vmax=1.0, origin="lower",
        extent=(frame.low[0], frame.high[0], frame.low[1], frame.high[1]),
        interpolation="nearest",
    )  # fmt: skip
    axes.set_axis_off()
    below = np.array([0.0, SCALE_MARGIN * float((frame.high - frame.low).max())])
    axes.set_ylim(frame.low[1] - below[1], frame.high[1])
    draw_scale(axes, view, frame.low - below, frame.high)


def _draw_border(axes: Axes, part: Frame) -> None:
    """Show where the part is."""
    across, up = np.stack([part.low, part.high]).T[:, [0, 1]]
    axes.plot(across[[0, 1, 1, 0, 0]], up[[0, 0, 1, 1, 0]], color=LINE_COLORS[0], lw=1.0)


def _draw_slice(axes: Axes, clouds: Sequence[ShadedCloud], part: Frame, spacing: float) -> None:
    """Draw the points of a thin slab through the middle of the part, as seen from its side."""
    apart = np.abs(clouds[1].turned[:, :2] - 0.5 * (part.low + part.high))
    inside = apart[:, 1] <= _SLICE * spacing
    inside &= apart[:, 0] <= _LENGTH * (part.high[0] - part.low[0])
    for cloud, color, name in zip(clouds, LINE_COLORS, ("before", "after"), strict=True):
        across, depth = cloud.turned[inside][:, [0, 2]].T
        axes.scatter(across, depth, s=9.0, color=color, label=name, lw=0)
    axes.set_title("a thin slice through the middle of the part, seen from below", fontsize=10)
    axes.set_xlabel("to the right, coordinate units")
    axes.set_ylabel("towards the viewer")
    axes.ticklabel_format(useOffset=False)
    axes.legend(loc="upper right", fontsize=9)
