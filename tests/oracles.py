"""Expected values that owe nothing to the kernels: closed forms, quadrature, differences.

Angles are measured on circles as unions of arcs, which is exact; what is left to integrate is a
function of one variable, smooth between known breakpoints.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import permutations
from math import acos, cos, pi, sin, sqrt

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.energies.balls import BallUnion
from pcsmooth.energies.protocol import UnionMeasures

Array = npt.NDArray[np.float64]

MEASURES = ("cell_volumes", "visible_areas", "volume_gradient", "area_gradient")

#: Measures of each point, and which power of length they are, counted from d. Unions of balls
#: alone have the tensors.
POWERS = {
    "cell_volumes": 0,
    "visible_areas": -1,
    "volume_gradient": -1,
    "area_gradient": -2,
    "volume_diagonal": -2,
    "area_diagonal": -3,
    "normal_tensors": -1,
}


@dataclass(frozen=True)
class Expected:
    """Measures of a union, as `BallUnion` names them."""

    cell_volumes: Array
    visible_areas: Array
    volume_gradient: Array
    area_gradient: Array

    @property
    def volume(self) -> float:
        return float(self.cell_volumes.sum())

    @property
    def area(self) -> float:
        return float(self.visible_areas.sum())


# --- clouds ---------------------------------------------------------------------------------


def uniform_cloud(n: int, dimension: int, seed: int = 0) -> Array:
    return np.random.default_rng(seed).random((n, dimension))


def random_sphere(n: int, radius: float = 1.0, seed: int = 0, dimension: int = 3) -> Array:
    """Points uniformly random by area on a sphere (a circle in 2D)."""
    directions = np.random.default_rng(seed).normal(size=(n, dimension))
    return np.asarray(radius * directions / np.linalg.norm(directions, axis=1, keepdims=True))


def random_torus(n: int, tube: float = 0.4, seed: int = 0) -> tuple[Array, Array]:
    """Points uniformly random by area on a torus about the z axis, R = 1, and outward normals."""
    rng = np.random.default_rng(seed)
    around, across = np.empty(0), np.empty(0)
    while len(around) < n:
        u, v, level = rng.random((3, n)) * [[2 * pi], [2 * pi], [1 + tube]]
        kept = level < 1 + tube * np.cos(v)
        around, across = np.r_[around, u[kept]], np.r_[across, v[kept]]
    u, v = around[:n], across[:n]
    normals = np.c_[np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)]
    return np.c_[np.cos(u), np.sin(u), np.zeros(n)] + tube * normals, normals


def distance_to_torus(points: Array, tube: float = 0.4) -> Array:
    """Signed distance to the torus of `random_torus`."""
    return np.asarray(np.hypot(np.hypot(points[:, 0], points[:, 1]) - 1, points[:, 2]) - tube)


def even_sphere(n: int, radius: float = 1.0) -> Array:
    """Points spread evenly over a sphere (Fibonacci lattice)."""
    k = np.arange(n)
    z = 1 - (2 * k + 1) / n
    angle = pi * (1 + sqrt(5)) * k
    flat = np.sqrt(1 - z * z)
    return np.asarray(radius * np.c_[flat * np.cos(angle), flat * np.sin(angle), z])


def even_circle(n: int, radius: float = 1.0) -> Array:
    angle = 2 * pi * np.arange(n) / n
    return np.asarray(radius * np.c_[np.cos(angle), np.sin(angle)])


def lattice(*counts: int) -> Array:
    """Points with integer coordinates 0 .. count - 1 on each axis."""
    return np.indices(counts).reshape(len(counts), -1).T.astype(float)


def random_rotation(dimension: int, rng: np.random.Generator) -> Array:
    rotation = np.linalg.qr(rng.normal(size=(dimension, dimension)))[0]
    rotation[:, 0] *= np.linalg.det(rotation)
    return rotation


# --- surfaces -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Surface:
    """Points of a surface with what is known there; curvatures are positive on a sphere."""

    points: Array
    normals: Array
    mean: Array
    gaussian: Array
    area: float

    @property
    def spacing(self) -> float:
        """Side of the square that is each point's share of the surface."""
        return sqrt(self.area / len(self.points))

    def noisy(self, noise: float, seed: int = 1) -> Array:
        """Points moved along the normals by normal deviates of `noise` spacings."""
        moves = np.random.default_rng(seed).normal(size=(len(self.points), 1))
        return np.asarray(self.points + noise * self.spacing * moves * self.normals)


