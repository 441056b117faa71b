"""Points on a segment with fixed ends."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components

from experiments.thesis_clouds import INPUTS, Array
from pcsmooth_experiments.plane.segment import (
    EXPERIMENT,
    count_components,
    five_components,
    measure_segment,
    possible_components,
)


def components(points: Array, radius: float) -> int:
    """By the graph of overlapping disks."""
    distances = np.linalg.norm(points[:, np.newaxis] - points, axis=2)
    return int(connected_components(distances <= 2 * radius)[0])


def unevenness(points: Array) -> float:
    gaps = np.diff(np.sort(points[:, 0]))
    return float(np.std(gaps) / np.mean(gaps))


def test_components_are_those_of_the_graph() -> None:
    line = INPUTS.points("line_fixed.xy")
    counts = {radius: components(line, radius) for radius in (1, 2.6, 6, 8, 9.9, 10, 15)}
    assert len(set(counts.values())) > 3
    for radius, count in counts.items():
        assert count_components(line, radius) == count
    assert components(five_components(), 10.0) == 5


def test_the_author_s_points_never_have_five() -> None:
    line = INPUTS.points("line_fixed.xy")
    table = possible_components(line)
    found = dict(zip(table["radius_from"].tolist(), table["components"].tolist(), strict=True))
    assert found == {radius: components(line, radius + 1e-9) for radius in found}
    tried = {components(line, radius) for radius in np.linspace(0.1, 30, 600)}
    assert tried == set(found.values())
    assert 5 not in tried


def test_area_is_concave_in_the_distance_and_perimeter_convex() -> None:
    # two disks of radius 1: area 2π - lens, perimeter 4π - two arcs on either
    d = np.linspace(0.1, 1.9, 50)
    half = np.arccos(d / 2)
    area = 2 * np.pi - (2 * half - d * np.sin(half))
    perimeter = 4 * np.pi - 4 * half
    assert np.all(np.diff(area, 2) < 0)
    assert np.all(np.diff(perimeter, 2) > 0)


def test_one_component() -> None:
    line = INPUTS.points("line_fixed.xy")
    flow = measure_segment("theirs", line, 15.0)
    assert flow.components == 1
    before = unevenness(line)
    assert flow.gaps["before"].variation == pytest.approx(before)
    assert unevenness(flow.points["perimeter"]) < 0.3 * before
    assert unevenness(flow.points["area"]) > 3 * before
    assert (flow.evens("perimeter"), flow.evens("area")) == (True, False)
    for points in flow.points.values():
        assert (points[:, 0].min(), points[0, 0]) == pytest.approx((-100, -100), abs=3)
        assert points[[0, -1]].tolist() == [[-100, 0], [100, 0]]
        assert np.abs(points[:, 1]).max() < 1e-9


def test_five_components_contract() -> None:
    flow = measure_segment("ours", five_components(), 10.0)
    assert flow.components == 5
    for name in ("area", "perimeter"):
        after = flow.points[name]
        assert not flow.evens(name)
        assert components(after, 10.0) == 5
        widths = np.ptp(np.sort(after[:, 0]).reshape(5, 3), axis=1)
        assert widths.max() < 0.4 * 18
        assert unevenness(after) > 2 * unevenness(five_components())


def test_outcome() -> None:
    outcome = EXPERIMENT.run(INPUTS)
    assert outcome.verdict == "agrees in part"
    assert "0.44 → 0.10 by perimeter (as reported), 0.44 → 1.43 by area (not" in outcome.caption
    assert "1, 8, 9, 12, 15 components, by the radius, never 5" in outcome.explanation
    assert outcome.explanation.endswith("the author's have 5.")
