"""Rows that can be drawn."""

from __future__ import annotations

import numpy as np
import pytest

from pcsmooth.errors import InvalidInputError
from pcsmooth.plots.finite_rows import finite_rows


def test_rows_are_finite_in_each_cloud() -> None:
    first = np.array([[0.0, np.nan], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]])
    last = np.array([[0.0, 0.0], [1.0, 1.0], [np.inf, 2.0], [3.0, 3.0]])
    assert finite_rows(first, last).tolist() == [1, 3]
    with pytest.raises(InvalidInputError, match="no point with finite coordinates is left"):
        finite_rows(first[::2], last[::2])
