"""Edges of the boundary of a union of convex polyhedra, found line by line."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from pcsmooth.autodiff.cell_edges import Row, edges_of_rows
from pcsmooth.autodiff.edge_sums import Edges
from pcsmooth.autodiff.polytopes import intersect_half_spaces
from pcsmooth.autodiff.shape import Shape

Array = npt.NDArray[np.float64]

#: How much the bodies are inflated for decisions, over their size: the first by x, y, z the most,
#: so that it owns what several bodies share.
_INFLATION = 1e-9

#: How far a facet must be inside another body to be out of the question, over their size.
_CLEAR = 1e-6

#: Products of unit vectors below this are those of vectors at right angles.
_FLAT = 1e-10


def visible_edges(points: Array, shape: Shape) -> Edges:
    """List the pieces of lines that bound what is visible of each facet of each body.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Distinct points, L.
    shape : Shape
        The polyhedron.

    Returns
    -------
    Edges
        In 2D visible pieces of the facets themselves; in 3D pieces of the edges of a facet, and,
        with the sign -1, of the edges of the holes that other bodies make in it.
    """
    body = intersect_half_spaces(shape.normals, shape.offsets)
    assert body is not None  # the origin is inside
    size = float(np.linalg.norm(body.corners, axis=1).max())
    rank = np.empty(len(points))
    rank[np.lexsort(points.T[::-1])] = np.arange(len(points))
    inflation = _INFLATION * size * (1.0 - rank / len(points))
    corners = [
        body.corners[[facet in planes for planes in body.planes]]
        for facet in range(len(shape.normals))
    ]
    tree = cKDTree(points)
    rows: list[Row] = []
    for i, point in enumerate(points):
        near = np.array([i, *(j for j in tree.query_ball_point(point, 2.0 * size) if j != i)])
        offsets = (
            (points[near] - point) @ shape.normals.T + shape.offsets + inflation[near, np.newaxis]
        )
        clearly_inside = offsets[1:, np.newaxis] - _CLEAR * size
        for facet, ends in enumerate(corners):
            if (ends @ shape.normals.T < clearly_inside).all(axis=(1, 2)).any():
                continue  # one body covers it all
            for planes, sign in _Facet(shape.normals, offsets, facet).pieces():
                labels = [(int(near[member]), plane) for member, plane in planes]
                rows.append((0, labels, sign))
    return edges_of_rows(rows, shape.dimension)


Plane = tuple[int, int]


@dataclass(frozen=True)
class _Facet:
    """A facet of the first of some bodies, normals x <= offsets[body].

    Attributes
    ----------
    normals : ndarray, shape (F, d)
        Unit normals of all bodies.
    offsets : ndarray, shape (B, F)
        Their offsets.
    facet : int
        Number of the facet of body 0.
    """

    normals: Array
    offsets: Array
    facet: int

    def pieces(self) -> Iterator[tuple[list[Plane], float]]:
        """List pieces of the boundary of what is visible: their planes, as in `Edges`, and sign."""
        own = (0, self.facet)
        normal = self.normals[self.facet]
        if len(normal) == 2:
            base, along = self.offsets[own] * normal, np.array([-normal[1], normal[0]])
            for ends in self._uncovered(base, along, own, own):
                yield [own, *ends], 1.0
            return
        # bodies that end below the plane cover nothing of it
        above = np.flatnonzero(self.offsets[:, self.facet] >= self.offsets[own])
        across = np.cross(normal, self.normals)
        sines = np.linalg.norm(across, axis=1)
        crossing = np.flatnonzero(sines > _FLAT)
        bodies, planes = (grid.ravel() for grid in np.meshgrid(above, crossing, indexing="ij"))
        alongs = (across / np.maximum(sines, _FLAT)[:, np.newaxis])[planes]
        levels = self.offsets[bodies, planes] - self.offsets[own] * (self.normals @ normal)[planes]
        levels /= sines[planes]
        bases = self.offsets[own] * normal + levels[:, np.newaxis] * np.cross(alongs, normal)
        for k in self._crossing(bases, alongs, bodies, planes):
            side = (int(bodies[k]), int(planes[k]))
            for ends in self._uncovered(bases[k], alongs[k], own, side):
                yield [own, side, *ends], 1.0 if side[0] == 0 else -1.0

    def _crossing(
        self,
        bases: Array,
        alongs: Array,
        bodies: npt.NDArray[np.int64],
        planes: npt.NDArray[np.int64],
    ) -> npt.NDArray[np.int64]:
        """Lines that are in this facet, and in the facet of the other body, somewhere."""
        lines, edges = np.arange(len(bases)), np.flatnonzero(bodies == 0)
        rates, levels = alongs @ self.normals.T, bases @ self.normals.T
        here, there = self.offsets[0] - levels, self.offsets[bodies] - levels
        here[:, self.facet] = np.inf
        there[lines, planes] = np.inf
        here[edges, planes[edges]] = np.inf
        there[edges, self.facet] = np.inf
        first, second = _spans(rates, here), _spans(rates, there)
        starts = np.maximum(first.starts, second.starts)
        return np.flatnonzero(starts < np.minimum(first.stops, second.stops))

    def _uncovered(
        self, base: Array, along: Array, own: Plane, side: Plane
    ) -> Iterator[tuple[Plane, Plane]]:
        """Planes that end each piece of a line in two facets that no third body covers."""
        rooms = self.offsets - self.normals @ base
        rooms[own] = rooms[side] = np.inf
        spans = _spans(self.normals @ along, rooms)
        inside = {own[0], side[0]}
        first = max(inside, key=lambda body: spans.starts[body])
        last = min(inside, key=lambda body: spans.stops[body])
        x, end = spans.starts[first], spans.stops[last]
        start = (first, int(spans.starting[first]))
        covers = (spans.starts < spans.stops) & (spans.stops > x) & (spans.starts < end)
        covers[list(inside)] = False
        others = np.flatnonzero(covers)
        for body in others[np.argsort(spans.starts[others], kind="stable")]:
            if spans.starts[body] > x:
                yield start, (int(body), int(spans.starting[body]))
            if spans.stops[body] > x:
                x = spans.stops[body]
                start = (int(body), int(spans.stopping[body]))
        if x < end:
            yield start, (last, int(spans.stopping[last]))


@dataclass(frozen=True)
class _Spans:
    """Where lines enter and leave bodies, and through which facets."""

    starts: Array
    stops: Array
    starting: npt.NDArray[np.int64]
    stopping: npt.NDArray[np.int64]


def _spans(rates: Array, rooms: Array) -> _Spans:
    """Intersect lines with bodies: x rates <= rooms, each (..., F)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        reached = rooms / rates
    starts = np.where(rates < -_FLAT, reached, -np.inf)
    stops = np.where(rates > _FLAT, reached, np.inf)
    misses = ((np.abs(rates) <= _FLAT) & (rooms < 0.0)).any(axis=-1)
    return _Spans(
        starts.max(axis=-1),
        np.where(misses, -np.inf, stops.min(axis=-1)),
        starts.argmax(axis=-1),
        stops.argmin(axis=-1),
    )
