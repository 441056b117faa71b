"""Volume and boundary of a union as a sum over the edges of its cells, for any type of number."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from pcsmooth.autodiff.shape import Shape

#: Arrays of floats or dual numbers.
Number = Any


@dataclass(frozen=True)
class Edges:
    """Oriented edges of cells, each a piece of a line in a facet; in 2D the facets themselves.

    Every plane is a facet of the shape around a point, or the bisector of a cell's point and
    another one. The last two planes end the edge.

    Attributes
    ----------
    cells : ndarray of int, shape (m,)
        The point whose cell it is, and from which its planes are seen.
    points : ndarray of int, shape (m, d + 1)
        Points of the planes: facet, in 3D also side, start and stop.
    facets : ndarray of int, shape (m, d + 1)
        Facet of the shape around these points, -1 for bisectors.
    signs : ndarray, shape (m,)
        1 where the facet lies behind the side plane, -1 where it lies in front.
    """

    cells: npt.NDArray[np.int64]
    points: npt.NDArray[np.int64]
    facets: npt.NDArray[np.int64]
    signs: npt.NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of edges."""
        return len(self.cells)

    def __getitem__(self, rows: slice) -> Edges:
        """Select edges."""
        return Edges(self.cells[rows], self.points[rows], self.facets[rows], self.signs[rows])

    @property
    def owners(self) -> npt.NDArray[np.int64]:
        """Points to whose boundary each edge adds, (m,)."""
        owners = self.cells.copy()
        bodies = self.facets[:, 0] >= 0
        owners[bodies] = self.points[bodies, 0]
        return owners

    @property
    def slots(self) -> npt.NDArray[np.int64]:
        """Points on which each edge depends, (m, d + 2), some of them twice."""
        return np.concatenate([self.cells[:, np.newaxis], self.points], axis=1)


class Parts(NamedTuple):
    """What each edge adds.

    Attributes
    ----------
    volumes : array of numbers, shape (m,)
        To the volume of its cell.
    areas : array of numbers, shape (m,)
        To the boundary of its owner.
    """

    volumes: Number
    areas: Number


def parts_of(edges: Edges, positions: Number, shape: Shape) -> Parts:
    """Measure what edges add to volume and boundary.

    Parameters
    ----------
    edges : Edges
        Which planes make them, found beforehand from values alone.
    positions : array of numbers, shape (m, d + 2, d)
        Positions of the points of `Edges.slots`, L.
    shape : Shape
        The ball or polyhedron.

    Returns
    -------
    Parts
        To the boundary of a union of balls has to be added what a whole ball has (see
        `whole_ball`).

    Notes
    -----
    An edge lies in a facet at the height h over the cell's point, at the signed distance s from
    the foot of that height, between a and b along it. Over the foot it spans a triangle of area
    s (b - a) / 2, and over the cell's point a pyramid of h / 3 times that. In a ball of radius r,
    what is farther than rho = sqrt(r^2 - h^2) from the foot is replaced by a sector of angle t,
    of area rho^2 t / 2, seen from the point under the solid angle t (1 - h / r).
    """
    planes = [_plane(edges, positions, shape, k) for k in range(edges.points.shape[1])]
    is_flat = shape.dimension == 2
    line = _line_2d(planes) if is_flat else _line_3d(planes)
    if shape.ball is not None:
        return _disk_parts(line, shape.ball) if is_flat else _ball_parts(line, shape.ball)
    lengths = edges.signs * (line.stop - line.start)
    triangles = line.level * lengths / 2.0
    measures, volumes = (
        (lengths, triangles) if is_flat else (triangles, line.height * triangles / 3.0)
    )
    return Parts(volumes, np.where(edges.facets[:, 0] >= 0, measures, 0.0))


def whole_ball(radius: float, dimension: int) -> tuple[float, float]:
    """Volume and boundary that `parts_of` does not count, of each ball."""
    if dimension == 2:
        return 0.0, 0.0
    return 4.0 * math.pi * radius**3 / 3.0, 4.0 * math.pi * radius**2


