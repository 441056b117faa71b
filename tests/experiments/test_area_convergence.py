"""Volume of the union of balls over 2r against the area."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pcsmooth_experiments.theory.area_convergence import (
    Series,
    breaks_of_print,
    judge,
    measure_area_convergence,
    outcome_of,
    share_of_bound,
)
from pcsmooth_experiments.theory.joint_limits import FIXED_RADIUS, FIXED_RATIO, RATIO_AS_RADIUS

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def found() -> tuple[Series, ...]:
    return measure_area_convergence((50, 100, 200), (610, 987, 1597))


def disks_on_a_circle(n: int, r: float) -> float:
    """Area of n disks on the unit circle: sectors that are seen, and kites to the two crossings."""
    h = np.sin(np.pi / n)
    return float(n * (2 * r * r * np.arcsin(h / r) + 2 * h * np.sqrt(r * r - h * h)))


def test_circle(found: tuple[Series, ...]) -> None:
    circles = [series for series in found if series.shape == "circle"]
    assert [series.limit for series in circles] == [FIXED_RADIUS, FIXED_RATIO, RATIO_AS_RADIUS]
    for series in circles:
        expected = [
            disks_on_a_circle(n, r) for n, r in zip(series.n_points, series.radius, strict=True)
        ]
        assert series.volume == pytest.approx(expected, rel=1e-12)
        rings = np.pi * ((1 + series.radius) ** 2 - (1 - series.radius) ** 2)
        assert series.tube == pytest.approx(rings, rel=1e-9)
        assert series.sampling_error == pytest.approx(1 - expected / rings, abs=1e-8)
        # the mean of the squared distance along an arc is a third of the square of the largest,
        # which is found a hundredth too small
        thirds = 3 * series.leading_error / series.bound
        assert 0.999 < thirds.min() <= thirds.max() < 1.022


def test_leading_error(found: tuple[Series, ...]) -> None:
    """It is what the error tends to; the rest is smaller by the squares of eps/r and r."""
    for series in found:
        rest = series.sampling_error / series.leading_error - 1
        assert (rest < 0.6 * series.ratio**2 + 12.0 * series.radius**2).all()
        assert (rest > -0.01).all()


def test_shares_of_the_bound(found: tuple[Series, ...]) -> None:
    """On surfaces between 1/3 and 5/12 in the limit of regular hexagons, spirals being uneven."""
    low, high = share_of_bound(found, 2)
    assert 0.32 < low < high < 0.4
    low, high = share_of_bound(found, 3)
    assert 0.28 < low < high < 5 / 12


def test_tube_error_of_the_sphere(found: tuple[Series, ...]) -> None:
    for series in found:
        expected = (
            series.radius**2 / 3 if series.shape == "sphere" else np.zeros(len(series.radius))
        )
        assert series.tube_error == pytest.approx(expected, abs=1e-8)


def test_verdict(found: tuple[Series, ...]) -> None:
    assert judge(found) == "agrees"
    too_large = tuple(replace(series, volume=1.001 * series.tube) for series in found)
    assert judge(too_large) != "agrees"
    slow = tuple(
        replace(
            series,
            volume=series.tube
            - 2 * series.radius * series.area * (0.4 * series.bound[0] * series.ratio),
        )
        for series in found
    )
    assert {series.order < 1.8 for series in slow if series.limit == FIXED_RADIUS} == {True}
    assert judge(slow) != "agrees"


def test_equation_as_printed(found: tuple[Series, ...]) -> None:
    """Without A(S) the bound is broken, shares of a third being more than 1 / (2 pi)."""
    broken, all_of = breaks_of_print(found)
    assert all_of == sum(len(series.radius) for series in found)
    assert broken == all_of
    tiny = tuple(replace(series, area=1.0) for series in found[:1])
    assert breaks_of_print(tiny)[0] in (0, len(found[0].radius))


def test_outcome(found: tuple[Series, ...]) -> None:
    outcome = outcome_of(found)
    assert len(outcome.caption) <= 200
    rows = outcome.tables["area-convergence"]
    assert rows["error"] == pytest.approx(
        rows["error_by_radius"] - rows["error_by_points"], abs=1e-12
    )
    orders = outcome.tables["area-convergence-orders"]
    fixed = orders["limit"] == FIXED_RADIUS.name
    assert f"order {orders['order'][fixed].min():.2f} or more" in outcome.caption
    stays = (orders["limit"] == FIXED_RATIO.name) & (orders["shape"] != "sphere")
    assert abs(orders["order"][stays]).max() < 0.1
