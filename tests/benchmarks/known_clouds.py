"""Clouds of which the surface and the noise are known point by point, each hard in its own way.

Lengths are metres.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import numpy.typing as npt
from scenes import Box
from surface_distances import Array

Marks = npt.NDArray[np.bool_]
_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class KnownCloud:
    """A cloud and the truth about it.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
        As they were measured.
    noise : ndarray, shape (n,)
        Standard deviation of the noise of each along its normal.
    distances : callable
        Gives the distance of points (n, 3), in the same rows, to the surface that each is of.
    outliers : ndarray of bool, shape (n,)
        Which are of no surface.
    classes : mapping of str to ndarray of bool, shape (n,)
        Points that are looked at by themselves.
    normals : ndarray, shape (n, 3), or None
        True ones, if these are known.
    """

    points: Array
    noise: Array
    distances: Callable[[Array], Array]
    outliers: Marks
    classes: Mapping[str, Marks] = field(default_factory=dict)
    normals: Array | None = None

    @property
    def errors(self) -> Array:
        """Distance of each point to its surface, (n,)."""
        return self.distances(self.points)


def directions(up: Array, around: Array) -> Array:
    """Unit directions, (k m, 3), of all pairs of k angles upwards and m around the vertical."""
    elevation, azimuth = (angles.ravel() for angles in np.meshgrid(up, around, indexing="ij"))
    level = np.cos(elevation)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=1)


def scan_lines(across: float, seed: int) -> KnownCloud:
    """A plane in lines so many times farther apart than the points on them."""
    rng = np.random.default_rng(seed)
    lines = round(np.sqrt(20_000 / across))
    x, y = np.meshgrid(np.arange(20_000 // lines), across * np.arange(lines))
    flat = 0.001 * np.stack([x.ravel() + rng.uniform(-0.3, 0.3, x.size), y.ravel()], axis=1)
    return _level(flat, 0.0005, rng)


def two_walls(noise: float, seed: int) -> KnownCloud:
    """Two square walls 10 mm apart, of random points 5 mm apart."""
    rng = np.random.default_rng(seed)
    side = rng.integers(0, 2, 40_000)
    level = 0.01 * side
    flat = 0.7 * rng.uniform(size=(len(side), 2))
    points = np.column_stack([flat, level + noise * rng.normal(size=len(side))])
    return KnownCloud(
        points, np.full(len(side), noise), lambda points: np.abs(points[:, 2] - level),
        np.zeros(len(side), np.bool_), normals=(2.0 * side[:, np.newaxis] - 1.0) * _UP,
    )  # fmt: skip


def plate(noise: float, seed: int) -> KnownCloud:
    """A plate of 400 x 400 x 10 mm, of random points 5 mm apart."""
    rng = np.random.default_rng(seed)
    half = np.array([0.2, 0.2, 0.005])
    areas = half.prod() / half
    axes = rng.choice(3, round(8.0 * areas.sum() / 0.005**2), p=areas / areas.sum())
    rows = np.arange(len(axes))
    points = rng.uniform(-half, half, (len(axes), 3))
    points[rows, axes] = rng.choice([-1.0, 1.0], len(axes)) * half[axes]
    normals = np.zeros_like(points)
    normals[rows, axes] = np.sign(points[rows, axes])
    box = Box((0.0, 0.0, 0.0), (0.2, 0.2, 0.005))
    return KnownCloud(
        points + noise * rng.normal(size=points.shape), np.full(len(points), noise),
        lambda points: np.abs(box.distances(points)), np.zeros(len(points), np.bool_),
        normals=normals,
    )  # fmt: skip


def ground_from_tripod(seed: int) -> KnownCloud:
    """Flat ground seen from 2 m above, 3 to 60 m away: the spacing grows some hundred times."""
    rng = np.random.default_rng(seed)
    beams = directions(-np.linspace(0.033, 0.7, 160), np.linspace(0.0, 0.6, 200))
    cosines = -beams[:, 2]
    ways = 2.0 / cosines
    deviations = 0.0005 * (1.0 + ways)
    ways += deviations * rng.normal(size=len(ways))
    return KnownCloud(
        [0.0, 0.0, 2.0] + ways[:, np.newaxis] * beams, deviations * cosines,
        lambda points: np.abs(points[:, 2]), np.zeros(len(ways), np.bool_),
        normals=np.tile(_UP, (len(ways), 1)),
    )  # fmt: skip


def rings_in_room(seed: int) -> KnownCloud:
    """A room of 10 x 8 x 4 m seen by 32 rotating lasers: rings far apart, noise of 10 mm."""
    rng = np.random.default_rng(seed)
    beams = directions(np.radians(np.linspace(-25, 15, 32)), np.radians(np.arange(0, 360, 0.2)))
    walls = np.where(beams > 0.0, [5.0, 4.0, 2.2], [-5.0, -4.0, -1.8])
    ways = np.divide(walls, beams, out=np.full_like(walls, np.inf), where=beams != 0.0)
    rows, axes = np.arange(len(ways)), ways.argmin(axis=1)
    levels, cosines = walls[rows, axes], np.abs(beams[rows, axes])
    measured = ways[rows, axes] + 0.01 * rng.normal(size=len(ways))
    normals = np.zeros_like(beams)
    normals[rows, axes] = np.sign(levels)
    return KnownCloud(
        measured[:, np.newaxis] * beams, 0.01 * cosines,
        lambda points: np.abs(points[rows, axes] - levels), np.zeros(len(ways), np.bool_),
        normals=normals,
    )  # fmt: skip


def cables(seed: int) -> KnownCloud:
    """Three cables of 20 m, noise 5 mm in all directions, over ground with noise of 20 mm."""
    rng = np.random.default_rng(seed)
    x = np.tile(np.linspace(0.0, 20.0, 1500), 3)
    axis = np.stack([x, np.repeat([0.0, 1.0, 2.0], 1500), 6.0 + 0.02 * (x - 10.0) ** 2], axis=1)
    ground = rng.uniform([0.0, -3.0, 0.0], [20.0, 5.0, 0.0], (20_000, 3))
    is_cable = np.arange(len(axis) + len(ground)) < len(axis)
    points = np.concatenate([
        axis + 0.005 * rng.normal(size=axis.shape),
        ground + 0.02 * rng.normal(size=(len(ground), 1)) * _UP,
    ])  # fmt: skip

    def distances(points: Array) -> Array:
        sagging = points[is_cable]
        height = 6.0 + 0.02 * (sagging[:, 0] - 10.0) ** 2
        slope = 0.04 * (sagging[:, 0] - 10.0)
        across = np.hypot(sagging[:, 1] - axis[:, 1], (sagging[:, 2] - height) / np.hypot(1, slope))
        return np.concatenate([across, np.abs(points[~is_cable, 2])])

    # Of the distance to a line there are two directions.
    noise = np.where(is_cable, 0.005 * np.sqrt(2.0), 0.02)
    return KnownCloud(
        points, noise, distances, np.zeros(len(points), np.bool_),
        {"cables": is_cable, "ground": ~is_cable},
    )  # fmt: skip


def depth_steps(seed: int) -> KnownCloud:
    """A slanted wall whose depths come in steps of 10 mm: steps farther apart than the points."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(0.004 * np.arange(150), 0.004 * np.arange(150))
    flat = np.stack([x.ravel(), y.ravel()], axis=1)
    slope = rng.uniform(0.2, 0.4)
    depths = slope * flat[:, 0] + rng.uniform(0.0, 0.01)
    points = np.column_stack([flat, 0.01 * np.round(depths / 0.01)])
    normal = np.array([-slope, 0.0, 1.0]) / np.hypot(1.0, slope)
    offset = (points[:, 2] - depths) * normal[2]
    middle = (points @ normal - offset)[0]
    return KnownCloud(
        points, np.full(len(points), 0.01 / np.sqrt(12.0) * normal[2]),
        lambda points: np.abs(points @ normal - middle), np.zeros(len(points), np.bool_),
        normals=np.tile(normal, (len(points), 1)),
    )  # fmt: skip


