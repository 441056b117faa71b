"""From claims of the thesis that were tested to a verdict."""

from __future__ import annotations

from collections.abc import Iterable

from pcsmooth_experiments.experiment import Verdict


def verdict_on(claims: Iterable[bool]) -> Verdict:
    """Sum up which claims hold: all of them, some, or none.

    Raises
    ------
    ValueError
        If there is no claim.
    """
    held = [bool(claim) for claim in claims]
    if not held:
        raise ValueError("there is no claim to sum up")
    return "agrees" if all(held) else "agrees in part" if any(held) else "disagrees"


def in_words(claim: bool) -> str:
    """Say whether a claim of the thesis holds."""
    return "as reported" if claim else "not as reported"
