"""The energy of a cloud in tiles."""

from __future__ import annotations

from collections.abc import Callable

from pcsmooth.energies.protocol import Energy
from pcsmooth.tiling.flow import TiledState, Totals, energy_halo, totals_of
from pcsmooth.tiling.runner import Runner
from pcsmooth.tiling.tiled_cloud import TiledCloud


def measure_in_tiles(
    cloud: TiledCloud,
    state: TiledState,
    energy: Energy,
    runner: Runner,
    on_tile: Callable[[], None],
) -> list[Totals]:
    """Evaluate an energy where no step is taken.

    Parameters
    ----------
    cloud : TiledCloud
        The cloud.
    state : TiledState
        Where it is.
    energy : Energy
        What to evaluate.
    runner : Runner
        Does the work.
    on_tile : callable
        Called after each tile.

    Returns
    -------
    list of Totals
        Of the tiles.
    """
    totals = []
    tasks = ((cloud, tile, state, energy) for tile in range(cloud.partition.n_tiles))
    for total in runner.map(_measure_tile, tasks):
        totals.append(total)
        on_tile()
    return totals


def _measure_tile(cloud: TiledCloud, tile: int, state: TiledState, energy: Energy) -> Totals:
    halo = energy_halo(energy, cloud.dimension)
    loaded = cloud.tile(tile, state.points, halo, state.drift)
    return totals_of(loaded.own, energy.evaluate(loaded.points, state.box))
