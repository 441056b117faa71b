"""A convex polygon or polyhedron around the origin, the unit ball of a polyhedral norm."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, Self

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from pcsmooth.bodies.half_spaces import corners
from pcsmooth.bodies.hull_planes import hull_planes
from pcsmooth.bodies.unit_normals import unit_normals
from pcsmooth.errors import InvalidInputError
from pcsmooth.real_numbers import real_array

#: What is nearer than this, over the size of the body, is one: normals, vertices, planes.
TOLERANCE = 1e-9

#: Sizes of bodies: products of several are to be floats.
_SMALLEST, _LARGEST = 1e-30, 1e30

#: Vectors whose products with all rows are held at a time.
_AT_ONCE = 4096


@dataclass(frozen=True, init=False, eq=False, repr=False)
class ConvexBody:
    """A bounded intersection of half-spaces in 2D or 3D with the origin strictly inside.

    K = {x : normals x <= offsets} is the unit ball of `norm`, which is symmetric only if K is.
    All arrays are read-only.

    Parameters
    ----------
    normals : array_like of float, shape (F, d)
        Outward normals of the facets, d = 2 or 3; not zero, of any length.
    offsets : float or array_like of float, shape (F,)
        Right-hand sides, > 0, one for all or for each; they shrink with the normals to unit
        length.
    tolerance : float
        How near, over the circumradius, vertices must be to be one, and normals to be opposite.

    Attributes
    ----------
    normals : ndarray, shape (F, d)
        Unit normals. Opposite ones are exact negatives of each other.
    offsets : ndarray, shape (F,)
        Distances of the facets from the origin, L.
    vertices : ndarray, shape (V, d)
        Corners, L.
    facets : tuple of F tuples of int
        Numbers of the vertices of each facet, counter-clockwise seen from outside; in 2D the two
        ends, counter-clockwise around the body.
    is_symmetric : bool
        Whether K = -K, so that `norm` is a norm.

    Raises
    ------
    InvalidInputError
        If an array has the wrong shape or a value that is not finite; a normal is zero; an offset
        is not positive (the origin is not inside); two half-spaces are the same; one bounds no
        part of the body; there are fewer than d + 1; or the body is unbounded.

    Examples
    --------
    >>> diamond = ConvexBody([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    >>> len(diamond.vertices), diamond.is_symmetric, round(diamond.volume, 12)
    (4, True, 2.0)
    >>> round(diamond.norm([3.0, -4.0]), 12)
    7.0
    """

    normals: npt.NDArray[np.float64]
    offsets: npt.NDArray[np.float64]
    vertices: npt.NDArray[np.float64]
    facets: tuple[tuple[int, ...], ...]
    is_symmetric: bool

    def __init__(
        self, normals: npt.ArrayLike, offsets: npt.ArrayLike = 1.0, *, tolerance: float = TOLERANCE
    ) -> None:
        unit, distances = _unit_half_spaces(_as_rows(normals, "normals"), offsets)
        pairs = cKDTree(unit).query_pairs(TOLERANCE)
        for first, second in sorted(pairs)[:1]:
            raise InvalidInputError(
                f"half-spaces {first} and {second} have the same normal; remove one"
            )
        is_symmetric = _match_opposite(unit, distances, tolerance)
        vertices, facets = corners(unit, distances, tolerance)
        self.__dict__.update(
            normals=_read_only(unit),
            offsets=_read_only(distances),
            vertices=_read_only(vertices),
            facets=facets,
            is_symmetric=is_symmetric,
        )

    @classmethod
    def from_vertices(
        cls, vertices: npt.ArrayLike, *, center: bool = False, tolerance: float = TOLERANCE
    ) -> Self:
        """Make the convex hull of points.

        Parameters
        ----------
        vertices : array_like of float, shape (n, d)
            Points, L; those inside the hull are ignored.
        center : bool
            Whether to move the hull's centre of mass into the origin.
        tolerance : float
            How near a plane, over the size of the body, points must be to be on one facet.

        Returns
        -------
        ConvexBody
            With one facet for each set of coplanar points, and vertices in an order of its own.

        Raises
        ------
        InvalidInputError
            If the points have the wrong shape, are not finite, are fewer than d + 1, lie in a
            plane, or their hull does not have the origin strictly inside.

        Examples
        --------
        >>> kite = ConvexBody.from_vertices([[2, 0], [0, 1], [-1, 0], [0, -1], [0.5, 0.5]])
        >>> len(kite.facets), kite.is_symmetric
        (4, False)
        """
        points = _as_rows(vertices, "vertices")
        _check_sizes(np.abs(points).max(axis=1), "vertex")
        if center:
            points -= points.mean(axis=0)
            points -= cls.from_vertices(points, tolerance=tolerance).centroid
        return cls(*hull_planes(points, tolerance), tolerance=tolerance)

    def __repr__(self) -> str:
        """Name it by its size: its numbers are many."""
        return (
            f"<ConvexBody in {self.dimension}D: {len(self.facets)} facets, "
            f"{len(self.vertices)} vertices>"
        )

    @property
    def dimension(self) -> int:
        """Number of coordinates d."""
        return int(self.normals.shape[1])

    @property
    def inradius(self) -> float:
        """Radius of the largest ball around the origin inside, L."""
        return float(self.offsets.min())

    @cached_property
    def circumradius(self) -> float:
        """Radius of the smallest ball around the origin that holds the body, L."""
        return float(np.linalg.norm(self.vertices, axis=1).max())

    @cached_property
    def simplices(self) -> npt.NDArray[np.int64]:
        """Vertices of the triangles (in 2D edges) that make the facets, (n, d), turned like them.

        They come facet by facet, and those of a facet all start at its first vertex.
        """
        if self.dimension == 2:
            fans = [list(facet) for facet in self.facets]
        else:
            fans = [[facet[0], *pair] for facet in self.facets for pair in pairwise(facet[1:])]
        return _read_only(np.array(fans))

    @cached_property
    def facet_areas(self) -> npt.NDArray[np.float64]:
        """Measures of the facets, (F,), L^(d-1)."""
        edges = np.diff(self.vertices[self.simplices], axis=1)
        if self.dimension == 2:
            sizes = np.linalg.norm(edges[:, 0], axis=1)
        else:
            sizes = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        counts = [len(facet) - self.dimension + 1 for facet in self.facets]
        return _read_only(np.add.reduceat(sizes, np.cumsum([0, *counts[:-1]])))

    @property
    def volume(self) -> float:
        """Volume (area in 2D), L^d."""
        return float(self.offsets @ self.facet_areas) / self.dimension

    @property
    def centroid(self) -> npt.NDArray[np.float64]:
        """Centre of mass, (d,), L."""
        cones = self.vertices[self.simplices]  # from the origin
        volumes = np.linalg.det(cones)
        return np.asarray(volumes @ cones.sum(axis=1) / volumes.sum() / (self.dimension + 1))

    def norm(self, points: npt.ArrayLike) -> Any:
        """Gauge of K, the least t >= 0 with the point in t K: (n, d) -> (n,), (d,) -> float."""
        return self._largest(self.normals / self.offsets[:, None], points)

    def support(self, directions: npt.ArrayLike) -> Any:
        """Largest product of a direction and a point of K: (n, d) -> (n,), (d,) -> float."""
        return self._largest(self.vertices, directions)

    def radial(self, directions: npt.ArrayLike) -> Any:
        """Largest t with t times the direction in K: (n, d) -> (n,), (d,) -> float; 0 -> inf."""
        with np.errstate(divide="ignore"):
            return np.divide(1.0, 0.0 + self.norm(directions))  # no -0

    def scaled(self, factor: npt.ArrayLike) -> ConvexBody:
        """Scale by a factor > 0, or by one for each axis."""
        try:
            factors = np.broadcast_to(real_array(factor, "factors"), self.dimension)
        except ValueError as error:
            raise InvalidInputError(
                f"scale is {factor!r}; it must be a number or {self.dimension} of them"
            ) from error
        if not (np.isfinite(factors).all() and factors.min() > 0.0):
            raise InvalidInputError(f"scale is {factor!r}; it must be finite and positive")
        least = factors.min()
        return ConvexBody(self.normals * (least / factors), self.offsets * least)

    def rotated(self, matrix: npt.ArrayLike) -> ConvexBody:
        """Turn by an orthogonal matrix (d, d), which may mirror too."""
        turn = real_array(matrix, "entries of the rotation")
        if turn.shape != (self.dimension,) * 2:
            raise InvalidInputError(
                f"rotation has shape {turn.shape}; it must be {(self.dimension,) * 2}"
            )
        if not np.allclose(turn @ turn.T, np.eye(self.dimension), rtol=0.0, atol=TOLERANCE):
            raise InvalidInputError("rotation is not orthogonal; its rows must be orthonormal")
        return ConvexBody(self.normals @ turn.T, self.offsets)

    def _largest(self, rows: npt.NDArray[np.float64], vectors: npt.ArrayLike) -> Any:
        """Largest product of each vector with a row."""
        factors = real_array(vectors, "vectors")
        if factors.ndim not in (1, 2) or factors.shape[-1] != self.dimension:
            raise InvalidInputError(
                f"vectors have shape {factors.shape}; they must be (n, {self.dimension}) or "
                f"({self.dimension},)"
            )
        columns = np.atleast_2d(factors).T
        largest = np.empty(columns.shape[1])
        for start in range(0, len(largest), _AT_ONCE):  # for the sake of memory
            part = slice(start, start + _AT_ONCE)
            largest[part] = (rows @ columns[:, part]).max(axis=0)
        return largest if factors.ndim == 2 else float(largest[0])


def _read_only(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    array.flags.writeable = False
    return array


def _as_rows(values: npt.ArrayLike, name: str) -> npt.NDArray[np.float64]:
    """Copy normals or vertices into a new array, d + 1 rows or more."""
    rows = real_array(values, name)
    if rows.ndim != 2 or rows.shape[1] not in (2, 3):
        raise InvalidInputError(f"{name} have shape {rows.shape}; they must be (n, 2) or (n, 3)")
    for bad in np.flatnonzero(~np.isfinite(rows).all(axis=1))[:1]:
        raise InvalidInputError(f"{name}: row {bad} is not finite; remove it")
    if len(rows) <= rows.shape[1]:
        raise InvalidInputError(
            f"there are {len(rows)} {name}; a body in {rows.shape[1]}D needs at least "
            f"{rows.shape[1] + 1}"
        )
    return rows


def _check_sizes(sizes: npt.NDArray[np.float64], name: str) -> None:
    """Raise `InvalidInputError` if a body is too large or small to be measured."""
    largest = int(np.abs(sizes).argmax())
    if not _SMALLEST <= abs(sizes[largest]) <= _LARGEST:
        raise InvalidInputError(
            f"{name} {largest} is of size {abs(sizes[largest]):g}, and bodies are from "
            f"{_SMALLEST:g} to {_LARGEST:g} large; scale it"
        )


def _unit_half_spaces(
    normals: npt.NDArray[np.float64], offsets: npt.ArrayLike
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Check half-spaces and give their normals unit length."""
    distances = real_array(offsets, "offsets")
    if distances.ndim == 0:
        distances = np.full(len(normals), distances)
    if distances.shape != (len(normals),):
        raise InvalidInputError(
            f"offsets have shape {distances.shape}; {len(normals)} normals need ({len(normals)},)"
        )
    for zero in np.flatnonzero(~normals.any(axis=1))[:1]:
        raise InvalidInputError(f"normal {zero} is zero; give it a direction")
    unit, lengths = unit_normals(normals)
    distances /= lengths
    for bad in np.flatnonzero(~np.isfinite(distances))[:1]:
        raise InvalidInputError(f"offset {bad} is not finite; give it a value")
    _check_sizes(distances, "offset")
    for bad in np.flatnonzero(distances <= TOLERANCE * distances.max())[:1]:
        raise InvalidInputError(
            f"offset {bad} is {distances[bad]:g}, but the origin must lie strictly inside the "
            "body; move or center it"
        )
    return unit, distances


def _match_opposite(
    normals: npt.NDArray[np.float64], offsets: npt.NDArray[np.float64], tolerance: float
) -> bool:
    """Make opposite half-spaces exactly so, in place; say whether every one has its opposite."""
    apart, opposite = cKDTree(normals).query(-normals)
    later = np.flatnonzero((apart <= tolerance) & (opposite < np.arange(len(normals))))
    normals[later] = 0.0 - normals[opposite[later]]  # no -0
    equal = np.abs(offsets[later] - offsets[opposite[later]]) <= tolerance * offsets[later]
    offsets[later[equal]] = offsets[opposite[later[equal]]]
    return bool(2 * np.count_nonzero(equal) == len(normals))
