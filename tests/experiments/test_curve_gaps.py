"""Gaps between consecutive points, against circles and lines where they are known."""

from __future__ import annotations

import numpy as np
import pytest

from oracles import even_circle
from pcsmooth_experiments.plane.curve_gaps import gaps_along, gaps_around
from pcsmooth_experiments.plane.ellipse import REPORT_ELLIPSE, sampling_parameters


def test_even_points_have_no_variation() -> None:
    gaps = gaps_around(even_circle(60, 10.0))
    np.testing.assert_allclose(gaps.distances, 20 * np.sin(np.pi / 60))
    np.testing.assert_allclose(gaps.along, 20 * np.pi / 60, rtol=1e-6)
    assert gaps.variation == pytest.approx(0, abs=1e-9)
    assert gaps.largest == pytest.approx(1)


def test_a_missing_arc_is_the_largest_gap() -> None:
    points = np.random.default_rng(0).permutation(even_circle(60, 10.0)[5:])  # angles 30 to 354
    gaps = gaps_around(points)
    short, long = 20 * np.sin(np.pi / 60), 20 * np.sin(6 * np.pi / 60)
    lengths = np.array([short] * 54 + [long])
    np.testing.assert_allclose(np.sort(gaps.distances), lengths, rtol=1e-6)
    assert gaps.variation == pytest.approx(lengths.std() / lengths.mean())
    assert gaps.largest == pytest.approx(long / lengths.mean())
    direction = np.degrees(np.arctan2(*gaps.widest[::-1]))
    assert direction == pytest.approx(12, abs=1e-3)
    arc = 10 * np.radians(36)
    assert [gaps.holes(radius) for radius in (0.5, 0.49 * arc, 0.51 * arc)] == [55, 1, 0]


def test_a_point_off_the_curve_makes_no_hole() -> None:
    points = REPORT_ELLIPSE.at(sampling_parameters(200))
    off = np.vstack([points, [[200.0, 140.0]]])
    assert gaps_around(off).largest > 5
    assert gaps_around(off).holes(15.0) == 0


def test_gaps_on_a_line_are_in_its_order() -> None:
    gaps = gaps_along(np.array([[3.0, 0.0], [-1.0, 0.0], [0.0, 0.0]]))
    assert gaps.distances.tolist() == gaps.along.tolist() == [1.0, 3.0]
    assert gaps.widest.tolist() == [1.5, 0.0]
    assert gaps.variation == 0.5
    assert gaps.largest == 1.5
    assert [gaps.holes(radius) for radius in (0.4, 0.5, 1.4, 1.5)] == [2, 1, 1, 0]
