"""How many points of a cloud are not like the others, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pcsmooth.files.report import PointFacts


def exceptions_in_words(facts: PointFacts, fixed: int = 0) -> list[str]:
    """Say how many points do not take part, or do not move; nothing of counts of 0.

    Parameters
    ----------
    facts : PointFacts
        What was read.
    fixed : int
        Points that stay.
    """
    words = {
        "not finite (passed through)": facts.not_finite,
        "of a noise class or withheld (passed through)": facts.noise_class,
        "fixed": fixed,
    }
    return [f"{count} {what}" for what, count in words.items() if count]
