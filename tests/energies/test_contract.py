"""What holds of every energy, whatever the shapes and however their union is measured."""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import get_args

import numpy as np
import pytest

import oracles
import polyhedron_oracles as expect
from energies.cases import AUTODIFF, BALLS, KERNELS, POLYHEDRA, UNIT, Case
from oracles import Array, assert_close, assert_same_measures
from pcsmooth.energies.by_autodiff import AutodiffEnergy
from pcsmooth.energies.protocol import Quantity, UnionMeasures, Weight
from pcsmooth.errors import InvalidInputError
from pcsmooth.kernels.threads import thread_limit

every_shape = pytest.mark.parametrize("case", [*BALLS, *POLYHEDRA, *AUTODIFF], ids=str)
every_energy = pytest.mark.parametrize("case", [*KERNELS, *AUTODIFF], ids=str)
every_kernel = pytest.mark.parametrize("case", KERNELS, ids=str)


def totals(union: UnionMeasures) -> list[float]:
    return [union.volume, union.area]


def names_of(union: UnionMeasures) -> list[str]:
    """Its measures of each point."""
    return [name for name in oracles.POWERS if hasattr(union, name)]


def bytes_of(union: UnionMeasures) -> list[bytes]:
    return [getattr(union, name).tobytes() for name in names_of(union)]


# --- gradients


@every_shape
def test_gradients_are_derivatives(case: Case) -> None:
    union = case.measure()
    for direction in expect.probes(case.points, 0 if case.autodiff else 1):
        slopes = expect.slopes(
            lambda points: totals(case.measure(points)), case.points, direction, 1e-5 * case.radius
        )
        gradients = union.volume_gradient, union.area_gradient
        for slope, gradient in zip(slopes, gradients, strict=True):
            derivative = float((gradient * direction).sum())
            assert slope == pytest.approx(derivative, rel=0, abs=3e-8 * abs(gradient).max())


@pytest.mark.parametrize("case", [*BALLS, *POLYHEDRA], ids=str)
def test_gradients_are_those_of_the_reference(case: Case) -> None:
    few = case.of(20 if case.is_ball else 7 if len(case.offsets) < 20 else 5)
    energy = few.energy()
    assert not isinstance(energy, AutodiffEnergy)
    union, reference = few.measure(), AutodiffEnergy(energy).evaluate(few.points).union
    for name in ("volume", "area", "cell_volumes", "visible_areas"):
        assert_close(getattr(reference, name), getattr(union, name), 1e-12)
    for name in ("volume_gradient", "area_gradient"):
        gradient = getattr(union, name)
        assert_close(getattr(reference, name), gradient, 1e-9)
        power = few.dimension + oracles.POWERS[name]
        assert abs(gradient).max() > 0.1 * few.radius**power
    for name in ("radius", "carriers", "volume_diagonal", "area_diagonal"):
        np.testing.assert_array_equal(getattr(reference, name), getattr(union, name))


# --- identities


@every_shape
def test_cells_add_up_and_motions_do_no_work(case: Case) -> None:
    union = case.measure()
    assert union.volume == pytest.approx(union.volume_shares.sum(), rel=1e-13)
    assert union.area == pytest.approx(union.visible_areas.sum(), rel=1e-13)
    least = -case.rounding if case.autodiff else 0.0
    assert union.cell_volumes.min() >= least * union.cell_volumes.max()
    if case.rule != "inclusion-exclusion":
        assert union.visible_areas.min() >= least * union.visible_areas.max()
    if case.adds_up:
        assert union.volume == pytest.approx(union.cell_volumes.sum(), rel=1e-13)
    arms = case.points - case.points.mean(axis=0)
    for gradient in (union.volume_gradient, union.area_gradient):
        assert_close(gradient.sum(axis=0), 0, case.rounding, abs(gradient).max())
        if case.is_ball:  # turned balls are balls
            moments = arms.T @ gradient
            size = abs(arms).max() * abs(gradient).sum()
            assert_close(moments - moments.T, 0, case.rounding, size)
    for diagonal in (union.volume_diagonal, union.area_diagonal):
        assert np.isfinite(diagonal).all()
        assert diagonal.min() >= 0


