from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import oracles
from oracles import Array
from pcsmooth.denoised_rows import DenoisedRows
from pcsmooth.errors import InvalidInputError
from pcsmooth.filters import outliers, passes, redistribution
from pcsmooth.filters.planning import plan_filter
from pcsmooth.filters.surface_filter import filter_points
from pcsmooth.kernels.threads import MANY, thread_limit
from pcsmooth.methods.filter import Filter
from pcsmooth.neighbors.coincident import mark_distinct
from pcsmooth.neighbors.surroundings import look_around
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.positions import usable_rows
from pcsmooth.python.denoising import denoise
from pcsmooth.tiling.cutting import cut_cloud
from pcsmooth.tiling.runner import InProcess
from pcsmooth.tiling.tiled_cloud import TiledCloud
from tiling.in_tiles import TiledResult, denoise_in_tiles
from tiling.whole_and_tiled import compare, source_of


def sheet(n: int, noise: float = 0.4) -> Array:
    """A wavy sheet with a spacing of 1."""
    rng = np.random.default_rng(3)
    x, y = rng.random((2, n)) * np.sqrt(n)
    return np.stack(
        [x, y, 4 * np.sin(x / 20) * np.cos(y / 15) + noise * rng.normal(size=n)], axis=1
    )


def circle(n: int) -> Array:
    rng = np.random.default_rng(4)
    angles = rng.random(n) * 2 * np.pi
    radii = 1 + 1e-3 * rng.normal(size=n)
    return np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)


def lattice(n: int) -> Array:
    axes = np.meshgrid(np.arange(n), np.arange(n), [0.0], indexing="ij")
    return np.stack(axes, axis=-1).reshape(-1, 3)


def soiled(points: Array) -> Array:
    """A cloud with outliers, clumps of them, duplicates and rows that are no numbers."""
    rng = np.random.default_rng(5)
    low, high = points.min(axis=0), points.max(axis=0)
    strays = low + (high - low) * (rng.random((60, points.shape[1])) * 1.6 - 0.3)
    clumps = np.repeat(strays[:6], 3, axis=0) + 1e-3 * rng.normal(size=(18, points.shape[1]))
    mixed = np.concatenate([points, strays, clumps, points[::40], points[::80]])
    mixed[::333, 0] = np.nan
    return mixed[rng.permutation(len(mixed))]


def sphere(n: int, noise: float = 0.5) -> Array:
    return oracles.sphere_surface(n).noisy(noise)


def assert_same_in_tiles(
    points: Array, folder: Path, tile_points: int, **options: Any
) -> tuple[DenoisedRows, TiledResult]:
    """Denoise a cloud both ways; one thread each, as most kernels have too little to do."""
    options = {"scheme": "auto", "threads": 1, **options}
    unlike, whole, tiled = compare(points, tile_points, folder, **options)
    assert unlike == []
    return whole, tiled


@pytest.mark.slow
@pytest.mark.parametrize("tile_points", [250, 1000, 100_000])
def test_tiles_of_any_size(tile_points: int, tmp_path: Path) -> None:
    _, tiled = assert_same_in_tiles(sphere(2500), tmp_path, tile_points)
    assert (tiled.store.partition.n_tiles > 8) == (tile_points == 250)
    assert (tiled.store.partition.n_tiles == 1) == (tile_points == 100_000)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [None, 0.02])
def test_thin_closed_surfaces(noise: float | None, tmp_path: Path) -> None:
    shell = oracles.random_sphere(3000)
    shell[1500:] *= 0.9
    shell += 0.02 * np.random.default_rng(7).normal(size=shell.shape)
    whole, tiled = assert_same_in_tiles(shell, tmp_path, 600, closed=True, noise=noise)
    assert tiled.store.partition.n_tiles > 2
    assert whole.plan is not None
    assert whole.plan.tells_sides_apart


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [{"max_move": "0.2x"}, {"motion": "normal", "noise": "0.2x"}, {"radius": "3x"}],
)
@pytest.mark.parametrize("shape", ["sphere", "torus", "circle"])
def test_soiled_clouds(shape: str, options: dict[str, Any], tmp_path: Path) -> None:
    make: dict[str, Callable[[], Array]] = {
        "sphere": lambda: sphere(2500),
        "torus": lambda: oracles.torus_surface(2500).noisy(0.3) + np.array([4e5, 5.5e6, 300]),
        "circle": lambda: circle(2500),
    }
    points = soiled(make[shape]())
    fixed = np.random.default_rng(6).random(len(points)) < 0.05
    if "radius" in options:
        options = {**options, "scheme": "filter"}
    whole, tiled = assert_same_in_tiles(points, tmp_path, 900, fixed=fixed, **options)
    assert tiled.store.partition.n_tiles > 2
    assert whole.method.name == "filter"
    assert whole.outliers is not None
    assert 0 < np.count_nonzero(whole.outliers) < 200
    assert whole.displacement[fixed].max() == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("is_rough", [False, True])
def test_exact_grid(is_rough: bool, tmp_path: Path) -> None:
    """Many points are at equal distances; without noise none moves."""
    points = lattice(50)
    if is_rough:
        points[:, 2] = np.random.default_rng(8).integers(0, 3, len(points)) / 4
    whole, _ = assert_same_in_tiles(points, tmp_path, 700)
    assert whole.plan is not None
    assert whole.plan.moves_points == is_rough
    assert (whole.displacement.max() > 0.0) == is_rough


