"""Oscillations: the author's cloud made again, and what the flows leave of it."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.thesis_clouds import INPUTS, widest_angle
from pcsmooth_experiments.plane.oscillations import (
    AMPLITUDES,
    EXPERIMENT,
    measure_oscillations,
    oscillating_ellipse,
)

pytestmark = pytest.mark.slow


def test_the_author_s_cloud_of_two_amplitudes_comes_out() -> None:
    theirs = INPUTS.points("ellipse-osc2.xy")
    assert theirs.shape == (100, 2)
    np.testing.assert_allclose(oscillating_ellipse(AMPLITUDES), theirs, atol=6e-4)  # six digits
    assert np.abs(oscillating_ellipse((20.0,)) - theirs).max() > 15


def test_amplitudes_are_heights_of_waves() -> None:
    # the highest of ten samples of a wave is at a fifth of it
    height = np.sin(2 * np.pi / 5)
    one = measure_oscillations("one", oscillating_ellipse((20.0,)), 15.0, 1)
    assert one.amplitudes["before"] == pytest.approx((20 * height,), rel=0.02)
    two = measure_oscillations("two", oscillating_ellipse((20.0, 40.0)), 15.0, 2)
    assert two.amplitudes["before"] == pytest.approx((20 * height, 40 * height), rel=0.02)


@pytest.mark.parametrize("amplitudes", [(20.0,), (20.0, 40.0)], ids=str)
def test_small_disks_smooth_both(amplitudes: tuple[float, ...]) -> None:
    flow = measure_oscillations("x", oscillating_ellipse(amplitudes), 15.0, len(amplitudes))
    assert flow.area_opens_holes
    assert flow.perimeter_smooths
    assert widest_angle(flow.points["perimeter"])[0] < 0.15
    assert widest_angle(flow.points["area"])[0] > 0.25
    x, y = flow.points["perimeter"].T
    levels = np.hypot(x / np.ptp(x), y / np.ptp(y)) * 2
    assert np.ptp(levels) < 0.05  # an ellipse again
    assert np.ptp(np.hypot(*(oscillating_ellipse(amplitudes) / [180, 120]).T)) > 0.3


def test_disks_between_the_amplitudes_make_a_band() -> None:
    flow = measure_oscillations("two", oscillating_ellipse((20.0, 40.0)), 30.0, 2)
    assert flow.area_opens_holes
    assert not flow.perimeter_smooths
    x, y = flow.points["perimeter"].T
    levels = np.hypot(x / np.ptp(x), y / np.ptp(y)) * 2
    assert np.ptp(levels) > 0.3


def test_outcome() -> None:
    outcome = EXPERIMENT.run(INPUTS)
    assert outcome.verdict == "agrees in part"
    assert "Area flow opens holes in 3 of 3: as reported." in outcome.caption
    assert outcome.caption.endswith("(r = 30): not as reported.")
    assert len(outcome.tables["oscillations"]["cloud"]) == 9
