"""Titles, labels and numbers of axes never lie over each other, whatever the shape of a cloud."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations

import numpy as np
import numpy.typing as npt
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from pcsmooth.plots.cloud_figure import cloud_figure
from pcsmooth.plots.curve_figure import curve_figure
from pcsmooth.plots.energy_figure import energy_figure
from pcsmooth.plots.shaded_figure import shaded_figure
from pcsmooth.plots.valued_clouds import along_normals, by_curvature, by_displacement
from pcsmooth.plots.views import View
from pcsmooth.record import Record

Floats = npt.NDArray[np.float64]

RNG = np.random.default_rng(0)

#: Extents along x, y, z, and where the cloud lies.
SHAPES = {
    "ball": ([1.0, 1.0, 1.0], [0.0, 0.0, 0.0]),
    "long": ([1000.0, 1.0, 1.0], [0.0, 0.0, 0.0]),
    "high": ([1.0, 1000.0, 1000.0], [0.0, 0.0, 0.0]),
    "flat": ([100.0, 100.0, 0.01], [0.0, 0.0, 0.0]),
    "far": ([120.0, 80.0, 30.0], [637_290.75, 851_209.9, 510.7]),
    "tiny": ([3e-9, 2e-9, 1e-9], [0.0, 0.0, 0.0]),
    "tiny and far": ([0.02, 0.03, 0.01], [4e6, 5e6, 100.0]),
    "huge": ([3e12, 2e12, 1e12], [0.0, 0.0, 0.0]),
}


def cloud(name: str, dimension: int) -> tuple[Floats, Floats, Floats]:
    """Points before and after, and normals."""
    extent, place = (np.array(numbers)[:dimension] for numbers in SHAPES[name])
    unit = RNG.normal(size=(400, dimension))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    after = place + unit * extent
    return after + 0.02 * extent * RNG.normal(size=after.shape), after, unit


def boxes(figure: Figure) -> Iterator[tuple[str, Bbox]]:
    """Where each text that is seen lies, but for those of legends, which may cover points."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # type: ignore[no-untyped-call]
    legends = [axes.get_legend() for axes in figure.axes]
    inner = {id(text) for legend in legends if legend for text in legend.findobj(Text)}
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        if text.get_visible() and text.get_text().strip() and id(text) not in inner:
            box = text.get_window_extent()
            if _is_drawn(text, figure):
                yield text.get_text(), box


def _is_drawn(text: Text, figure: Figure) -> bool:
    """Whether a text is drawn: ticks beyond the limits, and those of axes turned off, are not."""
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            for tick in axis.get_major_ticks() + axis.get_minor_ticks():
                if text in (tick.label1, tick.label2):
                    low, high = sorted(axis.get_view_interval())
                    slack = 1e-9 * (high - low)
                    return axes.axison and low - slack <= tick.get_loc() <= high + slack
            if text in (axis.label, axis.offsetText):
                return axes.axison
    return True


def overlaps(figure: Figure) -> list[tuple[str, str]]:
    found = list(boxes(figure))
    assert found
    return [
        (first, second)
        for (first, one), (second, other) in combinations(found, 2)
        if one.width > 0
        and other.width > 0
        and min(one.x1, other.x1) - max(one.x0, other.x0) > 1.0
        and min(one.y1, other.y1) - max(one.y0, other.y0) > 1.0
    ]


TITLES = ["before: a_name_that_is_as_long_as_names_of_scans_are_0123456789.ply", "after: b.ply"]


def displaced(name: str, dimension: int) -> Figure:
    before, after, normals = cloud(name, dimension)
    moved = by_displacement(before, after, TITLES)
    spacing = float(np.ptp(after, axis=0).max()) / 20
    return cloud_figure(along_normals(moved, normals), spacing=spacing)


def curved(name: str, dimension: int) -> Figure:
    _, after, _ = cloud(name, dimension)
    values = RNG.normal(size=400) / np.ptp(after, axis=0).max()
    return cloud_figure(by_curvature({"after": (after, values)}, TITLES[1:]))


def shown(name: str, dimension: int) -> Figure:
    before, after, normals = cloud(name, dimension)
    if dimension == 2:
        return curve_figure(before, after, TITLES)
    return shaded_figure(before, after, normals, View(), TITLES)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("draw", [displaced, curved, shown])
def test_nothing_overlaps(draw: Callable[[str, int], Figure], dimension: int, name: str) -> None:
    assert overlaps(draw(name, dimension)) == []


def test_energies() -> None:
    history = [Record(k, 1e5 - k, 2e5 - 3 * k, 0.1, 0.2) for k in range(7)]
    assert overlaps(energy_figure(history, 3)) == []


def test_overlaps_are_found() -> None:
    figure = Figure(figsize=(2.0, 2.0))
    axes = figure.add_subplot()
    axes.set_xticks(range(30), [str(100 + number) for number in range(30)])
    assert len(overlaps(figure)) >= 28
