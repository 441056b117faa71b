from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from pcsmooth.errors import InvalidInputError
from pcsmooth.parts import streamed_median as module
from pcsmooth.parts.streamed_median import (
    Reader,
    streamed_median,
    streamed_order_statistics,
    streamed_percentile,
)
from pcsmooth.tiling.column_store import FileColumn


@pytest.fixture(params=[0, 3, 1 << 22])
def few(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    """How many values are sorted in memory: none, or few, or all."""
    monkeypatch.setattr(module, "_FEW", request.param)
    monkeypatch.setattr(module, "_BLOCK", 5)
    return int(request.param)


def in_chunks(values: npt.NDArray[np.float64], size: int = 7) -> Reader:
    return lambda: [values[start : start + size] for start in range(0, len(values), size)]


def assert_same(values: npt.NDArray[np.float64]) -> None:
    """The median is that of NumPy to the last bit; the sign of zero does not count."""
    with np.errstate(all="ignore"):
        expected = np.median(values)
        found = streamed_median(in_chunks(values))
    assert np.array([found + 0.0]).tobytes() == np.array([expected + 0.0]).tobytes()


ANY_FLOATS = st.floats(allow_nan=False)
CLOSE_FLOATS = st.integers(-5, 5).map(lambda step: 1.0 + step * 2.0**-52)


@given(hnp.arrays(np.float64, st.integers(1, 40), elements=ANY_FLOATS | CLOSE_FLOATS))
@settings(deadline=None)
@pytest.mark.usefixtures("few")
def test_median_of_any_numbers(values: npt.NDArray[np.float64]) -> None:
    assert_same(values)


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize(
    "values",
    [
        [0.0],
        [-0.0],
        [-0.0, 0.0, -0.0],
        [np.inf],
        [-np.inf, np.inf],
        [np.inf, np.inf, 3.0, -np.inf],
        [-np.inf, -np.inf],
        [1.7e308, 1.7e308],
        [1.7e308],
        [5e-324, -5e-324, 5e-324, -5e-324],
        [-1.0, -2.0, -3.0, -4.0],
        [1.0] * 9,
    ],
)
def test_median_of_odd_numbers(values: list[float]) -> None:
    assert_same(np.array(values))


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize("n", [1000, 1001])
def test_median_of_many_numbers(n: int) -> None:
    rng = np.random.default_rng(n)
    assert_same(rng.normal(size=n))
    assert_same(rng.normal(size=n) * 1e-9 + 1.0)
    assert_same(np.exp(rng.normal(size=n) * 40.0))


@pytest.mark.slow
@given(hnp.arrays(np.float64, st.integers(1, 30), elements=ANY_FLOATS | CLOSE_FLOATS), st.data())
@settings(deadline=None)
@pytest.mark.usefixtures("few")
def test_order_statistics(values: npt.NDArray[np.float64], data: st.DataObject) -> None:
    ranks = data.draw(st.lists(st.integers(0, len(values) - 1), max_size=5))
    found = streamed_order_statistics(in_chunks(values), lambda _: ranks)
    np.testing.assert_array_equal(found, np.sort(values)[ranks])


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize("n", [1, 2, 3, 1000, 1001])
@pytest.mark.parametrize("percent", [0.0, 5.0, 37.3, 50.0, 95.0, 99.99, 100.0])
def test_percentiles(n: int, percent: float) -> None:
    """Those of NumPy to the last bit."""
    rng = np.random.default_rng(n)
    for values in (rng.normal(size=n), rng.normal(size=n) * 1e-9 + 1.0, np.ones(n)):
        assert streamed_percentile(in_chunks(values), percent) == np.percentile(values, percent)


def test_median_of_a_column(tmp_path: Path) -> None:
    values = np.random.default_rng(0).normal(size=(501, 2)).astype(np.float32)
    column = FileColumn.create(str(tmp_path / "column"), ("f4", (2,)), 501)
    column.write(0, values)
    assert streamed_median(lambda: column.chunks(100)) == np.median(values.astype(np.float64))
    assert streamed_median(lambda: (c[:, 1] for c in column.chunks(100))) == np.median(values[:, 1])


@pytest.mark.usefixtures("few")
def test_numbers_without_a_median() -> None:
    with pytest.raises(InvalidInputError, match="no values"):
        streamed_median(lambda: [])
    with pytest.raises(InvalidInputError, match="no values"):
        streamed_median(lambda: [np.zeros(0)])
    for nan in (np.nan, -np.nan):
        with pytest.raises(InvalidInputError, match="not numbers"):
            streamed_median(in_chunks(np.array([1.0, nan, 2.0])))


@pytest.mark.usefixtures("few")
def test_values_that_change_meanwhile() -> None:
    def read() -> Iterator[npt.NDArray[np.float64]]:
        calls.append(1)
        yield np.arange(10.0)[: 11 - len(calls)] + 5.0 * (len(calls) - 1)

    calls: list[int] = []
    with pytest.raises(InvalidInputError, match="changed"):
        streamed_median(read)
