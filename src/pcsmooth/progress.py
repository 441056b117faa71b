"""What a callback is told on the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pcsmooth.record import Record


@dataclass(frozen=True)
class Progress:
    """How far a run is.

    Attributes
    ----------
    stage : str
        What is being done.
    done, total : int
        How many pieces of it are done, and how many there are.
    record : Record, optional
        The state of the cloud, if one has just been reached.
    """

    stage: str
    done: int
    total: int
    record: Record | None = None


#: Is told how far a run is: each time that a piece of a stage is done or a state is reached.
Callback = Callable[[Progress], object]


def ignore(_progress: Progress) -> None:
    """Be told, and do nothing."""
