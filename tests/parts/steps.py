"""Small steps over the parts of a cloud; on their own, so that other processes find them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part


@dataclass(frozen=True, eq=False)
class MeanAround:
    """Write at each point the mean of the points within reach; gives how many pairs there are.

    Sums are taken point by point, in the order of the rows, so that they tell if that changes.
    """

    reach: float
    target: Column

    def __call__(self, part: Part) -> int:
        points, own = part.points, part.own
        means, pairs = np.zeros_like(points), 0
        for i in range(len(points))[own]:
            near = points[np.abs(points - points[i]).max(axis=1) <= self.reach]
            means[i] = np.cumsum(near, axis=0)[-1] / len(near)
            pairs += len(near)
        part.write(self.target, means)
        return pairs


@dataclass(frozen=True, eq=False)
class Copy:
    """Write a column, read at all points, into another; gives the own rows."""

    source: Column
    target: Column
    reach: float = 0.0

    def __call__(self, part: Part) -> tuple[int, int]:
        part.write(self.target, part.read(self.source))
        return part.first, part.stop


@dataclass(frozen=True, eq=False)
class LookAround:
    """Give what a part says of itself."""

    reach: float

    def __call__(self, part: Part) -> tuple[int, int, np.ndarray, np.ndarray, np.ndarray]:
        return part.first, part.stop, part.rows, part.rows[part.own], part.points


@dataclass(frozen=True, eq=False)
class Remember:
    """Make something of a part under a name; gives what came out and how often it was made."""

    key: str

    reach = 0.0

    def __call__(self, part: Part) -> tuple[str, int]:
        made = 0

        def make() -> str:
            nonlocal made
            made += 1
            return f"{self.key} of {len(part.points)}"

        found = part.remember(self.key, make)
        assert part.remember(self.key, make).startswith(self.key)
        return found, made
