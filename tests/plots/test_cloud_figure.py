"""What is handed to matplotlib, taken from the figure that it makes."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.patches import StepPatch

from pcsmooth.plots import cloud_figure as module
from pcsmooth.plots.cloud_figure import (
    cloud_figure,
    counts_in_words,
    point_diameter,
)
from pcsmooth.plots.figures import png_of
from pcsmooth.plots.histogram import histograms
from pcsmooth.plots.scale_bar import round_length
from pcsmooth.plots.valued_clouds import (
    ValuedCloud,
    ValuedClouds,
    by_curvature,
    by_displacement,
    by_distance,
    magnitudes,
)
from pcsmooth.plots.views import View

Points = npt.NDArray[np.float64]


def moved(dimension: int, n: int = 200) -> tuple[Points, Points]:
    rng = np.random.default_rng(dimension)
    before = rng.normal(size=(n, dimension)) * [4.0, 1.0, 2.0][:dimension]
    return before, before + rng.normal(scale=0.1, size=before.shape)


def drawn(axes: Axes) -> PathCollection:
    (points,) = axes.collections
    assert isinstance(points, PathCollection)
    return points


def histogram_of(figure: Figure) -> Axes:
    (axes,) = (axes for axes in figure.axes if axes.get_ylabel() == "points")
    return axes


def curved(dimension: int) -> ValuedClouds:
    before, after = moved(dimension)
    values = np.linspace(-2.0, 1.0, 200)
    values[:7] = np.nan
    return by_curvature({"before": (before, values), "after": (after, 0.5 * values)})


@pytest.mark.parametrize("dimension", [2, 3])
class TestPanels:
    def test_points_and_values(self, dimension: int) -> None:
        before, after = moved(dimension)
        shown = by_distance(before, after[:150])
        view = View(20.0, 70.0)
        figure = cloud_figure(shown, view=view)
        for axes, cloud in zip(figure.axes, shown.clouds, strict=False):
            points = drawn(axes)
            places, order = cloud.points, np.arange(len(cloud.points))
            if dimension == 3:
                turned = places @ view.axes.T
                places, order = turned[:, :2], np.argsort(turned[:, 2])
            np.testing.assert_allclose(np.asarray(points.get_offsets()), places[order])
            np.testing.assert_allclose(np.asarray(points.get_array()), cloud.values[order])

    def test_limits_scale_and_size_are_common(self, dimension: int) -> None:
        shown = by_displacement(*moved(dimension))
        figure = cloud_figure(shown)
        left, right = figure.axes[:2]
        assert left.get_xlim() == right.get_xlim()
        assert left.get_ylim() == right.get_ylim()
        assert left.get_aspect() == right.get_aspect() == 1.0
        for axes in (left, right):
            points = drawn(axes)
            assert points.get_clim() == shown.limits
            assert points.get_cmap().name == "viridis"
            low, high = (
                np.array(limits) for limits in zip(axes.get_xlim(), axes.get_ylim(), strict=True)
            )
            places = np.asarray(points.get_offsets())
            assert (low < places.min(axis=0)).all()
            assert (places.max(axis=0) < high).all()

    def test_labels_have_units(self, dimension: int) -> None:
        shown = by_displacement(*moved(dimension), ["before: a.ply", "after: b.ply"])
        figure = cloud_figure(shown)
        assert figure.axes[0].get_title() == "before: a.ply\n200 points"
        assert figure.axes[1].get_title() == "after: b.ply\n200 points"
        assert "displacement, coordinate units" in [axes.get_ylabel() for axes in figure.axes]
        if dimension == 2:
            assert figure.axes[0].get_xlabel() == "x, coordinate units"
            assert figure.axes[0].get_ylabel() == "y, coordinate units"
        else:
            words = [text.get_text() for text in figure.axes[0].texts]
            assert words[0].endswith(" coordinate units")
            assert words[1:] == ["x", "y", "z"]
            line = figure.axes[0].lines[0].get_xdata()
            assert np.ptp(line) == pytest.approx(float(words[0].split()[0]))

    def test_titles_are_text(self, dimension: int) -> None:
        figure = cloud_figure(by_displacement(*moved(dimension), ["$\\frac{$", "a_$b$"]))
        assert png_of(figure)
        assert not any(axes.title.get_parse_math() for axes in figure.axes[:2])

    @pytest.mark.slow
    def test_curvature_diverges_and_unknown_is_grey(self, dimension: int) -> None:
        shown = curved(dimension)
        figure = cloud_figure(shown)
        points = drawn(figure.axes[0])
        figure.draw_without_rendering()
        colors = np.asarray(points.get_facecolor())
        values: Points = np.ma.filled(np.ma.asarray(points.get_array()), np.nan)
        unknown = np.isnan(values)
        assert unknown.sum() == 7
        np.testing.assert_allclose(colors[unknown], [[0.6, 0.6, 0.6, 1.0]] * 7)
        low, high = shown.limits
        expected = mpl.colormaps["coolwarm"]((values[~unknown] - low) / (high - low))
        np.testing.assert_allclose(colors[~unknown], expected)
        assert "200 points; 7 of unknown value, grey" in figure.axes[0].get_title()

    def test_the_colormap_can_be_chosen(self, dimension: int) -> None:
        figure = cloud_figure(curved(dimension), colormap="turbo")
        assert {drawn(axes).get_cmap().name for axes in figure.axes[:2]} == {"turbo"}

    def test_only_some_of_many_are_drawn_and_all_are_counted(
        self, dimension: int, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(module, "MOST_DRAWN", 50)
        shown = by_displacement(*moved(dimension))
        figure = cloud_figure(shown, view=View(90, -90))
        values = np.asarray(drawn(figure.axes[0]).get_array())
        np.testing.assert_array_equal(np.sort(values), np.sort(shown.clouds[0].values[::4]))
        assert figure.axes[0].get_title() == "before\n200 points; 50 of them drawn"
        (bars,) = histogram_of(figure).patches
        assert isinstance(bars, StepPatch)
        assert bars.get_data()[0].sum() == 200

    @pytest.mark.parametrize("points", [1, 2])
    def test_a_place_and_a_line_can_be_drawn(self, dimension: int, points: int) -> None:
        places = np.full((points, dimension), 1e6)
        places[:, 0] += np.arange(points)
        assert png_of(cloud_figure(by_displacement(places, places)))

    def test_one_cloud(self, dimension: int) -> None:
        points, _ = moved(dimension)
        shown = by_curvature({"after": (points, np.ones(200))}, ["after"])
        figure = cloud_figure(shown)
        assert sum(bool(axes.get_title()) for axes in figure.axes) == 1


@pytest.mark.slow
def test_same_bytes_in_space() -> None:
    """In the plane: see the page of a denoised curve."""
    first, second = (png_of(cloud_figure(curved(3))) for _ in "ab")
    assert first == second


class TestHistogram:
    def test_bars_and_legend(self) -> None:
        shown = by_distance(*moved(3))
        axes = histogram_of(cloud_figure(shown))
        counts, edges = histograms(shown.distributions, shown.limits)
        assert len(axes.patches) == 2
        for bars, (name, values) in zip(axes.patches, shown.distributions.items(), strict=True):
            assert isinstance(bars, StepPatch)
            np.testing.assert_array_equal(bars.get_data()[0], counts[name])
            np.testing.assert_array_equal(bars.get_data()[1], edges)
            assert bars.get_label() == f"{name}: {magnitudes(values).in_words()}"
            assert f"median {np.median(values):.4g}" in str(bars.get_label())
        assert axes.get_xlim() == shown.limits
        assert axes.get_ylim()[1] > max(bars.max() for bars in counts.values())
        assert axes.get_legend() is not None

    def test_a_second_scale_in_spacings(self) -> None:
        figure = cloud_figure(by_displacement(*moved(3)), spacing=0.05)
        axes = histogram_of(figure)
        (scale,) = axes.child_axes
        assert scale.get_xlabel() == "in mean spacings"
        figure.draw_without_rendering()
        assert scale.get_xlim() == pytest.approx(np.array(axes.get_xlim()) / 0.05)


def test_counts_in_words() -> None:
    values = np.r_[np.zeros(1500), np.full(30, np.nan)]
    cloud = ValuedCloud("c", np.zeros((1530, 2)), values, np.arange(1530), 1200)
    assert counts_in_words(cloud, 1000) == (
        "1,530 points; 1,000 of them drawn; 1,200 not finite, left out; 30 of unknown value, grey"
    )
    assert counts_in_words(cloud, 1530).startswith("1,530 points; 1,200 not")


def test_points_are_smaller_the_more_there_are() -> None:
    rng = np.random.default_rng(0)
    sizes = [
        point_diameter(rng.random((n, 2)), 3, (5.0, 4.0))
        for n in (10, 1000, 10_000, 100_000, 1_000_000)
    ]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] == 5.0
    assert sizes[-1] == 1.4


@pytest.mark.parametrize(
    ("length", "rounded"),
    [(1.0, 1.0), (1.99, 1.0), (2.0, 2.0), (4.9, 2.0), (5.1, 5.0), (0.0031, 0.002), (7e5, 5e5)],
)
def test_round_lengths(length: float, rounded: float) -> None:
    assert round_length(length) == rounded
