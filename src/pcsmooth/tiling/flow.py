"""Explicit flows of a cloud in tiles: each step takes every tile from one state to the next.

What a step does to a point depends on nothing but the points around it, in an order that is the
same in a part of the cloud as in the whole. The displacements are therefore the same to the last
bit, however the cloud is cut.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.denoise_result import Record
from pcsmooth.energies.polyhedra.union import PolyhedronEnergy
from pcsmooth.energies.protocol import Energy, Evaluation
from pcsmooth.flows.euler import stiffness
from pcsmooth.flows.flow import next_displacement
from pcsmooth.flows.implicit import Implicit
from pcsmooth.flows.restraint import Restraint
from pcsmooth.flows.scheme import Scheme
from pcsmooth.flows.state import State
from pcsmooth.neighbors import CUBE_LEVEL
from pcsmooth.tiling.column_store import Column
from pcsmooth.tiling.runner import Runner
from pcsmooth.tiling.streamed_median import streamed_median
from pcsmooth.tiling.tiled_cloud import TiledCloud

#: Cells around a cube that what happens in it depends on: two for the cells of its points, and two
#: for those of the points that share a facet with them.
_CELLS_AROUND = 4

#: Cells that the normals of a step reach beyond the cells of its points.
_CELLS_OF_NORMALS = 2

#: Lengths over which an implicit step's mean falls off before it is cut: e^-14 is 1e-6.
_DECAY_LENGTHS = 20.0

_RATE = "rate"


def cell_halo(radius: float, dimension: int) -> float:
    """How far the cells of a union of balls may depend on points, along an axis, L."""
    cells = (1 << CUBE_LEVEL[dimension]) + _CELLS_AROUND
    return 2.0 * radius * cells


def implicit_halo(scheme: Scheme, step: float) -> float:
    """How far the solution of an implicit step depends on points noticeably, along an axis, L.

    The solution is a mean of positions that falls off with distance like exp(-d / l), l being
    sqrt(2 step) at most (and of second order at that rate times sqrt(1 / 2)).
    """
    return _DECAY_LENGTHS * math.sqrt(2.0 * step) if isinstance(scheme, Implicit) else 0.0


def energy_halo(energy: Energy, dimension: int) -> float:
    """How far the evaluation of an energy at a point may depend on others, along an axis, L."""
    factor = energy.body.circumradius if isinstance(energy, PolyhedronEnergy) else 1.0
    return cell_halo(energy.radius * max(1.0, factor), dimension)


@dataclass(frozen=True, eq=False)
class TiledState:
    """A cloud in tiles on its way.

    Attributes
    ----------
    iteration : int
        Steps taken.
    points : Column
        Positions, L.
    box : ndarray, shape (2, d)
        Their bounding box, L.
    drift : float
        Most that a point is away from its start along an axis, L.
    mean_move, max_move : float
        Of the last step, L.
    rests : bool
        Whether the points that are not fixed moved less than the tolerance in the last step.
    solver_iterations : int
        Iterations of the solver of linear equations in the last step, most of any tile.
    solver_error : float
        Bound of the error that it has left, of the worst tile: see `Displacement.error`.
    """

    iteration: int
    points: Column
    box: npt.NDArray[np.float64]
    drift: float
    mean_move: float = 0.0
    max_move: float = 0.0
    rests: bool = False
    solver_iterations: int = 0
    solver_error: float = 0.0


@dataclass(frozen=True)
class Totals:
    """Sums over the points of a tile."""

    volume: float
    area: float


@dataclass(frozen=True, eq=False)
class Moves:
    """What a step did to the points of a tile."""

    low: npt.NDArray[np.float64]
    high: npt.NDArray[np.float64]
    drift: float
    total: float
    largest: float
    free_total: float
    free: int
    solver_iterations: int = 0
    solver_error: float = 0.0


def record_in_tiles(state: TiledState, totals: list[Totals]) -> Record:
    """Take down a state."""
    return Record(
        state.iteration,
        math.fsum(total.volume for total in totals),
        math.fsum(total.area for total in totals),
        state.mean_move,
        state.max_move,
    )


def automatic_step(
    cloud: TiledCloud, energy: Energy, runner: Runner, on_tile: Callable[[], None]
) -> float:
    """Find the automatic step of explicit flows (see `Euler`).

    Parameters
    ----------
    cloud : TiledCloud
        The cloud.
    energy : Energy
        What is to decrease.
    runner : Runner
        Does the work.
    on_tile : callable
        Called after each tile.
    """
    rates = cloud.create(_RATE, np.float64)
    for _ in runner.map(
        _write_rates, ((cloud, tile, energy) for tile in range(cloud.partition.n_tiles))
    ):
        on_tile()

    def known() -> Iterator[npt.NDArray[np.float64]]:
        return (chunk[~np.isnan(chunk)] for chunk in rates.chunks())

    moves = any(len(chunk) for chunk in known())
    step = 1.0 / streamed_median(known) if moves else 0.0  # isolated points rest
    cloud.drop(_RATE)
    return step


def _write_rates(cloud: TiledCloud, tile: int, energy: Energy) -> None:
    loaded = cloud.tile(tile, cloud.start, energy_halo(energy, cloud.dimension), 0.0)
    evaluation = energy.evaluate(loaded.points, cloud.box)
    loaded.write(cloud.column(_RATE, np.float64), stiffness(evaluation))


def take_step(
    cloud: TiledCloud,
    state: TiledState,
    energy: Energy,
    scheme: Scheme,
    step: float,
    restraint: Restraint,
    stop: float,
    runner: Runner,
    on_tile: Callable[[], None],
) -> tuple[Record, TiledState]:
    """Take a step.

    Parameters
    ----------
    cloud : TiledCloud
        The cloud.
    state : TiledState
        Where it is.
    energy : Energy
        What is to decrease.
    scheme : Scheme
        How to step. An implicit step looks at each tile and what is around it, and leaves out
        what is too far to be felt.
    step : float
        Time step.
    restraint : Restraint
        How the points may move; volumes cannot be kept.
    stop : float
        Mean move below which the state rests, L.
    runner : Runner
        Does the work.
    on_tile : callable
        Called after each tile.

    Returns
    -------
    record : Record
        Of the state before.
    state : TiledState
        The next one.
    """
    # A name of its own: a worker that was given up may still write to an earlier one.
    target = cloud.points(f"points_{state.iteration + 1}")
    Column.create(target.path, target.dtype, target.rows)
    tasks = (
        (cloud, tile, state, target, energy, scheme, step, restraint)
        for tile in range(cloud.partition.n_tiles)
    )
    totals, moves = [], []
    for total, move in runner.map(_step_tile, tasks):
        totals.append(total)
        moves.append(move)
        on_tile()
    cloud.drop(f"points_{state.iteration}")
    following = next_state(cloud, state.iteration + 1, target, moves, stop)
    return record_in_tiles(state, totals), following


def next_state(
    cloud: TiledCloud, iteration: int, points: Column, moves: list[Moves], stop: float
) -> TiledState:
    """Tell where a step has taken a cloud.

    Parameters
    ----------
    cloud : TiledCloud
        The cloud.
    iteration : int
        Steps taken.
    points : Column
        Positions, L.
    moves : list of Moves
        Of the tiles.
    stop : float
        Mean move below which the state rests, L.
    """
    free = sum(move.free for move in moves)
    return TiledState(
        iteration,
        points,
        np.stack(
            [
                np.min([move.low for move in moves], axis=0),
                np.max([move.high for move in moves], axis=0),
            ]
        ),
        max(move.drift for move in moves),
        math.fsum(move.total for move in moves) / cloud.count,
        max(move.largest for move in moves),
        math.fsum(move.free_total for move in moves) < stop * free,
        max(move.solver_iterations for move in moves),
        max(move.solver_error for move in moves),
    )


def _step_tile(
    cloud: TiledCloud,
    tile: int,
    state: TiledState,
    target: Column,
    energy: Energy,
    scheme: Scheme,
    step: float,
    restraint: Restraint,
) -> tuple[Totals, Moves]:
    halo = energy_halo(energy, cloud.dimension) + implicit_halo(scheme, step)
    if restraint.along_normals:
        halo += 2.0 * energy.radius * _CELLS_OF_NORMALS
    loaded = cloud.tile(tile, state.points, halo, state.drift)
    start, fixed = loaded.read(cloud.start), loaded.read(cloud.fixed)
    evaluation = energy.evaluate(loaded.points, state.box)
    here = State(
        state.iteration, loaded.points, evaluation, np.zeros(len(start)), step, box=state.box
    )
    displacement, held = next_displacement(here, scheme, start, fixed, restraint)
    moved = loaded.points + displacement.vectors
    loaded.write(target, moved)
    moves = moves_of(loaded.own, start, moved, displacement.vectors, held)
    return totals_of(loaded.own, evaluation), replace(
        moves, solver_iterations=displacement.iterations, solver_error=displacement.error
    )


def moves_of(
    own: npt.NDArray[np.int64],
    start: npt.NDArray[np.float64],
    moved: npt.NDArray[np.float64],
    vectors: npt.NDArray[np.float64],
    held: npt.NDArray[np.bool_],
) -> Moves:
    """Sum up what a step did to some points, from starts, ends, displacements and who is held."""
    lengths = np.linalg.norm(vectors[own], axis=1)
    free = ~held[own]
    return Moves(
        moved[own].min(axis=0),
        moved[own].max(axis=0),
        float(np.abs(moved[own] - start[own]).max()),
        float(lengths.sum()),
        float(lengths.max()),
        float(lengths[free].sum()),
        int(np.count_nonzero(free)),
    )


def totals_of(own: npt.NDArray[np.int64], evaluation: Evaluation) -> Totals:
    """Sum the union's measures over some points."""
    union = evaluation.union
    return Totals(float(union.volume_shares[own].sum()), float(union.visible_areas[own].sum()))
