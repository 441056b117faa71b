from __future__ import annotations

import numpy as np
import pytest

from pcsmooth.errors import InvalidInputError
from pcsmooth.point_order import HALVINGS
from pcsmooth.tiling.cube_width import choose_width
from pcsmooth.tiling.cubes import cube_codes


def fullest(points: np.ndarray, corner: np.ndarray, width: float) -> int:
    return int(np.unique(cube_codes(points, corner, width), return_counts=True)[1].max())


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("most", [200, 1000, 3000, 20_000])
def test_widest_cubes_that_hold_no_more(dimension: int, most: int) -> None:
    rng = np.random.default_rng(0)
    points = rng.random((20_000, dimension)) ** 2  # denser at a corner
    points[:, -1] *= 0.01
    corner, extent = points.min(axis=0), float(np.ptp(points, axis=0).max())
    width = choose_width(points, 20_000, corner, extent, most)
    assert fullest(points, corner, width) <= most
    assert width == extent or fullest(points, corner, 2 * width) > most


def test_sample_stands_for_the_whole_cloud() -> None:
    points = np.random.default_rng(0).random((100_000, 2))
    corner = np.zeros(2)
    assert choose_width(points[::10], 100_000, corner, 1.0, 2000) == 1 / 8
    assert fullest(points, corner, 1 / 8) <= 2000


def test_coincident_points_are_split_as_far_as_it_helps() -> None:
    rng = np.random.default_rng(0)
    points = rng.random((10_000, 3))
    points[:3000] = 0.3
    width = choose_width(points, 10_000, np.zeros(3), 1.0, 100)
    assert 1 / 32 <= width <= 1 / 8  # where it holds few others, and cubes still hold several
    assert choose_width(points[:3000], 3000, np.zeros(3), 1.0, 100) == 1.0
    assert choose_width(points[:3000], 3000, points[0], 0.0, 100) == 1.0
    assert choose_width(points[:1], 1, points[0], 0.0, 1) == 1.0


def test_sparse_samples_do_not_lead_to_tiny_cubes() -> None:
    points = np.random.default_rng(0).random((1000, 2))
    assert choose_width(points, 10**9, np.zeros(2), 1.0, 1000) == 1 / 16


def test_halving_ends() -> None:
    points = np.repeat([[0.0, 0.0], [2.0**-30, 0.0], [1.0, 1.0]], 100, axis=0)
    assert choose_width(points, 300, np.zeros(2), 1.0, 100) == 1.0
    points[100:200] = 2.0**-20
    assert choose_width(points, 300, np.zeros(2), 1.0, 100) == 2.0**-HALVINGS


@pytest.mark.parametrize(
    ("samples", "extent", "most"),
    [(0, 1.0, 1), (1, -1.0, 1), (1, np.nan, 1), (1, np.inf, 1), (1, 1.0, 0)],
)
def test_what_has_no_width(samples: int, extent: float, most: int) -> None:
    with pytest.raises(InvalidInputError, match="no width of cubes"):
        choose_width(np.zeros((samples, 2)), 1, np.zeros(2), extent, most)
