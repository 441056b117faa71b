"""Normals of a cloud in tiles: cell normals of every tile, and signs that agree across them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import find_cell_normals
from pcsmooth.curvature.component_votes import ComponentVotes
from pcsmooth.curvature.orientation import Orientation
from pcsmooth.energies.balls import BallUnion, measure_balls
from pcsmooth.energies.protocol import Energy
from pcsmooth.kernels.surface.forest_pieces import EDGE, exit_edges, span, thin
from pcsmooth.kernels.surface.signed_sets import refer_to_lowest
from pcsmooth.kernels.surface.spanning_forest import join_alike
from pcsmooth.neighbors import CUBE_LEVEL, cube_starts
from pcsmooth.tiling.column_store import Column
from pcsmooth.tiling.flow import TiledState, Totals, cell_halo, energy_halo, totals_of
from pcsmooth.tiling.runner import Runner
from pcsmooth.tiling.streamed_median import streamed_median
from pcsmooth.tiling.tiled_cloud import TiledCloud
from pcsmooth.unit_of_length import unit_near

#: Cells around a cube of points that their normals and links depend on.
_CELLS_OF_NORMALS = 3


@dataclass(frozen=True, eq=False)
class TiledNormals:
    """Cell normals of a cloud in tiles: see `CellNormals`.

    Attributes
    ----------
    normals, anchors : Column
        Unit normals and where they hold, (d,).
    weights, areas, squares : Column
        Volume of the cell, visible area, squared radius of the neighbourhood.
    is_distinct : Column
        Whether the point is the first at its position; the rest is 0 for those that are not.
    names : Column
        Lowest row among the points that each has been joined to in its tile.
    signs : Column
        Sign of the normal relative to that point's.
    count : int
        Points whose cells give a normal.
    distinct : int
        Number of distinct points.
    extent : float
        Median radius of the neighbourhoods, L.
    """

    normals: Column
    anchors: Column
    weights: Column
    areas: Column
    squares: Column
    is_distinct: Column
    names: Column
    signs: Column
    count: int
    distinct: int = 0
    extent: float = math.nan

    def parts(self, *columns: Column) -> Iterator[tuple[npt.NDArray[Any], ...]]:
        """Read columns chunk by chunk, after the marks of distinct points."""
        return zip(*(column.chunks() for column in (self.is_distinct, *columns)), strict=True)


def normal_columns(cloud: TiledCloud, count: int) -> TiledNormals:
    """Make room for the cell normals of so many points' cells."""

    def create(name: str, dtype: npt.DTypeLike) -> Column:
        return cloud.create(f"{name}_{count}", dtype)

    vector = (np.float64, (cloud.dimension,))
    return TiledNormals(
        normals=create("normals", vector),
        anchors=create("anchors", vector),
        weights=create("weights", np.float64),
        areas=create("areas", np.float64),
        squares=create("squares", np.float64),
        is_distinct=create("is_distinct", np.bool_),
        names=create("names", np.int64),
        signs=create("signs", np.int8),
        count=count,
    )


def find_normals(
    cloud: TiledCloud,
    state: TiledState,
    energy: Energy,
    count: int,
    orientation: Orientation,
    given: Column | None,
    runner: Runner,
    on_tile: Callable[[], None],
) -> tuple[TiledNormals, dict[str, int], list[Totals]]:
    """Find the cell normals of all points and which way they look.

    Parameters
    ----------
    cloud : TiledCloud
        The cloud.
    state : TiledState
        Where it is.
    energy : Energy
        Whose value is to be told; balls have its radius.
    count : int
        Points whose cells give a normal.
    orientation : Orientation
        Where normals point, seen from the cloud's origin.
    given : Column or None
        Normals of the input.
    runner : Runner
        Does the work.
    on_tile : callable
        Called after each tile.

    Returns
    -------
    normals : TiledNormals
        With signs.
    reasons : dict of str to int
        See `orient_normals`.
    totals : list of Totals
        The energy of the tiles.
    """
    found = normal_columns(cloud, count)
    tasks = ((cloud, tile, state, energy, found) for tile in range(cloud.partition.n_tiles))
    totals: list[Totals] = []
    edges = np.empty(0, EDGE)
    for total, more in runner.map(_normals_of_tile, tasks):
        totals.append(total)
        edges = thin(np.concatenate([edges, more]))
        on_tile()
    distinct = sum(int(np.count_nonzero(chunk)) for chunk in found.is_distinct.chunks())

    def squares() -> Iterator[npt.NDArray[np.float64]]:
        return (values[chosen] for chosen, values in found.parts(found.squares))

    extent = math.sqrt(streamed_median(squares))
    found = replace(found, distinct=distinct, extent=extent)
    found, reasons = _orient(found, state.points, cloud, edges, orientation, given)
    cloud.drop(f"normals_{count}", f"areas_{count}", f"squares_{count}", f"names_{count}")
    return found, reasons, totals


