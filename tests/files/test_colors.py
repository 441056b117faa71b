from __future__ import annotations

import sys

import matplotlib
import numpy as np
import pytest

from pcsmooth.errors import InvalidInputError, PcsmoothError
from pcsmooth.files.colors import GREY, check_colormap, colors_of, largest_shown

ALL = np.ones(5, np.bool_)


@pytest.mark.parametrize("name", ["coolwarm", "viridis", "turbo", "RdBu_r"])
def test_colors_are_those_of_the_map(name: str) -> None:
    values = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    colors = colors_of(values, ALL, name, (-2.0, 2.0))
    expected = matplotlib.colormaps[name](np.linspace(0, 1, 5))[:, :3] * 255
    assert colors.dtype == np.uint8
    np.testing.assert_allclose(colors, expected, atol=1)


def test_values_beyond_the_limits_have_the_colors_there() -> None:
    values = np.array([-1e9, -1.0, 0.0, 1.0, 1e9])
    colors = colors_of(values, ALL, "coolwarm", (-1.0, 1.0))
    np.testing.assert_array_equal(colors[0], colors[1])
    np.testing.assert_array_equal(colors[3], colors[4])
    assert (colors[1] != colors[3]).any()


def test_unknown_values_are_grey() -> None:
    known = np.array([True, False, True, True, False])
    values = np.array([0.0, np.nan, 0.5, 1.0, 7.0])
    colors = colors_of(values, known, "viridis", (0.0, 1.0))
    np.testing.assert_array_equal(colors[~known], GREY)
    np.testing.assert_array_equal(
        colors[known], colors_of(values[known], known[known], "viridis", (0.0, 1.0))
    )


def test_where_all_values_are_equal_the_color_is_the_middle_one() -> None:
    colors = colors_of(np.zeros(5), ALL, "gray", (0.0, 0.0))
    np.testing.assert_allclose(colors, 127.5, atol=1)


def test_the_largest_that_is_shown_leaves_out_a_few() -> None:
    sizes = np.abs(np.append(np.linspace(-3.0, 1.0, 401), 1e6))
    high = largest_shown(lambda: np.array_split(sizes, 5))
    assert high == np.percentile(sizes, 98)
    assert high < 3.0


def test_of_nothing_nothing_is_shown() -> None:
    assert largest_shown(lambda: [np.empty(0)]) == 0.0


def test_an_unknown_name() -> None:
    with pytest.raises(InvalidInputError, match=r"no color map 'rainboww'; try coolwarm, .*turbo"):
        check_colormap("rainboww")


def test_without_matplotlib(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(PcsmoothError, match=r"matplotlib.*; pip install 'pcsmooth\[colors\]'"):
        check_colormap("coolwarm")