@pytest.mark.slow
@pytest.mark.parametrize("is_even", [False, True])
def test_points_that_fill_a_volume_stay(is_even: bool, tmp_path: Path) -> None:
    points = np.random.default_rng(9).random((2000, 3))
    if is_even:
        points = np.indices((12, 12, 12)).reshape(3, -1).T.astype(float)
    whole, tiled = assert_same_in_tiles(points, tmp_path, 300)
    assert tiled.store.partition.n_tiles > 4
    assert whole.plan is not None
    assert not whole.plan.has_surface
    np.testing.assert_array_equal(whole.points, points)


@pytest.mark.parametrize("n", [2, 11, 12, 40])
def test_few_points(n: int, tmp_path: Path) -> None:
    whole, tiled = assert_same_in_tiles(sphere(n), tmp_path, 4)
    assert (whole.plan is None) == (n < 12)
    assert tiled.store.partition.n_tiles > 1 or n == 2


@pytest.mark.slow
def test_sparse_points_are_no_outliers_if_they_are_many(tmp_path: Path) -> None:
    """How many are on their own is decided for the cloud, not for a tile."""
    sparse = sphere(600, 0.0) * np.array([30, 30, 1]) + np.array([0, 0, 40])
    points = np.concatenate([sheet(2500, 0.1), sparse])
    rng = np.random.default_rng(7)
    assert_same_in_tiles(points[rng.permutation(len(points))], tmp_path, 900)


def test_a_flow_is_chosen_by_its_options(tmp_path: Path) -> None:
    whole, _ = assert_same_in_tiles(sphere(1500), tmp_path, 500, iterations=1)
    assert whole.method.name == "euler"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scheme": "filter", "iterations": 2}, "iterations is given and the scheme is filter"),
        ({"scheme": "euler", "noise": "1x"}, "noise is given and the scheme is euler"),
    ],
)
def test_options_out_of_place(options: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match=message):
        denoise_in_tiles(source_of(sphere(20)), tmp_path, 10, InProcess(), **options)


@pytest.mark.slow
@pytest.mark.parametrize("tile_points", [200, 700, 5000])
@pytest.mark.parametrize("cloud", ["lattice", "soiled", "circle"])
def test_surroundings(cloud: str, tile_points: int, tmp_path: Path) -> None:
    points = {"lattice": lattice(45), "soiled": soiled(sphere(2000)), "circle": circle(900)}[cloud]
    tiles = TiledCloud(cut_cloud(source_of(points), tmp_path, tile_points), InProcess())
    whole = WholeCloud.of(points, usable_rows(points))
    found, expected = (
        look_around(cloud, mark_distinct(cloud), "noise", 800, 1000, 400)
        for cloud in (tiles, whole)
    )
    assert found.count == expected.count
    dimension = points.shape[1]
    assert found.positions.shape == (len(found.distances), 400, dimension)
    np.testing.assert_array_equal(found.distances * tiles.unit, expected.distances * whole.unit)
    np.testing.assert_array_equal(found.positions * tiles.unit, expected.positions * whole.unit)


def is_same_filter(points: Array, expected: Array, radius: float, folder: Path, tile: int) -> bool:
    """Whether the filter alone takes the points, in tiles, where they are expected."""
    with thread_limit(1):
        store = cut_cloud(source_of(points), folder, tile)
        cloud = TiledCloud(store, InProcess())
        state = filter_points(cloud, plan_filter(cloud, mark_distinct(cloud)), radius).state
    ends, starts, numbers = (column.read(0, cloud.count) for column in (
        state.points, cloud.start, store.numbers
    ))  # fmt: skip
    assert cloud.n_parts >= 8
    return bool(np.array_equal(points[numbers] + (ends - starts), expected[numbers]))


@pytest.mark.slow
def test_a_large_sheet(tmp_path: Path) -> None:
    points = sheet(20_000)  # more than one block of the kernels
    assert len(points) > MANY
    whole = denoise(points, threads=1)
    assert is_same_filter(points, whole.points, whole.radius, tmp_path, 2000)


@pytest.fixture(scope="module")
def filtered_sheet() -> tuple[Array, DenoisedRows]:
    points = sheet(5000)
    return points, denoise(points, threads=1)


@pytest.mark.slow
@pytest.mark.parametrize("tile_points", [400, 1500])
def test_noise_and_spacing_that_differ_are_those_of_the_whole(
    tile_points: int, tmp_path: Path
) -> None:
    """A sheet whose spacing and noise grow eight times from one end to the other."""
    rng = np.random.default_rng(0)
    x = 8.0 ** rng.random(4000)
    points = np.stack([x, x * rng.random(4000), 0.02 * x * rng.normal(size=4000)], axis=1)
    unlike, whole, tiled = compare(points, tile_points, tmp_path, method=Filter())
    assert unlike == []
    assert tiled.store.partition.n_tiles > 1
    assert whole.plan is not None
    assert whole.plan.scale_map is not None


@pytest.mark.slow
@pytest.mark.parametrize("stage", ["none", "outliers", "passes", "redistribution", "last step"])
def test_halos_matter(
    stage: str,
    filtered_sheet: tuple[Array, DenoisedRows],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    points, whole = filtered_sheet
    if stage == "outliers":
        monkeypatch.setattr(
            outliers, "search_reach", lambda plan, _: 0.1 * plan.passes[0].max_radius
        )
    elif stage == "passes":
        monkeypatch.setattr(passes, "PASS_REACHES", 1)
    elif stage == "redistribution":
        monkeypatch.setattr(
            redistribution, "redistribution_reach", lambda plan: plan.passes[-1].max_radius
        )
    elif stage == "last step":
        monkeypatch.setattr(passes, "LAST_REACHES", 1)
    same = is_same_filter(points, whole.points, whole.radius, tmp_path, 500)
    assert same == (stage == "none")