def sphere_surface(n: int, radius: float = 1.0, seed: int = 0) -> Surface:
    points = random_sphere(n, radius, seed)
    ones = np.ones(n)
    area = sphere_area(radius, 3)
    return Surface(points, points / radius, ones / radius, ones / radius**2, area)


def torus_surface(n: int, tube: float = 0.4, seed: int = 0) -> Surface:
    points, normals = random_torus(n, tube, seed)
    across = (
        (np.hypot(points[:, 0], points[:, 1]) - 1) / tube / np.hypot(points[:, 0], points[:, 1])
    )
    return Surface(points, normals, (1 / tube + across) / 2, across / tube, 4 * pi**2 * tube)


def ellipsoid_surface(n: int, axes: tuple[float, float, float], seed: int = 0) -> Surface:
    """Uniformly random by area: the image of a sphere, thinned by how much the map stretches."""
    half = np.array(axes)
    rng = np.random.default_rng(seed)
    tries = rng.normal(size=(1000 + 10 * n, 3))
    tries /= np.linalg.norm(tries, axis=1, keepdims=True)
    stretch = np.linalg.norm(tries / half, axis=1) * half.min()
    kept = tries[rng.random(len(tries)) < stretch][:n]
    assert len(kept) == n
    points = kept * half
    slopes = points / half**2
    sizes = np.linalg.norm(slopes, axis=1)
    normals = slopes / sizes[:, np.newaxis]
    mean = ((1 / half**2).sum() - (normals**2 / half**2).sum(axis=1)) / (2 * sizes)
    # the map multiplies areas by the product of the axes times the size of the slope
    area = sphere_area(1.0, 3) * float(stretch.mean() / half.min() * half.prod())
    return Surface(points, normals, mean, 1 / (half.prod() * sizes**2) ** 2, area)


def waves_surface(n: int, seed: int = 0) -> Surface:
    """The sheet z = 0.05 sin 6x cos 6y over [-1, 1]^2, uniformly random from above."""
    x, y = np.random.default_rng(seed).uniform(-1, 1, (2, n))
    z = 0.05 * np.sin(6 * x) * np.cos(6 * y)
    z_x, z_y = 0.3 * np.cos(6 * x) * np.cos(6 * y), -0.3 * np.sin(6 * x) * np.sin(6 * y)
    z_xx, z_xy = -36 * z, -1.8 * np.cos(6 * x) * np.sin(6 * y)
    stretch = np.sqrt(1 + z_x**2 + z_y**2)
    normals = np.c_[-z_x, -z_y, np.ones(n)] / stretch[:, np.newaxis]
    twice = ((1 + z_x**2) + (1 + z_y**2)) * z_xx - 2 * z_x * z_y * z_xy
    gaussian = (z_xx**2 - z_xy**2) / stretch**4
    area = 4 * float(stretch.mean())
    return Surface(np.c_[x, y, z], normals, -twice / (2 * stretch**3), gaussian, area)


def degrees_between(normals: Array, expected: Array) -> Array:
    """Angle between unit vectors (n, d), without the arccosine's rounding near 0."""
    chords = np.linalg.norm(normals - expected, axis=1)
    return np.asarray(np.degrees(2 * np.arcsin(np.minimum(chords / 2, 1))))


# --- closed forms ---------------------------------------------------------------------------


def ball_volume(radius: float, dimension: int) -> float:
    return pi * radius**2 if dimension == 2 else 4 / 3 * pi * radius**3


def sphere_area(radius: float, dimension: int) -> float:
    return 2 * pi * radius if dimension == 2 else 4 * pi * radius**2


def _from_facets(
    points: Array, radius: float, facets: Array, rims: Array, visible: Array
) -> Expected:
    """Measures of n balls all near each other, from facets and rims (n, n) and visible (n,)."""
    dimension = points.shape[1]
    arms = points - points[:, np.newaxis]
    distances = np.linalg.norm(arms, axis=2)
    units = arms / (distances + np.eye(len(points)))[:, :, np.newaxis]
    return Expected(
        cell_volumes=(radius * visible + (0.5 * distances * facets).sum(axis=1)) / dimension,
        visible_areas=visible,
        volume_gradient=-np.einsum("ij,ijk->ik", facets, units),
        area_gradient=-np.einsum("ij,ijk->ik", rims, units),
    )


