from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from pcsmooth.tiling.cubes import CELLS_PER_AXIS, cells_within, cube_cells, cube_codes


@pytest.mark.parametrize("dimension", [2, 3])
def test_codes_interleave_the_bits_of_clamped_numbers(dimension: int) -> None:
    rng = np.random.default_rng(dimension)
    corner = rng.normal(size=dimension)
    numbers = rng.integers(0, CELLS_PER_AXIS, (500, dimension))
    numbers[:20] = rng.integers(0, 3, (20, dimension))
    numbers[20:40] = CELLS_PER_AXIS - 1
    points = corner + (numbers + 0.5) * 0.25
    points[20:40] += rng.choice([0.0, 1e9], (20, dimension))
    codes = cube_codes(points, corner, 0.25)
    np.testing.assert_array_equal(cube_cells(codes, dimension), numbers)
    for code, number in zip(codes[:60].tolist(), numbers.tolist(), strict=False):
        bits = [int(n) >> b & 1 for b in range(21) for n in number]
        assert code == sum(bit << place for place, bit in enumerate(bits))
    assert not cube_codes(corner - 1e9 * np.ones((1, dimension)), corner, 0.25).any()


def numbers(dimension: int) -> st.SearchStrategy[npt.NDArray[np.int64]]:
    """Cells that are close together, at either end of the range."""
    near_ends = st.integers(0, 12) | st.integers(CELLS_PER_AXIS - 4, CELLS_PER_AXIS - 1)
    shapes = st.tuples(st.integers(0, 8), st.just(dimension))
    return hnp.arrays(np.int64, shapes, elements=near_ends)


@given(st.data(), st.sampled_from([2, 3]), st.integers(0, 5) | st.just(CELLS_PER_AXIS))
@settings(deadline=None)
def test_cells_within_reach_are_those_of_brute_force(
    data: st.DataObject, dimension: int, reach: int
) -> None:
    cells, targets = data.draw(numbers(dimension)), data.draw(numbers(dimension))
    apart = np.abs(cells[:, None] - targets).max(axis=2)
    np.testing.assert_array_equal(cells_within(cells, targets, reach), (apart <= reach).any(axis=1))