def ball_among(outliers: float, clump: int, seed: int) -> KnownCloud:
    """A unit ball's 20,000 points, noise 10 mm, among a share of outliers in clumps of so many.

    They are five noises off it, or more. Clumps are 30 mm wide, less than the points' spacing.
    """
    rng = np.random.default_rng(seed)
    count = round(20_000 * outliers)
    on_ball = rng.normal(size=(20_000, 3))
    on_ball /= np.linalg.norm(on_ball, axis=1, keepdims=True)
    on_ball *= 1.0 + 0.01 * rng.normal(size=(len(on_ball), 1))
    places = np.repeat(rng.uniform(-1.5, 1.5, (count // clump, 3)), clump, axis=0)
    places += 0.015 * (clump > 1) * rng.uniform(-1.0, 1.0, places.shape)
    places = places[np.abs(np.linalg.norm(places, axis=1) - 1.0) > 0.05]
    order = rng.permutation(len(on_ball) + len(places))
    points = np.concatenate([on_ball, places])[order]

    def distances(points: Array) -> Array:
        return np.asarray(np.abs(np.linalg.norm(points, axis=1) - 1.0))

    return KnownCloud(points, np.full(len(points), 0.01), distances, order >= len(on_ball))


def _level(flat: Array, noise: float, rng: np.random.Generator) -> KnownCloud:
    """Points (n, 2) of the plane z = 0, with noise across it."""
    return KnownCloud(
        np.column_stack([flat, noise * rng.normal(size=len(flat))]), np.full(len(flat), noise),
        lambda points: np.abs(points[:, 2]), np.zeros(len(flat), np.bool_),
        normals=np.tile(_UP, (len(flat), 1)),
    )  # fmt: skip


#: Each by its name in the tables, from a seed.
KNOWN_CLOUDS: Mapping[str, Callable[[int], KnownCloud]] = {
    **{f"lines {n} times as far apart": partial(scan_lines, n) for n in (5, 7, 10, 20)},
    "two walls 5 noises apart": partial(two_walls, 0.002),
    "two walls 20 noises apart": partial(two_walls, 0.0005),
    "plate 20 noises thick": partial(plate, 0.0005),
    "ground from a tripod": ground_from_tripod,
    "rings in a room": rings_in_room,
    "cables": cables,
    "steps of depth": depth_steps,
    **{
        f"ball, {share:.0%} outliers": partial(ball_among, share, 1)
        for share in (0.01, 0.03, 0.1, 0.3)
    },
    "ball, 3% in clumps of 15": partial(ball_among, 0.03, 15),
}