def two_balls(points: Array, radius: float) -> Expected:
    """Two intersecting balls or disks."""
    half = 0.5 * float(np.linalg.norm(points[1] - points[0]))
    rho = sqrt(radius**2 - half**2)
    if points.shape[1] == 3:
        facet, rim, visible = pi * rho**2, 2 * pi * radius, 2 * pi * radius * (radius + half)
    else:
        facet, rim, visible = 2 * rho, 2 * radius / rho, 2 * radius * (pi - acos(half / radius))
    other = 1 - np.eye(2)
    return _from_facets(points, radius, facet * other, rim * other, np.full(2, visible))


def lens_tensor(radius: float, distance: float) -> Array:
    """Tensor of the visible boundary of a ball whose one neighbour is along the x axis."""
    level = distance / (2 * radius)
    along = 2 * pi * radius**2 * (1 + level**3) / 3
    across = (2 * pi * radius**2 * (1 + level) - along) / 2
    return np.diag([along, across, across])


def three_disks(points: Array, radius: float) -> Expected:
    """Three disks with a common point, centred on the vertices of an acute triangle."""
    facets, rims, visible = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(3)
    for i, j, k in permutations(range(3)):
        half = 0.5 * float(np.linalg.norm(points[j] - points[i]))
        rho = sqrt(radius**2 - half**2)
        # the facet runs from the visible end, past the middle, to the circumcentre
        facets[i, j] = rho + half / np.tan(_angle(points[i] - points[k], points[j] - points[k]))
        rims[i, j] = radius / rho
        visible[i] -= radius * acos(half / radius)
    for i, j, k in [(0, 1, 2), (1, 2, 0), (2, 0, 1)]:
        visible[i] += radius * (2 * pi - _angle(points[j] - points[i], points[k] - points[i]))
    return _from_facets(points, radius, facets, rims, visible)


def three_balls(points: Array, radius: float) -> Expected:
    """Three balls with a common point, by the dihedral angles at one of their two corners.

    With P a corner, the tetrahedron of the centres and P has dihedral angle delta_ij at the
    edge ij. The third ball hides the arc from -delta_ij to delta_ij of the circle of i and j.
    """
    corner = _corner(points, radius)
    facets, rims, visible = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(3)
    for i, j, k in permutations(range(3)):
        half = 0.5 * float(np.linalg.norm(points[j] - points[i]))
        delta = _dihedral(points[i], points[j], points[k], corner)
        facets[i, j] = (radius**2 - half**2) * (pi - delta + sin(delta) * cos(delta))
        rims[i, j] = 2 * radius * (pi - delta)
        # two caps hide their sum less the lens that they share, which is twice the sum of
        # their sectors less the spherical triangle j k P
        visible[i] -= 2 * (pi - delta) * radius * (radius - half)
    for i, j, k in [(0, 1, 2), (1, 2, 0), (2, 0, 1)]:
        visible[i] += radius**2 * (4 * pi - 2 * _solid_angle(points, i, j, k, corner))
    return _from_facets(points, radius, facets, rims, visible)


def three_ball_totals(points: Array, radius: float | Array) -> tuple[float, float]:
    """Volume and area of `three_balls` by inclusion and exclusion.

    The tetrahedron T of the centres and a corner is covered, so that with the angles of T as
    weights vol(T) = sum omega_i V_i - sum delta_ij / 2 pi V_ij + V_123 / 2, and likewise for
    the area, of which there is none in T.
    """
    radii = np.broadcast_to(radius, 3)
    corner = _corner(points, radii)
    volume = sum(ball_volume(r, 3) for r in radii)
    area = sum(sphere_area(r, 3) for r in radii)
    common_volume = abs(float(np.linalg.det(points - corner))) / 6
    common_area = 0.0
    for i, j, k in [(0, 1, 2), (1, 2, 0), (2, 0, 1)]:
        distance = float(np.linalg.norm(points[j] - points[i]))
        pair_volume, pair_area = _lens(radii[i], radii[j], distance)
        share = _dihedral(points[i], points[j], points[k], corner) / (2 * pi)
        omega = _solid_angle(points, i, j, k, corner) / (4 * pi)
        volume -= pair_volume
        area -= pair_area
        common_volume += share * pair_volume - omega * ball_volume(radii[i], 3)
        common_area += share * pair_area - omega * sphere_area(radii[i], 3)
    return volume + 2 * common_volume, area + 2 * common_area


