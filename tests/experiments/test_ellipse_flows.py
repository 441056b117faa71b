"""The ellipse under both flows."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.thesis_clouds import INPUTS, RADIUS
from oracles import even_circle
from pcsmooth.energies.balls import measure_balls
from pcsmooth_experiments.plane.ellipse_flows import EXPERIMENT, EllipseFlow, measure_ellipse_flows


@pytest.fixture(scope="module")
def flows() -> tuple[EllipseFlow, ...]:
    return measure_ellipse_flows(100)


def test_measures_of_roundness() -> None:
    circle = even_circle(12)
    flow = EllipseFlow("even", "area", np.array([circle * [3.0, 1.0], circle * [1.5, 1.0], circle]))
    np.testing.assert_allclose(flow.aspects, [3.0, 1.5, 1.0])
    assert flow.roundness[2] == pytest.approx(np.pi / 12 / np.tan(np.pi / 12))
    assert flow.roundness[0] < flow.roundness[1] < flow.roundness[2]
    assert flow.becomes_rounder
    assert not EllipseFlow("even", "area", flow.states[::-1]).becomes_rounder


def test_the_flows_are_stable_all_along(flows: tuple[EllipseFlow, ...]) -> None:
    assert len(flows) == 4
    for flow in flows:
        for points in flow.states[::10]:
            union = measure_balls(points, RADIUS)
            stiffness = union.volume_diagonal / RADIUS if flow.flow == "area" else None
            largest = (union.area_diagonal if stiffness is None else stiffness).max()
            assert largest <= 1


def test_every_ellipse_stays_symmetric(flows: tuple[EllipseFlow, ...]) -> None:
    for flow in flows:
        end = flow.states[-1]
        np.testing.assert_allclose(end, -np.roll(end, 50, axis=0), atol=1e-3)


def test_evenly_spaced_points_become_round_faster(flows: tuple[EllipseFlow, ...]) -> None:
    ratios = {
        (flow.sampling, flow.flow): np.ptp(flow.states[-1], axis=0) for flow in flows
    }  # width, height
    end = {key: width / height for key, (width, height) in ratios.items()}
    for name in ("area", "perimeter"):
        assert end["even", name] < end["parameter", name] - 0.03
        assert end["parameter", name] < 1.47
    for flow in flows:
        assert flow.aspects[0] == pytest.approx(1.5, abs=1e-3)
        assert np.all(np.diff(flow.aspects) < 0)
        assert np.all(np.diff(flow.roundness) > 0)


def test_outcome() -> None:
    outcome = EXPERIMENT.run(INPUTS)
    assert outcome.verdict == "agrees"
    table = outcome.tables["ellipse-flows"]
    assert table["iteration"].tolist() == list(range(101))
    end = table["aspect_perimeter_even"][-1]
    assert f"{end:.3f} (perimeter)" in outcome.caption
