"""Curvature of the ellipse: the truth, the misprint, and whose error is smaller."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.thesis_clouds import INPUTS, A, Array, B, ellipse_points
from pcsmooth.energies.balls import measure_balls
from pcsmooth_experiments.plane.ellipse_curvature import (
    EXPERIMENT,
    CurvatureErrors,
    measure_ellipse_curvature,
)


def true_curvature(t: Array) -> Array:
    """By differences of the curve itself."""
    step = 1e-4
    velocity = (ellipse_points(t + step) - ellipse_points(t - step)) / (2 * step)
    forward = ellipse_points(t + step) - 2 * ellipse_points(t) + ellipse_points(t - step)
    acceleration = forward / step**2
    turning = velocity[:, 0] * acceleration[:, 1] - velocity[:, 1] * acceleration[:, 0]
    return np.asarray(turning / np.hypot(*velocity.T) ** 3)


def test_the_formula_and_its_misprint() -> None:
    found = measure_ellipse_curvature(100)
    np.testing.assert_allclose(found.expected, true_curvature(found.t), rtol=1e-5)
    # as printed it is the curvature of an ellipse turned by a quarter
    np.testing.assert_allclose(found.printed, np.roll(found.expected, 25), rtol=1e-12)
    assert found.printed[0] == pytest.approx(B / A**2)
    assert found.expected[0] == pytest.approx(A / B**2)


def test_estimates_are_gradient_over_visible_boundary() -> None:
    found = measure_ellipse_curvature(100)
    union = measure_balls(ellipse_points(found.t), 15.0)
    area = np.hypot(*union.volume_gradient.T) / (15.0 * union.visible_areas)
    perimeter = np.hypot(*union.area_gradient.T) / union.visible_areas
    np.testing.assert_allclose(found.estimates["area"], area)
    np.testing.assert_allclose(found.estimates["perimeter"], perimeter)


def test_errors_in_numbers() -> None:
    t = 2 * np.pi * np.arange(1000) / 1000
    errors = CurvatureErrors(2 + np.sin(3 * t))
    assert errors.median == pytest.approx(2, abs=1e-3)
    assert errors.largest == pytest.approx(3, abs=1e-3)
    assert errors.oscillation == pytest.approx(12, abs=1e-3)


def test_errors_fall_with_the_square_of_the_spacing() -> None:
    by_count = [measure_ellipse_curvature(n) for n in (200, 400, 800)]
    for name in ("area", "perimeter"):
        medians = [np.median(np.abs(f.estimates[name] - true_curvature(f.t))) for f in by_count]
        assert medians[0] / medians[1] == pytest.approx(4, rel=0.05)
        assert medians[1] / medians[2] == pytest.approx(4, rel=0.05)


def test_outcome() -> None:
    outcome = EXPERIMENT.run(INPUTS)
    table = outcome.tables["ellipse-curvature-errors"]
    rows = {
        (count, name): (median, oscillation)
        for count, name, median, oscillation in zip(
            table["points"].tolist(), table["estimator"].tolist(),
            table["median_error"].tolist(), table["oscillation"].tolist(), strict=True,
        )
    }  # fmt: skip
    counts = sorted({count for count, _ in rows})
    assert counts == [50, 100, 200, 400, 1000]
    for count in counts:
        assert rows[count, "perimeter"][0] < rows[count, "area"][0]
        assert rows[count, "perimeter"][1] < rows[count, "area"][1]
        assert rows[count, "pcsmooth"][0] < rows[count, "perimeter"][0] / 4
        if count >= 100:
            ratio = rows[count, "perimeter"][0] / rows[count, "area"][0]
            assert ratio == pytest.approx(0.5, abs=0.1)
    assert outcome.verdict == "agrees in part"
    assert ": not as reported. Oscillation" in outcome.caption
    assert outcome.caption.endswith(": as reported.")
    against = np.median(np.abs(
        outcome.tables["ellipse-curvature"]["area"]
        - outcome.tables["ellipse-curvature"]["printed_formula"]
    ))  # fmt: skip
    assert f"{against:.2g}" in outcome.explanation
    assert against > 10 * rows[100, "area"][0]
