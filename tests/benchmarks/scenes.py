"""Scenes made of shapes, where rays meet them, and how far points are from their surface.

A shape gives signed distances, negative within it. That of a scene is the least of its shapes'.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Protocol

import numpy as np
from surface_distances import Array

Vector = tuple[float, float, float]
_NEAR = 1e-6  #: a ray has met a surface that is nearer than that share of its way
_STEPS = 400  #: of a ray, at most
_STEP = 1e-5  #: of the differences that give normals, L


class Shape(Protocol):
    """What a scene is made of."""

    def distances(self, points: Array) -> Array:
        """Signed distances of points (n, 3), (n,), or less."""

    def edge_distances(self, points: Array) -> Array:
        """Distances of points (n, 3) to the nearest sharp edge, (n,)."""


Scene = Sequence[Shape]


@dataclass(frozen=True)
class Smooth:
    """A shape without sharp edges."""

    def edge_distances(self, points: Array) -> Array:
        """Give infinity."""
        return np.full(len(points), np.inf)


@dataclass(frozen=True)
class Ball(Smooth):
    """A ball."""

    center: Vector
    radius: float

    def distances(self, points: Array) -> Array:
        """Distance to the centre, less the radius."""
        return np.asarray(np.linalg.norm(points - self.center, axis=1) - self.radius)


@dataclass(frozen=True)
class Column(Smooth):
    """A vertical cylinder without an end."""

    x: float
    y: float
    radius: float

    def distances(self, points: Array) -> Array:
        """Distance to the axis, less the radius."""
        return np.asarray(np.hypot(points[:, 0] - self.x, points[:, 1] - self.y) - self.radius)


@dataclass(frozen=True)
class Ground(Smooth):
    """Ground around z = 0, with waves: height, length and direction in radians of each."""

    waves: tuple[Vector, ...] = ()

    def distances(self, points: Array) -> Array:
        """Height over it times the cosine of the steepest slope: no more than the distance."""
        steepest = sum(height * 2.0 * np.pi / length for height, length, _ in self.waves)
        heights = points[:, 2].copy()
        for height, length, direction in self.waves:
            along = np.cos(direction) * points[:, 0] + np.sin(direction) * points[:, 1]
            heights -= height * np.sin(2.0 * np.pi / length * along)
        return np.asarray(heights / np.hypot(1.0, steepest))


@dataclass(frozen=True)
class Box:
    """A box, turned around the vertical by an angle in radians.

    If it is hollow, it is a room: what is outside of it is solid.
    """

    center: Vector
    half: Vector
    angle: float = 0.0
    hollow: bool = False

    def _local(self, points: Array) -> Array:
        """How far points are beyond each pair of faces."""
        x, y, z = (points - self.center).T
        cosine, sine = np.cos(self.angle), np.sin(self.angle)
        local = np.stack([cosine * x + sine * y, cosine * y - sine * x, z], axis=1)
        return np.asarray(np.abs(local) - self.half)

    def distances(self, points: Array) -> Array:
        """Distance to the nearest face, edge or corner."""
        beyond = self._local(points)
        outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
        found = outside + np.minimum(beyond.max(axis=1), 0.0)
        return np.asarray(-found if self.hollow else found)

    def edge_distances(self, points: Array) -> Array:
        """Distance to the nearest of the twelve."""
        beyond = self._local(points)
        past = np.maximum(beyond, 0.0)
        found = [
            np.hypot(np.hypot(beyond[:, i], beyond[:, j]), past[:, 3 - i - j])
            for i, j in combinations(range(3), 2)
        ]
        return np.asarray(np.min(found, axis=0))


def signed_distances(scene: Scene, points: Array) -> Array:
    """Signed distances of points (n, 3) to the nearest surface, (n,)."""
    return np.asarray(np.min([shape.distances(points) for shape in scene], axis=0))


def edge_distances(scene: Scene, points: Array) -> Array:
    """Distances of points (n, 3) to the nearest sharp edge, (n,)."""
    return np.asarray(np.min([shape.edge_distances(points) for shape in scene], axis=0))


def gradients(scene: Scene, points: Array) -> Array:
    """Gradients of the signed distance at points (n, 3): nearly unit normals, but of ground."""
    sides = [
        [signed_distances(scene, points + sign * step) for sign in (1.0, -1.0)]
        for step in _STEP * np.eye(3)
    ]
    return np.stack([(there - back) / (2.0 * _STEP) for there, back in sides], axis=1)


def ways_to(scene: Scene, origins: Array, directions: Array, farthest: float) -> Array:
    """How long rays are from origins to the surface, (n,): infinite if they meet none so near.

    Each takes steps as long as it is far from the surface.
    """
    ways = np.zeros(len(directions))
    going = np.arange(len(directions))
    for _ in range(_STEPS):
        reached = origins[going] + ways[going, np.newaxis] * directions[going]
        steps = signed_distances(scene, reached)
        ways[going] += steps
        going = going[(steps > _NEAR * (1.0 + ways[going])) & (ways[going] < farthest)]
    ways[going] = np.inf
    ways[ways >= farthest] = np.inf
    return ways
