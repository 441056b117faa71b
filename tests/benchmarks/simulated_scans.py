"""Scans of scenes as scanners make them: noise by range and incidence, split beams, misfits.

Lengths are metres, angles radians.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from known_clouds import KnownCloud, directions
from scenes import (
    Ball,
    Box,
    Column,
    Ground,
    Scene,
    Vector,
    edge_distances,
    gradients,
    signed_distances,
    ways_to,
)
from surface_distances import Array

_GRAZING = 0.08  #: least cosine of the incidence that noise knows of
_SPLIT = 0.7  #: share of the beams that are split at an edge in depth
_GAP = 20.0  #: least depth of such an edge, in units of the noise
_SLANT = 5.0  #: the same in units of what the beam's width is along a slanted surface
_DEEPEST = 3.0  #: depth of such an edge from which a scanner tells two echoes apart
_AT_EDGES = 0.02  #: points nearer to sharp edges than this, and four times the noise, are at them

HALL: Scene = (
    Box((0, 0, 2.2), (8, 5, 2.2), hollow=True), Box((2.5, 1.5, 0.4), (0.9, 0.4, 0.4), 0.6),
    Box((-3.5, -1.5, 1.1), (0.04, 1.0, 1.1)), Box((-6, -3.2, 0.5), (0.8, 0.5, 0.5), -0.5),
    Column(-5, 2.5, 0.25), Column(4.5, -2.5, 0.05), Ball((0.5, 3.0, 0.7), 0.7),
)  # fmt: skip
STREET: Scene = (
    Ground(((0.07, 16, 0.4), (0.03, 6, 1.5))), Box((0, 10, 4), (13, 2, 4)),
    Box((-7, -9, 3), (5, 2.5, 3), 0.15), Box((8, -9, 4), (4, 2, 4), -0.2),
    Box((3, 0.5, 0.7), (2.0, 0.9, 0.5), 0.1), Column(-3.5, 4.5, 0.12), Column(5, 4.5, 0.12),
    Ball((-8, 2.5, 3.2), 1.2),
)  # fmt: skip
SITE: Scene = (
    Ground(((1.0, 80, 0.6), (0.35, 30, 2.1), (0.1, 8, 1.1))), Box((9, 9, 3), (6, 5, 4), 0.4),
    Box((-18, -5, 2), (5, 8, 3.5), -0.15), Box((22, -16, 1), (6, 4, 3)), Ball((-8, 16, 1), 4),
)  # fmt: skip
DESK: Scene = (
    Ground(), Box((0, 0.8, 0.4), (0.9, 0.02, 0.6)), Box((-0.3, 0.25, 0.1), (0.12, 0.08, 0.1), 0.5),
    Box((0.45, 0.3, 0.03), (0.1, 0.07, 0.03), -0.3), Column(0.1, 0.55, 0.05),
    Ball((0.15, 0.2, 0.1), 0.1), Box((-0.55, 0.45, 0.15), (0.1, 0.006, 0.15), -0.4),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Beams:
    """Where beams start and go, (n, 3) each; directions have unit length."""

    origins: Array
    directions: Array


@dataclass(frozen=True)
class Law:
    """What a scanner's noise along the beam is, and how wide the beam.

    Attributes
    ----------
    constant, per_range, per_square : float
        Coefficients of the standard deviation as a polynomial in the range.
    grazes : bool
        Whether it grows with the incidence: by one over the root of its cosine.
    width : float
        Angle from the middle of the beam to its border.
    """

    constant: float
    per_range: float = 0.0
    per_square: float = 0.0
    grazes: bool = True
    width: float = 0.0

    def deviations(self, ranges: Array, cosines: Array) -> Array:
        """Standard deviations along beams that meet the surface at such angles."""
        known = self.constant + ranges * (self.per_range + ranges * self.per_square)
        return np.asarray(known / np.sqrt(cosines)) if self.grazes else known


def from_tripod(station: Vector, step: float, around: float = np.pi) -> Beams:
    """A grid of angles, so far apart, up to `around` to both sides of the x axis."""
    beams = directions(np.arange(-0.8, 0.6, step), np.arange(-around, around, step))
    return _from_all(np.array([station]), beams)


def from_street(path: Array, lasers: int, step: float) -> Beams:
    """Lasers that rotate at each place of a path (m, 3)."""
    around = np.arange(0.0, 2.0 * np.pi, step)
    return _from_all(path, directions(np.linspace(-0.44, 0.26, lasers), around))


def from_flight(y: float, ahead: float, step: float) -> Beams:
    """A line along x, 60 m high: lines across it, so far ahead of each other."""
    across = np.arange(-0.45, 0.45, step)
    x, angle = (grid.ravel() for grid in np.meshgrid(np.arange(-20.0, 20.0, ahead), across))
    origins = np.stack([x, np.full_like(x, y), np.full_like(x, 60.0)], axis=1)
    return Beams(origins, np.stack([0.0 * x, np.sin(angle), -np.cos(angle)], axis=1))


def from_camera(eye: Vector, target: Vector, columns: int, rows: int) -> Beams:
    """A pinhole camera with a view of 62 degrees."""
    ahead = np.subtract(target, eye)
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    u, v = np.meshgrid(np.arange(columns) - columns / 2, np.arange(rows) - rows / 2)
    sideways = np.outer(u.ravel(), right) + np.outer(v.ravel(), np.cross(ahead, right))
    beams = ahead + 1.2 / columns * sideways
    beams /= np.linalg.norm(beams, axis=1, keepdims=True)
    return Beams(np.tile(eye, (len(beams), 1)), beams)


def measured(
    scene: Scene, beams: Beams, law: Law, farthest: float, rng: np.random.Generator
) -> KnownCloud:
    """Measure a scene along beams.

    A beam that is split by an edge in depth measures something between two surfaces: an outlier.
    """
    ways = ways_to(scene, beams.origins, beams.directions, farthest)
    hit = np.isfinite(ways)
    ways, origins, along = ways[hit], beams.origins[hit], beams.directions[hit]
    true = origins + ways[:, np.newaxis] * along
    normals = gradients(scene, true)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    cosines = np.abs(np.einsum("ij,ij->i", normals, along))
    deviations = law.deviations(ways, np.maximum(cosines, _GRAZING))
    ranges = ways.copy()
    beside = along + law.width * rng.normal(size=along.shape)
    beside /= np.linalg.norm(beside, axis=1, keepdims=True)
    gaps = ways_to(scene, origins, beside, farthest) - ways if law.width > 0.0 else 0.0 * ways
    least = np.maximum(_GAP * deviations, _SLANT * law.width * ways / np.maximum(cosines, _GRAZING))
    is_split = (gaps > least) & (gaps < _DEEPEST)
    is_split &= rng.uniform(size=len(ways)) < _SPLIT
    ranges[is_split] += rng.uniform(size=np.count_nonzero(is_split)) * gaps[is_split]
    ranges += deviations * rng.normal(size=len(ranges))
    at_edges = edge_distances(scene, true) < _AT_EDGES + 4.0 * np.median(deviations)
    near, far = np.quantile(ways, (0.3, 0.7))
    return KnownCloud(
        origins + ranges[:, np.newaxis] * along, deviations * cosines,
        lambda points: np.abs(signed_distances(scene, points)), is_split,
        {"near": ways <= near, "far": ways >= far, "edges": at_edges, "smooth": ~at_edges},
        normals,
    )  # fmt: skip


def misfitting(scan: KnownCloud, shift: Array, turn: float) -> KnownCloud:
    """Move a scan, (3,), and turn it around the vertical through the origin, as a misfit does."""
    x, y, z = scan.points.T
    turned = [np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y, z]
    return replace(scan, points=np.stack(turned, axis=1) + shift)


def together(scans: Sequence[KnownCloud]) -> KnownCloud:
    """Put scans of one scene into one cloud."""
    return KnownCloud(
        np.concatenate([scan.points for scan in scans]),
        np.concatenate([scan.noise for scan in scans]),
        scans[0].distances,
        np.concatenate([scan.outliers for scan in scans]),
        {name: np.concatenate([scan.classes[name] for scan in scans]) for name in scans[0].classes},
    )


def _from_all(stations: Array, beams: Array) -> Beams:
    """The same beams (k, 3) from each of some stations (m, 3)."""
    return Beams(np.repeat(stations, len(beams), axis=0), np.tile(beams, (len(stations), 1)))


def _tripod(seed: int) -> KnownCloud:
    rng = np.random.default_rng(seed)
    beams = from_tripod((-2.0, 0.3, 1.6), 0.0075, 1.05)
    return measured(HALL, beams, Law(0.001, 0.0012, width=0.002), 40.0, rng)


def _stations(seed: int) -> KnownCloud:
    rng = np.random.default_rng(seed)
    law = Law(0.002, 0.0006, width=0.002)
    return together([
        misfitting(
            measured(HALL, from_tripod(place, 0.025), law, 40.0, rng),
            0.004 * rng.normal(size=3), 0.0009 * rng.normal(),
        )
        for place in ((-4.5, 0.0, 1.6), (3.5, -0.8, 1.5), (1.0, 2.0, 1.7))
    ])  # fmt: skip


def _coarse(seed: int) -> KnownCloud:
    rng = np.random.default_rng(seed)
    law = Law(0.002, 0.0006, width=0.002)
    places = ((-4.5, 0.0, 1.6), (3.5, -0.8, 1.5))
    return together([measured(HALL, from_tripod(p, 0.025), law, 40.0, rng) for p in places])


def _rings(seed: int) -> KnownCloud:
    rng = np.random.default_rng(seed)
    path = np.stack([np.linspace(-6.0, 1.0, 6), np.full(6, 1.5), np.full(6, 1.9)], axis=1)
    return measured(STREET, from_street(path, 32, 0.03), Law(0.02, width=0.002), 40.0, rng)


def _flights(seed: int) -> KnownCloud:
    rng = np.random.default_rng(seed)
    law = Law(0.03, grazes=False)
    return together([
        misfitting(
            measured(SITE, from_flight(y, 0.6, 0.006), law, 120.0, rng),
            0.03 * rng.normal() * np.array([0.0, 0.0, 1.0]), 0.0,
        )
        for y in (-22.0, -8.0, 8.0, 22.0)
    ])  # fmt: skip


def _flight_lines(seed: int) -> KnownCloud:
    rng = np.random.default_rng(seed)
    return measured(SITE, from_flight(0.0, 1.0, 0.0016), Law(0.03, grazes=False), 120.0, rng)


def _camera(seed: int) -> KnownCloud:
    rng = np.random.default_rng(seed)
    beams = from_camera((0.2, -0.9, 0.7), (0.0, 0.3, 0.15), 240, 180)
    return measured(DESK, beams, Law(0.0, per_square=0.0015, grazes=False), 4.0, rng)


#: Each by its name in the tables, from a seed.
SIMULATED_SCANS: Mapping[str, Callable[[int], KnownCloud]] = {
    "tripod in a hall": _tripod,
    "three stations that misfit": _stations,
    "two stations, coarse": _coarse,
    "rotating laser in a street": _rings,
    "flights that misfit": _flights,
    "a flight's lines": _flight_lines,
    "depth camera": _camera,
}
