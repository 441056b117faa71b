"""Expected measures of unions of bodies p_i + r_i K, which owe nothing to the kernels.

Three kinds: closed forms (boxes, simplices, a cube cut by a plane), brute force on Qhull
(`HalfspaceIntersection` of every half-space there is), and Monte Carlo. Of a body they read its
normals and offsets alone. In 2D read area for volume and length for area. A radius is one for all
points, or each has its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations, product
from math import factorial, prod, sqrt
from typing import Literal, Protocol, get_args

import numpy as np
import numpy.typing as npt
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

import oracles

Array = npt.NDArray[np.float64]
Simplex = tuple[int, ...]

Rule = Literal["naive", "inclusion-exclusion", "exact"]
RULES: tuple[Rule, ...] = get_args(Rule)


class Body(Protocol):
    """K = {x : normals . x <= offsets}, with unit normals."""

    @property
    def normals(self) -> Array: ...

    @property
    def offsets(self) -> Array: ...


@dataclass(frozen=True)
class Solid:
    normals: Array
    offsets: Array


@dataclass(frozen=True)
class Union:
    """Measures of a union; those per body leave out what two bodies share twice."""

    volume: float
    area: float
    visible_areas: Array
    volume_gradient: Array


# --- bodies ---------------------------------------------------------------------------------

SHAPES = {
    2: ("square", "hexagon", "triangle", "lopsided polygon"),
    3: ("cube", "tetrahedron", "icosahedron", "sphere", "lopsided polyhedron"),
}

_LOPSIDED = {"lopsided polygon": (2, 7, 1), "lopsided polyhedron": (3, 11, 30)}


@cache
def solid(shape: str) -> Solid:
    """Bodies by name; all but the lopsided ones have their centre at the origin."""
    if shape in ("square", "cube"):
        dimension = 2 if shape == "square" else 3
        return Solid(np.r_[np.eye(dimension), -np.eye(dimension)], np.ones(2 * dimension))
    if shape in ("triangle", "hexagon"):
        sides = 3 if shape == "triangle" else 6
        return Solid(oracles.even_circle(sides), np.full(sides, 0.6 if sides == 3 else 1.0))
    if shape == "tetrahedron":
        corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
        return Solid(corners / sqrt(3), np.full(4, 0.5))
    if shape == "icosahedron":
        golden = (1 + sqrt(5)) / 2
        rectangles = [[0, a / golden, b * golden] for a, b in product((-1, 1), repeat=2)]
        corners = np.concatenate(
            [list(product((-1, 1), repeat=3))]
            + [np.roll(rectangles, shift, axis=1) for shift in range(3)]
        )
        return Solid(corners / sqrt(3), np.ones(20))
    if shape == "sphere":
        return Solid(oracles.even_sphere(50), np.ones(50))
    dimension, facets, seed = _LOPSIDED[shape]
    rng = np.random.default_rng(seed)
    normals = oracles.random_sphere(facets, seed=seed, dimension=dimension)
    return Solid(normals, rng.uniform(0.8, 1.1, facets))


def rotated(body: Body, rotation: Array) -> Solid:
    return Solid(body.normals @ rotation.T, body.offsets)


# --- clouds ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scene:
    points: Array
    radius: float
    body: Solid


@cache
def scene(shape: str, kind: str, n: int, seed: int = 0) -> Scene:
    """Random points whose bodies overlap a lot, and a radius that shows parts of most of them.

    A "cloud" fills the unit cube, a "cap" is a noisy piece of the unit sphere. No two bodies have
    facets in nearly one plane: areas jump where they pass each other.
    """
    body = solid(shape)
    dimension = body.normals.shape[1]
    size = 1.0 if kind == "cloud" else oracles.sphere_area(1.0, dimension) / 5
    spacing = (size / n) ** (1 / (dimension if kind == "cloud" else dimension - 1))
    ball = oracles.ball_volume(1.0, dimension) / measure_body(body).volume
    radius = (0.75 if kind == "cloud" else 1.2) * spacing * ball ** (1 / dimension)
    for attempt in range(1000 * seed, 1000 * seed + 1000):
        if kind == "cloud":
            points = oracles.uniform_cloud(n, dimension, attempt)
        else:
            around = oracles.random_sphere(5 * n, dimension=dimension, seed=attempt)
            points = around[np.argsort(-around[:, -1])[:n]]
            noise = np.random.default_rng(attempt).normal(size=(n, 1))
            points = points * (1 + 0.2 * spacing * noise)
        if smallest_gap(points, body) > 1e-4 * radius:
            return Scene(points, radius, body)
    raise AssertionError("no seed gives points in general position")


def smallest_gap(points: Array, body: Body) -> float:
    """Smallest distance of the planes of two equal facets of two bodies."""
    heights = np.sort(points @ body.normals.T, axis=0)
    return float(np.diff(heights, axis=0).min())


def levels_of(points: Array, radius: Array | float, body: Body) -> Array:
    """How high the facets of the bodies are, (n, F)."""
    return points @ body.normals.T + np.reshape(radius, (-1, 1)) * body.offsets


# --- polytopes by Qhull ---------------------------------------------------------------------


@dataclass(frozen=True)
class Polytope:
    volume: float
    facet_areas: Array
    vertices: Array


def intersect_half_spaces(normals: Array, offsets: Array) -> Polytope | None:
    """Polytope {x : normals . x <= offsets}; None where it has no interior."""
    centre, inradius = _place_inside(normals, offsets)
    if inradius <= 1e-10:
        return None
    # about the centre, for the sake of the rounding of Qhull's dual points
    levels = offsets - normals @ centre
    crossing = HalfspaceIntersection(np.c_[normals, -levels], np.zeros(normals.shape[1]))
    vertices = crossing.intersections
    areas = _facet_measures(vertices, normals, levels)
    volume = float(levels @ areas) / normals.shape[1]
    assert volume == pytest.approx(ConvexHull(vertices).volume, rel=1e-7)
    return Polytope(volume, areas, vertices + centre)


def _place_inside(normals: Array, offsets: Array) -> tuple[Array, float]:
    """A point and its distance from the boundary: the origin, or where that is near, the middle.

    A negative distance: there is no inside.
    """
    dimension = normals.shape[1]
    if offsets.min() > 0.1 * np.median(offsets):
        return np.zeros(dimension), float(offsets.min())
    found = linprog(
        np.r_[np.zeros(dimension), -1],
        A_ub=np.c_[normals, np.ones(len(normals))],
        b_ub=offsets,
        bounds=[(None, None)] * (dimension + 1),
    )
    assert found.status == 0, found.message
    return found.x[:dimension], float(found.x[dimension])


def _facet_measures(vertices: Array, normals: Array, levels: Array) -> Array:
    """Length or area of each facet normal . x = level, from the corners of all."""
    on = abs(normals @ vertices.T - levels[:, np.newaxis]) < 1e-9 * abs(vertices).max()
    counts = on.sum(axis=1)
    if normals.shape[1] == 2:
        along = np.c_[-normals[:, 1], normals[:, 0]] @ vertices.T
        ends = np.where(on, along, np.inf).min(axis=1), np.where(on, along, -np.inf).max(axis=1)
        return np.where(counts >= 2, ends[1] - ends[0], 0.0)
    middles = on @ vertices / np.maximum(counts, 1)[:, np.newaxis]
    across = np.linalg.svd(normals[:, np.newaxis])[2][:, 1:]
    flat = (vertices - middles[:, np.newaxis]) @ across.transpose(0, 2, 1)
    around = np.argsort(np.where(on, np.arctan2(flat[..., 1], flat[..., 0]), np.inf), axis=1)
    is_corner = np.arange(len(vertices)) < counts[:, np.newaxis]
    around = np.where(is_corner, around, around[:, :1])  # the others stay at the first
    x, y = np.take_along_axis(flat, around[..., np.newaxis], axis=1).transpose(2, 0, 1)
    doubles = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)
    return np.where(counts >= 3, abs(doubles) / 2, 0.0)


@cache
def _measured(shape_bytes: tuple[bytes, bytes, int]) -> Polytope:
    normals, offsets = (np.frombuffer(part) for part in shape_bytes[:2])
    polytope = intersect_half_spaces(normals.reshape(-1, shape_bytes[2]), offsets)
    assert polytope is not None
    return polytope


def measure_body(body: Body) -> Polytope:
    """K itself, for r = 1."""
    normals = np.ascontiguousarray(body.normals, float)
    offsets = np.ascontiguousarray(body.offsets, float)
    return _measured((normals.tobytes(), offsets.tobytes(), normals.shape[1]))


# --- naive ----------------------------------------------------------------------------------


def naive_cells(
    points: Array, radius: Array | float, body: Body, numbers: Iterable[int] | None = None
) -> tuple[Array, Array]:
    """|V_i and (p_i + r_i K)| and the area of its facets in V_i, for each of the points.

    Each cell is cut by the radical planes of the balls in the bodies and in all others. Of the
    numbers alone, if given; the others have 0.
    """
    volumes, areas = np.zeros(len(points)), np.zeros(len(points))
    radii = np.broadcast_to(radius, len(points))
    powers = (radii * body.offsets.min()) ** 2
    for i in range(len(points)) if numbers is None else numbers:
        point = points[i]
        arms = np.delete(points, i, axis=0) - point
        distances = np.linalg.norm(arms, axis=1)
        heights = (distances + (powers[i] - np.delete(powers, i)) / distances) / 2
        cell = intersect_half_spaces(
            np.r_[body.normals, arms / distances[:, np.newaxis]],
            np.r_[radii[i] * body.offsets, heights],
        )
        if cell is not None:
            volumes[i] = cell.volume
            areas[i] = cell.facet_areas[: len(body.normals)].sum()
    return volumes, areas


@cache
def naive_cells_of_scene(shape: str, kind: str, n: int, seed: int = 0) -> tuple[Array, Array]:
    """`naive_cells` of a `scene`."""
    made = scene(shape, kind, n, seed)
    return naive_cells(made.points, made.radius, made.body)


# --- inclusion-exclusion --------------------------------------------------------------------


def sum_over_simplices(
    points: Array, radius: Array | float, body: Body, simplices: Iterable[Simplex] | None = None
) -> Union:
    """Inclusion-exclusion over a complex, its vertices included.

    Without a complex the sum runs over the whole nerve: every set of bodies that meet. That is the
    exact union, and its boundary too, since the area of the boundary is a valuation.
    """
    terms = (
        _nerve(points, radius, body)
        if simplices is None
        else ((s, _intersect_bodies(points, radius, body, s)) for s in simplices)
    )
    volume, areas, gradient = 0.0, np.zeros(len(points)), np.zeros_like(points)
    heights = levels_of(points, radius, body)
    for simplex, polytope in terms:
        if polytope is None:
            continue
        sign = (-1) ** (len(simplex) - 1)
        lowest = np.array(simplex)[np.argmin(heights[list(simplex)], axis=0)]
        volume += sign * polytope.volume
        np.add.at(areas, lowest, sign * polytope.facet_areas)
        np.add.at(gradient, lowest, sign * polytope.facet_areas[:, np.newaxis] * body.normals)
    return Union(volume, float(areas.sum()), areas, gradient)


def _intersect_bodies(
    points: Array, radius: Array | float, body: Body, simplex: Simplex
) -> Polytope | None:
    chosen = list(simplex)
    middle = points[chosen].mean(axis=0)  # which is often inside
    radii = np.broadcast_to(radius, len(points))[chosen]
    levels = levels_of(points[chosen] - middle, radii, body)
    found = intersect_half_spaces(body.normals, levels.min(axis=0))
    return None if found is None else replace(found, vertices=found.vertices + middle)


def _nerve(points: Array, radius: Array | float, body: Body) -> Iterator[tuple[Simplex, Polytope]]:
    waiting: list[Simplex] = [(i,) for i in range(len(points))]
    while waiting:
        simplex = waiting.pop()
        polytope = _intersect_bodies(points, radius, body, simplex)
        if polytope is not None:
            yield simplex, polytope
            waiting += [(*simplex, j) for j in range(simplex[-1] + 1, len(points))]


def alpha_complex(points: Array, radius: Array | float) -> set[Simplex]:
    """Simplices up to `radius` by the definition, from all empty circumscribed spheres.

    If each point has its own radius, what the sphere has in common with their balls is that all
    are orthogonal. Points in general position, and few of them: every subset of d + 1 is looked at.
    """
    weights = np.broadcast_to(np.square(radius), len(points))
    values = _alpha_values(
        (np.ascontiguousarray(points, float).tobytes(), *points.shape),
        np.ascontiguousarray(weights).tobytes(),
    )
    return {simplex for simplex, value in values.items() if value <= 0}


@cache
def _alpha_values(cloud: tuple[bytes, int, int], radii2: bytes) -> dict[Simplex, float]:
    """The power of each simplex of the regular triangulation that it has in the complex."""
    n, dimension = cloud[1:]
    points, weights = np.frombuffer(cloud[0]).reshape(n, dimension), np.frombuffer(radii2)
    values: dict[Simplex, float] = {}
    for size in range(dimension + 1, 0, -1):
        candidates = (
            set(combinations(range(n), size))
            if size == dimension + 1
            else {face for s in values if len(s) == size + 1 for face in combinations(s, size)}
        )
        for simplex in candidates:
            centre, own = _circumscribed(points[list(simplex)], weights[list(simplex)])
            others = np.delete(points, list(simplex), axis=0)
            powers = ((others - centre) ** 2).sum(axis=1) - np.delete(weights, list(simplex))
            empty = not (powers < own).any()
            if empty:
                values[simplex] = own
            elif size <= dimension:
                cofaces = [v for s, v in values.items() if len(s) == size + 1 and {*simplex} < {*s}]
                values[simplex] = min(cofaces)
    return values


def _circumscribed(corners: Array, weights: Array) -> tuple[Array, float]:
    """Centre of the smallest sphere orthogonal to all balls, and its squared radius."""
    arms = corners[1:] - corners[0]
    if len(arms) == 0:
        return corners[0], -float(weights[0])
    gram = arms @ arms.T
    centre = np.linalg.solve(gram, (np.diag(gram) + weights[0] - weights[1:]) / 2) @ arms
    return corners[0] + centre, float(centre @ centre - weights[0])


def gudhi_alpha_complex(points: Array, radius: Array | float) -> set[Simplex]:
    """The same by gudhi; the test is skipped where it is not installed."""
    gudhi = pytest.importorskip("gudhi")
    weights = np.broadcast_to(np.square(radius), len(points)).tolist()
    whole = gudhi.AlphaComplex(points=points.tolist(), weights=weights, precision="exact")
    tree = whole.create_simplex_tree(max_alpha_square=0.0)
    return {tuple(sorted(simplex)) for simplex, _ in tree.get_simplices()}


# --- exact unions ---------------------------------------------------------------------------


def box_union(points: Array, radius: Array | float, tolerance: float = 0.0) -> Union:
    """Union of cubes (squares) of half side `radius`, on the grid of all their coordinates.

    A part of the boundary that several boxes share is the first one's. Coordinates that are not
    more than `tolerance` apart are one.
    """
    n, dimension = points.shape
    halves = np.reshape(radius, (-1, 1))
    faces = np.stack([points - halves, points + halves])
    places = np.empty(faces.shape, int)
    widths = []
    for axis in range(dimension):
        ticks, where = np.unique(faces[:, :, axis], return_inverse=True)
        one = np.r_[0, np.cumsum(np.diff(ticks) > tolerance)]
        places[:, :, axis] = one[where].reshape(2, n)
        widths.append(np.diff(ticks[np.r_[True, np.diff(one) > 0]]))
    covered = np.zeros([len(w) + 2 for w in widths], bool)  # a layer of nothing all around
    spans = [[slice(*places[:, i, axis] + 1) for axis in range(dimension)] for i in range(n)]
    for span in spans:
        covered[tuple(span)] = True
    volume = _weigh(covered[(slice(1, -1),) * dimension], widths)
    areas, gradient = np.zeros(n), np.zeros_like(points)
    area = 0.0
    for axis in range(dimension):
        steps = np.diff(covered.astype(np.int8), axis=axis)
        across = [w for k, w in enumerate(widths) if k != axis]
        inner = tuple(slice(None) if k == axis else slice(1, -1) for k in range(dimension))
        area += sum(
            _weigh(abs(np.take(steps[inner], layer, axis=axis)), across)
            for layer in range(steps.shape[axis])
        )
        for side in (-1, 1):
            free = steps == -side
            for i, span in enumerate(spans):
                layer = span[axis].start - 1 if side < 0 else span[axis].stop - 1
                part = tuple(layer if k == axis else s for k, s in enumerate(span))
                own = [
                    w[s.start - 1 : s.stop - 1]
                    for k, (w, s) in enumerate(zip(widths, span, strict=True))
                    if k != axis
                ]
                seen = _weigh(free[part], own)
                free[part] = False
                areas[i] += seen
                gradient[i, axis] += side * seen
    assert areas.sum() == pytest.approx(area, rel=1e-13)
    return Union(volume, area, areas, gradient)


def _weigh(cells: npt.NDArray[np.generic], widths: list[Array]) -> float:
    total = cells.astype(float)
    for width in reversed(widths):
        total = total @ width
    return float(total)


def simplex_union(points: Array, radius: Array | float, body: Body) -> tuple[Union, Array]:
    """Union of homothetic simplices in closed form, with the gradient of its area.

    Any intersection of them is {x : n_k . x <= b_k} with the normals of the simplex, so it is
    a homothetic one of size (sum of A_k b_k) / (d |K|), because the A_k n_k add up to 0; it is
    empty where that is negative. The sum runs over the whole nerve.
    """
    n, dimension = points.shape
    assert len(body.normals) == dimension + 1
    whole = measure_body(body)
    share = whole.facet_areas / (dimension * whole.volume)
    heights = levels_of(points, radius, body)
    volume, areas = 0.0, np.zeros(n)
    gradients = np.zeros((2, n, dimension))
    for count in range(1, n + 1):
        sign = (-1) ** (count - 1)
        for simplex in combinations(range(n), count):
            chosen = heights[list(simplex)]
            size = share @ chosen.min(axis=0)
            if size <= 0:
                continue
            lowest = np.array(simplex)[np.argmin(chosen, axis=0)]
            growth = sign * share[:, np.newaxis] * body.normals
            volume += sign * whole.volume * size**dimension
            np.add.at(areas, lowest, sign * whole.facet_areas * size ** (dimension - 1))
            rates = (
                dimension * whole.volume * size ** (dimension - 1),
                (dimension - 1) * whole.facet_areas.sum() * size ** (dimension - 2),
            )
            for gradient, rate in zip(gradients, rates, strict=True):
                np.add.at(gradient, lowest, rate * growth)
    return Union(volume, float(areas.sum()), areas, gradients[0]), gradients[1]


def polygon_union(
    points: Array, radius: Array | float, body: Body, tolerance: float = 1e-12
) -> Union:
    """Union of homothetic polygons: each edge is a segment minus a union of intervals.

    Of edges on one line the first body's is kept; edges that touch from both sides are covered.
    """
    corners, numbers = measure_body(body).vertices, np.arange(len(points))
    areas, gradient, volume = np.zeros(len(points)), np.zeros_like(points), 0.0
    for i, (point, size) in enumerate(
        zip(points, np.broadcast_to(radius, len(points)), strict=True)
    ):
        for normal, offset in zip(body.normals, body.offsets, strict=True):
            along = np.array([-normal[1], normal[0]])
            on_edge = corners[abs(corners @ normal - offset) < 1e-9] @ along
            start = point + size * (offset * normal + on_edge.min() * along)
            length = size * np.ptp(on_edge)
            rates = body.normals @ along
            parallel = abs(rates) < 1e-12
            slacks = levels_of(points - start, radius, body)
            # on one line: covered from the other side, or by a body that comes first
            same_side = body.normals @ normal > 0
            later = numbers[:, np.newaxis] > i
            shut = (slacks < -tolerance) | ((abs(slacks) <= tolerance) & same_side & later)
            hides = (numbers != i) & ~(parallel & shut).any(axis=1)
            falling, rising = ~parallel & (rates < 0), ~parallel & (rates > 0)
            low = (slacks[:, falling] / rates[falling]).max(axis=1, initial=0.0)
            high = (slacks[:, rising] / rates[rising]).min(axis=1, initial=length)
            seen, reached = 0.0, 0.0
            for j in sorted(np.flatnonzero(hides & (high > low)), key=lambda j: float(low[j])):
                seen += max(0.0, low[j] - reached)
                reached = max(reached, high[j])
            seen += length - reached
            areas[i] += seen
            gradient[i] += seen * normal
            volume += seen * (normal @ point + size * offset) / 2
    return Union(volume, float(areas.sum()), areas, gradient)


@dataclass(frozen=True)
class Sampled:
    """Monte Carlo estimates and their standard errors."""

    volume: float
    volume_error: float
    visible_areas: Array
    area_errors: Array

    @property
    def area(self) -> float:
        return float(self.visible_areas.sum())

    @property
    def area_error(self) -> float:
        return float(np.linalg.norm(self.area_errors))


def sample_union(points: Array, radius: float, body: Body, samples: int, seed: int = 0) -> Sampled:
    """Volume and visible area of each body, from `samples` points inside and on each body."""
    rng = np.random.default_rng(seed)
    whole = measure_body(body)
    hull = ConvexHull(whole.vertices)
    dimension = points.shape[1]
    triangles = hull.points[hull.simplices]
    cones = np.concatenate(
        [triangles, np.broadcast_to(whole.vertices.mean(axis=0), triangles[:, :1].shape)], axis=1
    )
    heights = points @ body.normals.T + radius * body.offsets
    volume, volume_variance = 0.0, 0.0
    areas, errors = np.zeros(len(points)), np.zeros(len(points))
    body_volume = whole.volume * radius**dimension
    body_area = whole.facet_areas.sum() * radius ** (dimension - 1)
    reach = radius * float(np.linalg.norm(whole.vertices, axis=1).max())
    for i, point in enumerate(points):
        inside = point + radius * _sample_simplices(cones, samples, rng)
        near = np.linalg.norm(points - point, axis=1) < 2 * reach
        near[i] = False
        others = heights[near]
        shares = 1 / (1 + _count_bodies(inside, others, body.normals))
        volume += body_volume * shares.mean()
        volume_variance += body_volume**2 * shares.var() / samples
        on = point + radius * _sample_simplices(triangles, samples, rng)
        seen = int((_count_bodies(on, others, body.normals) == 0).sum())
        areas[i] = body_area * seen / samples
        chance = (seen + 2) / (samples + 4)  # away from 0 and 1, where the variance would be 0
        errors[i] = body_area * sqrt(chance * (1 - chance) / samples)
    return Sampled(volume, sqrt(volume_variance), areas, errors)


def _sample_simplices(simplices: Array, samples: int, rng: np.random.Generator) -> Array:
    arms = simplices[:, 1:] - simplices[:, :1]
    sizes = np.sqrt(np.linalg.det(arms @ arms.transpose(0, 2, 1)))
    chosen = simplices[rng.choice(len(simplices), samples, p=sizes / sizes.sum())]
    weights = rng.dirichlet(np.ones(simplices.shape[1]), samples)
    return np.asarray(np.einsum("sv,svx->sx", weights, chosen))


def _count_bodies(places: Array, heights: Array, normals: Array) -> npt.NDArray[np.int64]:
    """How many bodies, given by the levels of their facets, hold each of the places."""
    levels = places @ normals.T
    counts = np.zeros(len(places), np.int64)
    for body_heights in heights:
        counts += (levels < body_heights).all(axis=1)
    return counts


# --- a cube cut by a plane ------------------------------------------------------------------


def cut_cube(half: float, direction: Array, level: float) -> float:
    """Measure of {x in [-half, half]^d : direction . x <= level}; the direction may be empty."""
    weights = direction[direction != 0] * 2 * half
    level += half * float(direction.sum())
    full = (2 * half) ** len(direction)
    if len(weights) == 0:
        return full * (level >= 0)
    powers = sum(
        (-1) ** sum(corner) * max(0.0, level - weights @ np.array(corner)) ** len(weights)
        for corner in product((0, 1), repeat=len(weights))
    )
    return float(full * powers / (factorial(len(weights)) * weights.prod()))


def naive_pair_of_cubes(arm: Array, radius: float) -> tuple[float, float]:
    """Cell volume and visible area of each of two cubes (squares), `arm` apart."""
    level = float(arm @ arm) / 2
    area = 0.0
    for axis, side in product(range(len(arm)), (-1, 1)):
        area += cut_cube(radius, np.delete(arm, axis), level - side * radius * arm[axis])
    return cut_cube(radius, arm, level), area


def overlap_of_cubes(points: Array, radius: float) -> tuple[float, float]:
    """Volume and boundary area of what all cubes (squares) share; 0 where they do not meet."""
    sides = 2 * radius - np.ptp(points, axis=0)
    if (sides <= 0).any():
        return 0.0, 0.0
    return float(sides.prod()), 2 * sum(prod(np.delete(sides, k)) for k in range(len(sides)))


# --- differences ----------------------------------------------------------------------------


def slopes(
    function: Callable[[Array], npt.ArrayLike], points: Array, direction: Array, step: float
) -> Array:
    """Derivative of a function of a cloud along a direction: central, of order step^4."""
    wide, narrow = (
        (np.asarray(function(points + h * direction)) - function(points - h * direction)) / (2 * h)
        for h in (step, step / 2)
    )
    return np.asarray((4 * narrow - wide) / 3)


def probes(points: Array, count: int, seed: int = 0) -> Iterator[Array]:
    """Directions to differentiate along: all points at once, then some one by one."""
    rng = np.random.default_rng(seed)
    whole = rng.normal(size=points.shape)
    yield whole / np.linalg.norm(whole, axis=1).max()
    for i in rng.permutation(len(points))[:count]:
        direction = np.zeros_like(points)
        direction[i] = rng.normal(size=points.shape[1])
        yield direction / np.linalg.norm(direction)


# --- comparisons ----------------------------------------------------------------------------


class Measured(Protocol):
    """What is compared: a `pcsmooth.PolyhedronUnion`."""

    @property
    def volume(self) -> float: ...

    @property
    def area(self) -> float: ...

    @property
    def cell_volumes(self) -> Array: ...

    @property
    def visible_areas(self) -> Array: ...

    @property
    def volume_gradient(self) -> Array: ...

    @property
    def area_gradient(self) -> Array: ...


def assert_union(actual: Measured, expected: Union, rtol: float) -> None:
    """Compare everything that the oracles know, each relative to its largest value."""
    assert actual.volume == pytest.approx(expected.volume, rel=rtol, abs=0)
    assert actual.area == pytest.approx(expected.area, rel=rtol, abs=0)
    oracles.assert_close(actual.visible_areas, expected.visible_areas, rtol)
    oracles.assert_close(
        actual.volume_gradient, expected.volume_gradient, rtol, expected.visible_areas.max()
    )


def assert_totals(actual: Measured, expected: Union, rtol: float) -> None:
    """Compare the sums alone, where it is open which body a shared part of the boundary is of."""
    assert actual.volume == pytest.approx(expected.volume, rel=rtol, abs=0)
    assert actual.area == pytest.approx(expected.area, rel=rtol, abs=0)
    assert actual.visible_areas.sum() == pytest.approx(expected.area, rel=rtol, abs=0)
