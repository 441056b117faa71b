"""How work on tiles is handed out: what every engine offers, and the one at hand."""

from __future__ import annotations

from collections import deque
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


class Pending(Protocol):
    """A task that has been handed out."""

    def result(self) -> Any:
        """Wait for what comes of it."""

    def cancel(self) -> object:
        """Forget it, as far as possible; called on tasks that are done, too, and never waits."""


def in_order(
    submit: Callable[[tuple[Any, ...]], Pending], tasks: Iterable[tuple[Any, ...]], ahead: int
) -> Iterator[Any]:
    """Hand out tasks, a few ahead of the one whose result is awaited.

    Parameters
    ----------
    submit : callable
        Hands out a task.
    tasks : iterable of tuple
        The tasks.
    ahead : int
        Most tasks that are handed out at a time, >= 1.

    Yields
    ------
    object
        The results, in the order of the tasks. What is still handed out when one fails, or when
        no more results are asked for, is cancelled.
    """
    waiting: deque[Pending] = deque()
    try:
        for task in tasks:
            waiting.append(submit(task))
            if len(waiting) >= ahead:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        for pending in waiting:
            pending.cancel()


def tile_name(task: tuple[Any, ...]) -> str:
    """Name the tile of a task in messages."""
    return f"tile {task[1]}"
