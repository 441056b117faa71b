"""How many points of a cloud are not like the others, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_WORDS = {
    "not_finite": "not finite (passed through)",
    "noise_class": "of a noise class or withheld (passed through)",
    "fixed": "fixed",
}


def exceptions_in_words(summary: Mapping[str, Any]) -> list[str]:
    """Say how many points do not take part, or do not move.

    Parameters
    ----------
    summary : mapping
        Facts about a cloud; counts of 0 or that are not there are left out.

    Examples
    --------
    >>> exceptions_in_words({"not_finite": 0, "fixed": 2})
    ['2 fixed']
    """
    return [f"{summary[key]} {words}" for key, words in _WORDS.items() if summary.get(key)]
