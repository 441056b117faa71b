from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import oracles
from pcsmooth import Balls, Polyhedra, load_presets
from pcsmooth.energies.protocol import Quantity

PRESETS = load_presets()


@pytest.mark.parametrize("quantity", ["volume", "area"])
@pytest.mark.parametrize("radius", [0.05, 0.2, 3.0])
@pytest.mark.parametrize(
    ("shapes", "dimension"),
    [
        (Balls(), 2),
        (Balls(), 3),
        (Polyhedra(body=PRESETS["square"]), 2),
        (Polyhedra(body=PRESETS["cube"]), 3),
        (Polyhedra(body=PRESETS["cube"].scaled(0.1)), 3),
        (Polyhedra(body=PRESETS["octahedron"].scaled(5.0)), 3),
    ],
)
def test_no_cell_has_a_larger_mass(
    shapes: Balls, dimension: int, radius: float, quantity: Quantity
) -> None:
    """Neither those of points close together nor that of one far from all."""
    points = oracles.uniform_cloud(100, dimension)
    points[0] = 1000.0
    shapes = replace(shapes, quantity=quantity, weight="cell")
    masses = shapes.energy(radius).evaluate(points).masses
    largest = shapes.largest_mass(radius, dimension)
    assert masses.max() <= largest * (1 + 1e-12)
    if not isinstance(shapes, Polyhedra):
        assert np.isclose(masses.max(), largest, rtol=1e-12)
