"""Every energy as one line of parameters: what is measured, how, and around which points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

import oracles
import polyhedron_oracles as expect
from oracles import Array
from pcsmooth import (
    BallEnergy,
    ConvexBody,
    PolyhedronEnergy,
    PolyhedronUnion,
    measure_polyhedra,
)
from pcsmooth.energies.by_autodiff import AutodiffEnergy
from pcsmooth.energies.protocol import Quantity, UnionMeasures, Weight
from polyhedron_oracles import Rule

#: Coordinates of the clouds are multiples of it: on a map, millions from the origin, they are
#: numbers all the same.
UNIT = 2.0**-28


@dataclass(frozen=True)
class Case:
    """An energy, and its cloud.

    Attributes
    ----------
    shape : str
        "ball", or a body of `polyhedron_oracles`.
    dimension : int
        d.
    rule : str
        How the union of polyhedra is computed; "" of balls.
    kind : str
        "cloud" or "cap" of `polyhedron_oracles.scene`; of balls "cloud" or "surface".
    n : int
        Points of the cloud.
    spacings : float
        Radius of balls in distances between neighbours.
    autodiff : bool
        Whether the gradients are those of the reference.
    """

    shape: str
    dimension: int
    rule: Rule | Any
    kind: str
    n: int
    spacings: float = 0.0
    autodiff: bool = False

    def __str__(self) -> str:
        how = f"{self.dimension}D" if self.is_ball else self.rule
        cloud = f"{self.kind} {self.spacings:g}" if self.is_ball else self.kind
        return ", ".join([self.shape, how, cloud, *["autodiff"] * self.autodiff])

    @property
    def is_ball(self) -> bool:
        return self.shape == "ball"

    @property
    def adds_up(self) -> bool:
        """Whether the union is the sum of the restricted cells."""
        return self.is_ball or self.rule == "naive"

    @property
    def rounding(self) -> float:
        """What rounding leaves of a measure, relative to the largest."""
        return 1e-13 if self.is_ball else 1e-12

    def of(self, n: int) -> Case:
        """The same with so many points."""
        return replace(self, n=n)

    @property
    def points(self) -> Array:
        return _place(self)[0]

    @property
    def radius(self) -> float:
        return _place(self)[1]

    @property
    def offsets(self) -> Array:
        """Distances of the facets from the centre, in radii."""
        return np.ones(1) if self.is_ball else expect.solid(self.shape).offsets

    @property
    def whole(self) -> tuple[float, float]:
        """Volume and area of one shape of radius 1."""
        if self.is_ball:
            ball = oracles.ball_volume(1.0, self.dimension)
            return ball, oracles.sphere_area(1.0, self.dimension)
        body = expect.measure_body(expect.solid(self.shape))
        return body.volume, float(body.facet_areas.sum())

    @property
    def circumradius(self) -> float:
        """Largest distance of a point of a shape from its centre, in radii."""
        if self.is_ball:
            return 1.0
        corners = expect.measure_body(expect.solid(self.shape)).vertices
        return float(np.linalg.norm(corners, axis=1).max())

    @property
    def reach(self) -> float:
        """Points that are not nearer than twice this have nothing to do with each other."""
        return self.radius * max(1.0, self.circumradius)

    def energy(
        self,
        radius: float | None = None,
        quantity: Quantity = "volume",
        weight: Weight = "none",
        rotation: Array | None = None,
    ) -> BallEnergy | PolyhedronEnergy | AutodiffEnergy:
        """The energy with the cloud's radius, or another; the rotation turns the body."""
        radius = self.radius if radius is None else radius
        energy: BallEnergy | PolyhedronEnergy = BallEnergy(radius, quantity, weight)
        if not self.is_ball:
            solid = expect.solid(self.shape)
            turned = solid if rotation is None else expect.rotated(solid, rotation)
            energy = PolyhedronEnergy(radius, convex_body(turned), self.rule, quantity, weight)
        return AutodiffEnergy(energy) if self.autodiff else energy

    def measure(
        self,
        points: Array | None = None,
        radius: float | None = None,
        rotation: Array | None = None,
    ) -> UnionMeasures:
        """The measures of the cloud, or of other points."""
        if points is None and radius is None and rotation is None:
            return _measure(self)
        energy = self.energy(radius, rotation=rotation)
        return energy.evaluate(self.points if points is None else points).union