@every_shape
def test_volume_and_area_are_homogeneous(case: Case) -> None:
    """Euler: p . gradient + r dV/dr = d V, and with d - 1 for the area."""
    points, radius, union = case.points, case.radius, case.measure()
    volume, area = (
        float((points * gradient).sum())
        for gradient in (union.volume_gradient, union.area_gradient)
    )
    growth = expect.slopes(  # the radius as a cloud of one coordinate
        lambda r: totals(case.measure(points, float(r[0, 0]))),
        np.array([[radius]]),
        np.ones((1, 1)),
        1e-5 * radius,
    )
    d = case.dimension
    assert volume + radius * growth[0] == pytest.approx(d * union.volume, rel=1e-8)
    assert area + radius * growth[1] == pytest.approx((d - 1) * union.area, rel=1e-8)
    if np.ptp(case.offsets) == 0:  # the boundary moves outwards as the radius does
        grown = radius * case.offsets[0] * union.area
        assert volume + grown == pytest.approx(d * union.volume, rel=case.rounding)


@every_energy
def test_masses_are_those_of_the_weight(case: Case) -> None:
    points, radius = case.of(3).points[[0, 1, 2, 0]], case.of(3).radius
    union = case.measure(points, radius)
    divisors = {
        "none": np.ones(4),
        "cell": union.cell_volumes,
        "boundary": radius * union.visible_areas,
    }
    for quantity, weight in product(get_args(Quantity), get_args(Weight)):
        found = case.energy(radius, quantity, weight).evaluate(points)
        assert (found.quantity, found.weight) == (quantity, weight)
        assert found.value == getattr(union, quantity)
        np.testing.assert_array_equal(found.gradient, getattr(union, f"{quantity}_gradient"))
        np.testing.assert_array_equal(found.diagonal, getattr(union, f"{quantity}_diagonal"))
        unit = radius if quantity == "area" and weight != "none" else 1.0
        np.testing.assert_allclose(found.masses, divisors[weight] / unit, rtol=1e-15)
        assert found.masses.min() >= 0
        assert weight == "boundary" or found.masses[:3].min() > 0
        # the last one does not carry its position
        assert not found.gradient[3].any()
        assert weight == "none" or found.masses[3] == 0


# --- motions, scale, order


@every_shape
def test_order_of_points_does_not_matter(case: Case) -> None:
    order = np.random.default_rng(4).permutation(case.n)
    found = case.measure(case.points[order])
    assert_same_measures(found, case.measure(), case.rounding, order=order)


@every_shape
def test_map_coordinates_change_nothing(case: Case) -> None:
    eastings_northings_heights = np.array([5e5, 4.2e6, 1e6])
    found = case.measure(case.points + eastings_northings_heights[: case.dimension])
    assert_same_measures(found, case.measure(), 10 * case.rounding)


@every_shape
def test_moving_points_and_body_changes_nothing(case: Case) -> None:
    rotation = oracles.random_rotation(case.dimension, np.random.default_rng(3))
    points = case.points @ rotation.T + np.arange(1, case.dimension + 1)
    found = case.measure(points, rotation=rotation)
    # moving rounds the coordinates to 1e-15 of lengths that are tenths of the radius
    assert_same_measures(found, case.measure(), 10 * case.rounding, rotation)


@every_shape
def test_scale_gives_the_unit(case: Case) -> None:
    factor = 3.7e-5
    found = case.measure(factor * case.points, factor * case.radius)
    assert_same_measures(found, case.measure(), 10 * case.rounding, factor=factor)


@every_shape
def test_scaling_by_a_power_of_two_is_exact(case: Case) -> None:
    for exponent in (-60, 40) if case.autodiff else (-300, 300):
        found = case.measure(
            np.ldexp(case.points, exponent), float(np.ldexp(case.radius, exponent))
        )
        for name in names_of(found):
            power = case.dimension + oracles.POWERS[name]
            unscaled = np.ldexp(getattr(found, name), -exponent * power)
            np.testing.assert_array_equal(unscaled, getattr(case.measure(), name))


# --- coincident, near and far points


@every_shape
def test_first_of_coincident_points_carries_the_cell(case: Case) -> None:
    n = case.n
    of = np.r_[np.random.default_rng(5).integers(0, n, n), np.arange(n)]
    found = case.measure(case.points[of])
    first = np.array([list(of).index(place) for place in range(n)])
    np.testing.assert_array_equal(found.carriers, first[of])
    distinct = case.measure()
    assert totals(found) == pytest.approx(totals(distinct), rel=case.rounding)
    others = np.setdiff1d(np.arange(len(of)), first)
    for name in names_of(found):
        assert not getattr(found, name)[others].any()
        assert_close(getattr(found, name)[first], getattr(distinct, name), case.rounding)