class _Plane(NamedTuple):
    normal: list[Number]
    offset: Number


class _Line(NamedTuple):
    height: Number
    level: Number
    start: Number
    stop: Number


def _plane(edges: Edges, positions: Number, shape: Shape, k: int) -> _Plane:
    axes = range(shape.dimension)
    apart = [positions[:, k + 1, c] - positions[:, 0, c] for c in axes]
    facets = edges.facets[:, k]
    bisects = facets < 0
    # the facets of a cell's own point are at no distance, which has no derivative
    distance = np.sqrt(np.where(bisects, _dot(apart, apart), 1.0))
    normals = shape.normals[facets]
    return _Plane(
        [np.where(bisects, apart[c] / distance, normals[:, c]) for c in axes],
        np.where(
            bisects,
            distance / 2.0,
            shape.offsets[facets] + sum(normals[:, c] * apart[c] for c in axes),
        ),
    )


def _line_2d(planes: list[_Plane]) -> _Line:
    (nx, ny), level = planes[0]
    along = [-ny, nx]
    start, stop = (
        (end.offset - level * _dot([nx, ny], end.normal)) / _dot(along, end.normal)
        for end in planes[1:]
    )
    return _Line(0.0, level, start, stop)


def _line_3d(planes: list[_Plane]) -> _Line:
    (normal, height), side, *ends = planes
    across = _cross(normal, side.normal)
    sine = np.sqrt(_dot(across, across))
    along = [x / sine for x in across]
    out = _cross(along, normal)
    level = (side.offset - height * _dot(normal, side.normal)) / sine
    start, stop = (
        (end.offset - height * _dot(normal, end.normal) - level * _dot(out, end.normal))
        / _dot(along, end.normal)
        for end in ends
    )
    return _Line(height, level, start, stop)


def _disk_parts(line: _Line, radius: float) -> Parts:
    first, last, sector = _in_disk(line, radius * radius)
    return Parts(line.level * (last - first) / 2.0 + radius**2 * sector / 2.0, radius * sector)


def _ball_parts(line: _Line, radius: float) -> Parts:
    height, level = line.height, line.level
    rim = radius * radius - height * height
    first, last, sector = _in_disk(line, rim)
    area = level * (last - first) / 2.0 + rim * sector / 2.0
    angle = (
        _angle_over(height, level, last)
        - _angle_over(height, level, first)
        + sector * (1.0 - height / radius)
    )
    visible = -radius * radius * angle
    return Parts((radius * visible + height * area) / 3.0, visible)


def _in_disk(line: _Line, rim: Number) -> tuple[Number, Number, Number]:
    """Find the part of a line within sqrt(rim) of the foot, and the angle of what is beyond."""
    square = rim - line.level * line.level
    meets = square > 0.0
    half = np.where(meets, np.sqrt(np.where(meets, square, 1.0)), 0.0)
    first, last = (np.minimum(np.maximum(x, -half), half) for x in (line.start, line.stop))
    sector = (
        _turn(line.level, line.stop)
        - _turn(line.level, last)
        + _turn(line.level, first)
        - _turn(line.level, line.start)
    )
    return first, last, sector


def _turn(level: Number, x: Number) -> Number:
    """Angle at the foot from the nearest point of a line at a signed distance to x along it."""
    side = np.where(level < 0.0, -1.0, 1.0)
    return np.arctan2(side * x, side * level)


def _angle_over(height: Number, level: Number, x: Number) -> Number:
    """Solid angle of the triangle of the foot, the line's nearest point and x, from a height."""
    side = np.where(level < 0.0, -1.0, 1.0)
    distance = np.sqrt(height * height + level * level + x * x)
    return _turn(level, x) - np.arctan2(side * height * x, side * level * distance)


def _dot(a: list[Number], b: list[Number]) -> Number:
    return sum(x * y for x, y in zip(a, b, strict=True))


def _cross(a: list[Number], b: list[Number]) -> list[Number]:
    return [a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)]
