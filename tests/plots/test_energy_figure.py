from __future__ import annotations

import sys

import numpy as np
import pytest

from pcsmooth.errors import PcsmoothError
from pcsmooth.plots.energy_figure import energy_figure
from pcsmooth.record import Record

HISTORY = [Record(step, 9.0 - step, 5.0 - 0.5 * step, 0.1, 0.2) for step in range(4)]
LABELS = {
    2: ["area, coordinate units$^2$", "perimeter, coordinate units"],
    3: ["volume, coordinate units$^3$", "area, coordinate units$^2$"],
}


@pytest.mark.parametrize("dimension", [2, 3])
def test_every_state_is_drawn(dimension: int) -> None:
    axes = energy_figure(HISTORY, dimension).axes
    assert [each.get_ylabel() for each in axes] == LABELS[dimension]
    for each, values in zip(axes, ([9, 8, 7, 6], [5, 4.5, 4, 3.5]), strict=True):
        (line,) = each.lines
        assert np.asarray(line.get_xdata()).tolist() == [0, 1, 2, 3]
        assert np.asarray(line.get_ydata()).tolist() == values
        assert each.get_xlabel() == "iteration"


def test_without_matplotlib(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(PcsmoothError, match="matplotlib"):
        energy_figure(HISTORY, 3)
