"""Clouds side by side, coloured by a value, over its histogram: a figure of matplotlib."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from pcsmooth.plots.figures import new_figure, panel_title
from pcsmooth.plots.histogram import height_of, histograms
from pcsmooth.plots.plane_axes import frame_of, set_plane
from pcsmooth.plots.scale_bar import SCALE_MARGIN, draw_scale
from pcsmooth.plots.valued_clouds import ValuedCloud, ValuedClouds, magnitudes
from pcsmooth.plots.views import View, seen, thinned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]

MOST_DRAWN = 100_000
"""Points of a cloud beyond which only some are drawn."""

#: Widths of the figure by number of clouds, lowest and highest panels, and what is around and
#: below them, inches.
_WIDTHS = {1: 8.0, 2: 12.0}
_HEIGHTS = (2.2, 5.0)
_AROUND = 1.6
_BELOW = 2.2

#: Share of the figure's width that panels have: the rest is color bar and labels.
_PANELS_SHARE = 0.88

#: Share of the extent that is left free on each side.
_MARGIN = 0.04

#: Diameter of a point, in units of the spacing of the points as seen, by dimension: a surface has
#: a front and a back. Bounds in typographic points.
_OVERLAPS = {2: 0.65, 3: 2.3}
_DIAMETERS = (1.4, 5.0)

#: Cells of the grid, per axis, by which the area that points cover is measured.
_CELLS = 64

#: Most numbers on the axis of a histogram.
_NUMBERS = 7

_UNKNOWN = "0.6"
LINE_COLORS = ("#c0504d", "#1f4e79")


def cloud_figure(
    shown: ValuedClouds,
    *,
    view: View | None = None,
    colormap: str | None = None,
    spacing: float | None = None,
) -> Figure:
    """Draw clouds side by side with one scale of colors, and the histogram of their values.

    Parameters
    ----------
    shown : ValuedClouds
        One or two clouds. At most `MOST_DRAWN` points of each are drawn, at regular ranks; the
        histogram counts all.
    view : View, optional
        From where clouds in space are seen, without perspective.
    colormap : str, optional
        A color map of matplotlib; the one that suits the values by default.
    spacing : float, optional
        Mean spacing, L; gives the histogram a second scale in its units.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    PcsmoothError
        If matplotlib is not installed.
    """
    view = view or View()
    low, high = _frame(shown, view)
    n_clouds = len(shown.clouds)
    width = _WIDTHS[n_clouds]
    panel = _PANELS_SHARE * width / n_clouds
    height = float(np.clip(panel * (high - low)[1] / (high - low)[0], *_HEIGHTS))
    figure = new_figure(width, height + _AROUND + _BELOW)
    figure.set_layout_engine("constrained", w_pad=0.1, h_pad=0.1)
    grid = figure.add_gridspec(2, n_clouds, height_ratios=[height + 0.5 * _AROUND, _BELOW])
    panels = [figure.add_subplot(grid[0, column]) for column in range(n_clouds)]
    for axes, cloud in zip(panels, shown.clouds, strict=True):
        points = _draw(axes, cloud, shown, view, colormap, (panel, height))
        set_plane(axes, low, high, (panel, height))
        if shown.dimension == 3:
            axes.set_axis_off()
            draw_scale(axes, view, low, high)
    figure.colorbar(
        points, ax=panels, label=shown.label, extend=shown.reaches_beyond,
        fraction=0.05, pad=0.02, aspect=25, panchor=(0.5, 0.5),
    )  # fmt: skip
    _draw_histogram(figure.add_subplot(grid[1, :]), shown, spacing)
    return figure


def counts_in_words(cloud: ValuedCloud, most_drawn: int) -> str:
    """Say how many points a cloud has, and which of its rows and points are not drawn."""
    n_points = len(cloud.points)
    unknown = int(np.isnan(cloud.values).sum())
    notes = [
        f"{n_points:,} points",
        *([f"{most_drawn:,} of them drawn"] if n_points > most_drawn else []),
        *([f"{cloud.left_out:,} not finite, left out"] if cloud.left_out else []),
        *([f"{unknown:,} of unknown value, grey"] if unknown else []),
    ]
    return "; ".join(notes)


def _frame(shown: ValuedClouds, view: View) -> tuple[Floats, Floats]:
    """Corners of what is seen of all clouds, with a margin, L."""
    projected = [seen(cloud.points, view)[0] for cloud in shown.clouds]
    corners = [part for points in projected for part in (points.min(axis=0), points.max(axis=0))]
    low, high = frame_of(np.array(corners), _MARGIN)
    below = SCALE_MARGIN * (high - low).max() if shown.dimension == 3 else 0.0
    return low - [0.0, below], high


def _draw(
    axes: Axes,
    cloud: ValuedCloud,
    shown: ValuedClouds,
    view: View,
    colormap: str | None,
    size: tuple[float, float],
) -> PathCollection:
    """Draw the points of a cloud, the farthest first."""
    import matplotlib

    chosen = thinned(len(cloud.points), MOST_DRAWN)
    projected, order = seen(cloud.points[chosen], view)
    shades = matplotlib.colormaps[colormap or shown.colormap].with_extremes(bad=_UNKNOWN)
    # A dollar in the name of a file begins no formula.
    title = f"{panel_title(cloud.title)}\n{counts_in_words(cloud, MOST_DRAWN)}"
    axes.set_title(title, fontsize=10, parse_math=False)
    across, upwards = projected[order].T
    return axes.scatter(
        across,
        upwards,
        c=cloud.values[chosen][order],
        s=point_diameter(projected, shown.dimension, size) ** 2,
        cmap=shades,
        vmin=shown.limits[0],
        vmax=shown.limits[1],
        linewidths=0,
        plotnonfinite=True,
    )


def point_diameter(projected: Floats, dimension: int, size: tuple[float, float]) -> float:
    """Choose the diameter of points with which a surface looks closed.

    Parameters
    ----------
    projected : ndarray, shape (n, 2)
        The points as they are seen, L.
    dimension : int
        2 for a curve, which is not filled, 3 for a surface with a front and a back.
    size : tuple of float
        Width and height of the panel, inches.

    Returns
    -------
    float
        Typographic points (1/72 inch).
    """
    extent = np.ptp(projected, axis=0)
    longest = extent.max() or 1.0
    cells = (projected - projected.min(axis=0)) / longest * (_CELLS - 1)
    covered = len(np.unique(cells.astype(np.int64) @ [_CELLS, 1])) / _CELLS**2
    scale = (np.asarray(size) / np.maximum(extent, 1e-9 * longest)).min()
    side = 72.0 * scale * longest  # inches to typographic points
    spacing = np.sqrt(covered * side**2 / len(projected))
    return float(np.clip(_OVERLAPS[dimension] * spacing, *_DIAMETERS))


def _draw_histogram(axes: Axes, shown: ValuedClouds, spacing: float | None) -> None:
    counts, edges = histograms(shown.distributions, shown.limits)
    # The last stands alone in the color of what is after.
    for name, color in zip(counts, LINE_COLORS[-len(counts) :], strict=True):
        found = magnitudes(shown.distributions[name])
        axes.stairs(
            counts[name], edges, fill=True, facecolor=(color, 0.25), edgecolor=color, lw=1.2,
            label=f"{name}: {found.in_words(shown.symbol)}",
        )  # fmt: skip
    axes.set_xlim(*shown.limits)
    axes.set_xlabel(shown.label)
    axes.locator_params(axis="x", nbins=_NUMBERS)
    axes.set_ylim(0.0, height_of(counts))
    axes.set_ylabel("points")
    title = "what is beyond the scale is in the outermost bars"
    axes.legend(loc="upper right", fontsize=9, title=title, title_fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    if spacing:
        scale = axes.secondary_xaxis(
            "top", functions=(_multiply(1.0 / spacing), _multiply(spacing))
        )
        scale.set_xlabel("in mean spacings")
        scale.locator_params(axis="x", nbins=_NUMBERS)


def _multiply(factor: float) -> Callable[[Any], Any]:
    return lambda values: values * factor
