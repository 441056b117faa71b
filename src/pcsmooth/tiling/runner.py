"""How work on tiles is handed out: what every engine offers, and the one at hand."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, Protocol

#: A function of the cloud, the number of a tile and more; it may run more than once on a tile.
TileWork = Callable[..., Any]


class Runner(Protocol):
    """Something that does work on tiles."""

    def map(self, work: TileWork, tasks: Iterable[tuple[Any, ...]]) -> Iterator[Any]:
        """Call `work(*task)` for each task, in any order; yield the results in that of the tasks.

        Parameters
        ----------
        work : callable
            A function of a module, so that other processes can find it. What it writes are rows
            of its own tile, always the same.
        tasks : iterable of tuple
            Its arguments.
        """


class InProcess:
    """Does one task after another in this process; kernels share each out among the threads."""

    def map(self, work: TileWork, tasks: Iterable[tuple[Any, ...]]) -> Iterator[Any]:
        """Call `work(*task)` for each task, in order."""
        for task in tasks:
            yield work(*task)
