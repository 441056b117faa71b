"""A curve before and after: whole, and the part of it that has moved most."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.plots.cloud_figure import LINE_COLORS, MOST_DRAWN, point_diameter
from pcsmooth.plots.figures import new_figure, panel_title
from pcsmooth.plots.finite_rows import finite_rows
from pcsmooth.plots.plane_axes import frame_of, set_plane
from pcsmooth.plots.views import thinned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]

#: Points that the part that is shown larger holds at the median, and bounds of its side, as shares
#: of the longer side of the whole.
_PART = 20
_SIDES = (0.02, 0.3)

#: Width of the figure, lowest and highest panels, and height of the part, inches.
_WIDTH = 12.0
_HEIGHTS = (2.2, 5.5)
_PART_HEIGHT = 5.0

#: Share of the extent that is left free on each side.
_MARGIN = 0.05


def curve_figure(
    before: Floats, after: Floats, titles: Sequence[str] = ("before", "after")
) -> Figure:
    """Draw a curve before and after with the same axes, and both in the part that moved most.

    Parameters
    ----------
    before, after : ndarray, shape (n, 2)
        Positions, L; row i is the same point in both. Rows that are not finite in both are left
        out.
    titles : sequence of str
        What the clouds are.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidInputError
        If the clouds differ in shape, are no curves in the plane, or no point is left.
    PcsmoothError
        If matplotlib is not installed.
    """
    if before.shape != after.shape or before.shape[1] != 2:
        raise InvalidInputError(
            "only the same points before and after can be shown as a curve; choose --color-by "
            "distance"
        )
    usable = finite_rows(before, after)
    rows = usable[thinned(len(usable), MOST_DRAWN)]
    clouds = [before[rows], after[rows]]
    low, high = frame_of(np.concatenate(clouds), _MARGIN)
    height = float(np.clip(0.5 * _WIDTH * (high - low)[1] / (high - low)[0], *_HEIGHTS))
    figure = new_figure(_WIDTH, height + _PART_HEIGHT + 1.6)
    grid = figure.add_gridspec(2, 2, height_ratios=[height, _PART_HEIGHT])
    part = _part(clouds[0], clouds[1], low, high)
    size = (0.45 * _WIDTH, height)
    for column, (cloud, color, title) in enumerate(zip(clouds, LINE_COLORS, titles, strict=True)):
        axes = figure.add_subplot(grid[0, column])
        _draw(axes, cloud, color, size)
        set_plane(axes, low, high, size)
        axes.set_title(panel_title(title), fontsize=10, parse_math=False)
        corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])
        axes.plot(*(part[0] + corners * (part[1] - part[0])).T, color="0.4", lw=1.0)
    axes = figure.add_subplot(grid[1, :])
    for cloud, color, name in zip(clouds, LINE_COLORS, ("before", "after"), strict=True):
        inside = ((cloud >= part[0]) & (cloud <= part[1])).all(axis=1)
        axes.scatter(*cloud[inside].T, s=16.0, color=color, label=name, linewidths=0)  # type: ignore[misc]
    moved = np.linalg.norm(clouds[1] - clouds[0], axis=1) > 0.0
    inside = ((clouds[1] >= part[0]) & (clouds[1] <= part[1])).all(axis=1) & moved
    ways = np.stack([clouds[0][inside], clouds[1][inside]])
    axes.plot(ways[..., 0], ways[..., 1], color="0.7", lw=0.8, zorder=0)
    set_plane(axes, *part, (_PART_HEIGHT, _PART_HEIGHT))
    axes.set_title("the part that moved most", fontsize=10)
    axes.legend(loc="upper right", fontsize=9)
    return figure


def _part(before: Floats, after: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Corners of the square around a point in which the points have moved farthest on average."""
    from scipy.spatial import cKDTree

    centers = after[thinned(len(after), 200)]
    tree = cKDTree(after)
    reach = tree.query(centers, [min(_PART, len(after))], p=np.inf)[0]
    longest = float((high - low).max())
    half = float(np.clip(np.median(reach), 0.5 * _SIDES[0] * longest, 0.5 * _SIDES[1] * longest))
    around = tree.query_ball_point(centers, half, p=np.inf)
    moved = np.linalg.norm(after - before, axis=1)
    means = [float(moved[rows].mean()) if 2 * len(rows) >= _PART else -1.0 for rows in around]
    center = centers[int(np.argmax(means))]
    return center - half, center + half


def _draw(axes: Axes, cloud: Floats, color: str, size: tuple[float, float]) -> None:
    diameter = point_diameter(cloud, 2, size)
    axes.scatter(cloud[:, 0], cloud[:, 1], s=diameter**2, color=color, linewidths=0)
