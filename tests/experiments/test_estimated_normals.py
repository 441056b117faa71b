"""Gradients as normals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

import oracles
import polyhedron_oracles as expect
from experiments.thesis_clouds import INPUTS
from pcsmooth import load_presets
from pcsmooth.neighbors.spacing import mean_spacing
from pcsmooth_experiments.space.estimated_normals import (
    EXPERIMENT,
    Estimates,
    degrees_between,
    judge,
    measure_normals,
    outcome_of,
)
from pcsmooth_experiments.space.ring_sector import sample_ring_sector

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def found() -> tuple[Estimates, ...]:
    points = oracles.even_sphere(400)
    return (
        measure_normals("report's sphere", points, 2.0 * points, (2.0,)),
        measure_normals("even sphere", points, points, (2.0,)),
        measure_normals("model", *sample_ring_sector(0.1), (2.0,)),
    )


def test_angles() -> None:
    vectors = np.array([[2.0, 0, 0], [0, 3, 0], [-1, 0, 0], [1, 1, 0], [0, 0, 0]])
    normals = np.tile([1.0, 0, 0], (5, 1))
    assert degrees_between(vectors, normals) == pytest.approx([0, 90, 180, 45, 90])


def test_gradients_are_slopes_of_the_volume(found: tuple[Estimates, ...]) -> None:
    """Central differences of an independent volume at one point of the sphere.

    Only cells of bodies that meet the point's change; they depend on points twice as far.
    """
    sphere = found[0]
    preset = load_presets()["sphere-200"]
    body = expect.Solid(preset.normals, preset.offsets)
    radius = 2.0 * mean_spacing(sphere.points)
    distances = np.linalg.norm(sphere.points - sphere.points[200], axis=1)
    order = np.argsort(distances)[: np.count_nonzero(distances < 4.5 * radius)]
    changed = np.count_nonzero(distances < 2.2 * radius)
    local = sphere.points[order]
    move = np.zeros_like(local)
    move[0] = 1e-5 * np.array([0.6, 0.0, 0.8])
    higher, lower = (
        expect.naive_cells(local + sign * move, radius, body, range(changed))[0].sum()
        for sign in (1, -1)
    )
    slope = (higher - lower) / 2e-5
    gradient = sphere.decisive.vectors[200]
    scale = float(np.linalg.norm(gradient))
    assert gradient @ move[0] / 1e-5 == pytest.approx(slope, abs=1e-3 * scale)


def test_even_sphere(found: tuple[Estimates, ...]) -> None:
    """Body and ball differ by 10 degrees in their normals, and gradients by far less."""
    even = found[1].decisive
    assert np.median(even.angles) < 1.5
    assert even.spread < 0.1
    assert even.angles == pytest.approx(found[0].decisive.angles, abs=1e-9)


def test_verdict(found: tuple[Estimates, ...]) -> None:
    sphere, even, model = found
    assert judge(found) == "agrees in part"  # the model's flat faces have no curvature

    def along_normals(one: Estimates) -> Estimates:
        perfect = replace(one.decisive, vectors=one.normals, angles=np.zeros(len(one.points)))
        return replace(one, gradients=(perfect,))

    def turned_round(one: Estimates) -> Estimates:
        uneven = np.linspace(0.1, 2.0, len(one.points))[:, None]
        worst = replace(
            one.decisive, vectors=-uneven * one.normals, angles=np.full(len(one.points), 180.0)
        )
        return replace(one, gradients=(worst,))

    assert judge((along_normals(sphere), even, along_normals(model))) == "agrees"
    assert judge((turned_round(sphere), even, turned_round(model))) == "disagrees"


def test_outcome(found: tuple[Estimates, ...]) -> None:
    outcome = outcome_of(found)
    assert len(outcome.caption) <= 200
    summary = outcome.tables["normals-angles"]
    chosen = (summary["cloud"] == "model") & (summary["normals_from"] == "gradient, naive")
    assert f"model: {summary['median_angle'][chosen][0]:.0f}°" in outcome.caption


def test_report_cloud_and_stand_in() -> None:
    """The shipped folder has no fandisk: the caption says what stands in."""
    outcome = EXPERIMENT.run(INPUTS)
    if INPUTS.has("fandisk_simplified.xyz"):
        assert "fandisk:" in outcome.caption
    else:
        assert "ring sector, for the fandisk" in outcome.caption
    assert len(outcome.caption) <= 200
    assert len(outcome.tables["normals-sphere"]["x"]) == 1050


@pytest.mark.parametrize("spacing", [0.1, 0.06])
def test_ring_sector(spacing: float) -> None:
    """Even, and flat or on cylinders where its normals say so."""
    points, normals = sample_ring_sector(spacing)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(np.ones(len(points)))
    tree = cKDTree(points)
    nearest = tree.query(points, 2)[0][:, 1]
    assert nearest.min() > 0.5 * spacing
    assert nearest.max() < 1.3 * spacing
    area = 2 * (np.pi / 3) * (1 - 0.16) + 2 * np.pi / 3 * 1.4 * 0.5 + 2 * 0.6 * 0.5
    assert len(points) * spacing**2 == pytest.approx(area, rel=0.1)
    for i, near in enumerate(tree.query_ball_point(points, 1.5 * spacing)):
        same = [j for j in near if normals[i] @ normals[j] > 0.8]
        heights = (points[same] - points[i]) @ normals[i]
        assert abs(heights).max() < 1.2 * (1.5 * spacing) ** 2 / (2 * 0.4)
    inside = points - 0.4 * spacing * normals  # the body is on the other side
    outside = points + 0.4 * spacing * normals
    center = points.mean(axis=0)
    flat = normals[-1]  # a cap
    assert (normals @ flat).max() == pytest.approx(1.0)
    caps = abs(normals @ flat) > 0.999
    assert (abs((outside[caps] - center) @ flat) > abs((inside[caps] - center) @ flat)).all()
