"""Corners: how sharp, and what the flows make of them."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.thesis_clouds import INPUTS, Array
from oracles import even_circle
from pcsmooth_experiments.plane.corners import EXPERIMENT, CornerFlow, mean_turning, measure_corners
from pcsmooth_experiments.plane.descents import Descent


@pytest.fixture(scope="module")
def flows() -> tuple[CornerFlow, ...]:
    return measure_corners({
        name: INPUTS.points(f"{name}.xy") for name in ("shark", "bird", "square")
    })  # fmt: skip


def exposed_angle(points: Array, number: int, radius: float) -> float:
    """Angle of the circle around a point that no other disk covers: arcs between all ends."""
    offsets = np.delete(points, number, axis=0) - points[number]
    distances = np.hypot(*offsets.T)
    near = (distances < 2 * radius) & (distances > 0)
    halves = np.arccos(distances[near] / (2 * radius))
    starts = np.arctan2(offsets[near, 1], offsets[near, 0]) - halves
    edges = np.concatenate([starts, starts + 2 * halves, [0.0]]) % (2 * np.pi)
    edges = np.append(np.sort(edges), 2 * np.pi)
    middles = 0.5 * (edges[1:] + edges[:-1])
    covered = ((middles[:, np.newaxis] - starts) % (2 * np.pi) < 2 * halves).any(axis=1)
    return float(np.diff(edges)[~covered].sum())


@pytest.mark.parametrize("reach", [0.0, 0.1, 0.9])
def test_a_square_turns_by_quarters(reach: float) -> None:
    inside = np.random.default_rng(0).random((50, 2))
    square = np.vstack([inside, [[0, 0], [1, 0], [1, 1], [0, 1]]])
    assert mean_turning(square, reach) == pytest.approx(90)


@pytest.mark.parametrize("beside", [0, 1, 4])
def test_a_circle_turns_by_what_is_within_reach(beside: int) -> None:
    reach = 2 * np.sin((beside + 0.5) * np.pi / 90)  # chords of `beside` sides on either hand
    points = np.random.default_rng(1).permutation(even_circle(90))
    assert mean_turning(points, reach) == pytest.approx((2 * beside + 1) * 4)


def test_sharp_corners_count_by_their_turning() -> None:
    # a rhombus: exterior angles 120 and 60, twice each
    rhombus = np.array([[1, 0], [0, 3**0.5], [-1, 0], [0, -(3**0.5)]])
    assert mean_turning(rhombus, 0.1) == pytest.approx((120**2 + 60**2) / 180)


@pytest.mark.slow
def test_the_author_s_disks_hide_most_points(flows: tuple[CornerFlow, ...]) -> None:
    checked = 0
    for flow in flows:
        if flow.cloud == "bird" and flow.is_reported:
            numbers = range(len(flow.before))
            seen = [exposed_angle(flow.before, i, flow.radius) > 1e-9 for i in numbers]
            assert flow.visible == sum(seen) < len(flow.before) / 3
            checked += 1
        if not flow.is_reported:
            assert flow.visible == len(flow.before)
            checked += 1
    assert checked == 3


def test_the_author_s_step_is_unstable_with_small_disks(flows: tuple[CornerFlow, ...]) -> None:
    small = [flow for flow in flows if not flow.is_reported]
    assert len(small) == 2
    for flow in small:
        assert flow.step <= flow.stable_step < 0.05 / 5
        states = Descent("area", flow.radius, 0.05).states(flow.before, 5)
        assert states[-1].evaluation.value > 2 * states[0].evaluation.value


def test_corners_are_blunted(flows: tuple[CornerFlow, ...]) -> None:
    reported = [flow for flow in flows if flow.is_reported]
    assert [flow.cloud for flow in reported] == ["shark", "bird", "square", "square"]
    assert [len(flow.sharpness) - 1 for flow in reported] == [20, 20, 20, 200]
    for flow in reported:
        reach = 0.02 * np.hypot(*np.ptp(flow.before, axis=0))
        assert flow.sharpness[0] == pytest.approx(mean_turning(flow.before, reach))
        assert flow.sharpness[-1] == pytest.approx(mean_turning(flow.after, reach))
        assert flow.is_smoothed
        assert flow.sharpness[-1] < 0.75 * flow.sharpness[0]
    square = reported[2]
    # its corners, 100 sqrt(2) from the middle, withdraw; the middles of its sides stay
    assert np.hypot(*square.after.T).max() < 0.8 * 100 * 2**0.5
    assert reported[3].sharpness[0] == pytest.approx(90)


def test_outcome(flows: tuple[CornerFlow, ...]) -> None:
    outcome = EXPERIMENT.run(INPUTS)
    assert outcome.verdict == "agrees"
    table = outcome.tables["corners"]
    assert len(table["cloud"]) == sum(len(flow.sharpness) for flow in flows)
    first = flows[0]
    assert (
        f"shark {first.sharpness[0]:.0f}° → {first.sharpness[-1]:.0f}° (perimeter)"
        in outcome.caption
    )
    assert f"only {first.visible} of 423" in outcome.explanation
