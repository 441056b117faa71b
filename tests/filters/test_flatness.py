from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

import oracles
from filters.whole import surroundings_of
from oracles import Array
from pcsmooth.filters.design import DESIGN
from pcsmooth.filters.flatness import flatness, shows_surface
from pcsmooth.python.denoising import denoise

RNG = np.random.default_rng(0)


def shows(points: Array) -> bool:
    return shows_surface(surroundings_of(points), DESIGN)


def ball(n: int, dimension: int) -> Array:
    radii = RNG.random((n, 1)) ** (1 / dimension)
    return oracles.random_sphere(n, dimension=dimension) * radii


def volumes(dimension: int) -> Iterator[tuple[str, Array]]:
    for side in {2: (9, 20, 60), 3: (6, 12, 20)}[dimension]:
        lattice = oracles.lattice(*[side] * dimension)
        yield f"lattice {side}", lattice
        yield f"jittered lattice {side}", lattice + 0.1 * RNG.normal(size=lattice.shape)
    for n in (250, 1000, 10_000):
        yield f"uniform {n}", RNG.random((n, dimension))
        yield f"blob {n}", RNG.normal(size=(n, dimension))
        yield f"ball {n}", ball(n, dimension)
        yield f"long box {n}", RNG.random((n, dimension)) * [2.0, *[1.0] * (dimension - 1)]


def cube(n: int) -> Array:
    """Random points of the surface of the unit cube."""
    points, side = RNG.random((n, 3)), RNG.integers(0, 6, n)
    points[np.arange(n), side % 3] = side // 3
    return points


def surfaces() -> Iterator[tuple[str, Array]]:
    """Surfaces, and as much noise as still lets them be seen."""
    for n, noises in ((150, (0.1, 0.5)), (1000, (0.1, 1.0)), (10_000, (0.1, 1.0, 3.0))):
        for noise in noises:
            for make in (oracles.sphere_surface, oracles.torus_surface):
                if n > 150 or make is oracles.sphere_surface:
                    yield f"{make.__name__} {n} {noise}", make(n).noisy(noise)
            deviation = noise * (6 / n) ** 0.5
            for name, points in (
                ("cube", cube(n)),
                ("plate", cube(n) * [1, 1, 0.1]),
                ("sheet", np.c_[RNG.random((n, 2)), np.zeros(n)]),
                ("lines", np.c_[RNG.integers(0, 20, n) / 20, RNG.random(n), np.zeros(n)]),
            ):
                yield f"{name} {n} {noise}", points + deviation * RNG.normal(size=(n, 3))
    wire = np.linspace(0, 20, 2000)
    yield "wire", np.c_[np.cos(wire), np.sin(wire), 0.1 * wire]


def curves() -> Iterator[tuple[str, Array]]:
    for n, noises in ((60, (0.1, 1.0)), (400, (0.1, 3.0)), (5000, (0.1, 5.0))):
        for noise in noises:
            deviation = noise / n
            angles = 2 * np.pi * RNG.random(n)
            circle = np.c_[np.cos(angles), np.sin(angles)]
            yield f"circle {n} {noise}", circle + 6.3 * deviation * RNG.normal(size=(n, 2))
            x = 10 * RNG.random(n)
            wave = np.c_[x, np.sin(x)]
            yield f"wave {n} {noise}", wave + 12 * deviation * RNG.normal(size=(n, 2))


CASES = [
    *((name, points, False) for d in (2, 3) for name, points in volumes(d)),
    *((name, points, True) for name, points in (*surfaces(), *curves())),
]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("points", "expected"),
    [(points, expected) for _, points, expected in CASES],
    ids=[f"{name} {points.shape[1]}D" for name, points, _ in CASES],
)
def test_volumes_are_told_from_surfaces(points: Array, expected: bool) -> None:
    assert shows(points) == expected


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_mixed_clouds_have_a_surface(share: float) -> None:
    """Trees on a slope, outliers around a sphere."""
    n = 4000
    many = int(share * n)
    trees = RNG.random((many, 3)) * [1.0, 1.0, 0.5]
    ground = np.c_[RNG.random((n - many, 2)), np.zeros(n - many)]
    ground[:, 2] = 0.3 * ground[:, 0] - 0.02
    assert shows(np.r_[trees, ground])
    around = 3.0 * RNG.random((many, 3)) - 1.5
    assert shows(np.r_[around, oracles.random_sphere(n - many)])


def test_slabs_are_taken_for_noisy_sheets() -> None:
    slab = oracles.lattice(40, 40, 8)
    assert shows(slab)
    assert shows(
        np.c_[40.0 * RNG.random((len(slab), 2)), RNG.normal(0.0, slab[:, 2].std(), len(slab))]
    )


@pytest.mark.parametrize(("dimension", "n"), [(2, 40), (3, 90)])
def test_of_few_points_nothing_is_known(dimension: int, n: int) -> None:
    assert shows(RNG.random((n, dimension)))


def test_flatness() -> None:
    box = np.array([[x, y, z] for x in (-3.0, 3.0) for y in (-2.0, 2.0) for z in (-1.0, 1.0)])
    turned = box @ oracles.random_rotation(3, RNG) + 5.0
    flat = box * [1.0, 1.0, 0.0]
    np.testing.assert_allclose(flatness(np.stack([box, turned, flat])), [1 / 9, 1 / 9, 0])
    assert flatness(np.ones((1, 8, 3))).tolist() == [0.0]


def test_flows_move_volumes_where_they_are_asked_to() -> None:
    points = oracles.lattice(7, 7, 7)
    assert denoise(points).displacement.max() == 0.0
    for options in ({"scheme": "euler"}, {"scheme": "implicit"}, {"noise": 0.3}):
        assert denoise(points, **options).displacement.max() > 0.0
