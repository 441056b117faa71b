"""Clouds side by side on a page, to be turned and enlarged: a figure of plotly."""

from __future__ import annotations

from dataclasses import astuple
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import PcsmoothError
from pcsmooth.files.colors import colors_of
from pcsmooth.plots.cloud_figure import LINE_COLORS, counts_in_words, point_diameter
from pcsmooth.plots.histogram import height_of, histograms
from pcsmooth.plots.page import page, paragraph, table
from pcsmooth.plots.valued_clouds import ValuedCloud, ValuedClouds, magnitudes
from pcsmooth.plots.views import View, seen, thinned
from pcsmooth.printable import printable

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

Floats = npt.NDArray[np.float64]

MOST_TURNED = 40_000
"""Points of a cloud beyond which only some are drawn, so that it turns smoothly."""

#: Height of the figure and size of a panel for choosing the size of points, pixels and inches.
_HEIGHT = 860
_PANEL = (7.0, 6.0)
_PIXELS_PER_POINT = 96.0 / 72.0

_UNKNOWN = "rgb(150,150,150)"

#: Colors of the scale, between which the browser interpolates.
_SHADES = 65

#: Extents that single precision holds with all its digits.
_OF_SINGLES = (1e-30, 1e38)

#: In space plotly draws a point of size 1 with three pixels.
_SIZES_PER_PIXEL = {2: 1.0, 3: 1.0 / 3.0}

#: Distance of the eye from the middle of the box, and size of the box with which it fills a
#: panel. There is no perspective.
_EYE = 2.0
_BOX = 1.6

#: Coordinates farther from 0 than this, in units of the extent, are drawn from the middle of the
#: clouds: browsers draw in single precision.
_FAR = 100.0

#: Turns both clouds together. An event of the cloud that followed finds nothing left to do.
_TURN_TOGETHER = """
const plot = document.getElementById("{plot_id}");
plot.on("plotly_relayout", () => {
  const [left, right] = [plot.layout.scene.camera, plot.layout.scene2.camera].map(JSON.stringify);
  if (left === right) return;
  const moved = left === plot.seen ? right : left;
  plot.seen = moved;
  Plotly.relayout(plot, {"scene.camera": JSON.parse(moved), "scene2.camera": JSON.parse(moved)});
});
plot.seen = JSON.stringify(plot.layout.scene.camera);
"""


def check_plotly() -> None:
    """Raise `PcsmoothError` if plotly is not installed."""
    try:
        import plotly  # noqa: F401
    except ImportError as error:
        raise PcsmoothError(
            "pages to turn clouds on need plotly, which is not installed; "
            "pip install 'pcsmooth[plot]'"
        ) from error


def interactive_page(
    shown: ValuedClouds, title: str, *, view: View | None = None, colormap: str | None = None
) -> str:
    """Make a page that needs no other file and no network.

    Parameters
    ----------
    shown : ValuedClouds
        Before and after. At most `MOST_TURNED` points of each are drawn, at regular ranks; the
        histogram and the table count all.
    title : str
        Title of the page, plain text.
    view : View, optional
        From where clouds in space are seen at first.
    colormap : str, optional
        A color map of matplotlib; the one that suits the values by default.

    Returns
    -------
    str
        HTML; the same input gives the same text.

    Raises
    ------
    PcsmoothError
        If plotly or matplotlib is not installed.
    """
    check_plotly()
    figure = interactive_figure(shown, view=view, colormap=colormap)
    drawn = figure.to_html(
        include_plotlyjs=True,
        full_html=False,
        div_id="clouds",
        default_width="100%",
        default_height=f"{_HEIGHT}px",
        config={"displaylogo": False, "responsive": True},
        post_script=_TURN_TOGETHER if shown.dimension == 3 else None,
    )
    rows = [
        [name, str(len(values)), *(f"{number:.6g}" for number in astuple(magnitudes(values)))]
        for name, values in shown.distributions.items()
    ]
    of = f" {shown.symbol}" if shown.symbol else ""
    return page(
        title,
        [
            paragraph(f"Colours: {shown.label}."),
            # Wider than the text of the page.
            f'<div style="width: 94vw; margin-left: calc(50% - 47vw)">{drawn}</div>',
            table(["", "points", f"mean{of}", f"median{of}", f"RMS{of}", f"max{of}"], rows),
        ],
    )


def interactive_figure(
    shown: ValuedClouds, *, view: View | None = None, colormap: str | None = None
) -> Figure:
    """Make the figure of `interactive_page`, whose arguments it takes."""
    from plotly.subplots import make_subplots

    view = view or View()
    is_space = shown.dimension == 3
    origin = _origin(shown)
    panel = {"type": "scene" if is_space else "xy"}
    titles = [
        f"{escape(printable(cloud.title), quote=False)}<br>"
        f"<sub>{counts_in_words(cloud, MOST_TURNED)}</sub>"
        for cloud in shown.clouds
    ]
    figure = make_subplots(
        2, 2, specs=[[panel, panel], [{"colspan": 2}, None]], row_heights=[0.76, 0.24],
        vertical_spacing=0.08, horizontal_spacing=0.03 if is_space else 0.06,
        subplot_titles=titles,
    )  # fmt: skip
    for column, cloud in enumerate(shown.clouds, 1):
        for trace in _point_traces(cloud, origin, shown, view):
            figure.add_trace(trace, row=1, col=column)
    counts, edges = histograms(shown.distributions, shown.limits)
    for trace in _bars(shown, counts, edges):
        figure.add_trace(trace, row=2, col=1)
    names = [_axis_name(name, start) for name, start in zip("xyz", origin, strict=False)]
    if is_space:
        figure.update_scenes(_scene(shown, origin, names, view))
    else:
        low, high = _ranges(shown, origin)
        for column in (1, 2):
            figure.update_xaxes(
                title=names[0], range=[low[0], high[0]], matches="x", row=1, col=column
            )
            figure.update_yaxes(
                title=names[1], range=[low[1], high[1]], matches="y", scaleanchor="x", row=1,
                col=column,
            )  # fmt: skip
    figure.update_xaxes(
        title=f"{shown.label} (what is beyond the scale is in the outermost bars)",
        range=list(shown.limits), row=2, col=1,
    )  # fmt: skip
    figure.update_yaxes(title="points", range=[0.0, height_of(counts)], row=2, col=1)
    low_value, high_value = shown.limits
    figure.update_layout(
        template="plotly_white",
        barmode="overlay",
        bargap=0,
        showlegend=True,
        legend={"x": 1, "xanchor": "right", "y": 0.22, "yanchor": "top"},
        margin={"l": 60, "r": 20, "t": 60, "b": 50},
        coloraxis={
            "cmin": low_value,
            "cmax": high_value,
            "colorscale": _scale(colormap or shown.colormap),
            "colorbar": {
                "title": {"text": shown.label, "side": "right"},
                "len": 0.74, "y": 1, "yanchor": "top",
            },
        },
    )  # fmt: skip
    return figure


