"""Energies of the parts of a cloud are those of the whole, to the last bit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from energies.cases import KERNELS, Case
from oracles import Array
from pcsmooth.energies.balls import BallEnergy
from pcsmooth.energies.on_parts import Measure, Totals, evaluate, sum_of
from pcsmooth.energies.protocol import Energy
from pcsmooth.kernels.grid.grid import CELL_OF_ZERO
from pcsmooth.neighbors import grid
from pcsmooth.neighbors.grid import CUBE_LEVEL, FULL_CUBE
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts, Reach
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.tiling.cutting import cut_cloud
from pcsmooth.tiling.runner import InProcess
from pcsmooth.tiling.tiled_cloud import TiledCloud
from tiling.whole_and_tiled import source_of


@dataclass(frozen=True, eq=False)
class WriteGradient:
    """Write the gradient of an energy, its diagonal and the masses; gives the totals."""

    energy: Energy
    box: npt.NDArray[np.float64]
    target: Column

    @property
    def reach(self) -> float | Reach:
        return self.energy.reach(self.box.shape[1])

    def __call__(self, part: Part) -> Totals:
        found = evaluate(part, self.energy, self.box)
        part.write(self.target, np.c_[found.gradient, found.diagonal, found.masses])
        return Totals.of(part, found)


def measured(cloud: Parts, energy: Energy) -> tuple[bytes, tuple[float, float]]:
    """What an energy gives at all points of a cloud, and its totals."""
    target = cloud.create("gradient", (np.float64, (cloud.dimension + 2,)))
    totals = list(cloud.map("gradient", WriteGradient(energy, cloud.box, target), cloud.start))
    assert len(totals) == cloud.n_parts
    sums = sum_of(totals)
    assert sums == sum_of(list(cloud.map("energy", Measure(energy, cloud.box), cloud.start)))
    return target.read(0, cloud.count).tobytes(), sums


def assert_parts_are_as_the_whole(
    points: Array, energy: Energy, tile_points: int, folder: Path
) -> None:
    whole = WholeCloud.of(points)
    tiles = TiledCloud(cut_cloud(source_of(points), folder, tile_points), InProcess())
    assert tiles.n_parts >= 4
    assert measured(tiles, energy) == measured(whole, energy)


def crowd(dimension: int, cell: float, count: int) -> Array:
    """Random points in one cube of cells, and one at the corner of the cloud."""
    cells = 1 << CUBE_LEVEL[dimension]
    first = -CELL_OF_ZERO % cells  # the first cell of a cube, seen from the corner
    points = np.random.default_rng(12).random((count, dimension))
    points = cell * (first + 1e-4 + cells * (1.0 - 1e-4) * points)
    return np.asarray(np.r_[points, np.zeros((1, dimension))])


@pytest.mark.parametrize("dimension", [3, 2])
def test_a_cube_that_is_cut_up_in_the_whole_is_so_in_parts(dimension: int, tmp_path: Path) -> None:
    """Parts see all of it, though a point's cell depends on a small part of it."""
    points = crowd(dimension, 2.0, FULL_CUBE + 150)
    assert_parts_are_as_the_whole(points, BallEnergy(1.0), 800, tmp_path)


@pytest.mark.parametrize("case", KERNELS, ids=str)
@pytest.mark.parametrize("is_full", [True, False])
def test_parts_see_the_cubes_of_the_whole(
    case: Case, is_full: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(grid, "FULL_CUBE", 500 if is_full else 1000)
    energy = case.energy(1.0)
    points = crowd(case.dimension, 2.0 * case.reach / case.radius, 550)
    assert_parts_are_as_the_whole(points, energy, 100, tmp_path)