@every_energy
@pytest.mark.parametrize("gap", [1e-7, 1e-10, 1e-13])
def test_near_copies_change_little(case: Case, gap: float) -> None:
    few = case.of(3 if case.autodiff else 50)
    moves = gap * np.random.default_rng(1).normal(
        size=(1 if case.autodiff else 3, *few.points.shape)
    )
    found = few.measure(np.concatenate([few.points, *(few.points + moves)]))
    # what balls and the reference lose to rounding grows with 1 / gap
    rounding = 1e-16 / gap if case.is_ball or case.autodiff else 1e-10
    assert totals(found) == pytest.approx(totals(few.measure()), rel=300 * gap + rounding)


@every_energy
@pytest.mark.parametrize("gap", [1e-20, 1e-150, 1e-200])
def test_nearest_points_have_finite_measures(case: Case, gap: float) -> None:
    points = case.of(3).points - case.of(3).points[0]
    found = case.measure(np.r_[points, points[:1] + gap], case.of(3).radius)
    for name in names_of(found):
        assert np.isfinite(getattr(found, name)).all()
    if not (case.is_ball or case.autodiff):
        assert totals(found) == pytest.approx(totals(case.of(3).measure()), rel=1e-12)


@every_energy
@pytest.mark.parametrize("distance", [2.001, 1e6])
def test_far_parts_are_measured_as_if_alone(case: Case, distance: float) -> None:
    n, alone = case.n, case.measure()
    away = np.zeros(case.dimension)
    away[-1] = np.ptp(case.points) + distance * case.reach
    found = case.measure(np.r_[case.points, case.points + np.round(away / UNIT) * UNIT])
    # the volume of the exact union is that of cones from one place; the reference measures from
    # there what is visible of each body, too
    cones = case.rule == "exact"
    here = 1e-15 * distance**2 if cones and case.autodiff else 0.0
    there = max(10 * case.rounding, here, 1e-15 * distance if cones else 0.0)
    for name in names_of(found):
        values, expected = getattr(found, name), getattr(alone, name)
        assert_close(values[:n], expected, here)
        assert_close(values[n:], expected, there)
    assert totals(found) == pytest.approx([2 * total for total in totals(alone)], rel=there)


@pytest.mark.parametrize("case", [c for c in [*KERNELS, *AUTODIFF] if c.adds_up], ids=str)
def test_farthest_point_does_not_matter(case: Case) -> None:
    found = case.measure(np.r_[case.points, np.full((1, case.dimension), 1e149)])
    for name in names_of(found):
        assert_close(getattr(found, name)[:-1], getattr(case.measure(), name), 1e-14)
    one = case.measure(np.zeros((1, case.dimension)), case.radius)
    assert found.cell_volumes[-1] == pytest.approx(one.volume, rel=case.rounding)


@every_energy
def test_sign_of_zero_does_not_matter(case: Case) -> None:
    points = np.array([[0.0, -0.0, 0.0], [-0.0, 0.0, -0.0], [0.5, -0.0, 0.1], [0.5, 0.0, 0.1]])
    points = points[:, : case.dimension]
    found = case.measure(points, 0.5)
    np.testing.assert_array_equal(found.carriers, [0, 0, 2, 2])
    assert bytes_of(found) == bytes_of(case.measure(points + 0.0, 0.5))


# --- parts of the work


@cache
def strip(case: Case) -> Array:
    """A cloud of several blocks of the kernels, which are so and so many diameters long."""
    points = oracles.uniform_cloud(600, case.dimension)
    points[:, 0] *= 200 * case.circumradius
    return 2 * points


@every_kernel
@pytest.mark.parametrize("in_ties", [False, True])
def test_number_of_threads_changes_no_byte(case: Case, in_ties: bool) -> None:
    points = np.round(strip(case)) if in_ties else strip(case)
    found = []
    for threads in (1, 2):
        with thread_limit(threads):
            found.append(bytes_of(case.measure(points, 1.0)))
    assert found[0] == found[1]


@every_kernel
def test_blocks_leave_no_seams(case: Case) -> None:
    """They begin where the cloud does: a point before it moves them all."""
    points = strip(case)
    whole, before = case.measure(points, 1.0), points[:1].copy()
    for cells in (1.5, 17.0):
        before[0, 0] = points[:, 0].min() - 2 * case.reach / case.radius * cells
        found = case.measure(np.r_[points, before], 1.0)
        for name in names_of(found):
            assert_close(getattr(found, name)[:-1], getattr(whole, name), case.rounding)


@every_kernel
def test_part_of_a_cloud_in_its_box_has_the_measures_of_the_whole(case: Case) -> None:
    points, energy = strip(case), case.energy(1.0)
    assert not isinstance(energy, AutodiffEnergy)
    whole = energy.evaluate(points).union
    box = np.array([points.min(axis=0), points.max(axis=0)])
    middle, halo = points[:, 0].mean(), energy.reach(case.dimension)
    part = np.flatnonzero(abs(points[:, 0] - middle) < halo + 10)
    assert len(part) < 0.9 * len(points)
    inner = abs(points[part, 0] - middle) < 10
    found = energy.evaluate(points[part], box).union
    for name in names_of(found):
        expected = getattr(whole, name)[part[inner]]
        np.testing.assert_array_equal(getattr(found, name)[inner], expected)


