from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pcsmooth.bodies.presets import load_presets
from pcsmooth.energies.balls import BallEnergy, measure_balls
from pcsmooth.errors import InvalidInputError
from pcsmooth.flows import implicit
from pcsmooth.flows.conjugate_gradients import TOLERANCE
from pcsmooth.flows.flow import run_flow
from pcsmooth.flows.implicit import Implicit
from pcsmooth.python.denoising import denoise
from tiling.clouds import curve, ribbon
from tiling.whole_and_tiled import compare, in_tiles

pytestmark = pytest.mark.slow


def difference(points: Any, folder: Path, **options: Any) -> float:
    """How far whole and tiles are apart, as a share of the displacement, root of mean squares."""
    options = {"scheme": "implicit", "iterations": 1, "threads": 1, **options}
    _, whole, tiled = compare(points, len(points) // 8, folder, **options)
    assert tiled.store.partition.n_tiles >= 6
    assert tiled.overall.step == whole.step
    assert tiled.overall.method == whole.method
    assert len(tiled.overall.solver_iterations) == 1
    assert tiled.overall.solver_error <= TOLERANCE
    rows = tiled.ordered.read(0, len(points))
    ends = whole.points
    apart = rows["end"] + tiled.store.origin - ends
    return float(np.sqrt(np.sum(apart**2) / np.sum((ends - points) ** 2)))


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"order": 1},
        {"step": 9.0, "order": 1},
        {"weight": "boundary"},
        {"energy": "area"},
        {"weight": "none"},
        {"weight": "none", "energy": "area", "order": 1},
        {"weight": "none", "step": 2.0, "order": 1},
        {"motion": "normal"},
        {"keep_volume": True},
    ],
    ids=str,
)
def test_steps_agree_to_the_tolerance_of_the_solver(
    options: dict[str, Any], tmp_path: Path
) -> None:
    assert difference(ribbon(6000), tmp_path, **options) < 2 * TOLERANCE


@pytest.mark.parametrize(("weight", "scale"), [("none", 0.01), ("none", 100.0), ("cell", 100.0)])
def test_long_steps_agree_whatever_the_size_of_the_cells(
    weight: str, scale: float, tmp_path: Path
) -> None:
    """Without a weight a step of the same length is one over the cell times as long."""
    points = ribbon(6000) * scale
    step = 300.0 * scale**2
    if weight == "none":
        step /= float(np.median(measure_balls(points, 2.0 * scale).cell_volumes))
    options = {"radius": 2.0 * scale, "weight": weight, "step": step, "order": 1}
    assert difference(points, tmp_path, **options) < 2 * TOLERANCE


@pytest.mark.parametrize("union", ["naive", "exact"])
def test_polyhedra_agree_too(union: str, tmp_path: Path) -> None:
    options = {"polyhedron": load_presets()["cube"], "union": union}
    assert difference(ribbon(2400, width=6.0), tmp_path, **options) < 2 * TOLERANCE


def test_curves_agree_too(tmp_path: Path) -> None:
    assert difference(curve(6000), tmp_path, order=1) < 2 * TOLERANCE


def test_several_steps(tmp_path: Path) -> None:
    points = ribbon(4000)
    tiled = in_tiles(points, 700, tmp_path, scheme="implicit", iterations=3, threads=1)
    whole = denoise(points, scheme="implicit", iterations=3, threads=1)
    assert len(tiled.overall.solver_iterations) == 3
    for ours, theirs in zip(tiled.overall.history, whole.history, strict=True):
        assert ours.volume == pytest.approx(theirs.volume, rel=1e-4)
        assert ours.mean_move == pytest.approx(theirs.mean_move, rel=1e-2)


def test_a_halo_that_is_too_small_shows(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Long steps are felt farther than cells are."""
    monkeypatch.setattr(implicit, "_DECAY_LENGTHS", 0.0)
    monkeypatch.setattr(BallEnergy, "reach", lambda energy, _dimension: 2.0 * energy.radius)
    assert difference(ribbon(6000), tmp_path, step=100.0, order=1) > 2 * TOLERANCE


def test_a_point_is_felt_as_far_as_is_said() -> None:
    """The displacement of one point moves others by less than exp(-d / sqrt(2 step))."""
    points = np.stack([np.arange(400.0), np.zeros(400)], axis=1)
    moved = points.copy()
    moved[200, 1] = 0.1
    step = 25.0
    ends = [
        list(run_flow(BallEnergy(2.0), cloud, Implicit(1.0, 1, step, tolerance=1e-13), 1))[1].points
        for cloud in (points, moved)
    ]
    felt = np.abs(ends[1] - ends[0])[:, 1]
    distance = np.abs(np.arange(400) - 200)
    assert felt.max() == felt[200]
    assert np.all(felt <= 2.0 * felt.max() * np.exp(-distance / np.sqrt(2.0 * step)) + 1e-13)


@pytest.mark.parametrize("radius", [1e-6, 1.0])
def test_clouds_may_not_be_too_wide(radius: float, tmp_path: Path) -> None:
    """Cells of a cloud too wide for their numbers begin elsewhere than those of its tiles."""
    points = np.r_[ribbon(300), [[4e6, 0.0, 0.0]]]
    with pytest.raises(InvalidInputError, match=r"wide, more than .* remove far outliers"):
        in_tiles(points, 100, tmp_path, radius=radius, iterations=1)
