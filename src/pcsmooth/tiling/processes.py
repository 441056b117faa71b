"""Work on tiles in several processes of this machine, which may die without ending the run."""

from __future__ import annotations

import os
import queue
import signal
import threading
import traceback
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from types import TracebackType
from typing import Any, Self

from pcsmooth.child_processes import deaf_to_interrupts, spawning, when_parent_ends
from pcsmooth.errors import InvalidInputError, PcsmoothError
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.tiling.runner import TileWork, in_order, tile_name

#: Tasks that are handed out at a time, for each process.
_AHEAD = 2


class ProcessRunner:
    """Does work on tiles in processes of its own, each with a share of the cores.

    A process that dies loses the task it was at, and no other: another one takes its place and
    does that task again. Only pickled tasks and results pass between processes. To be closed, or
    used as a context manager; closing ends the processes, whatever they are doing.

    Parameters
    ----------
    processes : int
        How many, >= 1; each needs memory for a tile.
    threads : int, optional
        Threads for the kernels of each, >= 1; by default an equal share of those of this process.
    retries : int
        How often a task is repeated whose process died.

    Raises
    ------
    InvalidInputError
        A number that is too small.
    """

    def __init__(self, processes: int, threads: int | None = None, retries: int = 3) -> None:
        if processes < 1 or (threads is not None and threads < 1) or retries < 0:
            raise InvalidInputError(
                f"no work by {processes} processes of {threads} threads with {retries} retries"
            )
        if threads is None:
            with thread_limit(None) as available:
                threads = max(1, available // processes)
        self._ahead = _AHEAD * processes
        self._retries = retries
        self._workers = [_Worker(threads) for _ in range(processes)]
        self._idle: queue.SimpleQueue[_Worker] = queue.SimpleQueue()
        for worker in self._workers:
            self._idle.put(worker)
        # One for each process: waits for it.
        self._waiters = ThreadPoolExecutor(processes, "tiles")

    def map(self, work: TileWork, tasks: Iterable[tuple[Any, ...]]) -> Iterator[Any]:
        """Call `work(*task)` for each task in one of the processes; see `Runner.map`.

        Raises
        ------
        PcsmoothError
            Every process that tried a task died.
        """
        yield from in_order(partial(self._submit, work), tasks, self._ahead)

    def close(self) -> None:
        """End the processes."""
        for worker in self._workers:
            worker.close()
        self._waiters.shutdown(cancel_futures=True)

    def __enter__(self) -> Self:
        """Give the runner itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close it."""
        self.close()

    def _submit(self, work: TileWork, task: tuple[Any, ...]) -> Future[Any]:
        return self._waiters.submit(self._do, work, task)

    def _do(self, work: TileWork, task: tuple[Any, ...]) -> Any:
        """Have a task done by a process, and by others after it if that dies."""
        worker = self._idle.get()
        try:
            for _ in range(1 + self._retries):
                try:
                    return worker.call(work, task)
                except _DiedError as death:
                    ending = death
        finally:
            self._idle.put(worker)
        raise PcsmoothError(
            f"{tile_name(task)}: {1 + self._retries} processes at work on it died ({ending}), "
            "perhaps for lack of memory; use smaller tiles or fewer processes"
        )


class _DiedError(Exception):
    """A process ended during a task."""


class _Worker:
    """A process that does one task after another, started when there is one.

    Parameters
    ----------
    threads : int
        Threads for its kernels.
    """

    def __init__(self, threads: int) -> None:
        self._threads = threads
        self._process: SpawnProcess | None = None
        self._is_closed = False
        self._lock = threading.Lock()

    def call(self, work: TileWork, task: tuple[Any, ...]) -> Any:
        """Have a task done; returns its result, or raises what it raised, or `_DiedError`."""
        with self._lock:
            if self._is_closed:
                raise PcsmoothError(f"{tile_name(task)}: the processes have been ended")
            if self._process is None:
                self._start()
            process, connection = self._process, self._connection
        assert process is not None
        try:
            connection.send((work, task))
            result, error = connection.recv()
        except (EOFError, ConnectionError) as ending:
            process.join()
            with self._lock:
                connection.close()
                self._process = None
            raise _DiedError(_manner(process.exitcode)) from ending
        if error is not None:
            raise error
        return result

    def close(self) -> None:
        """End the process, and start no more."""
        with self._lock:
            self._is_closed = True
            process = self._process
        if process is not None:
            process.kill()  # nothing of its own is to be put away
            process.join()

    def _start(self) -> None:
        context = spawning()
        self._connection, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, self._threads), daemon=True)
        with deaf_to_interrupts():
            process.start()
        theirs.close()
        self._process = process


def _manner(exit_code: int | None) -> str:
    """Say how a process ended."""
    if exit_code is None or exit_code >= 0:
        return f"exit status {exit_code}"
    try:
        return signal.Signals(-exit_code).name
    except ValueError:
        return f"signal {-exit_code}"


def _serve(connection: Connection, threads: int) -> None:
    """Do tasks until nobody is there any more to send them."""
    when_parent_ends(lambda: os._exit(1))  # even during a task
    with thread_limit(threads):
        while True:
            try:
                work, task = connection.recv()
                outcome = _outcome(work, task)
            except (EOFError, ConnectionError):
                return
            except Exception as error:  # from unpickling; a task's own are caught
                outcome = None, error
            try:
                connection.send(outcome)
            except ConnectionError:
                return
            except Exception as error:
                name = type(outcome[1] or outcome[0]).__name__
                connection.send((None, TypeError(f"a {name} cannot be sent: {error}")))


def _outcome(work: TileWork, task: tuple[Any, ...]) -> tuple[Any, BaseException | None]:
    """Do a task: its result, or what it raised."""
    try:
        return work(*task), None
    except BaseException as error:
        error.add_note(f"in another process:\n{traceback.format_exc()}")
        return None, error
