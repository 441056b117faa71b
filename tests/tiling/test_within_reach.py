from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from pcsmooth.errors import InvalidInputError
from pcsmooth.tiling.within_reach import within_reach


def chebyshev(
    own: npt.NDArray[np.float64], others: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Distance of each of the others to the nearest own point."""
    distances: npt.NDArray[np.float64] = cKDTree(own).query(others, p=np.inf)[0]
    return distances


@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([2, 3]),
    st.sampled_from([0.001, 0.1, 0.25, 1.0, 50.0]),
    st.sampled_from([0.0, -3.3, 1e6]),
)
@settings(deadline=None)
def test_all_points_within_reach_are_found_and_none_far(
    seed: int, dimension: int, reach: float, offset: float
) -> None:
    rng = np.random.default_rng(seed)
    own = rng.random((80, dimension)) * [1.0, 4.0, 2.0][:dimension] + offset
    others = np.concatenate([rng.uniform(-2.0, 4.0, (200, dimension)) + offset, own[:5]])
    near = within_reach(own, others, reach)
    apart = chebyshev(own, others)
    assert near[apart <= reach].all()
    assert not near[apart > 1.500002 * reach].any()


def test_points_of_a_lattice_that_are_just_within_reach() -> None:
    steps = np.arange(300) * 0.1
    own = np.stack([steps, np.zeros(300)], axis=1)
    for reach in (0.1, 0.3, 0.7):
        others = own + np.array([0.0, reach])
        assert within_reach(own, others, reach).all()
        assert not within_reach(own, others, reach / 1.51).any()


def test_far_outliers_on_either_side_lose_nothing() -> None:
    rng = np.random.default_rng(0)
    own = np.concatenate([rng.random((500, 3)), [[1e12, 0.0, 0.0], [-1e9, 1e9, 5.0]]])
    others = np.concatenate(
        [rng.uniform(-1.0, 2.0, (500, 3)), own[-2:] + 1e-3, rng.uniform(-1e12, 1e12, (9, 3))]
    )
    near = within_reach(own, others, 0.05)
    apart = chebyshev(own, others)
    assert near[apart <= 0.05].all()
    assert not near[:500][apart[:500] > 0.0751].any()


@pytest.mark.parametrize(("n_own", "n_others"), [(0, 0), (0, 3), (3, 0), (1, 1)])
def test_few_points(n_own: int, n_others: int) -> None:
    near = within_reach(np.zeros((n_own, 3)), np.zeros((n_others, 3)), 1.0)
    assert near.tolist() == [n_own > 0] * n_others


@pytest.mark.parametrize("reach", [0.0, -1.0, np.nan, np.inf])
def test_reaches_that_are_none(reach: float) -> None:
    with pytest.raises(InvalidInputError, match="it must be positive and finite"):
        within_reach(np.zeros((1, 2)), np.zeros((1, 2)), reach)
