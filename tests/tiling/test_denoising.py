"""Clouds in tiles are denoised exactly as they are as a whole."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.bodies.presets import load_presets
from pcsmooth.curvature import fitted_cloud, oriented_normals
from pcsmooth.curvature.oriented_normals import find_oriented_normals
from pcsmooth.denoised_rows import DenoisedRows
from pcsmooth.denoising import Facts
from pcsmooth.energies import balls
from pcsmooth.energies.balls import BallEnergy
from pcsmooth.errors import InvalidInputError
from pcsmooth.kernels.threads import MANY
from pcsmooth.progress import Progress
from pcsmooth.python.denoising import denoise
from pcsmooth.record import Record
from pcsmooth.tiling.tile_store import TileStore
from tiling.clouds import MAP_COORDINATES, Points, battered, curve, layers, ribbon, sphere
from tiling.whole_and_tiled import compare, differences, in_tiles

CUBE = load_presets()["cube"]
SQUARE = load_presets()["square"]


def some(points: Points, share: float) -> Any:
    """Marks of some points."""
    return np.random.default_rng(5).random(len(points)) < share


def upward(points: Points) -> Points:
    """Normals as they may come with a cloud: some missing, some turned."""
    normals = np.zeros_like(points)
    normals[:, -1] = 1.0
    normals[::7] = 0.0
    normals[::11] *= -2.5
    normals[::501] = np.nan
    return normals


RIBBON, CURVE, SPHERE = ribbon(), curve(), sphere()
NARROW = ribbon(1500, width=6.0)
ROUGH, ROUGH_CURVE = battered(RIBBON), battered(CURVE)
LINE = np.outer(np.random.default_rng(6).random(1500) * 1500.0, [3.0, 2.0, 1.0])

#: Points, and options of `denoise`; two steps unless they say otherwise.
CASES: dict[str, tuple[Points, dict[str, Any]]] = {
    "sheet": (RIBBON, {"iterations": "auto"}),
    "sphere": (SPHERE, {}),
    "curve": (CURVE, {}),
    "curve on the perimeter": (CURVE, {"energy": "area", "weight": "boundary"}),
    "rough sheet": (ROUGH, {}),
    "rough curve": (ROUGH_CURVE, {}),
    "no step": (RIBBON, {"iterations": 0}),
    "no step of a smooth sphere": (sphere(800, noise=0.01), {"iterations": 0}),
    "no step of a smooth curve": (curve(noise=0.001), {"iterations": 0}),
    "no step of a rough sheet": (ROUGH, {"iterations": 0}),
    "fixed points": (ROUGH, {"fixed": some(ROUGH, 0.3)}),
    "all points fixed": (RIBBON, {"fixed": some(RIBBON, 2.0)}),
    "along the normals": (ROUGH, {"motion": "normal"}),
    "curve along the normals": (ROUGH_CURVE, {"motion": "normal"}),
    "short moves": (RIBBON, {"max_move": "0.1x"}),
    "short moves of some along the normals": (
        RIBBON, {"max_move": 0.2, "motion": "normal", "fixed": some(RIBBON, 0.01)},
    ),
    "early end": (RIBBON, {"stop": 0.07, "iterations": 20}),
    "early end of some": (RIBBON, {"stop": 0.07, "iterations": 20, "fixed": some(RIBBON, 0.5)}),
    "step given": (RIBBON, {"step": 0.2}),
    "step given that is too long": (RIBBON, {"step": 5.0, "max_move": "1x"}),
    "area": (ROUGH, {"energy": "area"}),
    "volume, no weight": (RIBBON, {"weight": "none"}),
    "area, weight of boundaries": (RIBBON, {"energy": "area", "weight": "boundary"}),
    "map coordinates": (ROUGH + MAP_COORDINATES, {"energy": "area"}),
    "map coordinates of a curve": (ROUGH_CURVE + MAP_COORDINATES[:2], {}),
    "layers of an exact grid": (layers(), {"iterations": 1}),
    "points of a line": (LINE, {}),
    "given normals": (ROUGH, {"normals": upward(ROUGH)}),
    "given normals of a curve": (ROUGH_CURVE, {"normals": upward(ROUGH_CURVE)}),
    "given normals as a rule": (ROUGH, {"normals": upward(ROUGH), "orient": "input"}),
    "given normals, not wanted": (ROUGH, {"normals": upward(ROUGH), "orient": "outward"}),
    "outward": (SPHERE, {"orient": "outward"}),
    "up at the highest point": (ROUGH, {"orient": "propagate"}),
    "to a viewpoint": (ROUGH, {"orient": "viewpoint=200,5,30"}),
    "to a viewpoint on the map": (
        ROUGH + MAP_COORDINATES, {"orient": "viewpoint=400200,5500000,200"},
    ),
    "along a direction": (ROUGH, {"orient": "direction=1,0,-2"}),
    "support": (ROUGH, {"support": 20}),
    "smallest support": (RIBBON, {"support": 3}),
    "support of a curve": (CURVE, {"support": 40}),
    "support of few distinct points": (
        np.repeat(ribbon(20), 60, axis=0), {"support": 1000, "radius": 2.0},
    ),
    "more threads": (ROUGH, {"threads": 2}),
    "radius of the extent": (RIBBON, {"radius": "0.4%"}),
    "radius": (RIBBON, {"radius": 1.3, "iterations": 1}),
    "radius below the spacing": (RIBBON, {"radius": 0.2}),
    **{
        f"cubes, {union}": (NARROW, {"polyhedron": CUBE, "union": union, "iterations": 1})
        for union in ("naive", "inclusion-exclusion", "exact")
    },
    **{
        f"cubes on the map, {union}": (
            battered(NARROW) + MAP_COORDINATES,
            {"polyhedron": CUBE, "union": union, "energy": "area", "support": 30, "iterations": 1},
        )
        for union in ("naive", "inclusion-exclusion", "exact")
    },
    "squares along the normals": (CURVE, {"polyhedron": SQUARE, "motion": "normal"}),
}  # fmt: skip


#: What says most of all in one run each, for those who have little time.
TELLING = ("rough curve", "short moves of some along the normals", "given normals", "cubes, exact")


@pytest.mark.parametrize(
    ("points", "options"),
    [
        pytest.param(*case, id=name, marks=[] if name in TELLING else pytest.mark.slow)
        for name, case in CASES.items()
    ],
)
def test_tiles_change_no_bit(tmp_path: Path, points: Points, options: dict[str, Any]) -> None:
    # Several threads would wait for each other on so few points.
    options = {"iterations": 2, "threads": 1, **options}
    unlike, whole, tiled = compare(points, 1 + len(points) // 5, tmp_path, **options)
    assert unlike == []
    assert tiled.store.partition.n_tiles >= 4
    facts = tiled.denoised.facts()
    without = replace(facts, rms_along_normal=None, rms_along_surface=None)
    assert without == facts_of(whole, options.get("fixed"))
    found = facts.rms_along_normal, facts.rms_along_surface
    wanted = rms_of(whole, points, options.get("fixed"))
    assert found == (wanted if wanted[0] is None else pytest.approx(wanted, rel=1e-6))
    finite = np.flatnonzero(whole.finite)
    rows = finite[tiled.store.numbers.read(0, tiled.store.count)]
    told = np.concatenate([part.mean_curvature for part in tiled.denoised.estimated.all()])
    np.testing.assert_array_equal(told, whole.mean_curvature[rows])


def facts_of(whole: DenoisedRows, fixed: Any = None) -> Facts:
    """What a summary says, from the result of the whole."""
    moved = whole.displacement[whole.finite]
    free = moved if fixed is None else moved[~fixed[whole.finite]]
    return Facts(
        mean_displacement=math.fsum(free) / max(1, len(free)),
        max_displacement=float(moved.max()),
        outliers=None if whole.outliers is None else int(np.count_nonzero(whole.outliers)),
        at_limit=None if whole.outliers is None else at_limit(whole, moved),
        fixed=0 if fixed is None else int(np.count_nonzero(fixed[whole.finite])),
        rms_along_normal=None,
        rms_along_surface=None,
        noise_after=noise_after(whole, fixed),
    )


def noise_after(whole: DenoisedRows, fixed: Any) -> float | None:
    """Median of what is left of points that are not fixed, if a filter has moved any."""
    if whole.sigma_after is None or whole.sigma_after is whole.sigma:
        return None
    free = whole.finite if fixed is None else whole.finite & ~fixed
    return float(np.median(whole.sigma_after[free]))


def rms_of(
    whole: DenoisedRows, points: npt.NDArray[np.float64], fixed: Any = None
) -> tuple[float, float] | tuple[None, None]:
    """Root mean squares of the displacements along and across the normals, of what may move."""
    known = whole.curvature.has_normal & (True if fixed is None else ~fixed)
    if not known.any():
        return None, None
    vectors, normals = whole.points[known] - points[known], whole.normals[known]
    heights = np.einsum("ij,ij->i", vectors, normals)
    across = vectors - heights[:, np.newaxis] * normals
    return float(np.sqrt(np.mean(heights**2))), float(np.sqrt(np.mean(np.sum(across**2, axis=1))))


def at_limit(whole: DenoisedRows, moved: npt.NDArray[np.float64]) -> int:
    """Points that have moved six times the noise."""
    if whole.plan is None or not whole.plan.moves_points:
        return 0
    assert whole.plan.scale_map is None
    return int(np.count_nonzero(moved > 5.999999 * whole.plan.noise.deviation))


def test_cases_do_what_their_names_say(tmp_path: Path) -> None:
    def history(name: str) -> list[int]:
        points, options = CASES[name]
        result = in_tiles(points, 2000, tmp_path, threads=1, **options)
        return [record.iteration for record in result.overall.history]

    assert 3 < len(history("early end")) < 21
    seen: list[int] = []

    def noted(*arguments: Any) -> Any:
        seen.append(arguments[3])
        return find_oriented_normals(*arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fitted_cloud, "find_oriented_normals", noted)
        history("no step of a smooth sphere")
        assert len(seen) > 1  # finer ones were tried
        seen.clear()
        history("support of few distinct points")
        assert len(seen) == 2  # once more, with fewer


#: Clouds too small or too flat to be cut.
SMALL: dict[str, Points] = {
    "one point": np.array([[1.0, 2.0, 3.0]]),
    "two points": np.array([[1.0, 2.0, 3.0], [1.0, 2.5, 3.0]]),
    "two points of the plane": np.array([[1.0, 2.0], [1.5, 2.0]]),
    "all points at one place": np.full((50, 3), 7.5),
    "one place of the plane": np.full((50, 2), -7.5),
    "one point among none": np.array([[np.nan] * 3, [4e5, 5e6, 0.0], [np.inf, 0.0, 0.0]]),
}


@pytest.mark.parametrize("tile_points", [1, 100])
@pytest.mark.parametrize("points", SMALL.values(), ids=SMALL)
def test_small_clouds(tmp_path: Path, points: Points, tile_points: int) -> None:
    for options in ({}, {"support": 12}, {"iterations": 0}, {"motion": "normal", "stop": 0.1}):
        unlike, _, _ = compare(points, tile_points, tmp_path, radius=0.4, threads=1, **options)
        assert unlike == [], options


PATCH = ribbon(100)

#: Points and options that cannot be worked on.
UNUSABLE: dict[str, tuple[Points, dict[str, Any]]] = {
    "no finite point": (np.full((4, 3), np.nan), {}),
    "no point": (np.empty((0, 3)), {}),
    "radius of one place": (SMALL["all points at one place"], {}),
    "radius of no extent": (SMALL["one point"], {"radius": "2%"}),
    "move of no extent": (SMALL["one point"], {"radius": 1.0, "max_move": "2%"}),
    "negative radius": (PATCH, {"radius": -1.0}),
    "iterations": (PATCH, {"iterations": 1.5}),
    "energy": (PATCH, {"energy": "mass"}),
    "support": (PATCH, {"support": 2}),
    "rule": (PATCH, {"orient": "inward"}),
    "normals that are not there": (PATCH, {"orient": "input"}),
    "viewpoint of a plane": (PATCH, {"orient": "viewpoint=1,2", "iterations": 0}),
    "direction of a plane": (PATCH, {"orient": "direction=1,2", "iterations": 0}),
}


@pytest.mark.parametrize(("points", "options"), UNUSABLE.values(), ids=UNUSABLE)
def test_errors_are_the_same(tmp_path: Path, points: Points, options: dict[str, Any]) -> None:
    with pytest.raises(InvalidInputError) as of_the_whole:
        denoise(points, scheme="euler", **options)
    with pytest.raises(InvalidInputError) as of_tiles:
        in_tiles(points, 50, tmp_path, **options)
    assert str(of_tiles.value) == str(of_the_whole.value)


def test_tiles_without_points_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match="no tiles of 0 points"):
        in_tiles(RIBBON, 0, tmp_path)


def test_states_and_stages_are_told(tmp_path: Path) -> None:
    states: list[Record] = []
    told: list[tuple[str, int, int]] = []

    def tell(progress: Progress) -> None:
        if progress.record is not None:
            states.append(progress.record)
        else:
            told.append((progress.stage, progress.done, progress.total))

    result = in_tiles(
        RIBBON, 1500, tmp_path, iterations=2, threads=1, callback=tell,
    )  # fmt: skip
    assert states == list(result.overall.history)
    stages = list(dict.fromkeys(stage for stage, _, _ in told))
    assert stages == [
        "cutting into tiles", "coincident points", "spacing", "time step", "step 1 of 2",
        "step 2 of 2", "normals", "neighbourhoods", "curvature", "putting in order",
    ]  # fmt: skip
    tiles = result.store.partition.n_tiles
    totals = {"cutting into tiles": 3, "putting in order": 2}
    for stage, progress in groupby(told, lambda told: told[0]):
        total = totals.get(stage, tiles)
        passes = [list(range(total + 1))] * (len(counts := list(progress)) // (total + 1))
        assert counts == [(stage, done, total) for each in passes for done in each]


@pytest.mark.slow
def test_large_sheet(tmp_path: Path) -> None:
    points = ribbon(20_000, width=60.0)  # more than one block of the kernels
    assert len(points) > MANY
    unlike, _, tiled = compare(points, 1700, tmp_path, iterations=1)
    assert unlike == []
    assert tiled.store.partition.n_tiles >= 12


@pytest.fixture(scope="module")
def whole() -> DenoisedRows:
    """What becomes of a sheet as a whole."""
    return denoise(RIBBON, scheme="euler", iterations=1)


class TestWrongHalos:
    """The comparison tells when tiles see too little."""

    def differences(self, whole: DenoisedRows, folder: Path) -> list[str]:
        return differences(whole, in_tiles(RIBBON, 800, folder, iterations=1, threads=1), RIBBON)

    def shorten(self, patch: pytest.MonkeyPatch, place: object, name: str) -> None:
        reach: Callable[..., float] = getattr(place, name)
        patch.setattr(place, name, lambda *arguments: 0.02 * reach(*arguments))

    def test_of_the_energy(
        self, whole: DenoisedRows, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        self.shorten(monkeypatch, BallEnergy, "reach")
        assert "points" in self.differences(whole, tmp_path)

    def test_of_cells(
        self, whole: DenoisedRows, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        self.shorten(monkeypatch, balls, "cell_reach")
        self.shorten(monkeypatch, oriented_normals, "cell_reach")
        assert {"points", "normals"} <= {*self.differences(whole, tmp_path)}

    def test_of_cell_normals(
        self, whole: DenoisedRows, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        find = oriented_normals._FindNormals
        monkeypatch.setattr(find, "reach", property(lambda step: 0.1 * step.energy.radius))
        unlike = ["normals"]
        with contextlib.suppress(IndexError):  # tiles need not even agree about what is joined
            unlike = self.differences(whole, tmp_path)
        assert "points" not in unlike
        assert "normals" in unlike

    def test_of_shape_operators(
        self, whole: DenoisedRows, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(fitted_cloud, "_RADII", 0.1 * fitted_cloud._RADII)
        monkeypatch.setattr(fitted_cloud, "_ANCHORS", 0.1 * fitted_cloud._ANCHORS)
        unlike = self.differences(whole, tmp_path)
        assert "points" not in unlike
        assert {"normals", "mean_curvature"} <= {*unlike}

    def test_of_points_that_have_left_their_cubes(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        options: dict[str, Any] = {
            "iterations": 2,
            "radius": 2.0,
            "step": 30.0,
            "weight": "none",
            "threads": 1,
        }
        unlike, whole, _ = compare(RIBBON, 800, tmp_path, **options)
        assert unlike == []
        assert whole.displacement.max() > 50.0
        tile = TileStore.tile
        monkeypatch.setattr(
            TileStore, "tile",
            lambda store, number, points, halo, _drift: tile(store, number, points, halo, 0.0),
        )  # fmt: skip
        tiled = in_tiles(RIBBON, 800, tmp_path, **options)
        assert "normals" in differences(whole, tiled, RIBBON)
