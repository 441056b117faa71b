from __future__ import annotations

import numpy as np
import pytest

from pcsmooth.kernels.grid.radix_sort import BLOCK, sort_pairs
from pcsmooth.kernels.threads import thread_limit


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("bits", [0, 1, 12, 13, 24, 25, 40, 63])
@pytest.mark.parametrize("n", [1, 2, 1000, BLOCK, 2 * BLOCK + 5])
def test_pairs_are_sorted_by_key_and_keep_their_order(threads: int, bits: int, n: int) -> None:
    rng = np.random.default_rng(bits)
    keys = rng.integers(0, 2**bits, n)
    keys[rng.random(n) < 0.5] = 2**bits - 1  # many alike, with all bits in use
    numbers = rng.permutation(n)
    order = np.argsort(keys, kind="stable")
    with thread_limit(threads):
        pairs = sort_pairs(np.c_[keys, numbers], bits)
    np.testing.assert_array_equal(pairs, np.c_[keys, numbers][order])
