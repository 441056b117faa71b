"""Noisy ellipses: what each flow leaves."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.thesis_clouds import INPUTS, Array, widest_angle
from pcsmooth_experiments.plane.descents import Descent
from pcsmooth_experiments.plane.noise import EXPERIMENT, NoisyFlow, measure_noise_removal

pytestmark = pytest.mark.slow


def measured(cloud: str, radius: float) -> NoisyFlow:
    return measure_noise_removal(cloud, INPUTS.points(f"{cloud}.xy"), radius, True)


@pytest.fixture(scope="module")
def dense() -> NoisyFlow:
    return measured("ellipse-noisy-dense", 15.0)


def conic_rms(points: Array) -> float:
    """RMS distance to first order from the conic x²p + y²q + xs + yt = 1 that fits best."""
    x, y = points.T
    terms = np.stack([x**2, y**2, x, y], axis=1)
    p, q, s, t = np.linalg.lstsq(terms, np.ones(len(points)), rcond=None)[0]
    slope = np.hypot(2 * p * x + s, 2 * q * y + t)
    return float(np.sqrt(np.mean(((terms @ [p, q, s, t] - 1) / slope) ** 2)))


def levels(points: Array) -> Array:
    """Level of each point in the family of ellipses of its own moments; 1 on the curve."""
    centered = points - points.mean(axis=0)
    return np.asarray(np.hypot(*(centered / (np.sqrt(2) * centered.std(axis=0))).T))


@pytest.mark.parametrize("cloud", ["ellipse-noise-5", "ellipse-noisy-dense"])
def test_noise_is_the_distance_to_the_best_ellipse(cloud: str) -> None:
    flow = measured(cloud, 15.0)
    for name in ("before", "area"):
        assert flow.noise[name] == pytest.approx(conic_rms(flow.points[name]), rel=0.1)


def test_noise_is_removed_when_half_is_gone() -> None:
    flow = NoisyFlow("made up", 1.0, True, {}, {"before": 2.0, "area": 1.0, "perimeter": 1.01}, {})
    assert (flow.removes("area"), flow.removes("perimeter")) == (True, False)


def test_the_area_flow_removes_noise_and_opens_holes(dense: NoisyFlow) -> None:
    assert dense.removes("area")
    assert conic_rms(dense.points["area"]) < 0.25 * conic_rms(dense.points["before"])
    width, _ = widest_angle(dense.points["area"])
    assert width > 30 / 120 > widest_angle(dense.points["before"])[0]


def test_the_perimeter_flow_parts_dense_noise_into_two_curves(dense: NoisyFlow) -> None:
    assert not dense.removes("perimeter")
    points = dense.points["perimeter"]
    level = levels(points)
    inner = level < 0.98
    assert 30 < np.count_nonzero(inner) < 150
    sector = np.floor((np.arctan2(*points.T[::-1]) + np.pi) / (np.pi / 6)).astype(int) % 12
    both = [len(set(inner[sector == number].tolist())) == 2 for number in range(12)]
    assert sum(both) >= 8
    # each of the two is smoother than their union: one ellipse fits it
    outer = points[level > np.median(level)]
    assert conic_rms(outer) < 0.5 * conic_rms(points)


def test_smaller_steps_part_the_noise_as_well(dense: NoisyFlow) -> None:
    fine = Descent("area", 15.0, 0.2).end(dense.points["before"], 500)
    assert conic_rms(fine) == pytest.approx(conic_rms(dense.points["perimeter"]), rel=0.05)
    assert conic_rms(fine) > conic_rms(dense.points["before"])


def test_open_ends_withdraw_from_gaps_wider_than_the_disks() -> None:
    narrow, wide = measured("ellipse-noise-5", 15.0), measured("ellipse-noise-5", 20.0)
    assert widest_angle(narrow.points["before"])[0] > 0.25
    assert widest_angle(narrow.points["perimeter"])[0] > 0.8
    assert widest_angle(wide.points["perimeter"])[0] < 0.25
    assert wide.noise["perimeter"] > 0.45 * wide.noise["before"]


def test_outcome(dense: NoisyFlow) -> None:
    outcome = EXPERIMENT.run(INPUTS)
    assert outcome.verdict == "agrees in part"
    assert outcome.caption.endswith("Area flow: as reported; perimeter flow: not as reported.")
    table = outcome.tables["noise"]
    rows = [row for row in zip(*(column.tolist() for column in table.values()), strict=True)
            if row[:2] == ("ellipse-noisy-dense", 15.0)]  # fmt: skip
    assert [row[2] for row in rows] == ["before", "area", "perimeter"]
    assert [row[3] for row in rows] == pytest.approx(list(dense.noise.values()))