def _point_traces(cloud: ValuedCloud, origin: Floats, shown: ValuedClouds, view: View) -> list[Any]:
    """Make the points of a cloud, those of unknown value apart."""
    from plotly import graph_objects

    chosen = thinned(len(cloud.points), MOST_TURNED)
    places = cloud.points[chosen] - origin
    values = cloud.values[chosen]
    known = ~np.isnan(values)
    projected, _ = seen(places, view)
    pixels = _PIXELS_PER_POINT * point_diameter(projected, shown.dimension, _PANEL)
    size = _SIZES_PER_PIXEL[shown.dimension] * pixels
    kind = graph_objects.Scatter3d if shown.dimension == 3 else graph_objects.Scattergl
    symbol = shown.label.partition(",")[0]
    # Single precision is what browsers draw with, and half as long on the page.
    least, largest = _OF_SINGLES
    precision = np.float32 if least < np.abs(places).max(initial=0.0) < largest else np.float64
    traces = []
    for mask, marker, hover in (
        (known, {"color": values[known], "coloraxis": "coloraxis"}, "%{marker.color:.4g}"),
        (~known, {"color": _UNKNOWN}, "unknown"),
    ):
        if mask.any():
            axes = dict(zip("xyz", places[mask].T.astype(precision), strict=False))
            at = ", ".join(f"%{{{name}:.6g}}" for name in axes)
            traces.append(
                kind(
                    **axes,
                    mode="markers",
                    marker={"size": size, "line": {"width": 0}, **marker},
                    hovertemplate=f"{symbol} {hover}<br>at {at}<extra></extra>",
                    showlegend=False,
                )
            )
    return traces


def _bars(
    shown: ValuedClouds, counts: dict[str, npt.NDArray[np.int64]], edges: Floats
) -> list[Any]:
    from plotly import graph_objects

    return [
        graph_objects.Bar(
            x=0.5 * (edges[1:] + edges[:-1]),
            y=counts[name],
            width=float(edges[1] - edges[0]),
            marker={"color": color, "line": {"width": 0}},
            opacity=0.5,
            name=f"{name}: {magnitudes(values).in_words(shown.symbol)}",
        )
        for (name, values), color in zip(
            shown.distributions.items(), LINE_COLORS[-len(counts) :], strict=True
        )
    ]


def _origin(shown: ValuedClouds) -> Floats:
    """Choose from where coordinates are counted: 0, unless that is far away."""
    low, high = shown.box
    middle = 0.5 * (low + high)
    far = np.abs(middle).max() > _FAR * (high - low).max()
    return middle.round() if far else np.zeros(shown.dimension)


def _axis_name(name: str, start: float) -> str:
    since = f" − {start:.15g}" if start > 0.0 else f" + {-start:.15g}" if start < 0.0 else ""
    return f"{name}{since}, coordinate units"


def _ranges(shown: ValuedClouds, origin: Floats) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates of all clouds, with a margin."""
    low, high = shown.box
    margin = 0.03 * ((high - low).max() or 1.0)
    return low - origin - margin, high - origin + margin


def _scene(shown: ValuedClouds, origin: Floats, names: list[str], view: View) -> dict[str, Any]:
    """Set up a view in space, without perspective and with equal units on its axes."""
    low, high = _ranges(shown, origin)
    _, up, towards = view.axes
    axes = {
        f"{letter}axis": {
            "title": {"text": name}, "range": [start, end], "showbackground": False, "nticks": 5,
        }
        for letter, name, start, end in zip("xyz", names, low, high, strict=True)
    }  # fmt: skip
    return {
        **axes,
        "aspectmode": "manual",
        "aspectratio": dict(zip("xyz", _BOX * (high - low) / (high - low).max(), strict=True)),
        "camera": {
            "projection": {"type": "orthographic"},
            "eye": dict(zip("xyz", _EYE * towards, strict=True)),
            "up": dict(zip("xyz", up, strict=True)),
            "center": {"x": 0.0, "y": 0.0, "z": 0.0},
        },
    }


def _scale(colormap: str) -> list[list[Any]]:
    """Colors of a color map of matplotlib as plotly takes them."""
    shares = np.linspace(0.0, 1.0, _SHADES)
    colors = colors_of(shares, np.ones(_SHADES, np.bool_), colormap, (0.0, 1.0))
    return [
        [float(share), f"rgb({red},{green},{blue})"]
        for share, (red, green, blue) in zip(shares, colors.tolist(), strict=True)
    ]
