"""Simplices of three points in the plane."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

import polyhedron_oracles as expect
from pcsmooth_experiments.space.triple_complexes import (
    Array,
    Simplex,
    alpha_complex,
    nerve_of_squares,
    square_complex,
    sum_over,
)

pytestmark = pytest.mark.slow

TRIPLES = [2.2 * np.random.default_rng(seed).random((3, 2)) for seed in range(60)]


@pytest.mark.parametrize("points", TRIPLES)
def test_alpha_complex(points: Array) -> None:
    assert alpha_complex(points, 1.0) == expect.alpha_complex(points, 1.0)


def squares_by_brute_force(points: Array) -> set[Simplex]:
    """Centres on a grid from which the nearest points, by the maximum norm, are equally far."""
    ticks = np.linspace(-1.5, 3.7, 1301)
    centers = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 1, 2)
    distances = abs(centers - points).max(axis=-1)
    nearest = distances.min(axis=1, keepdims=True)
    step = ticks[1] - ticks[0]
    near = (distances - nearest < 1.01 * step) & (nearest <= 1.0)
    found: set[Simplex] = {(0,), (1,), (2,)}
    for simplex in [*combinations(range(3), 2), (0, 1, 2)]:
        if near[:, simplex].all(axis=1).any():
            found.add(simplex)
    return found


@pytest.mark.parametrize("points", TRIPLES[:24])
def test_square_complex(points: Array) -> None:
    extents = [np.ptp(points[list(pair)], axis=0).max() for pair in combinations(range(3), 2)]
    sides = np.sort(points, axis=0)
    if abs(np.array(extents) - 2).min() < 0.03 or np.diff(sides, axis=0).min() < 0.03:
        pytest.skip("too near a tie for the grid")
    assert square_complex(points, 1.0) == squares_by_brute_force(points)


@pytest.mark.parametrize("points", TRIPLES[:24])
def test_sums_over_the_nerve_are_exact(points: Array) -> None:
    """So are those over the complex of the maximum norm, and over any alpha-complex with all."""
    exact = expect.box_union(points, 1.0).volume
    assert sum_over(nerve_of_squares(points, 1.0), points, 1.0) == pytest.approx(exact, rel=1e-12)
    squares = square_complex(points, 1.0)
    if np.ptp(points, axis=0).max() <= 2.0:
        assert sum_over(squares, points, 1.0) == pytest.approx(exact, rel=1e-12)
    assert alpha_complex(points, 1.0) <= nerve_of_squares(points, 1.0)
