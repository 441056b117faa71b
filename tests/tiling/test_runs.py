from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pcsmooth.tiling.runs import equal_starts, join_runs


@given(st.lists(st.tuples(st.integers(0, 6), st.integers(0, 3)), max_size=12))
def test_joined_runs_hold_the_same_rows_and_do_not_adjoin(pairs: list[tuple[int, int]]) -> None:
    runs = np.array([(start, start + size) for start, size in pairs], np.int64).reshape(-1, 2)
    joined = join_runs(runs)

    def rows(of: np.ndarray) -> list[int]:
        return [row for start, stop in of.tolist() for row in range(start, stop)]

    assert rows(joined) == rows(runs)
    assert np.all(joined[:, 0] < joined[:, 1])
    assert not np.any(joined[1:, 0] == joined[:-1, 1])


@given(st.lists(st.integers(0, 4), max_size=20))
def test_starts_of_equal_values_are_those_of_unique(values: list[int]) -> None:
    ordered = np.sort(np.array(values, np.int64))
    np.testing.assert_array_equal(equal_starts(ordered), np.unique(ordered, return_index=True)[1])