def _lens(first: float, second: float, distance: float) -> tuple[float, float]:
    """Volume and area of what two balls have in common: two caps."""
    height = (distance + (first - second) * (first + second) / distance) / 2
    volume = area = 0.0
    for radius, depth in ((first, first - height), (second, second - distance + height)):
        volume += pi * depth**2 * (3 * radius - depth) / 3
        area += 2 * pi * radius * depth
    return volume, area


def _corner(points: Array, radius: float | Array) -> Array:
    """One of the two points on three spheres."""
    first, second, third = np.broadcast_to(radius, 3)
    a, b = points[1] - points[0], points[2] - points[0]
    normal = np.cross(a, b)
    gains = np.array([first**2 - second**2, first**2 - third**2, 0.0])
    foot = np.linalg.solve([a, b, normal], (np.array([a @ a, b @ b, 0]) + gains) / 2)
    height = sqrt(first**2 - foot @ foot)
    return np.asarray(points[0] + foot + height * normal / np.linalg.norm(normal))


def _angle(a: Array, b: Array) -> float:
    return acos(float(a @ b) / float(np.linalg.norm(a) * np.linalg.norm(b)))


def _dihedral(p: Array, q: Array, a: Array, b: Array) -> float:
    """Angle at the edge p q between the half-planes through a and b."""
    axis = (q - p) / np.linalg.norm(q - p)
    return _angle((a - p) - (a - p) @ axis * axis, (b - p) - (b - p) @ axis * axis)


def _solid_angle(points: Array, i: int, j: int, k: int, corner: Array) -> float:
    """Solid angle at p_i of the tetrahedron p_i p_j p_k corner (Girard)."""
    a, b, c = points[j], points[k], corner
    apex = points[i]
    return (
        _dihedral(apex, a, b, c) + _dihedral(apex, b, c, a) + _dihedral(apex, c, a, b) - pi
    )  # fmt: skip


# --- quadrature of one point's measures -----------------------------------------------------


def visible_arcs(middles: Array, half_widths: Array) -> tuple[Array, Array]:
    """Arcs of circles outside hidden arcs: (..., k) middles and half widths in [0, pi] -> ends.

    Returns starts and ends in [0, 2 pi], (..., 2 k + 1); arcs that do not exist have length 0.
    """
    turn = 2 * pi
    first = np.mod(middles - half_widths, turn)
    starts = np.concatenate([first, first - turn], axis=-1)
    ends = starts + 2 * np.concatenate([half_widths, half_widths], axis=-1)
    rank = np.argsort(starts, axis=-1)
    starts = np.clip(np.take_along_axis(starts, rank, -1), 0, turn)
    ends = np.clip(np.take_along_axis(ends, rank, -1), 0, turn)
    edge = np.zeros((*starts.shape[:-1], 1))
    reached = np.maximum.accumulate(np.concatenate([edge, ends], axis=-1), axis=-1)
    nexts = np.concatenate([starts, edge + turn], axis=-1)
    return reached, np.maximum(reached, nexts)


def radical_heights(arms: Array, radius: float, radii: Array) -> Array:
    """Distance, along each arm, of the points that have the same power for both balls, (k,)."""
    distances = np.linalg.norm(arms, axis=1)
    return np.asarray((distances + (radius - radii) * (radius + radii) / distances) / 2)


