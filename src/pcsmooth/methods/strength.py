"""Points that go a share of their way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.methods.ends import end_elsewhere
from pcsmooth.methods.method import Moved
from pcsmooth.parts.part import Parts

Floats = npt.NDArray[np.float64]


def go_a_share(parts: Parts, moved: Moved, share: float) -> Moved:
    """Take points back to a share of the way that a method has moved them.

    Parameters
    ----------
    parts : Parts
        The cloud.
    moved : Moved
        Where the method has taken it.
    share : float
        From 0, where all are at their start to the last bit, to 1.

    Returns
    -------
    Moved
        What is left of their errors is that of the share, too.
    """
    if share == 1.0:
        return moved
    return end_elsewhere(parts, moved, _Share(share), "share of the way")


@dataclass(frozen=True)
class _Share:
    share: float

    def __call__(self, _start: Floats, way: Floats) -> tuple[Floats, Floats]:
        return self.share * way, np.full(len(way), self.share)
