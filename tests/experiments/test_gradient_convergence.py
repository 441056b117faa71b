"""Gradients against the mean curvature vector."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import oracles
from pcsmooth import measure_balls
from pcsmooth.energies.protocol import Quantity
from pcsmooth_experiments.sampled_shapes import ellipse, torus
from pcsmooth_experiments.theory.gradient_convergence import (
    ERRORS,
    GradientConvergence,
    check_cells,
    draw_gradient_convergence,
    estimated_vectors,
    judge,
    measure_gradient_convergence,
    outcome_of,
)
from pcsmooth_experiments.theory.joint_limits import (
    FIXED_RADIUS,
    FIXED_RATIO,
    RATIO_AS_RADIUS,
    RATIO_AS_SQUARE,
)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def found() -> GradientConvergence:
    return measure_gradient_convergence((100, 200, 400, 800), (2584, 4181, 6765, 10946), 20_000)


def on_even_circle(x: float, quantity: Quantity) -> float:
    """Estimate over 1/R on n even points of a circle, x = R sin(pi / n) / r.

    A point has two facets of length 2 sqrt(r^2 - h^2), or four ends of arcs, whose normals have
    the inward component h / R, and sees 4 arcsin(x) of its circle.
    """
    if quantity == "volume":
        return float(x * np.sqrt(1 - x * x) / np.arcsin(x))
    return float(x / (np.sqrt(1 - x * x) * np.arcsin(x)))


@pytest.mark.parametrize("quantity", ["volume", "area"])
@pytest.mark.parametrize(("n", "r", "size"), [(16, 0.7, 1.0), (50, 0.2, 1.0), (30, 1.1, 2.0)])
def test_closed_form_on_even_points_of_a_circle(
    quantity: Quantity, n: int, r: float, size: float
) -> None:
    points = oracles.even_circle(n, size)
    vectors = estimated_vectors(measure_balls(points, r), quantity)
    expected = on_even_circle(size * np.sin(np.pi / n) / r, quantity) / size
    assert vectors == pytest.approx(expected * points / size, abs=1e-12)


def test_the_series_in_the_explanation() -> None:
    for x in (0.05, 0.1):
        assert on_even_circle(x, "volume") == pytest.approx(1 - 2 * x**2 / 3, abs=x**4)
        assert on_even_circle(x, "area") == pytest.approx(1 + x**2 / 3, abs=x**4)


@pytest.mark.parametrize(("quantity", "sign"), [("volume", 1), ("area", -1)])
def test_tangential_error_on_a_line_is_the_centroid_over_r_squared(
    quantity: Quantity, sign: int
) -> None:
    """On a straight line there is no curvature, and half arms of 1 and 2 are enough for an error.

    It does not fall with r where the arms fall as r^2.
    """
    for r in (1.0, 0.1):
        arm = 0.02 * r * r
        line = np.array([[-12 * arm, 0], [-2 * arm, 0], [0, 0], [4 * arm, 0], [14 * arm, 0]])
        (along, across) = estimated_vectors(measure_balls(line, r), quantity)[2]
        assert across == pytest.approx(0.0, abs=1e-12)
        assert along == pytest.approx(sign * 0.5 * arm / r**2, rel=0.01)


def test_cells_explain_the_errors_on_random_points() -> None:
    check = check_cells(torus(0.4), 60_000, radius=0.08)
    signs: dict[Quantity, float] = {"volume": 1.0, "area": -1.0}
    for quantity, sign in signs.items():
        assert sign * check.tangential_slope(quantity) == pytest.approx(1.0, abs=0.06)
        assert check.normal_slope(quantity) == pytest.approx(1.0, abs=0.12)
        left = check.normal[quantity] - check.expected_normal
        assert left.std() < 0.25 * check.normal[quantity].std()
    assert check.expected_normal.std() > 0.1


def test_numbers_on_the_circle(found: GradientConvergence) -> None:
    """Errors of even points are those of the closed form, in every limit."""
    for limit in (FIXED_RADIUS, FIXED_RATIO, RATIO_AS_RADIUS, RATIO_AS_SQUARE):
        for quantity in ("volume", "area"):
            one = found.find("circle", "even", limit, quantity)
            expected = [
                abs(on_even_circle(np.sin(np.pi / n) / r, quantity) - 1)
                for n, r in zip(one.n_points, one.radius, strict=True)
            ]
            for error in ("rms", "largest", "normal_rms", "normal_largest"):
                assert one.errors[error] == pytest.approx(expected, rel=1e-6, abs=1e-12)
            assert one.errors["tangential_largest"].max() < 1e-9


def test_parts_add_up(found: GradientConvergence) -> None:
    for one in found.series:
        both = np.hypot(one.errors["normal_rms"], one.errors["tangential_rms"])
        assert both == pytest.approx(one.errors["rms"], rel=1e-9)
        assert (one.errors["largest"] >= one.errors["rms"]).all()


def test_limits(found: GradientConvergence) -> None:
    for one in found.series:
        growth = np.log(one.radius[-1] / one.radius[0])
        assert growth == pytest.approx(
            one.limit.power * np.log(one.covering[-1] / one.covering[0]), abs=1e-12
        )


@pytest.mark.parametrize("quantity", ["volume", "area"])
def test_even_points_converge_at_order_two(found: GradientConvergence, quantity: Quantity) -> None:
    for shape in ("circle", "ellipse", "torus"):
        order = found.find(shape, "even", FIXED_RADIUS, quantity).order("rms")
        assert order == pytest.approx(2.0, abs=0.15)


def on_random_circle(n: int, r: float, quantity: Quantity) -> oracles.Array:
    """Normal and tangential components on random points of the unit circle, (n, 2).

    From the half chords to both neighbours, as on even points; the thesis' limit is (1, 0).
    """
    points = ellipse(1.0, 1.0).sample(n, "random").points
    angles = np.sort(np.arctan2(points[:, 1], points[:, 0]))
    halves = np.diff(angles, append=angles[0] + 2 * np.pi) / 2
    h = np.sin(halves)
    width = np.sqrt(r * r - h * h) if quantity == "volume" else 1 / np.sqrt(r * r - h * h)
    inward, along = width * h, width * np.cos(halves)
    seen = np.arcsin(h / r)
    masses = (seen + np.roll(seen, 1)) * (r * r if quantity == "volume" else 1.0)
    sums = np.c_[inward + np.roll(inward, 1), along - np.roll(along, 1)]
    return np.asarray(sums / masses[:, None])


@pytest.mark.parametrize("quantity", ["volume", "area"])
def test_random_points_of_a_circle(found: GradientConvergence, quantity: Quantity) -> None:
    for limit in (FIXED_RADIUS, FIXED_RATIO, RATIO_AS_RADIUS, RATIO_AS_SQUARE):
        one = found.find("circle", "random", limit, quantity)
        for i, (n, r) in enumerate(zip(one.n_points, one.radius, strict=True)):
            normal, tangential = on_random_circle(n, r, quantity).T
            rms = np.sqrt(np.mean((normal - 1) ** 2)), np.sqrt(np.mean(tangential**2))
            assert one.errors["normal_rms"][i] == pytest.approx(rms[0], rel=1e-6)
            assert one.errors["tangential_rms"][i] == pytest.approx(rms[1], rel=1e-6)


def test_verdict_follows_from_the_orders(found: GradientConvergence) -> None:
    assert judge(found) == "agrees in part"
    for power, verdict in ((1.0, "agrees"), (0.5, "disagrees")):
        series = tuple(
            replace(one, errors=dict.fromkeys(ERRORS, 0.3 * one.radius**power))
            for one in found.series
        )
        assert judge(replace(found, series=series)) == verdict


def test_outcome(found: GradientConvergence) -> None:
    outcome = outcome_of(found)
    assert len(outcome.caption) <= 200
    orders = outcome.tables["gradient-convergence-orders"]
    chosen = (
        (orders["shape"] == "ellipse")
        & (orders["sampling"] == "random")
        & (orders["limit"] == FIXED_RATIO.name)
        & (orders["quantity"] == "volume")
    )
    assert f"r^{orders['rms'][chosen][0]:.1f} at fixed" in outcome.caption
    assert len(draw_gradient_convergence(found).axes) == 9