def moments_on_sphere(
    arms: Array, radius: float, heights: Array | None = None, nodes: int = 32
) -> tuple[float, Array, Array]:
    """Integrals of 1, n and n n^T over the part of a sphere outside the balls at `arms` (k, d).

    Their radical planes are at these heights along the arms, by default in the middle. In 2D
    exact. In 3D exact along each parallel of latitude and by Gauss-Legendre quadrature between
    the latitudes at which an arc appears or vanishes, square-root ends smoothed by
    z = middle - half cos(s).
    """
    if heights is None:
        heights = np.linalg.norm(arms, axis=1) / 2
    d = arms.shape[1]
    if heights.min(initial=radius) <= -radius:
        return 0.0, np.zeros(d), np.zeros((d, d))
    arms, heights = arms[heights < radius], heights[heights < radius]
    distances = np.linalg.norm(arms, axis=1)
    levels = heights / radius
    longitudes = np.arctan2(arms[:, 1], arms[:, 0])
    if d == 2:
        starts, ends = visible_arcs(longitudes, np.arccos(levels))
        return _sum_over_arcs(starts, ends, np.ones(1), radius * np.ones(1))
    flat = np.hypot(arms[:, 0], arms[:, 1])
    units = arms / distances[:, np.newaxis]
    breaks = np.concatenate([_ends_on_sphere(units, levels), _corners_on_sphere(units, levels)])
    z, weights = _smoothed_gauss(np.unique(np.r_[-1, 1, breaks[:, 2]]), nodes)
    parallel = np.sqrt(1 - z * z)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosines = (distances * levels - np.outer(z, arms[:, 2])) / np.outer(parallel, flat)
    half_widths = np.arccos(np.clip(cosines, -1, 1))
    starts, ends = visible_arcs(np.broadcast_to(longitudes, half_widths.shape), half_widths)
    return _sum_over_arcs(starts, ends, parallel, weights * radius**2, z)


def _sum_over_arcs(
    starts: Array, ends: Array, parallel: Array, weights: Array, z: Array | None = None
) -> tuple[float, Array, Array]:
    def over(f: Callable[[Array], Array]) -> Array:
        return np.asarray((f(ends) - f(starts)).sum(axis=-1))

    length, c, s = over(lambda t: t), over(np.sin), over(lambda t: -np.cos(t))
    cc = over(lambda t: t / 2 + np.sin(2 * t) / 4)
    cs = over(lambda t: np.sin(t) ** 2 / 2)
    rows = {"x": parallel * c, "y": parallel * s}
    square = parallel**2
    tensor = {"xx": square * cc, "xy": square * cs, "yy": square * (length - cc)}
    names = "xy"
    if z is not None:
        names = "xyz"
        rows["z"] = z * length
        tensor |= {"xz": z * rows["x"], "yz": z * rows["y"], "zz": z * z * length}
    return (
        float((weights * length).sum()),
        np.array([(weights * rows[a]).sum() for a in names]),
        np.array([[(weights * tensor[min(a, b) + max(a, b)]).sum() for b in names] for a in names]),
    )


def _ends_on_sphere(units: Array, levels: Array) -> Array:
    """Highest and lowest points w of the circles w . u = level that are in no cap."""
    flat = np.hypot(units[:, 0], units[:, 1])
    ends = []
    for side in (-1, 1):
        angle = np.arctan2(flat, units[:, 2]) + side * np.arccos(levels)
        along = units[:, :2] * (np.sin(angle) / flat)[:, np.newaxis]
        ends.append(np.c_[along, np.cos(angle)])
    return _below(np.concatenate(ends), units, levels)


def _corners_on_sphere(units: Array, levels: Array) -> Array:
    """Points w of the unit sphere on two circles w . u = level and in no cap w . u > level."""
    i, j = np.triu_indices(len(units), 1)
    a, b = units[i], units[j]
    product = np.einsum("ij,ij->i", a, b)
    sine2 = 1 - product**2
    along_a = (levels[i] - product * levels[j]) / sine2
    along_b = (levels[j] - product * levels[i]) / sine2
    foot = along_a[:, np.newaxis] * a + along_b[:, np.newaxis] * b
    rest = (1 - np.einsum("ij,ij->i", foot, foot)) / sine2
    met = rest > 0
    swing = np.sqrt(rest[met])[:, np.newaxis] * np.cross(a[met], b[met])
    return _below(np.concatenate([foot[met] + swing, foot[met] - swing]), units, levels)


