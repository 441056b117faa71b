"""A surface before and after, shaded from its normals: whole, a part of it, and a thin slice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.plots.cloud_figure import LINE_COLORS
from pcsmooth.plots.figures import new_figure
from pcsmooth.plots.rough_normals import rough_normals
from pcsmooth.plots.shading import lit, occlusion
from pcsmooth.plots.splats import Frame, splat
from pcsmooth.plots.views import View, thinned
from pcsmooth.positions import usable_rows
from pcsmooth.printable import printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]

MOST_SHADED = 500_000
"""Points of a cloud beyond which only some are drawn."""

#: Pixels along the longer side of a panel and of that of the part, and share of the points left
#: outside of the whole view on each side, so that a few far away do not make it small.
_PIXELS = 700
_PART_PIXELS = 400
_OUTSIDE = 0.002

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

#: Diameter of a point, in units of that spacing; bounds in pixels. Depths are averaged over so many
#: diameters for the shadow in hollows, pixels at least.
_OVERLAP = 2.2
_DIAMETERS = (1.0, 20.0)
_SHADOW = 2.0
_LEAST_SHADOW = 6.0


@dataclass(frozen=True, eq=False)
class _Shaded:
    """A cloud as it is seen, and how bright its points are."""

    turned: Floats
    brightness: Floats


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
    usable = np.flatnonzero(usable_rows(before) & usable_rows(after))
    if len(usable) == 0:
        raise InvalidInputError("no point with finite coordinates is left; check the file")
    rows = usable[thinned(len(usable), MOST_SHADED)]
    found = [rough_normals(before[rows])]
    found.append(rough_normals(after[rows]) if normals is None else np.nan_to_num(normals[rows]))
    clouds = [
        _Shaded(points[rows] @ view.axes.T, lit(own @ view.axes.T))
        for points, own in zip((before, after), found, strict=True)
    ]
    whole = _frame_of(clouds[1].turned)
    spacing = _spacing(clouds[1].turned, whole)
    part = _part_of(clouds[1], whole, spacing)
    aspect = whole.height / whole.width
    figure = new_figure(12.0, float(np.clip(6.0 * aspect, 2.5, 9.0)) + 8.5)
    grid = figure.add_gridspec(3, 2, height_ratios=[max(6.0 * aspect, 2.5), 5.5, 2.5])
    for row, frame in enumerate((whole, part)):
        for column, (cloud, title) in enumerate(zip(clouds, titles, strict=True)):
            axes = figure.add_subplot(grid[row, column])
            _draw(axes, cloud, frame, spacing)
            words = printable(title) if row == 0 else "a part of it"
            axes.set_title(words, fontsize=10, parse_math=False)
            if row == 0:
                _draw_border(axes, part)
    _draw_slice(figure.add_subplot(grid[2, :]), clouds, part, spacing)
    return figure


def _frame_of(turned: Floats) -> Frame:
    """Frame all but a few points."""
    low, high = np.quantile(turned[:, :2], [_OUTSIDE, 1.0 - _OUTSIDE], axis=0)
    extent = high - low
    longest = float(extent.max()) or 1.0
    margin = 0.5 * np.maximum(0.05 * longest - extent, 0.0) + 0.03 * longest
    low, high = low - margin, high + margin
    size = np.maximum(1, np.round(_PIXELS * (high - low) / (high - low).max())).astype(int)
    return Frame(low, high, int(size[0]), int(size[1]))


def _spacing(turned: Floats, frame: Frame) -> float:
    """Distance of neighbouring points as seen, L: of as many on the area that they cover."""
    cells = np.floor((turned[:, :2] - frame.low) / (8.0 * frame.pixel)).astype(np.int64)
    area = len(np.unique(cells, axis=0)) * (8.0 * frame.pixel) ** 2
    return float(np.sqrt(area / len(turned)))


def _brightness(cloud: _Shaded, frame: Frame, spacing: float) -> Floats:
    """Brightness of each pixel, NaN where nothing is seen."""
    diameter = float(np.clip(_OVERLAP * spacing / frame.pixel, *_DIAMETERS))
    nearest, depth = splat(cloud.turned, frame, diameter)
    bright = np.where(nearest >= 0, cloud.brightness[nearest], np.nan)
    return bright * occlusion(depth, frame.pixel, max(_SHADOW * diameter, _LEAST_SHADOW))


def _part_of(cloud: _Shaded, whole: Frame, spacing: float) -> Frame:
    """Choose the part in which brightness varies most, of those that are well covered."""
    bright = _brightness(cloud, whole, spacing)
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


def _draw(axes: Axes, cloud: _Shaded, frame: Frame, spacing: float) -> None:
    axes.imshow(
        _brightness(cloud, frame, spacing), cmap="gray", vmin=0.0, vmax=1.0, origin="lower",
        extent=(frame.low[0], frame.high[0], frame.low[1], frame.high[1]),
        interpolation="nearest",
    )  # fmt: skip
    axes.set_axis_off()


def _draw_border(axes: Axes, part: Frame) -> None:
    """Show where the part is."""
    across, up = np.stack([part.low, part.high]).T[:, [0, 1]]
    axes.plot(across[[0, 1, 1, 0, 0]], up[[0, 0, 1, 1, 0]], color=LINE_COLORS[0], lw=1.0)


def _draw_slice(axes: Axes, clouds: Sequence[_Shaded], part: Frame, spacing: float) -> None:
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
