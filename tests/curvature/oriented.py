"""Normals that are given but for their signs, oriented as those that are estimated."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial import cKDTree

from oracles import Array
from pcsmooth.curvature import oriented_normals
from pcsmooth.curvature.cell_normals import CellNormals
from pcsmooth.curvature.orientation import Orientation
from pcsmooth.curvature.oriented_normals import find_oriented_normals
from pcsmooth.energies.balls import BallEnergy, BallUnion, measure_balls
from pcsmooth.energies.protocol import Evaluation
from pcsmooth.kernels.balls.facet_booking import VISIBLE_AREA
from pcsmooth.neighbors.grid import Grid
from pcsmooth.neighbors.spacing import mean_spacing
from pcsmooth.parts.cloud_state import CloudState
from pcsmooth.parts.column import ArrayColumn
from pcsmooth.parts.whole_cloud import WholeCloud

#: Nearest points along which signs are handed on.
LINKS = 8


@dataclass(frozen=True)
class WithAreas(BallEnergy):
    """Balls of whose boundary as much is visible as is said."""

    areas: Array = field(default_factory=lambda: np.empty(0))

    def evaluate(self, points: Array, box: Array | None = None) -> Evaluation:
        union = measure_balls(points, self.radius, box)
        union.measures[:, VISIBLE_AREA] = self.areas
        return self.of_union(union)


@dataclass(frozen=True)
class KnownNormals:
    """Takes the place of `find_cell_normals`: normals (n, d) by the points' numbers."""

    normals: Array

    def __call__(
        self,
        grid: Grid,
        numbers: npt.NDArray[np.int64],
        _union: BallUnion,
        dimension: int,
        _count: int,
        _reach: float,
    ) -> CellNormals:
        n = len(numbers)
        placed = grid.coordinates[:dimension].T
        links = cKDTree(placed).query(placed, min(LINKS, n) + 1)[1][:, 1:].astype(np.int32)
        normals = np.zeros((3, n))
        normals[:dimension] = self.normals[numbers].T
        return CellNormals(normals, grid.coordinates, links, np.ones(n), np.ones(n))


def orient(
    points: Array,
    normals: Array,
    orientation: Orientation | None = None,
    given: Array | None = None,
    areas: Array | None = None,
) -> tuple[Array, dict[str, int]]:
    """Give normals (n, d) of either sign those that a rule wants, and tell its reasons.

    Parameters
    ----------
    points, normals : ndarray, shape (n, d)
        Distinct positions and their unit normals, or zero.
    orientation : Orientation, optional
        The rule.
    given : ndarray, shape (n, d), optional
        Normals of the input.
    areas : ndarray, shape (n,), optional
        Weights of the points, all the same by default.
    """
    n, dimension = points.shape
    cloud = WholeCloud.as_it_is(points)
    if given is not None:
        cloud = replace(cloud, given=ArrayColumn(given))
    energy = WithAreas(
        2.0 * mean_spacing(points) if n > 1 else 1.0,
        areas=np.ones(n) if areas is None else areas,
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(oriented_normals, "find_cell_normals", KnownNormals(normals))
        found, _ = find_oriented_normals(
            cloud, CloudState.at_start(cloud), energy, LINKS, orientation or Orientation()
        )
    assert found.distinct == n
    return found.normals.read(0, n).reshape(n, dimension), found.reasons
