"""Tubes around curves and surfaces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pcsmooth_experiments.sampled_shapes import spheroid
from pcsmooth_experiments.theory.tubes import (
    Tubes,
    _measure_shape,
    judge,
    measure_tubes,
    outcome_of,
)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def found() -> tuple[Tubes, ...]:
    return measure_tubes((0.25, 0.35, 0.5), (1.2, 1.5))


def named(found: tuple[Tubes, ...], name: str) -> Tubes:
    return next(tubes for tubes in found if tubes.shape.name == name)


def test_circle_within_and_beyond_its_reach(found: tuple[Tubes, ...]) -> None:
    """A ring, and a disk once the centre is covered."""
    circle = named(found, "circle")
    r = circle.radius
    inner = np.maximum(1 - r, 0)
    assert circle.volume == pytest.approx(np.pi * ((1 + r) ** 2 - inner**2), rel=1e-9)
    assert circle.boundary == pytest.approx(2 * np.pi * (1 + r + inner), rel=1e-9)
    assert (circle.within == (r < 1)).all()
    assert abs(circle.volume_error[circle.within]).max() < 1e-9
    assert circle.volume_error[~circle.within].min() > 0.005


def test_sphere(found: tuple[Tubes, ...]) -> None:
    sphere = named(found, "sphere")
    r = sphere.radius
    assert sphere.volume == pytest.approx(4 / 3 * np.pi * ((1 + r) ** 3 - (1 - r) ** 3), rel=1e-5)
    assert sphere.boundary == pytest.approx(4 * np.pi * ((1 + r) ** 2 + (1 - r) ** 2), rel=1e-5)


def test_torus(found: tuple[Tubes, ...]) -> None:
    torus = named(found, "torus")
    r = torus.radius
    assert torus.volume == pytest.approx(2 * np.pi**2 * ((0.4 + r) ** 2 - (0.4 - r) ** 2), rel=1e-5)
    assert torus.boundary == pytest.approx(2 * 4 * np.pi**2 * 0.4 + 0 * r, rel=1e-5)


def test_boundary_is_the_derivative_of_the_volume() -> None:
    """By central differences, on an ellipsoid."""
    narrow = _measure_shape(spheroid(1.0, 0.7), (0.39, 0.4, 0.41), density=0.6)
    slope = (narrow.volume[2] - narrow.volume[0]) / (narrow.radius[2] - narrow.radius[0])
    assert slope == pytest.approx(narrow.boundary[1], rel=5e-4)


def test_orders(found: tuple[Tubes, ...]) -> None:
    for tubes in found:
        if tubes.constant:
            assert tubes.order(tubes.volume_error) == pytest.approx(2.0, abs=0.01)
            assert tubes.order(tubes.boundary_error) == pytest.approx(2.0, abs=0.01)
        else:
            assert tubes.order(tubes.volume_error) == np.inf
        assert tubes.order(tubes.printed_error) < -1  # A / r - A


def test_verdict(found: tuple[Tubes, ...]) -> None:
    assert judge(found) == "agrees in part"
    first_order = tuple(
        replace(t, volume=2 * t.radius * t.shape.area * (1 + t.radius)) for t in found
    )
    assert judge(first_order) == "disagrees"
    as_printed = tuple(replace(t, boundary=2 * t.radius * t.shape.area) for t in found)
    assert judge(as_printed) == "agrees"


def test_outcome(found: tuple[Tubes, ...]) -> None:
    outcome = outcome_of(found)
    assert len(outcome.caption) <= 200
    assert "is 4.19 r² on the sphere" in outcome.caption
    assert "then 12.57 r²" in outcome.caption
    table = outcome.tables["tubes"]
    within = table["below_reach"] == 1
    assert table["volume_error"][within] == pytest.approx(
        table["volume_error_expected"][within], abs=1e-5
    )
    assert table["boundary_error"][within] == pytest.approx(
        table["boundary_error_expected"][within], abs=1e-5
    )
