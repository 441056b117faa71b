"""Curves before and after."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.errors import InvalidInputError
from pcsmooth.plots import curve_figure as module
from pcsmooth.plots.curve_figure import curve_figure
from pcsmooth.plots.figures import png_of

pytest.importorskip("matplotlib")

Floats = npt.NDArray[np.float64]

ANGLES = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
CIRCLE = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)


def with_bump(place: int) -> Floats:
    moved = CIRCLE.copy()
    moved[place : place + 15] *= 1.02
    return moved


@pytest.mark.parametrize("place", [0, 120, 300])
def test_the_part_is_where_most_has_moved(place: int) -> None:
    figure = curve_figure(CIRCLE, with_bump(place), ["a_$b", "c"])
    first, second, part = figure.axes
    assert [axes.get_title() for axes in figure.axes] == ["a_$b", "c", "the part that moved most"]
    assert first.get_xlim() == second.get_xlim()
    assert first.get_ylim() == second.get_ylim()
    middle = CIRCLE[place + 7]
    low, high = np.transpose([part.get_xlim(), part.get_ylim()])
    assert ((low < middle) & (middle < high)).all()
    inside = ((low <= CIRCLE) & (high >= CIRCLE)).all(axis=1).sum()
    assert 15 <= inside <= 45
    ways = [line for line in part.lines if len(np.asarray(line.get_xdata())) == 2]
    assert len(ways) == pytest.approx(15, abs=3)
    assert [text.get_text() for text in part.get_legend().get_texts()] == ["before", "after"]  # type: ignore[union-attr]


def test_only_some_of_many_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_DRAWN", 100)
    figure = curve_figure(CIRCLE, CIRCLE)
    assert len(np.asarray(figure.axes[0].collections[0].get_offsets())) == 100


@pytest.mark.parametrize("n", [1, 2, 5])
def test_next_to_nothing(n: int) -> None:
    line = np.stack([np.arange(n) + 4e6, np.zeros(n)], axis=1)
    assert png_of(curve_figure(line, line))
    assert png_of(curve_figure(np.zeros((n, 2)), np.zeros((n, 2))))


def test_rows_that_are_not_finite_are_left_out() -> None:
    broken = CIRCLE.copy()
    broken[7] = np.nan
    figure = curve_figure(CIRCLE, broken)
    assert len(np.asarray(figure.axes[0].collections[0].get_offsets())) == 399
    with pytest.raises(InvalidInputError, match=r"no point .* is left; check the file"):
        curve_figure(CIRCLE, np.full_like(CIRCLE, np.nan))
    for other in (CIRCLE[1:], np.zeros((400, 3))):
        with pytest.raises(InvalidInputError, match=r"only the same points .*--color-by distance"):
            curve_figure(CIRCLE, other)
