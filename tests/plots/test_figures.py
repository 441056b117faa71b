from __future__ import annotations

import struct
import sys

import pytest

from pcsmooth.errors import PcsmoothError
from pcsmooth.plots.figures import check_matplotlib, new_figure, png_of


def test_size_and_bytes() -> None:
    drawn = [png_of(new_figure(3.0, 2.0)) for _ in range(2)]
    assert struct.unpack(">II", drawn[0][16:24]) == (330, 220)
    assert drawn[0] == drawn[1]


def test_without_matplotlib(monkeypatch: pytest.MonkeyPatch) -> None:
    check_matplotlib()
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    for call in (check_matplotlib, lambda: new_figure(1.0, 1.0)):
        with pytest.raises(PcsmoothError, match=r"matplotlib.*; pip install 'pcsmooth\[plot\]'"):
            call()
