from __future__ import annotations

import numpy as np
import pytest

from pcsmooth.plots.histogram import height_of, histograms

RNG = np.random.default_rng(5)


@pytest.mark.parametrize("n", [1, 50, 1000, 100_000])
@pytest.mark.parametrize("limits", [(0.0, 1.0), (-0.5, 0.5)])
def test_every_value_is_counted_once(n: int, limits: tuple[float, float]) -> None:
    values = {"a": RNG.normal(size=n), "b": RNG.normal(size=n // 2)}
    counts, edges = histograms(values, limits)
    assert {name: bars.sum() for name, bars in counts.items()} == {"a": n, "b": n // 2}
    assert (edges[0], edges[-1]) == limits
    assert len(edges) == len(counts["a"]) + 1 == len(counts["b"]) + 1
    assert 24 <= len(counts["a"]) <= 60
    inner = ((values["a"] >= edges[1]) & (values["a"] < edges[-2])).sum()
    assert counts["a"][1:-1].sum() == inner


def test_what_is_beyond_is_in_the_outermost_bins() -> None:
    counts, _ = histograms({"a": np.array([-9.0, -8.0, 0.55, 7.0, 8.0, 9.0])}, (0.0, 2.4))
    assert counts["a"][[0, 5, -1]].tolist() == [2, 1, 3]


def test_height() -> None:
    assert height_of({"a": np.array([3, 8]), "b": np.array([20, 0])}) == pytest.approx(27.0)
    assert height_of({"a": np.array([0])}) > 0.0