def _normals_of_tile(
    cloud: TiledCloud, tile: int, state: TiledState, energy: Energy, found: TiledNormals
) -> tuple[Totals, npt.NDArray[np.void]]:
    """Find the cell normals of a tile, and the lightest links between what is alike."""
    dimension, radius = cloud.dimension, energy.radius
    cells = (1 << CUBE_LEVEL[dimension]) + _CELLS_OF_NORMALS
    halo = cell_halo(radius, dimension) + 2.0 * radius * cells
    halo = max(halo, energy_halo(energy, dimension))
    loaded = cloud.tile(tile, state.points, halo, state.drift)
    evaluation = energy.evaluate(loaded.points, state.box)
    union = evaluation.union
    total = totals_of(loaded.own, evaluation)
    if not isinstance(union, BallUnion):
        union = measure_balls(loaded.points, radius, state.box)
    grid, numbers = union.grid, union.numbers
    cell_normals = find_cell_normals(grid, numbers, union, dimension, found.count, 2.0 * radius)
    normals = cell_normals.normals[:dimension]
    roots, signs = join_alike(normals, cell_normals.links, cube_starts(grid, dimension))
    names, signs = refer_to_lowest(roots, signs, loaded.rows[numbers])
    is_own = np.zeros(len(loaded.points), np.bool_)
    is_own[loaded.own] = True
    edges = exit_edges(
        normals, cell_normals.links, loaded.rows[numbers], names, signs, is_own[numbers]
    )
    areas = union.visible_areas[numbers] / unit_near(radius) ** (dimension - 1)
    for column, values, default in (
        (found.normals, normals.T, 0.0),
        (found.anchors, cell_normals.anchors[:dimension].T, 0.0),
        (found.weights, cell_normals.weights, 0.0),
        (found.areas, areas, 0.0),
        (found.squares, cell_normals.squares, 0.0),
        (found.is_distinct, np.ones(len(numbers), np.bool_), False),
        (found.names, names, -1),
        (found.signs, signs, 0),
    ):
        rows = np.full((len(loaded.points), *values.shape[1:]), default, column.dtype.base)
        rows[numbers] = values
        loaded.write(column, rows)
    return total, thin(edges)


def _orient(
    found: TiledNormals,
    points: Column,
    cloud: TiledCloud,
    edges: npt.NDArray[np.void],
    orientation: Orientation,
    given: Column | None,
) -> tuple[TiledNormals, dict[str, int]]:
    """Give all normals the signs that `orient_normals` gives them."""
    components = _join(found, edges)
    votes = ComponentVotes(orientation, cloud.dimension, components.count)
    for distinct, places, areas, names in found.parts(points, found.areas, found.names):
        labels, _ = components.look_up(names[distinct])
        votes.add_places(places[distinct].T, areas[distinct], labels)
    # Into a new column: a worker that was given up may still write to that of the tiles.
    oriented = cloud.create(f"oriented_{found.count}", found.normals.dtype)
    read = (points, found.areas, found.names, found.signs, found.normals)
    wanted = () if given is None else (given,)
    start = 0
    for distinct, places, areas, names, signs, normals, *others in found.parts(*read, *wanted):
        labels, relations = components.look_up(names[distinct])
        agreeing = normals[distinct] * (signs[distinct] * relations)[:, np.newaxis]
        normals[distinct] = agreeing
        oriented.write(start, normals)
        start += len(normals)
        theirs = others[0][distinct].T if others else None
        votes.add_votes(places[distinct].T, agreeing.T, areas[distinct], labels, theirs)
    decided = votes.decide()
    start = 0
    for distinct, names, normals, *others in found.parts(found.names, oriented, *wanted):
        labels, _ = components.look_up(names[distinct])
        theirs = others[0][distinct].T if others else None
        normals[distinct] *= decided.flips_of(normals[distinct].T, labels, theirs)[:, np.newaxis]
        oriented.write(start, normals)
        start += len(normals)
    return replace(found, normals=oriented), decided.counts()


@dataclass(frozen=True, eq=False)
class _Components:
    """The component of every name that points were given in their tiles.

    Attributes
    ----------
    names : ndarray of int, shape (k,)
        Increasing.
    labels : ndarray of int, shape (k,)
        Components, from 0.
    signs : ndarray of int8, shape (k,)
        Sign relative to the component's lowest row.
    count : int
        Number of components.
    """

    names: npt.NDArray[np.int64]
    labels: npt.NDArray[np.int64]
    signs: npt.NDArray[np.int8]
    count: int

    def look_up(
        self, names: npt.NDArray[np.int64]
    ) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int8]]:
        places = np.searchsorted(self.names, names)
        return self.labels[places], self.signs[places]


def _join(found: TiledNormals, edges: npt.NDArray[np.void]) -> _Components:
    """Join what was joined in tiles."""
    own, start = [], 0
    for chunk in found.names.chunks():
        own.append(chunk[chunk == np.arange(start, start + len(chunk))])
        start += len(chunk)
    names = np.concatenate(own)
    lowest = names.copy()
    signs = np.ones(len(names), np.int8)
    joined, root_of, sign_of = span(edges)
    places = np.searchsorted(names, joined)
    lowest[places] = root_of
    signs[places] = sign_of
    components, labels = np.unique(lowest, return_inverse=True)
    return _Components(names, labels, signs, len(components))
