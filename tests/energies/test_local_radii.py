"""The energy of balls and of polyhedra whose radii follow the local spacing."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np
import pytest

import polyhedron_oracles as expect
from energies.cases import ball_cloud, convex_body
from oracles import Array, assert_close
from pcsmooth.energies.balls import BallEnergy, measure_balls
from pcsmooth.energies.polyhedra.union import PolyhedronEnergy
from pcsmooth.energies.protocol import Quantity, Weight
from pcsmooth.energies.weighting import power_of_step
from pcsmooth.errors import InvalidInputError
from pcsmooth.neighbors.local_radii import LocalRadii
from pcsmooth.neighbors.local_spacing import local_spacings


def uneven(dimension: int, n: int = 60) -> tuple[Array, LocalRadii]:
    """A surface whose points are up to three times as far apart, and radii."""
    points, _ = ball_cloud("surface", dimension, 2.0, n)
    points = points * (1.0 + points[:, :1] / np.ptp(points[:, 0]))
    return points, LocalRadii.of(local_spacings(points), 2.0)


def energy_of(
    local: LocalRadii,
    quantity: Quantity,
    weight: Weight = "cell",
    shape: str = "ball",
    dimension: int = 3,
) -> BallEnergy | PolyhedronEnergy:
    if shape == "ball":
        return BallEnergy(local.median, quantity, weight, local)
    body = convex_body(expect.solid({2: "lopsided polygon", 3: "lopsided polyhedron"}[dimension]))
    union: Any = shape
    return PolyhedronEnergy(local.median, body, union, quantity, weight, local)


#: Balls, or how the union of bodies is computed.
every_shape = pytest.mark.parametrize("shape", ["ball", *expect.RULES])


@every_shape
@pytest.mark.parametrize("quantity", get_args(Quantity))
@pytest.mark.parametrize("dimension", [2, 3])
def test_gradients_are_derivatives_at_fixed_radii(
    quantity: Quantity, dimension: int, shape: str
) -> None:
    points, local = uneven(dimension)
    assert local.values.max() > 1.3 * local.values.min()
    energy = energy_of(local, quantity, "cell", shape, dimension)
    gradient = energy.evaluate(points).gradient
    step = 1e-5 * float(local.values.min())
    for direction in expect.probes(points, 1):
        [slope] = expect.slopes(
            lambda moved: [energy.evaluate(moved).value], points, direction, step
        )
        expected = float((gradient * direction).sum())
        assert slope == pytest.approx(expected, rel=0, abs=3e-8 * abs(gradient).max())


@every_shape
@pytest.mark.parametrize("quantity", get_args(Quantity))
@pytest.mark.parametrize("weight", get_args(Weight))
@pytest.mark.parametrize("dimension", [2, 3])
def test_each_shape_has_a_time_of_its_own(
    quantity: Quantity, weight: Weight, dimension: int, shape: str
) -> None:
    # Far from each other, two clouds that differ in size only get steps that differ as much.
    points, radius = ball_cloud("surface", dimension, 2.0, 40)
    n, factor = len(points), 8.0
    both = np.concatenate([points, factor * points + 1e3])
    local = LocalRadii.of(np.repeat([radius, factor * radius], n), 1.0)
    found = energy_of(local, quantity, weight, shape, dimension).evaluate(both)
    assert isinstance(found.paces, np.ndarray)
    moves = found.gradient / np.where(found.masses > 0.0, found.masses, np.inf)[:, np.newaxis]
    assert_close(moves[n:], factor * moves[:n], 1e-9)
    rates = found.diagonal / np.where(found.masses > 0.0, found.masses, np.inf)
    assert_close(rates[n:], rates[:n], 1e-9)
    assert np.all(
        found.paces[n:] == factor ** power_of_step(quantity, weight, dimension) * (found.paces[:n])
    )


def test_weights_are_those_of_each_ball() -> None:
    points, local = uneven(3)
    union = measure_balls(points, local.values)
    thickness: dict[Quantity, Any] = {"volume": 1.0, "area": local.values}
    for quantity, radii in thickness.items():
        found = energy_of(local, quantity, "cell").evaluate(points)
        assert_close(found.masses * found.paces, union.cell_volumes / radii, 1e-14)
        found = energy_of(local, quantity, "boundary").evaluate(points)
        visible = union.visible_areas * local.values / radii
        assert_close(found.masses * found.paces, visible, 1e-12)


def test_equal_spacings_are_one_radius() -> None:
    points, radius = ball_cloud("surface", 3, 2.0, 60)
    expected = BallEnergy(radius, "area", "boundary").evaluate(points)
    local = LocalRadii.of(np.full(len(points), radius / 2.0), 2.0)
    found = energy_of(local, "area", "boundary").evaluate(points)
    assert found.masses.tobytes() == expected.masses.tobytes()
    assert found.gradient.tobytes() == expected.gradient.tobytes()
    assert found.paces == 1.0


def test_other_points_than_were_measured() -> None:
    points, local = uneven(3)
    with pytest.raises(InvalidInputError, match=r"^radii have shape \(60,\); there must be one"):
        energy_of(local, "volume").evaluate(points[:-1])


@pytest.mark.parametrize(
    ("spacings", "expected"),
    [
        ([1.0, 2.0, 4.0], [2.0, 4.0, 8.0]),
        ([1.0, 2.0, 1e9], [2.0, 4.0, 2.0 * 4096.0]),
        ([1e-9, 2.0, 4.0], [4.0 / 4096.0, 4.0, 4.0]),
    ],
)
def test_radii_that_one_grid_has_room_for(spacings: list[float], expected: list[float]) -> None:
    local = LocalRadii.of(np.array(spacings), 2.0)
    assert local.values.tolist() == expected
    assert local.median == 4.0
