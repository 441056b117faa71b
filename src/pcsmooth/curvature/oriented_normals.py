"""Cell normals of a cloud in parts, with signs that agree across them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import extent_of_even_points, find_cell_normals
from pcsmooth.curvature.component_votes import ComponentVotes
from pcsmooth.curvature.components import Components, join_in_part, join_parts, links_reach
from pcsmooth.curvature.orientation import Orientation
from pcsmooth.energies.balls import centers_of
from pcsmooth.energies.cell_reach import cell_reach
from pcsmooth.energies.on_parts import Totals, balls_of, evaluate
from pcsmooth.energies.protocol import Energy
from pcsmooth.parts.cloud_state import CloudState
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts, Reach
from pcsmooth.parts.streamed_median import streamed_median
from pcsmooth.unit_of_length import unit_near

#: Name under which parts remember the order of their points.
CENTERS = "centers of estimates"


@dataclass(frozen=True, eq=False)
class OrientedNormals:
    """Cell normals of a cloud in parts: see `CellNormals`.

    Attributes
    ----------
    normals, anchors : Column
        Unit normals and where they hold, (d,).
    weights : Column
        Volume of the cell; 0 for a point that is not the first at its position, as all the rest.
    is_distinct : Column
        Whether the point is the first at its position.
    count : int
        Points whose cells give a normal.
    distinct : int
        Number of distinct points.
    extent : float
        Median radius of the neighbourhoods, L; of balls of local radius that of even points, in
        local spacings.
    reasons : dict of str to int
        How many components got their sign for which reason; those without normals do not count.
    """

    normals: Column
    anchors: Column
    weights: Column
    is_distinct: Column
    count: int
    distinct: int
    extent: float
    reasons: dict[str, int]

    def drop(self, parts: Parts) -> None:
        """Remove the columns."""
        names = ("oriented", "anchors", "weights", "is_distinct")
        parts.drop(*(f"{name}_{self.count}" for name in names))


@dataclass(frozen=True, eq=False)
class _Columns:
    """What is found in parts, of each point that is the first at its position, else 0.

    Unit normals of either sign and where they hold, (d,); cell volumes, visible areas, squared
    radii of the neighbourhoods; whether a point is the first at its position; the lowest row among
    the points that each has been joined to in its part, -1 for none, and the sign of the normal
    relative to that point's.
    """

    normals: Column
    anchors: Column
    weights: Column
    areas: Column
    squares: Column
    is_distinct: Column
    names: Column
    signs: Column

    def chunks(self, *columns: Column) -> Iterator[tuple[npt.NDArray[Any], ...]]:
        """Read columns chunk by chunk, after the marks of distinct points."""
        return zip(*(column.chunks() for column in (self.is_distinct, *columns)), strict=True)


def find_oriented_normals(
    parts: Parts, state: CloudState, energy: Energy, count: int, orientation: Orientation
) -> tuple[OrientedNormals, list[Totals]]:
    """Find the cell normals of all points; neighbours agree, components look where they should.

    Parameters
    ----------
    parts : Parts
        The cloud.
    state : CloudState
        Where it is.
    energy : Energy
        Whose value is to be told; balls have its radius.
    count : int
        Points whose cells give a normal.
    orientation : Orientation
        The rule; a viewpoint is seen from the cloud's origin, in its unit.

    Returns
    -------
    normals : OrientedNormals
        With signs.
    totals : list of Totals
        The energy of the parts.

    Notes
    -----
    First neighbours are made to agree (see `join_parts`). Then each connected component gets one
    sign:

    - outward: that for which sum a_i (p_i - c) . n_i, c the centroid, is positive, which by the
      divergence theorem is outward;
    - viewpoint, direction: that for which most of its area looks there;
    - propagate: that for which the normal at its last point along the last axis looks up;
    - input: points have the sign of the input's normal, those without one follow the majority;
    - auto: as the input where that has normals. Else outward, but where the normals' mean is
      longer than a quarter and the flux is below a quarter of sum a_i abs(p_i - c), the
      component is an open sheet, such as a terrain: its normals look along the positive
      direction of the axis that their mean is nearest to.

    Where a rule leaves the sign open, but for rounding, the lowest row keeps its normal.
    """

    def create(name: str, dtype: npt.DTypeLike) -> Column:
        return parts.create(f"{name}_{count}", dtype)

    vector = parts.start.dtype
    found = _Columns(
        normals=create("normals", vector),
        anchors=create("anchors", vector),
        weights=create("weights", np.float64),
        areas=create("areas", np.float64),
        squares=create("squares", np.float64),
        is_distinct=create("is_distinct", np.bool_),
        names=create("names", np.int64),
        signs=create("signs", np.int8),
    )
    step = _FindNormals(energy, state.box, count, found)
    totals, edges, distinct = [], [], 0
    for total, more, number in parts.map("normals", step, state.points, state.drift):
        totals.append(total)
        edges.append(more)
        distinct += number

    def squares() -> Iterator[npt.NDArray[np.float64]]:
        return (values[chosen] for chosen, values in found.chunks(found.squares))

    if energy.local is None:
        extent = math.sqrt(streamed_median(squares))
    else:
        extent = extent_of_even_points(count, parts.dimension)
    components = join_parts(found.names, edges)
    oriented, reasons = _orient(parts, state.points, found, components, orientation, count)
    parts.drop(*(f"{name}_{count}" for name in ("normals", "areas", "squares", "names", "signs")))
    normals = OrientedNormals(
        oriented, found.anchors, found.weights, found.is_distinct, count, distinct, extent, reasons
    )
    return normals, totals


@dataclass(frozen=True, eq=False)
class _FindNormals:
    """Find the cell normals of a part, and the lightest links between what is alike.

    Gives the energy, the links, and how many of the own points are the first at their position.
    """

    energy: Energy
    box: npt.NDArray[np.float64]
    count: int
    found: _Columns

    @property
    def reach(self) -> float | Reach:
        """As far as cells, normals and links look, one after the other."""
        dimension, radius = self.box.shape[1], self.energy.radius
        of_energy = self.energy.reach(dimension)
        if not isinstance(of_energy, float):
            return of_energy
        return max(of_energy, cell_reach(radius, dimension) + links_reach(radius, dimension))

    def __call__(self, part: Part) -> tuple[Totals, npt.NDArray[np.void], int]:
        evaluation = evaluate(part, self.energy, self.box)
        union = balls_of(part, evaluation, self.box)
        numbers, dimension, radius = union.numbers, union.dimension, union.radius
        cells = find_cell_normals(
            union.grid, numbers, union, dimension, self.count, union.grid_reaches
        )
        joined = join_in_part(part, union, cells)
        part.remember(CENTERS, lambda: centers_of(union))
        # Only their shares matter.
        areas = union.visible_areas[numbers] / unit_near(radius) ** (dimension - 1)
        found = self.found
        is_distinct = np.zeros(len(part.points), np.bool_)
        is_distinct[numbers] = True
        part.write(found.is_distinct, is_distinct)
        for column, values, default in (
            (found.normals, cells.normals[:dimension].T, 0.0),
            (found.anchors, cells.anchors[:dimension].T, 0.0),
            (found.weights, cells.weights, 0.0),
            (found.areas, areas, 0.0),
            (found.squares, cells.squares, 0.0),
            (found.names, joined.names, -1),
            (found.signs, joined.signs, 0),
        ):
            rows = np.full((len(part.points), *values.shape[1:]), default, column.dtype.base)
            rows[numbers] = values
            part.write(column, rows)
        own = int(np.count_nonzero(is_distinct[part.own]))
        return Totals.of(part, evaluation), joined.edges, own


def _orient(
    parts: Parts,
    points: Column,
    found: _Columns,
    components: Components,
    orientation: Orientation,
    count: int,
) -> tuple[Column, dict[str, int]]:
    """Give all normals their signs, in a new column; tell for which reasons."""
    votes = ComponentVotes(orientation, parts.dimension, components.count)
    for distinct, places, areas, names in found.chunks(points, found.areas, found.names):
        labels, _ = components.look_up(names[distinct])
        votes.add_places(places[distinct], areas[distinct], labels)
    # Into a new column: late workers may still write to that of the parts.
    oriented = parts.create(f"oriented_{count}", found.normals.dtype)
    read = (points, found.areas, found.names, found.signs, found.normals)
    wanted = () if parts.given is None else (parts.given,)
    start = 0
    for distinct, places, areas, names, signs, normals, *others in found.chunks(*read, *wanted):
        labels, relations = components.look_up(names[distinct])
        agreeing = normals[distinct] * (signs[distinct] * relations)[:, np.newaxis]
        _write_chosen(oriented, start, distinct, agreeing)
        start += len(distinct)
        theirs = others[0][distinct] if others else None
        votes.add_votes(places[distinct], agreeing, areas[distinct], labels, theirs)
    decided = votes.decide()
    start = 0
    for distinct, names, normals, *others in found.chunks(found.names, oriented, *wanted):
        labels, _ = components.look_up(names[distinct])
        theirs = others[0][distinct] if others else None
        chosen = normals[distinct]
        chosen *= decided.flips_of(chosen, labels, theirs)[:, np.newaxis]
        _write_chosen(oriented, start, distinct, chosen)
        start += len(distinct)
    return oriented, decided.counts()


def _write_chosen(
    column: Column, start: int, chosen: npt.NDArray[np.bool_], values: npt.NDArray[np.float64]
) -> None:
    """Write values (k, d) of the chosen rows of a chunk, (m,); zeros into the others."""
    if len(values) < len(chosen):
        rows = np.zeros((len(chosen), values.shape[1]))
        rows[chosen] = values
        values = rows
    column.write(start, values)
