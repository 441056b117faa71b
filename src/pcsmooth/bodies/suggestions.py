"""What to write in place of a word that is not known."""

from __future__ import annotations

from collections.abc import Collection
from difflib import get_close_matches


def suggestion(word: str, known: Collection[str]) -> str:
    """Name the known words that are near, or all of them.

    >>> suggestion("cub", ["cube", "sphere-50"])
    'did you mean cube?'
    >>> suggestion("torus", ["cube", "sphere-50"])
    'use one of cube, sphere-50'
    """
    close = get_close_matches(word, sorted(known))
    if close:
        return f"did you mean {' or '.join(close)}?"
    return f"use one of {', '.join(sorted(known))}"