def convex_body(body: expect.Body) -> ConvexBody:
    """The body, made once: its corners take longer than a small union."""
    return _convex_body(body.normals.tobytes(), body.offsets.tobytes())


def measure_bodies(points: Array, radius: float, body: expect.Body, rule: Rule) -> PolyhedronUnion:
    return measure_polyhedra(points, radius, convex_body(body), union=rule)


@cache
def _convex_body(normals: bytes, offsets: bytes) -> ConvexBody:
    distances = np.frombuffer(offsets)
    return ConvexBody(np.frombuffer(normals).reshape(len(distances), -1), distances)


@cache
def _measure(case: Case) -> UnionMeasures:
    return case.energy().evaluate(case.points).union


@cache
def _place(case: Case) -> tuple[Array, float]:
    if case.is_ball:
        points, radius = ball_cloud(case.kind, case.dimension, case.spacings, case.n)
    else:
        scene = expect.scene(case.shape, case.kind, case.n)
        points, radius = scene.points, scene.radius
    return np.round(points / UNIT) * UNIT, radius


@cache
def ball_cloud(kind: str, dimension: int, spacings: float, n: int) -> tuple[Array, float]:
    """Random points in a cube or near a sphere, and a radius of so many spacings."""
    if kind == "cloud":
        return oracles.uniform_cloud(n, dimension), spacings * n ** (-1 / dimension)
    size = oracles.sphere_area(1.0, dimension)
    spacing = size / n if dimension == 2 else np.sqrt(size / n)
    noise = 1 + 0.3 * spacing * np.random.default_rng(1).normal(size=(n, 1))
    return noise * oracles.random_sphere(n, dimension=dimension), spacings * spacing


def balls(dimension: int, kind: str, spacings: float) -> Case:
    return Case("ball", dimension, "", kind, 200, spacings)


def polyhedra(shape: str, kind: str, n: int) -> list[Case]:
    """One for each rule."""
    dimension = expect.solid(shape).normals.shape[1]
    return [Case(shape, dimension, rule, kind, n) for rule in expect.RULES]


#: Of balls every pair of a dimension, a kind of cloud and a radius.
BALLS = [
    balls(2, "cloud", 1.5),
    balls(2, "surface", 2.5),
    balls(2, "cloud", 4.0),
    balls(3, "surface", 1.5),
    balls(3, "cloud", 2.5),
    balls(3, "surface", 4.0),
]

POLYHEDRA = [
    *polyhedra("square", "cloud", 25),
    *polyhedra("hexagon", "cap", 18),
    *polyhedra("triangle", "cap", 18),
    *polyhedra("lopsided polygon", "cloud", 20),
    *polyhedra("cube", "cloud", 20),
    *polyhedra("tetrahedron", "cap", 20),
    *polyhedra("icosahedron", "cap", 16),
    *polyhedra("sphere", "cloud", 12),
    *polyhedra("lopsided polyhedron", "cloud", 16),
]

#: One of each kernel and rule, where the shape makes no difference.
KERNELS = [BALLS[1], BALLS[4], *polyhedra("hexagon", "cap", 18), *polyhedra("cube", "cloud", 20)]

#: By automatic differentiation, which is slow: each way to find edges, and each dimension.
AUTODIFF = [
    replace(case, n=8 if case.is_ball else 4, autodiff=True)
    for case in KERNELS
    if (case.shape, case.rule) not in [("hexagon", "naive"), ("cube", "inclusion-exclusion")]
]