def visible_rims(arms: Array, radius: float, heights: Array) -> tuple[Array, Array]:
    """What is visible of the circle in which the sphere meets each other one, its rim.

    `arms` (k, d) and `heights` (k,) as for `moments_on_sphere`. Returns the visible angle of each
    (in 2D the number of visible points), (k,), and the integral (the sum) of the unit vectors from
    the middle of the circle over it, (k, d).
    """
    angles, sums = np.zeros(len(arms)), np.zeros(arms.shape)
    distances = np.linalg.norm(arms, axis=1)
    for j in np.flatnonzero(abs(heights) < radius):
        rho = sqrt(radius**2 - heights[j] ** 2)
        frame = np.linalg.svd(arms[j, np.newaxis])[2][1:]
        others = np.delete(arms, j, axis=0)
        flat = rho * others @ frame.T
        room = np.delete(distances * heights, j) - others @ arms[j] * heights[j] / distances[j]
        if arms.shape[1] == 2:
            for sign in (1, -1):
                is_visible = np.all(sign * flat[:, 0] <= room)
                angles[j] += is_visible
                sums[j] += is_visible * sign * frame[0]
            continue
        half_widths = np.arccos(np.clip(room / np.hypot(*flat.T), -1, 1))
        starts, ends = visible_arcs(np.arctan2(flat[:, 1], flat[:, 0]), half_widths)
        angles[j] = (ends - starts).sum()
        parts = [(np.sin(ends) - np.sin(starts)).sum(), (np.cos(starts) - np.cos(ends)).sum()]
        sums[j] = parts @ frame
    return angles, sums


def rim_weights(arms: Array, radius: float) -> Array:
    """Weight w of each neighbour in grad_area_i = -sum w u: from the visible part of the rim.

    In 3D r times the visible angle of the circle in which two spheres meet, in 2D r / rho for
    each visible point; `arms` (k, d) are the neighbours relative to p_i.
    """
    halves = np.linalg.norm(arms, axis=1) / 2
    weights = radius * visible_rims(arms, radius, halves)[0]
    if arms.shape[1] == 2:
        weights[weights > 0] /= np.sqrt(radius**2 - halves[weights > 0] ** 2)
    return weights


def facet_areas(arms: Array, radius: float, heights: Array | None = None, nodes: int = 32) -> Array:
    """Measure of the facet towards each neighbour, (k,); arms and heights as in `visible_rims`.

    With v in the bisector, from its foot, neighbour k leaves the side a_k . v <= b_k. In 2D that
    is an interval. In 3D the area is int_0^rho s angle(s) ds with angle(s) exact, integrated as
    in `moments_on_sphere`.
    """
    areas = np.zeros(len(arms))
    distances = np.linalg.norm(arms, axis=1)
    if heights is None:
        heights = distances / 2
    for j, arm in enumerate(arms):
        rho2 = radius**2 - heights[j] ** 2
        others = np.delete(arms, j, axis=0)
        normals = others @ np.linalg.svd(arm[np.newaxis])[2][1:].T
        sizes = np.linalg.norm(normals, axis=1)
        levels = np.delete(distances * heights, j) - others @ arm * heights[j] / distances[j]
        levels /= sizes
        if rho2 <= 0 or levels.min(initial=0) <= -sqrt(rho2):
            continue
        near = levels < sqrt(rho2)
        units, levels = normals[near] / sizes[near, np.newaxis], levels[near]
        if arms.shape[1] == 2:
            ends = [np.min(levels[sign * units[:, 0] > 0], initial=sqrt(rho2)) for sign in (1, -1)]
            areas[j] = max(0.0, sum(ends))
            continue
        feet = _below(levels[:, np.newaxis] * units, units, levels)
        corners = _corners_in_plane(units, levels)
        breaks = np.r_[0, sqrt(rho2), np.linalg.norm(np.concatenate([feet, corners]), axis=1)]
        s, weights = _smoothed_gauss(np.unique(breaks[breaks <= sqrt(rho2)]), nodes)
        half_widths = np.arccos(np.clip(levels / s[:, np.newaxis], -1, 1))
        longitudes = np.arctan2(units[:, 1], units[:, 0])
        starts, arcs = visible_arcs(np.broadcast_to(longitudes, half_widths.shape), half_widths)
        areas[j] = (weights * s * (arcs - starts).sum(axis=-1)).sum()
    return areas


