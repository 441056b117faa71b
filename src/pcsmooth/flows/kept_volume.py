"""Steps that keep the volume that each connected component of a cloud encloses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import CellNormals
from pcsmooth.curvature.components import join_in_part, join_parts, links_reach
from pcsmooth.energies.on_parts import BALLS, EVALUATION, Totals
from pcsmooth.flows.restraint import Restraint
from pcsmooth.flows.wanted_step import WantingStep
from pcsmooth.kernels.surface.component_sums import add_terms
from pcsmooth.parts.cloud_state import CloudState, Moves
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts, Reach


def keep_volume(
    parts: Parts,
    state: CloudState,
    wanted: WantingStep,
    restraint: Restraint,
    target: Column,
    stage: str,
) -> list[tuple[Totals, Moves]]:
    """Take a step without its mean normal displacement in each connected component.

    Parameters
    ----------
    parts : Parts
        The cloud.
    state : CloudState
        Where it is.
    wanted : WantingStep
        What is wanted.
    restraint : Restraint
        How else the points may move.
    target : Column
        Gets the new positions, L.
    stage : str
        What the step is called.

    Returns
    -------
    list of (Totals, Moves)
        Of the parts.

    Notes
    -----
    Each point is weighted by its share of the surface, the mean cell of its 8 to 10 nearest: its
    own is larger for points that noise has moved to the outside of a bend, which are those to move
    in. The volume that a closed component encloses then changes only by terms of second order.

    Sums over components go over the points in the order of their rows, whatever the parts.
    """
    vector = parts.start.dtype
    columns = _Columns(
        vectors=parts.create("vectors", vector),
        normals=parts.create("step_normals", vector),
        shares=parts.create("shares", np.float64),
        names=parts.create("step_names", np.int64),
        held=parts.create("held", np.bool_),
    )
    first = _Want(wanted, restraint, columns)
    found = list(parts.map(stage, first, state.points, state.drift))
    parts.forget(EVALUATION, BALLS)
    components = join_parts(columns.names, (edges for _, _, _, edges in found))
    totals, ways = np.zeros(components.count), np.zeros(components.count)
    absolute = np.zeros(components.count)
    chunks = zip(
        *(column.chunks() for column in (columns.names, columns.shares, columns.vectors,
                                         columns.normals)),
        strict=True,
    )  # fmt: skip
    for names, shares, vectors, normals in chunks:
        chosen = np.flatnonzero(shares)
        labels, signs = components.look_up(names[chosen])
        along = np.einsum("ij,ij->i", vectors[chosen], normals[chosen]) * signs
        shares = shares[chosen]
        add_terms(np.ones(len(chosen)), shares, labels, totals, absolute)
        add_terms(along, shares, labels, ways, absolute)
    means = np.divide(ways, totals, out=ways, where=totals > 0.0)
    by_name: npt.NDArray[np.float64] = means[components.labels] * components.signs
    second = _TakeOut(columns, components.names, by_name, restraint, parts.start, target)
    moves = parts.map(f"{stage}: volume", second, state.points, state.drift)
    taken = [
        (total, move.solved(iterations, error))
        for (total, iterations, error, _), move in zip(found, moves, strict=True)
    ]
    parts.drop("vectors", "step_normals", "shares", "step_names", "held")
    return taken


@dataclass(frozen=True, eq=False)
class _Columns:
    """What a step wants, of all points, coincident ones the same.

    Displacements and unit normals, (d,), L; shares of the surface, 0 for points that are held or
    not the first at their position; names of what points have been joined to in their part, with
    whose normals theirs agree, -1 where there is no cell; and which points are held.
    """

    vectors: Column
    normals: Column
    shares: Column
    names: Column
    held: Column


@dataclass(frozen=True, eq=False)
class _Want:
    """Find what a step wants; gives the energy, what the solver did, and links between names."""

    wanted: WantingStep
    restraint: Restraint
    columns: _Columns

    @property
    def reach(self) -> float | Reach:
        """As far as scheme, normals and links look, one after the other."""
        radius = self.wanted.radius
        dimension = self.wanted.box.shape[1]
        return self.wanted.reach + self.restraint.reach(radius) + links_reach(radius, dimension)

    def __call__(self, part: Part) -> tuple[Totals, int, float, npt.NDArray[np.void]]:
        found = self.wanted.find(part)
        union = found.state.balls
        numbers, carriers, dimension = union.numbers, union.carriers, union.dimension
        cells = self.restraint.normals_of(union)
        vectors = self.restraint.along(found.vectors, union, cells)
        joined = join_in_part(part, union, cells)
        normals = np.zeros_like(vectors)
        normals[numbers] = (cells.normals[:dimension] * joined.signs).T
        names = np.full(len(carriers), -1)
        names[numbers] = joined.names
        shares = np.zeros(len(carriers))
        shares[numbers] = np.where(found.held[numbers], 0.0, _mean_over_links(cells))
        part.write(self.columns.vectors, vectors)
        part.write(self.columns.normals, normals[carriers])
        part.write(self.columns.shares, shares)
        part.write(self.columns.names, names[carriers])
        part.write(self.columns.held, found.held)
        totals = Totals.of(part, found.state.evaluation)
        return totals, found.iterations, found.error, joined.edges


@dataclass(frozen=True, eq=False)
class _TakeOut:
    """Take the mean displacement along the normal of each name out, and move the own points."""

    columns: _Columns
    names: npt.NDArray[np.int64]
    means: npt.NDArray[np.float64]
    restraint: Restraint
    start: Column
    target: Column

    reach = 0.0

    def __call__(self, part: Part) -> Moves:
        columns = self.columns
        held, start = part.read(columns.held), part.read(self.start)
        means = self.means[np.searchsorted(self.names, part.read(columns.names))]
        means = np.where(held, 0.0, means)[:, np.newaxis]
        vectors = part.read(columns.vectors) - means * part.read(columns.normals)
        vectors = self.restraint.shorten(part.points, vectors, held, start)
        moved = part.points + vectors
        part.write(self.target, moved)
        return Moves.of(part, start, moved, vectors, held)


def _mean_over_links(cells: CellNormals) -> npt.NDArray[np.float64]:
    """Mean of the cells' volumes over each point and the nearest others, (n,)."""
    weights = np.append(cells.weights, 0.0)  # there is no point n
    count = 1 + np.count_nonzero(cells.links < len(cells.links), axis=1)
    return np.asarray((cells.weights + weights[cells.links].sum(axis=1)) / count)
