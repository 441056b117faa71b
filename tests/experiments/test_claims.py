"""Claims to verdicts, rows to tables."""

from __future__ import annotations

import numpy as np
import pytest

from pcsmooth_experiments.claims import in_words, verdict_on
from pcsmooth_experiments.row_tables import table_of


@pytest.mark.parametrize(
    ("claims", "verdict"),
    [
        ([True], "agrees"),
        ([True, True], "agrees"),
        ([True, False], "agrees in part"),
        ([False, np.True_, False], "agrees in part"),
        ([np.False_], "disagrees"),
    ],
)
def test_verdicts(claims: list[bool], verdict: str) -> None:
    assert verdict_on(iter(claims)) == verdict


def test_no_claim_has_no_verdict() -> None:
    with pytest.raises(ValueError, match="there is no claim"):
        verdict_on([])


def test_words() -> None:
    assert (in_words(True), in_words(False)) == ("as reported", "not as reported")


def test_rows_become_columns() -> None:
    table = table_of(("name", "length"), iter([("a", 1.5), ("b", 2.0)]))
    assert {name: column.tolist() for name, column in table.items()} == {
        "name": ["a", "b"],
        "length": [1.5, 2.0],
    }


@pytest.mark.parametrize("rows", [[(1, 2), (3,)], [(1, 2, 3)], []], ids=str)
def test_rows_that_do_not_fit(rows: list[tuple[int, ...]]) -> None:
    with pytest.raises(ValueError, match="zip"):
        table_of(("x", "y"), rows)
