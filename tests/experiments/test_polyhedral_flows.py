"""A sphere under polyhedra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import oracles
from pcsmooth import load_presets, measure_polyhedra
from pcsmooth.neighbors.spacing import mean_spacing
from pcsmooth_experiments.space.polyhedral_flows import (
    Facing,
    PolyhedralFlow,
    draw_polyhedral_flows,
    facing_of,
    judge,
    measure_polyhedral_flows,
    outcome_of,
)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def found() -> tuple[PolyhedralFlow, ...]:
    return measure_polyhedral_flows(oracles.even_sphere(300), (3, 8))


def test_facing_of_the_body_itself() -> None:
    for name in ("cube", "icosahedron"):
        body = load_presets()[name]
        facing = facing_of(3.0 * body.vertices, body)
        assert facing.median == pytest.approx(0.0, abs=1e-5)
        assert facing.share == pytest.approx(1.0)


def test_facing_of_a_cube_by_a_turned_cube() -> None:
    """Turned by 20 degrees around z, two of the six sides stay."""
    angle = np.radians(20)
    turn = np.array([
        [np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]
    ])  # fmt: skip
    cube = load_presets()["cube"]
    facing = facing_of(cube.vertices @ turn.T, cube)
    assert facing.median == pytest.approx(20.0)
    assert facing.share == pytest.approx(1 / 3)


def test_facing_of_a_sphere() -> None:
    """Half of the directions are within that angle of an axis, by random directions."""
    directions = oracles.random_sphere(200_000)
    expected = np.degrees(np.median(np.arccos(abs(directions).max(axis=1))))
    facing = facing_of(oracles.even_sphere(4000), load_presets()["cube"])
    assert facing.median == pytest.approx(expected, abs=0.5)
    share = (abs(directions).max(axis=1) > np.cos(np.radians(10))).mean()
    assert facing.share == pytest.approx(share, abs=0.01)


def test_flows(found: tuple[PolyhedralFlow, ...]) -> None:
    start = oracles.even_sphere(300)
    radius = 2.0 * mean_spacing(start)
    assert len(found) == 9
    for flow in found:
        assert list(flow.clouds) == [0, 3, 8]
        assert (flow.clouds[0] == start).all()
        assert len(flow.facing) == len(flow.volumes) == 9
        body = load_presets()[flow.body]
        for count, cloud in flow.clouds.items():
            volume = measure_polyhedra(cloud, radius, body, flow.union).volume
            assert flow.volumes[count] == pytest.approx(volume, rel=1e-12)
            assert flow.facing[count] == facing_of(cloud, body)
        assert (np.diff(flow.volumes) < 0).all()


def test_sphere_turns_towards_the_body(found: tuple[PolyhedralFlow, ...]) -> None:
    for flow in found:
        assert flow.medians[8] < 0.95 * flow.medians[0]


def test_verdict(found: tuple[PolyhedralFlow, ...]) -> None:
    def falling(flow: PolyhedralFlow, slope: float) -> PolyhedralFlow:
        facing = tuple(Facing(30.0 + slope * i, 0.1) for i in range(len(flow.facing)))
        return replace(flow, facing=facing)

    every = tuple(falling(flow, -1.0) for flow in found)
    assert judge(every) == "agrees"
    assert judge((*every[:-2], falling(found[-2], 1.0), every[-1])) == "agrees in part"
    assert judge((*every[:-1], falling(found[-1], 1.0))) == "agrees"  # exact is not the thesis'
    assert judge(tuple(falling(flow, 1.0) for flow in found)) == "disagrees"
    rising = tuple(replace(flow, volumes=np.arange(9.0)) for flow in every)
    assert judge(rising) == "disagrees"


def test_outcome(found: tuple[PolyhedralFlow, ...]) -> None:
    outcome = outcome_of(found)
    assert len(outcome.caption) <= 200
    table = outcome.tables["polyhedral-flows"]
    chosen = (table["body"] == "cube") & (table["union"] == "exact") & (table["iteration"] == 3)
    assert f"exact {table['median_angle'][chosen][0]:.0f}°" in outcome.caption
    assert len(draw_polyhedral_flows(found).axes) == 18
