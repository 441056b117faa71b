"""What is handed to plotly, taken from the figure that it makes and from the page."""

from __future__ import annotations

import sys
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
import pytest
from plotly import graph_objects

from pcsmooth.errors import PcsmoothError
from pcsmooth.plots import interactive as module
from pcsmooth.plots.histogram import histograms
from pcsmooth.plots.interactive import check_plotly, interactive_figure, interactive_page
from pcsmooth.plots.valued_clouds import ValuedClouds, by_curvature, by_displacement, magnitudes
from pcsmooth.plots.views import View
from plots.pages import read_page

Points = npt.NDArray[np.float64]


def moved(dimension: int, n: int = 200, far: float = 0.0) -> ValuedClouds:
    rng = np.random.default_rng(dimension)
    before = rng.normal(size=(n, dimension)) * [4.0, 1.0, 2.0][:dimension]
    after = before + rng.normal(scale=0.1, size=before.shape)
    return by_displacement(before + far, after + far, ["b & b", "a"])


def places(trace: graph_objects.Scatter3d, dimension: int) -> Points:
    return np.stack([np.asarray(trace[name]) for name in "xyz"[:dimension]], axis=1)


@pytest.mark.parametrize("dimension", [2, 3])
class TestFigure:
    def test_points_values_and_one_scale(self, dimension: int) -> None:
        shown = moved(dimension)
        figure = interactive_figure(shown)
        kind = {2: "scattergl", 3: "scatter3d"}[dimension]
        traces = [trace for trace in figure.data if trace.type == kind]
        assert len(traces) == 2
        for trace, cloud in zip(traces, shown.clouds, strict=True):
            np.testing.assert_allclose(places(trace, dimension), cloud.points, rtol=1e-6)
            np.testing.assert_array_equal(trace.marker.color, cloud.values)
            assert trace.marker.coloraxis == "coloraxis"
            assert trace.marker.size == traces[0].marker.size or trace.marker.size > 0
        scale = figure.layout.coloraxis
        assert (scale.cmin, scale.cmax) == shown.limits
        assert scale.colorbar.title.text == "displacement, coordinate units"

    def test_bars_are_the_histogram(self, dimension: int) -> None:
        shown = moved(dimension)
        (bars,) = (trace for trace in interactive_figure(shown).data if trace.type == "bar")
        counts, edges = histograms(shown.distributions, shown.limits)
        np.testing.assert_array_equal(bars.y, counts["displacement"])
        assert np.sum(bars.y) == 200
        np.testing.assert_allclose(bars.x - 0.5 * bars.width, edges[:-1], atol=1e-12)
        found = magnitudes(shown.distributions["displacement"])
        assert bars.name == f"displacement: {found.in_words()}"

    def test_titles_and_units(self, dimension: int) -> None:
        figure = interactive_figure(moved(dimension))
        assert [note.text for note in figure.layout.annotations] == [
            "b &amp; b<br><sub>200 points</sub>",
            "a<br><sub>200 points</sub>",
        ]
        axes = (
            [figure.layout.scene, figure.layout.scene2] if dimension == 3 else [figure.layout] * 2
        )
        for axis in axes:
            assert axis.xaxis.title.text == "x, coordinate units"
            assert axis.yaxis.title.text == "y, coordinate units"

    @pytest.mark.parametrize("scale", [1e-90, 1e90])
    def test_extents_that_single_precision_does_not_hold(
        self, dimension: int, scale: float
    ) -> None:
        shown = moved(dimension)
        clouds = [replace(cloud, points=cloud.points * scale) for cloud in shown.clouds]
        figure = interactive_figure(replace(shown, clouds=tuple(clouds)))
        kind = {2: "scattergl", 3: "scatter3d"}[dimension]
        traces = [trace for trace in figure.data if trace.type == kind]
        for trace, cloud in zip(traces, clouds, strict=True):
            np.testing.assert_allclose(places(trace, dimension), cloud.points, rtol=1e-6)

    def test_far_coordinates_are_counted_from_nearby(self, dimension: int) -> None:
        shown = moved(dimension, far=5_000_000.0)
        figure = interactive_figure(shown)
        box = figure.layout.scene if dimension == 3 else figure.layout
        title = box.xaxis.title.text
        start = float(title.removeprefix("x − ").removesuffix(", coordinate units"))
        assert start == pytest.approx(5e6, abs=20.0)
        np.testing.assert_allclose(
            figure.data[0].x, shown.clouds[0].points[:, 0] - start, atol=1e-5
        )
        negative = interactive_figure(moved(dimension, far=-5_000_000.0))
        box = negative.layout.scene if dimension == 3 else negative.layout
        assert box.xaxis.title.text.startswith("x + ")

    def test_points_of_unknown_value_are_grey(self, dimension: int) -> None:
        cloud = moved(dimension).clouds[0]
        values = np.linspace(-1.0, 1.0, 200)
        values[:9] = np.nan
        clouds = {"before": (cloud.points, values), "after": (cloud.points, values)}
        figure = interactive_figure(by_curvature(clouds))
        known, unknown = figure.data[:2]
        assert (len(known.x), len(unknown.x)) == (191, 9)
        assert unknown.marker.color == "rgb(150,150,150)"
        np.testing.assert_allclose(places(unknown, dimension), cloud.points[:9], rtol=1e-6)

    def test_only_some_of_many_are_drawn_and_all_are_counted(
        self, dimension: int, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(module, "MOST_TURNED", 50)
        shown = moved(dimension)
        figure = interactive_figure(shown)
        np.testing.assert_array_equal(figure.data[0].marker.color, shown.clouds[0].values[::4])
        assert "200 points; 50 of them drawn" in figure.layout.annotations[0].text
        assert np.sum(figure.data[-1].y) == 200

    @pytest.mark.parametrize("colormap", [None, "turbo"])
    def test_colors(self, dimension: int, colormap: str | None) -> None:
        figure = interactive_figure(moved(dimension), colormap=colormap)
        for share, color in figure.layout.coloraxis.colorscale:
            channels = [int(word) for word in color[4:-1].split(",")]
            expected = mpl.colormaps[colormap or "viridis"](share, bytes=True)[:3]
            np.testing.assert_allclose(channels, expected, atol=1)


def test_space_has_equal_units_and_common_limits() -> None:
    shown = moved(3)
    view = View(20.0, 70.0)
    left, right = (
        interactive_figure(shown, view=view).layout[name] for name in ("scene", "scene2")
    )
    low, high = shown.box
    ratios = []
    for axis, lowest, highest in zip("xyz", low, high, strict=True):
        limits = left[f"{axis}axis"].range
        assert limits == right[f"{axis}axis"].range
        assert limits[0] < lowest < highest < limits[1]
        ratios.append((limits[1] - limits[0]) / left.aspectratio[axis])
    np.testing.assert_allclose(ratios, ratios[0])
    assert left.aspectmode == "manual"
    assert left.camera == right.camera
    eye = np.array([left.camera.eye[name] for name in "xyz"])
    np.testing.assert_allclose(eye / np.linalg.norm(eye), view.axes[2])
    np.testing.assert_allclose([left.camera.up[name] for name in "xyz"], view.axes[1])
    assert left.camera.projection.type == "orthographic"


def test_the_plane_has_equal_units_and_common_limits() -> None:
    layout = interactive_figure(moved(2)).layout
    assert layout.xaxis.range == layout.xaxis2.range
    assert layout.yaxis.range == layout.yaxis2.range
    assert layout.xaxis2.matches == "x"
    assert layout.yaxis2.matches == "y"
    assert layout.yaxis.scaleanchor == layout.yaxis2.scaleanchor == "x"


@pytest.mark.parametrize("dimension", [2, 3])
class TestPage:
    def test_it_needs_no_other_file(self, dimension: int) -> None:
        page = read_page(interactive_page(moved(dimension), "A <b> & B"))
        assert page.links == []
        assert page.headings == ["A <b> & B"]
        assert sum("Plotly.newPlot" in script for script in page.scripts) == 1
        assert max(map(len, page.scripts)) > 1_000_000  # the library

    def test_the_table_has_the_numbers(self, dimension: int) -> None:
        shown = moved(dimension)
        moves = np.linalg.norm(shown.clouds[1].points - shown.clouds[0].points, axis=1)
        facts = read_page(interactive_page(shown, "t")).facts
        assert facts[""] == ["points", "mean", "median", "RMS", "max"]
        numbers = [moves.mean(), np.median(moves), np.sqrt((moves**2).mean()), moves.max()]
        assert facts["displacement"] == ["200", *(f"{number:.6g}" for number in numbers)]

    def test_titles_are_text(self, dimension: int) -> None:
        wild = "</script><script>alert('<b>$1')</script>"
        cloud = moved(dimension).clouds[0].points
        page = read_page(interactive_page(by_displacement(cloud, cloud, [wild, wild]), wild))
        assert page.headings == [wild]
        assert not any(script.startswith("alert") for script in page.scripts)

    def test_same_bytes(self, dimension: int) -> None:
        assert interactive_page(moved(dimension), "t") == interactive_page(moved(dimension), "t")

    def test_clouds_in_space_turn_together(self, dimension: int) -> None:
        html = interactive_page(moved(dimension), "t")
        assert ('plot.on("plotly_relayout"' in html) == (dimension == 3)
        assert 'getElementById("clouds")' in html
        assert "{plot_id}" not in html


def test_without_plotly(monkeypatch: pytest.MonkeyPatch) -> None:
    check_plotly()
    monkeypatch.setitem(sys.modules, "plotly", None)
    with pytest.raises(PcsmoothError, match=r"plotly.*; pip install 'pcsmooth\[plot\]'"):
        interactive_page(moved(2), "t")
