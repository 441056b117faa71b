"""Lists of the neighbours of all points, kept where they are short."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

#: Neighbours of a point in the mean whose lists are kept, at most: 96 bytes for each point. Where
#: there are more, they are looked for whenever they are needed.
MOST_KEPT = 24


@dataclass(frozen=True, eq=False)
class NeighborLists:
    """The neighbours of points in grid order.

    Attributes
    ----------
    numbers : ndarray of int32
        Numbers of the neighbours of one after the other, in grid order, and some more.
    ends : ndarray of int, shape (n,)
        Where those of each point end. They begin where those of the point before it do. Empty if
        they are not kept.
    """

    numbers: npt.NDArray[np.int32]
    ends: npt.NDArray[np.int64]

    @classmethod
    def of_blocks(cls, blocks: list[Any], ends: npt.NDArray[np.int64]) -> NeighborLists:
        """Join what a kernel gives for each block: its first point, the one after its last, a list.

        In its list the neighbours of each point end there (n,). Blocks that have been joined are
        dropped, so that there is little more than one copy at a time.
        """
        lengths = [int(ends[stop - 1]) if stop > first else 0 for first, stop, *_ in blocks]
        numbers = np.empty(sum(lengths), np.int32)
        place = 0
        blocks.reverse()
        while blocks:
            first, stop, listed, *_ = blocks.pop()
            if stop == first:
                continue
            length = int(ends[stop - 1])
            numbers[place : place + length] = listed[:length]
            ends[first:stop] += place
            place += length
        return cls(numbers, ends)


#: What kernels are given that are to look for neighbours.
NOT_KEPT = NeighborLists(np.empty(0, np.int32), np.empty(0, np.int64))