def _corners_in_plane(units: Array, levels: Array) -> Array:
    """Corners of the polygon units . v <= levels."""
    i, j = np.triu_indices(len(units), 1)
    sine = units[i, 0] * units[j, 1] - units[i, 1] * units[j, 0]
    x = (levels[i] * units[j, 1] - levels[j] * units[i, 1]) / sine
    y = (levels[j] * units[i, 0] - levels[i] * units[j, 0]) / sine
    return _below(np.c_[x, y], units, levels)


def _below(places: Array, units: Array, levels: Array) -> Array:
    """Those of some places v with units . v <= levels for all."""
    return np.asarray(places[(places @ units.T <= levels + 1e-9).all(axis=1)])


def _smoothed_gauss(breaks: Array, nodes: int) -> tuple[Array, Array]:
    """Abscissae and weights between breakpoints at which the integrand may be a square root."""
    x, weight = np.polynomial.legendre.leggauss(nodes)
    s = pi * (x + 1) / 2
    middle, half = (breaks[1:] + breaks[:-1]) / 2, (breaks[1:] - breaks[:-1]) / 2
    z = middle[:, np.newaxis] - half[:, np.newaxis] * np.cos(s)
    return z.ravel(), (half[:, np.newaxis] * np.sin(s) * weight * pi / 2).ravel()


# --- comparisons ----------------------------------------------------------------------------


def scale_of(name: str, union: BallUnion) -> float:
    """Size that a measure of one point can have: radius to the power of its unit."""
    return float(union.radius ** (union.dimension + POWERS[name]))


def assert_close(
    actual: npt.ArrayLike, expected: npt.ArrayLike, rtol: float, scale: float = 0.0
) -> None:
    """Compare to a tolerance relative to the largest expected value, or to a scale."""
    size = max(scale, float(np.max(np.abs(expected))))
    np.testing.assert_allclose(np.asarray(actual), np.asarray(expected), rtol=0, atol=rtol * size)


def assert_same_measures(
    actual: UnionMeasures,
    expected: UnionMeasures,
    rtol: float,
    rotation: Array | None = None,
    *,
    order: npt.ArrayLike = slice(None),  # type: ignore[assignment]
    factor: float = 1.0,
) -> None:
    """Compare all measures of two unions whose points are the same but for order, turn and scale.

    Each to a tolerance relative to its largest value.
    """
    dimension = expected.volume_gradient.shape[1]
    assert actual.volume == pytest.approx(expected.volume * factor**dimension, rel=rtol, abs=0)
    assert actual.area == pytest.approx(expected.area * factor ** (dimension - 1), rel=rtol, abs=0)
    for name, power in POWERS.items():
        if not hasattr(expected, name):
            continue
        values = getattr(expected, name)[order] * factor ** (dimension + power)
        if rotation is not None and values.ndim > 1:
            values = values @ rotation.T
        if rotation is not None and values.ndim > 2:
            values = rotation @ values
        assert_close(getattr(actual, name), values, rtol)


def assert_identities(points: Array, union: BallUnion, rtol: float = 1e-9) -> None:
    """What holds of every union: motions change nothing, homogeneity, the divergence theorem."""
    d, centered = union.dimension, points - points.mean(axis=0)
    span = abs(centered).max()
    for gradient in (union.volume_gradient, union.area_gradient):
        size = abs(gradient).sum()
        assert_close(gradient.sum(axis=0), 0, rtol, size)
        moments = centered.T @ gradient
        assert_close(moments - moments.T, 0, rtol, span * size)
    virial = (centered * union.volume_gradient).sum()
    radii = union.radius if union.radii is None else union.radii
    assert_close(virial + (radii * union.visible_areas).sum(), d * union.volume, rtol)
    traces = np.trace(union.normal_tensors, axis1=1, axis2=2)
    assert_close(traces, union.visible_areas, rtol, scale_of("visible_areas", union))


def assert_positive_tensors(union: BallUnion, rtol: float = 1e-12) -> None:
    """Integrals of n n^T have no negative eigenvalue."""
    least = np.linalg.eigvalsh(union.normal_tensors).min(initial=0)
    assert_close(least, 0, rtol, scale_of("visible_areas", union))
