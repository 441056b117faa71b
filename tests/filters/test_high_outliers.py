"""Outliers above the surface around them, and others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.filters.high_outliers import high_outliers
from pcsmooth.parts.column import ArrayColumn


class Chunked(ArrayColumn):
    """A column that is read in chunks of seven rows."""

    def chunks(self, _rows: int = 0) -> Iterator[npt.NDArray[Any]]:
        return super().chunks(7)


def slope(steepness: float) -> npt.NDArray[np.float64]:
    """Give a grid of 10 x 10 that climbs along x."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(10.0), np.arange(10.0)))
    return np.stack([x, y, steepness * x], axis=1)


@pytest.mark.parametrize("column", [ArrayColumn, Chunked])
@pytest.mark.parametrize("steepness", [0.0, 1.0, -3.0])
@pytest.mark.parametrize("height", [0.5, 3.0, 400.0])
def test_above_and_below(column: type[ArrayColumn], steepness: float, height: float) -> None:
    up = np.array([-steepness, 0.0, 1.0]) / np.hypot(steepness, 1.0)
    foot = np.array([4.4, 5.3, 4.4 * steepness])
    points = np.insert(slope(steepness), [3, 60], foot + np.outer([height, -height], up), axis=0)
    marks = np.zeros(len(points), np.bool_)
    marks[[3, 61]] = True
    assert high_outliers(column(points), column(marks)).tolist() == [True, False]


def test_outliers_are_nobodys_surroundings() -> None:
    points = np.r_[slope(0.0), [[5.0, 5.0, height] for height in range(20, 50)]]
    assert high_outliers(ArrayColumn(points), ArrayColumn(points[:, 2] > 0)).all()


@pytest.mark.parametrize("points", [np.zeros((3, 3)), np.ones((3, 2))])
def test_none_is_high_in_the_plane_or_without_surroundings(
    points: npt.NDArray[np.float64],
) -> None:
    assert high_outliers(ArrayColumn(points), ArrayColumn(np.ones(3, bool))).tolist() == [False] * 3


def test_few_others_will_do() -> None:
    points = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    marks = np.array([True, False])
    assert high_outliers(ArrayColumn(points), ArrayColumn(marks)).tolist() == [True]


def test_beside_a_wall_the_mean_of_what_is_near_counts() -> None:
    wall = slope(0.0)[:, [0, 2, 1]]
    points = np.r_[wall, [[5.0, 1.0, 9.5], [5.0, 1.0, -0.5]]]
    marks = points[:, 1] > 0
    assert high_outliers(ArrayColumn(points), ArrayColumn(marks)).tolist() == [True, False]


def test_without_outliers() -> None:
    found = high_outliers(ArrayColumn(slope(0.0)), ArrayColumn(np.zeros(100, bool)))
    assert found.shape == (0,)
