"""Normals and curvatures of a cloud in tiles, the same to the last bit as of the whole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import CELLS, CellNormals
from pcsmooth.curvature.estimate import Support, limited_support, radius_of_support
from pcsmooth.curvature.orientation import Orientation
from pcsmooth.curvature.shape_operators import CLUSTERS, find_shape_operators
from pcsmooth.curvature.support import (
    NestedFits,
    Supports,
    choose_supports,
    fit_supports,
    ratios_of_supports,
    sample_ranks,
)
from pcsmooth.energies.centers import Centers, place_centers
from pcsmooth.energies.protocol import Energy
from pcsmooth.kernels.surface.shape_operators import N_ESTIMATES
from pcsmooth.tiling.column_store import Column
from pcsmooth.tiling.flow import TiledState, Totals
from pcsmooth.tiling.normals import TiledNormals, find_normals
from pcsmooth.tiling.runner import Runner
from pcsmooth.tiling.spacing import marked_rows
from pcsmooth.tiling.tiled_cloud import Tile, TiledCloud, check_width

#: Radii of a neighbourhood for curvature that a point's estimate depends on: the blocks of
#: clusters are not wider than 4 / 3 of one, and those around a point's own count.
_RADII = 8.0 / 3.0 + 1e-3

#: How far the anchors of two points may be from them, in radii of the balls.
_ANCHORS = 4.0


@dataclass(frozen=True, eq=False)
class TiledCurvature:
    """Normals and curvatures of a cloud in tiles: see `CurvatureEstimate`.

    Attributes
    ----------
    estimates : Column
        (N_ESTIMATES,), by the columns of `pcsmooth.kernels.surface.shape_operators`.
    normal_support, curvature_support : float
        Points of a neighbourhood.
    orientation : dict of str to int
        How many components got their sign for which reason.
    totals : list of Totals
        The energy of the tiles.
    """

    estimates: Column
    normal_support: float
    curvature_support: float
    orientation: dict[str, int]
    totals: list[Totals]


def estimate_in_tiles(
    cloud: TiledCloud,
    state: TiledState,
    energy: Energy,
    *,
    support: Support,
    orientation: Orientation,
    given: Column | None,
    runner: Runner,
    on_tile: Callable[[], None],
) -> TiledCurvature:
    """Estimate normals and curvatures at all points.

    Parameters
    ----------
    cloud : TiledCloud
        The cloud.
    state : TiledState
        Where it is. After a step the finest neighbourhoods are not tried, as in
        `estimate_on_union`.
    energy : Energy
        Whose radius the balls have, and whose value is told.
    support : int or "auto"
        Points of a neighbourhood.
    orientation : Orientation
        Where normals point, seen from the cloud's origin.
    given : Column or None
        Normals of the input, (d,), zero where there is none.
    runner : Runner
        Does the work.
    on_tile : callable
        Called after each tile, twice for each.

    Returns
    -------
    TiledCurvature
    """
    dimension = cloud.dimension

    def normals(count: int) -> tuple[TiledNormals, dict[str, int], list[Totals]]:
        return find_normals(cloud, state, energy, count, orientation, given, runner, on_tile)

    def supports_for(found: TiledNormals) -> Supports:
        return _choose(cloud, state, energy.radius, found, runner)

    if support == "auto":
        (count, *smaller) = CELLS[dimension]
        found, reasons, totals = normals(count)
        supports = supports_for(found)
        for fewer in smaller:
            if supports.may_be_finer and state.iteration == 0:
                finer, finer_reasons, _ = normals(fewer)
                others = supports_for(finer)
                if others.normal_error < supports.normal_error:
                    found, reasons, supports = finer, finer_reasons, others
        radii = (supports.normal_radius, supports.curvature_radius)
    else:
        wanted = limited_support(support, cloud.count)
        most = CELLS[dimension][0]
        found, reasons, totals = normals(min(wanted, most))
        wanted = limited_support(wanted, found.distinct)
        if min(wanted, most) < found.count:  # there are few distinct points
            found, reasons, totals = normals(wanted)
        radii = (radius_of_support(wanted, found.count, found.extent, dimension),) * 2
    check_width(state.box, radii[1] / CLUSTERS[dimension], state.box[0])
    estimates = cloud.create("estimates", (np.float64, (N_ESTIMATES,)))
    tasks = (
        (cloud, tile, state, energy.radius, found, radii, estimates)
        for tile in range(cloud.partition.n_tiles)
    )
    for _ in runner.map(_fit_tile, tasks):
        on_tile()
    points_of = [found.count * (length / found.extent) ** (dimension - 1) for length in radii]
    return TiledCurvature(estimates, points_of[0], points_of[1], reasons, totals)


def _loaded(
    cloud: TiledCloud, tile: int, state: TiledState, radius: float, found: TiledNormals, halo: float
) -> tuple[Tile, Centers, npt.NDArray[np.int64], CellNormals]:
    """Load a tile with its cell normals: these in the order of the grid, and their numbers."""
    loaded = cloud.tile(tile, state.points, halo + _ANCHORS * radius, state.drift)
    centers = place_centers(loaded.points, radius, reach=radius, box=state.box)
    numbers = centers.distinct[centers.grid.order]

    def rows(column: Column) -> npt.NDArray[np.float64]:
        values = loaded.read(column)[numbers]
        padded = np.zeros((3, len(numbers)))
        padded[: cloud.dimension] = values.T
        return padded

    links = np.empty((0, 0), np.int32)  # have served their purpose
    return (
        loaded,
        centers,
        numbers,
        CellNormals(
            rows(found.normals), rows(found.anchors), links, loaded.read(found.weights)[numbers],
            np.empty(0),
        ),
    )  # fmt: skip


def _choose(
    cloud: TiledCloud, state: TiledState, radius: float, found: TiledNormals, runner: Runner
) -> Supports:
    """Choose the radii of neighbourhoods from a sample of the points."""
    samples = marked_rows(found.is_distinct, sample_ranks(found.distinct))
    ratios = ratios_of_supports(found.distinct, cloud.dimension, found.count)
    fits = NestedFits(
        ratios,
        np.full((len(samples), len(ratios), 3), np.nan),
        np.full((len(samples), len(ratios), 3), np.nan),
    )
    tasks = (
        (cloud, tile, state, radius, found, ratios, samples)
        for tile in range(cloud.partition.n_tiles)
    )
    for places, part in runner.map(_fit_samples, tasks):
        fits.normals[places] = part.normals
        fits.shapes[places] = part.shapes
    return choose_supports(fits, found.extent, cloud.dimension)


def _fit_samples(
    cloud: TiledCloud,
    tile: int,
    state: TiledState,
    radius: float,
    found: TiledNormals,
    ratios: npt.NDArray[np.float64],
    samples: npt.NDArray[np.int64],
) -> tuple[npt.NDArray[np.int64], NestedFits]:
    """Fit the neighbourhoods of those samples that are a tile's own: which they are, the fits."""
    first, stop = cloud.partition.rows(tile)
    places = np.flatnonzero((samples >= first) & (samples < stop))
    if places.size == 0:
        none = np.empty((0, len(ratios), 3))
        return places, NestedFits(ratios, none, none)
    halo = 2.0 * found.extent * float(ratios[-1])
    loaded, centers, numbers, cells = _loaded(cloud, tile, state, radius, found, halo)
    ranks = np.empty(len(loaded.points), np.int64)
    ranks[numbers] = np.arange(len(numbers))
    chosen = ranks[np.searchsorted(loaded.rows, samples[places])]
    return places, fit_supports(
        cells, centers.grid.coordinates, cloud.dimension, chosen, found.extent, ratios
    )


def _fit_tile(
    cloud: TiledCloud,
    tile: int,
    state: TiledState,
    radius: float,
    found: TiledNormals,
    radii: tuple[float, float],
    estimates: Column,
) -> None:
    """Fit normals and shape operators at the points of a tile."""
    loaded, centers, numbers, cells = _loaded(cloud, tile, state, radius, found, _RADII * radii[1])
    fitted = find_shape_operators(
        cells, centers.grid.coordinates, numbers, len(loaded.points), cloud.dimension, *radii,
        state.box[0],
    )  # fmt: skip
    loaded.write(estimates, fitted[centers.carriers])
