"""The thesis' flows with constant steps, beside loops of the tests."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.thesis_clouds import INPUTS
from oracles import even_circle
from pcsmooth.energies.balls import measure_balls
from pcsmooth_experiments.plane.descents import (
    PERIMETER_STEP,
    Descent,
    area_descent,
    perimeter_descent,
    weighted_area_descent,
)


def test_a_flow_is_steps_down_the_gradient() -> None:
    start = INPUTS.points("ellipse-noise-5.xy")
    points = start.copy()
    for _ in range(3):
        points = points - measure_balls(points, 15.0).area_gradient
    np.testing.assert_allclose(perimeter_descent(15.0).end(start, 3), points, rtol=1e-12)
    states = area_descent(15.0).states(start, 4)
    assert [state.iteration for state in states] == [0, 1, 2, 3, 4]
    moved = start - measure_balls(start, 15.0).volume_gradient / 15.0
    np.testing.assert_allclose(states[1].points, moved, rtol=1e-12)


def test_weights_divide_by_cells() -> None:
    start = INPUTS.points("ellipse-outliers.xy")
    union = measure_balls(start, 15.0)
    step = union.cell_volumes.mean() / 15.0
    moved = start - step * union.volume_gradient / union.cell_volumes[:, np.newaxis]
    np.testing.assert_allclose(weighted_area_descent(start, 15.0).end(start, 1), moved, rtol=1e-12)


def test_fixed_points_stay() -> None:
    start = INPUTS.points("line_fixed.xy")
    fixed = np.abs(start[:, 0]) == 100
    moved = area_descent(15.0).end(start, 5, fixed)
    assert np.count_nonzero(fixed) == 2
    np.testing.assert_array_equal(moved[fixed], start[fixed])
    assert np.count_nonzero((moved != start).any(axis=1)) > 5


@pytest.mark.parametrize("radius", [10.0, 30.0])
def test_all_flows_go_at_one_pace_on_a_dense_circle(radius: float) -> None:
    start = even_circle(2000, 200.0)
    # the perimeter's gradient is curvature times visible boundary: a gap on either side
    pace = PERIMETER_STEP * 2 * (2 * np.pi * 200 / 2000) / 200
    flows: list[Descent] = [
        area_descent(radius), perimeter_descent(radius), weighted_area_descent(start, radius)
    ]  # fmt: skip
    for flow in flows:
        shrinks = 200 - np.linalg.norm(flow.end(start, 1), axis=1)
        np.testing.assert_allclose(shrinks, pace, rtol=0.01)
