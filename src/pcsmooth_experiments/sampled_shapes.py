"""Curves and surfaces whose measures are known, and points of them, even and random."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

Array = npt.NDArray[np.float64]
Sampling = Literal["even", "random"]

#: Pieces of a profile between which its length or area is integrated.
_PIECES = 200_000

#: Points of the whole shape, for one of the cloud, from which distances to it are taken, by
#: dimension.
_WITNESSES = {2: 100, 3: 10}

#: Largest number of these points.
_MOST_WITNESSES = 1_000_000

_GOLDEN = (1.0 + 5.0**0.5) / 2.0


@dataclass(frozen=True)
class SampledShape:
    """Points of a curve or surface, with what is known there.

    Attributes
    ----------
    points : ndarray, shape (n, d)
        Points exactly on the shape, L.
    normals : ndarray, shape (n, d)
        Outward unit normals.
    principal_curvatures : ndarray, shape (n, d - 1)
        Positive where the shape bends away from the normal, 1/L.
    """

    points: Array
    normals: Array
    principal_curvatures: Array

    @property
    def mean_curvatures(self) -> Array:
        """k1 + k2, in 2D k, (n,), 1/L: the thesis' H (its Definition 7)."""
        return np.asarray(self.principal_curvatures.sum(axis=1))


@dataclass(frozen=True)
class Shape:
    """A closed curve in the plane, or the surface that a curve makes around the z axis.

    The profile is the curve itself (x, y) or, of a surface, (distance from the axis, z).

    Attributes
    ----------
    name : str
        What it is.
    dimension : int
        d, 2 or 3.
    profile : callable
        Parameters t in [0, end] to the profile and its first and second derivatives, each
        (n, 2); counter-clockwise, so that its right side is outside.
    end : float
        Where the parameter ends.
    is_ring : bool
        Whether the profile of a surface is closed, as a torus's is.
    euler_characteristic : int
        Of a surface: 2 of a sphere, 0 of a torus. Of a curve 0.
    reach : float
        Largest radius of a tube that does not meet itself (report, Definition 6), L.
    """

    name: str
    dimension: int
    profile: Callable[[Array], tuple[Array, Array, Array]]
    end: float
    is_ring: bool
    euler_characteristic: int
    reach: float

    @property
    def area(self) -> float:
        """Area, of a curve its length, L^(d-1)."""
        return float(self._shares()[1][-1])

    def tube_volume(self, radius: float) -> float:
        """Volume of all that is nearer than a radius below the reach, L^d.

        By Weyl's formula: 2 r A, of a surface + (2 r^3 / 3) times the integral of k1 k2, which is
        2 pi times the Euler characteristic (report, proof of Proposition 2).
        """
        bend = 2.0 * np.pi * self.euler_characteristic
        return float(2.0 * radius * self.area + 2.0 * radius**3 / 3.0 * bend)

    def sample(self, n_points: int, sampling: Sampling, seed: int = 0) -> SampledShape:
        """Take points of it.

        Parameters
        ----------
        n_points : int
            How many.
        sampling : {"even", "random"}
            Curves: at equal arc lengths, or at random ones. Surfaces: along a spiral with equal
            area from point to point and the golden ratio of a turn (on rings the nearest ratio
            that closes: Fibonacci numbers of points are the most even), or independent of each
            other and uniform by area.
        seed : int
            Of the random numbers.

        Returns
        -------
        SampledShape
        """
        if sampling == "random":
            rng = np.random.default_rng(seed)
            shares, turns = rng.random(n_points), rng.random(n_points)
        else:
            shares = (np.arange(n_points) + 0.5) / n_points
            turn = round(n_points / _GOLDEN) / n_points if self.is_ring else 1.0 / _GOLDEN
            turns = np.arange(n_points, dtype=np.float64) * turn % 1.0
        parameters, sums = self._shares()
        place, first, second = self.profile(np.interp(shares * sums[-1], sums, parameters))
        speed = np.linalg.norm(first, axis=1)
        across = np.stack([first[:, 1], -first[:, 0]], axis=1) / speed[:, np.newaxis]
        bend = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**3
        if self.dimension == 2:
            return SampledShape(place, across, bend[:, np.newaxis])
        around = np.stack([np.cos(2.0 * np.pi * turns), np.sin(2.0 * np.pi * turns)], axis=1)
        return SampledShape(
            np.concatenate([place[:, :1] * around, place[:, 1:]], axis=1),
            np.concatenate([across[:, :1] * around, across[:, 1:]], axis=1),
            np.stack([bend, across[:, 0] / place[:, 0]], axis=1),
        )

    def distances_to(self, points: Array) -> Array:
        """Distances to a cloud from even points of the shape, (m,), L.

        There are 100 of them for each point of a curve, 10 for each of a surface.
        The largest is the least epsilon of which the cloud is an epsilon-sample (report,
        Definition 9), short of it by no more than the distance between these points.
        """
        n_witnesses = min(_WITNESSES[self.dimension] * len(points), _MOST_WITNESSES)
        witnesses = self.sample(n_witnesses, "even").points
        return np.asarray(cKDTree(points).query(witnesses, workers=-1)[0])

    def covering_radius(self, points: Array) -> float:
        """Measure the covering radius epsilon of a cloud, L: see `distances_to`."""
        return float(self.distances_to(points).max())

    def _shares(self) -> tuple[Array, Array]:
        """Length or area of the shape up to each of many parameters."""
        parameters = np.linspace(0.0, self.end, _PIECES + 1)
        middles = (parameters[1:] + parameters[:-1]) / 2.0
        place, first, _ = self.profile(middles)
        circumference = 2.0 * np.pi * place[:, 0] if self.dimension == 3 else np.ones(len(place))
        density = np.linalg.norm(first, axis=1) * circumference
        sums = np.concatenate([[0.0], np.cumsum(density)]) * (self.end / _PIECES)
        return parameters, sums


def _arc(
    center: float, half_axes: tuple[float, float], start: float
) -> Callable[[Array], tuple[Array, Array, Array]]:
    """Ellipse with its centre on the first axis, from an angle on, counter-clockwise."""
    middle, axes = np.array([center, 0.0]), np.array(half_axes)

    def profile(t: Array) -> tuple[Array, Array, Array]:
        along = axes * np.stack([np.cos(t + start), np.sin(t + start)], axis=1)
        first = axes * np.stack([-np.sin(t + start), np.cos(t + start)], axis=1)
        return middle + along, first, -along

    return profile


def ellipse(a: float = 1.0, b: float = 0.6) -> Shape:
    """Ellipse with the half axes a >= b; a circle if they are equal."""
    name = "circle" if a == b else "ellipse"
    return Shape(name, 2, _arc(0.0, (a, b), 0.0), 2.0 * np.pi, True, 0, b * b / a)


def spheroid(a: float = 1.0, c: float = 1.0) -> Shape:
    """Ellipsoid with the half axes a, a, c; a sphere if they are equal."""
    name = "sphere" if a == c else "ellipsoid"
    reach = min(a, c) ** 2 / max(a, c)
    return Shape(name, 3, _arc(0.0, (a, c), -np.pi / 2.0), np.pi, False, 2, reach)


def torus(tube: float = 0.4) -> Shape:
    """Torus around the z axis whose middle circle has the radius 1 and whose tube is thinner."""
    profile = _arc(1.0, (tube, tube), 0.0)
    return Shape("torus", 3, profile, 2.0 * np.pi, True, 0, min(tube, 1.0 - tube))
