from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from pcsmooth.parts import exact_sums
from pcsmooth.parts.exact_sums import exact_sum, total_of

Values = npt.NDArray[np.float64]

#: All that lengths, areas and volumes can be, and far beyond.
FLOATS = st.floats(-1e290, 1e290)
CLOSE_FLOATS = st.integers(-5, 5).map(lambda step: 1.0 + step * 2.0**-52)


@pytest.fixture(params=[1, 5, 1 << 14])
def block(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    """How many values are summed up at a time: one, a few, or all."""
    monkeypatch.setattr(exact_sums, "_BLOCK", request.param)
    return int(request.param)


def total_in_parts(values: Values, cuts: list[int]) -> float:
    return total_of(exact_sum(part) for part in np.split(values, sorted(cuts)))


@given(
    hnp.arrays(np.float64, st.integers(0, 40), elements=FLOATS | CLOSE_FLOATS),
    st.lists(st.integers(0, 40), max_size=4),
    st.randoms(use_true_random=False),
)
@settings(deadline=None)
@pytest.mark.usefixtures("block")
def test_sums_are_exact_whatever_the_order_and_the_parts(
    values: Values, cuts: list[int], random: st.DataObject
) -> None:
    expected = math.fsum(values)
    assert total_of([exact_sum(values)]) == expected
    shuffled = values.copy()
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    assert total_in_parts(shuffled, cuts) == expected


def wide(n: int, seed: int = 0) -> Values:
    """Numbers of either sign with exponents from the least to nearly the largest."""
    rng = np.random.default_rng(seed)
    return np.asarray(np.ldexp(rng.normal(size=n), rng.integers(-1074, 960, n)))


@pytest.mark.parametrize(
    "values",
    [
        wide(70_000),  # several blocks
        np.r_[wide(30_000), -wide(30_000)[::-1], [2.0**-1074]],
        np.random.default_rng(1).random(100_000),
        np.full(50_000, 0.1),
        np.array([1e200, 1.0, -1e200, 1e-200]),
        np.full(9, 5e-324),
        np.array([-0.0, 0.0, -0.0]),
        np.array([2.0**900, -(2.0**900)]),
    ],
    ids=["wide", "what is left of wide", "many", "tenths", "four", "least", "zeros", "nothing"],
)
@pytest.mark.parametrize("parts", [1, 7])
def test_sums_of_many_numbers_are_exact(values: Values, parts: int) -> None:
    order = np.random.default_rng(parts).permutation(len(values))
    cuts = np.random.default_rng(2).integers(0, len(values), parts - 1)
    assert total_in_parts(values[order], cuts.tolist()) == math.fsum(values)


def test_few_numbers_stand_for_many() -> None:
    """Parts tell them to each other."""
    lengths = np.random.default_rng(3).random(1_000_000)
    assert len(exact_sum(lengths)) < 400


def test_shape_and_layout_do_not_matter() -> None:
    values = wide(600).reshape(10, 20, 3)
    expected = math.fsum(values.ravel())
    for same in (values, values.T, values[::-1], np.asfortranarray(values)):
        assert total_of([exact_sum(same)]) == expected
    assert total_of([exact_sum(values[:, ::2])]) == math.fsum(values[:, ::2].ravel())


def test_values_are_left_alone() -> None:
    values = wide(100)
    values.flags.writeable = False
    exact_sum(values)


def test_nothing_adds_up_to_zero() -> None:
    assert exact_sum(np.empty(0)) == ()
    assert exact_sum(np.empty((0, 3))) == ()
    assert total_of([]) == 0.0
    assert total_of([(), exact_sum(np.zeros(5)), ()]) == 0.0


@pytest.mark.parametrize("endless", [math.inf, -math.inf])
def test_infinite_values_give_an_infinite_sum(endless: float) -> None:
    values = np.r_[wide(100), endless, wide(100)]
    assert exact_sum(values) == (endless,)
    assert total_of([exact_sum(wide(50)), exact_sum(values)]) == endless


@pytest.mark.parametrize("others", [[], [1.0, math.inf], [1e300]])
def test_what_is_no_number_gives_none(others: list[float]) -> None:
    (found,) = exact_sum(np.array([math.nan, *others]))
    assert math.isnan(found)
    assert math.isnan(total_of([(1.0,), (found,)]))


def test_values_near_the_largest_are_added_as_they_come() -> None:
    values = np.array([1e305, -3e304, 1e290, 1.0])
    assert total_of([exact_sum(values)]) == pytest.approx(math.fsum(values), rel=1e-15)