# --- one point, none, and what is no cloud


@every_shape
def test_one_point_has_the_whole_shape(case: Case) -> None:
    volume, area = case.whole
    d = case.dimension
    for radius in (1e-3, 1.0, 7.5):
        union = case.measure(np.full((1, d), 3.0), radius)
        # twelve digits of 3.0 are left to a shape of size 1e-3
        whole = volume * radius**d, area * radius ** (d - 1)
        assert totals(union) == pytest.approx(whole, rel=case.rounding, abs=0)
        cell = [union.cell_volumes[0], union.visible_areas[0]]
        assert cell == pytest.approx(whole, rel=case.rounding, abs=0)
        assert_close(union.volume_gradient, 0, case.rounding, whole[1])
        assert_close(union.area_gradient, 0, case.rounding, whole[1] / radius)


@every_energy
def test_what_is_no_cloud_is_refused(case: Case) -> None:
    d = case.dimension
    rows = np.zeros((4, d))
    for bad in (np.nan, np.inf, -np.inf, 1e151):
        rows[[1, 3], -1] = bad
        with pytest.raises(InvalidInputError, match="point 1 is not finite"):
            case.energy().evaluate(rows)
    with pytest.raises(InvalidInputError, match="there are no points"):
        case.energy().evaluate(np.zeros((0, d)))
    with pytest.raises(InvalidInputError, match=r"shape \(3,\)"):
        case.energy().evaluate(np.zeros(3))
    with pytest.raises(
        InvalidInputError, match=r"shape \(3, 4\); they must be \(n, 2\) or \(n, 3\)"
    ):
        case.energy().evaluate(np.zeros((3, 4)))
    with pytest.raises(InvalidInputError, match="not an array of real numbers"):
        case.energy().evaluate(np.array([["a"] * d]))
    for radius in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InvalidInputError, match=f"radius is {radius}; it must be finite and"):
            case.energy(radius).evaluate(np.zeros((1, d)))


# --- grids, rows and planes


HEXAGONS = np.array([[1, 0], [0.5, np.sqrt(0.75)]])

#: Points in ties, with distance 1 between neighbours.
TIES = {
    2: {
        "squares": oracles.lattice(4, 3),
        "triangles": oracles.lattice(4, 4) @ HEXAGONS,
        "row": oracles.lattice(5, 1),
        "slanted row": np.outer(np.arange(5), [0.6, 0.8]),
        "circle": oracles.even_circle(12) / (2 * np.sin(np.pi / 12)),
    },
    3: {
        "cubes": oracles.lattice(3, 3, 2),
        "plane": oracles.lattice(4, 1, 3),
        "slanted plane": oracles.lattice(3, 3) @ np.array([[0.6, 0.8, 0], [0, 0, 1]]),
        "row": oracles.lattice(1, 1, 5),
        "slanted row": np.outer(np.arange(5), [1 / 3, 2 / 3, 2 / 3]),
        "centred cubes": np.r_[oracles.lattice(2, 2, 2), [[0.5, 0.5, 0.5]]],
    },
}


@every_kernel
def test_points_in_ties_have_finite_measures(case: Case) -> None:
    volume, area = case.whole
    for points, radius in product(TIES[case.dimension].values(), (0.5, np.sqrt(0.5), 1.3)):
        n = len(points)
        union = case.measure(points, radius)
        for name in names_of(union):
            assert np.isfinite(getattr(union, name)).all()
        whole = volume * radius**case.dimension
        assert 0 < union.volume < n * whole * (1 + 1e-12)
        assert_close(union.volume_gradient.sum(axis=0), 0, 1e-12, n * area * radius)
        order = np.random.default_rng(1).permutation(n)
        other = case.measure(points[order], radius)
        assert totals(other) == pytest.approx(totals(union), rel=1e-12)
        assert_close(other.cell_volumes, union.cell_volumes[order], 1e-12)
        rotation = oracles.random_rotation(case.dimension, np.random.default_rng(2))
        turned = case.measure(points @ rotation.T, radius, rotation)
        assert_close(turned.cell_volumes, union.cell_volumes, 1e-11)
        if case.rule != "inclusion-exclusion":  # which takes other diagonals
            assert turned.volume == pytest.approx(union.volume, rel=1e-11)
