from __future__ import annotations

from pathlib import Path

import numpy as np

from oracles import Array
from pcsmooth.parts.cloud_state import CloudState, Moves, next_state
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.tiling.cutting import cut_cloud
from pcsmooth.tiling.runner import InProcess
from pcsmooth.tiling.tiled_cloud import TiledCloud
from tiling.clouds import ribbon
from tiling.whole_and_tiled import source_of


class Shift:
    """Move all points by what their positions tell, but those that are fixed."""

    reach = 3.0

    def __init__(self, target: Column, fixed: Column) -> None:
        self.target = target
        self.fixed = fixed

    def __call__(self, part: Part) -> Moves:
        held = part.read(self.fixed)
        vectors = np.where(held[:, np.newaxis], 0.0, np.sin(part.points))
        moved = part.points + vectors
        part.write(self.target, moved)
        return Moves.of(part, part.points, moved, vectors, held).solved(part.first, 1.0 / part.stop)


def shifted(parts: Parts, stop: float) -> tuple[CloudState, Array]:
    target = parts.create("target", parts.start.dtype)
    start = CloudState.at_start(parts)
    moves = list(parts.map("shift", Shift(target, parts.fixed), parts.start))
    state = next_state(parts, start, target, moves, stop)
    return state, target.read(0, parts.count)


def test_a_state_tells_the_same_of_all_points_however_they_are_cut(tmp_path: Path) -> None:
    points = ribbon(900, width=6.0)
    fixed = np.arange(len(points)) % 5 == 0
    whole = WholeCloud.of(points, fixed=fixed)
    tiles = TiledCloud(cut_cloud(source_of(points, fixed=fixed), tmp_path, 100), InProcess())
    assert tiles.n_parts > 7
    one, moved = shifted(whole, 0.0)
    starts = whole.start.read(0, whole.count)
    lengths = np.linalg.norm(moved - starts, axis=1)
    free = ~whole.fixed.read(0, whole.count)
    for cloud in (whole, tiles):
        state, places = shifted(cloud, 0.0)
        np.testing.assert_array_equal(places, moved)
        assert (state.iteration, state.converged) == (1, False)
        np.testing.assert_array_equal(state.box, [moved.min(axis=0), moved.max(axis=0)])
        assert state.mean_move == one.mean_move
        assert state.max_move == one.max_move
        assert state.drift == np.abs(moved - starts).max()
    np.testing.assert_allclose(one.mean_move, lengths.mean(), rtol=1e-13)
    np.testing.assert_allclose(one.max_move, lengths.max(), rtol=1e-13)
    mean_of_free = float(np.linalg.norm(np.sin(starts[free]), axis=1).mean())
    for share, converged in ((0.999, False), (1.001, True)):
        assert shifted(whole, share * mean_of_free)[0].converged is converged
        assert shifted(tiles, share * mean_of_free)[0].converged is converged


def test_a_state_tells_of_the_part_that_was_solved_worst(tmp_path: Path) -> None:
    tiles = TiledCloud(cut_cloud(source_of(ribbon(400)), tmp_path, 100), InProcess())
    state, _ = shifted(tiles, 0.0)
    last, _ = tiles.store.partition.rows(tiles.n_parts - 1)
    _, first = tiles.store.partition.rows(0)
    assert (state.solver_iterations, state.solver_error) == (last, 1.0 / first)


def test_drift_is_how_far_points_are_from_their_start() -> None:
    """Not how far they have gone."""
    cloud = WholeCloud.as_it_is(np.zeros((3, 2)))
    state = CloudState.at_start(cloud)
    for x in (0.5, 0.25):
        (move,) = cloud.map("move", _Give(np.full((3, 2), x)), state.points)
        state = next_state(cloud, state, state.points, [move])
        assert state.drift == x
    assert state.iteration == 2


class _Give:
    """Tell of a move without making it."""

    reach = 0.0

    def __init__(self, ends: Array) -> None:
        self.ends = ends

    def __call__(self, part: Part) -> Moves:
        held = np.zeros(len(part.points), np.bool_)
        return Moves.of(part, part.points, self.ends, self.ends, held)
