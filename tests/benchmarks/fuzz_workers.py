"""Judge damaged files in processes of their own, which may crash or hang without harm."""

import itertools
import multiprocessing
import time
from collections.abc import Iterator
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess

from fuzz_trial import Verdict, judged, trial

STALLED = 60.0
"""Seconds of silence after which a process counts as hung: timers do not end compiled loops."""

Judged = tuple[int, str, Verdict]
"""Index of an input, its format, and what it became."""

_CONTEXT = multiprocessing.get_context("spawn")


class _Worker:
    """A process that judges inputs from one place to another and tells of each."""

    process: SpawnProcess
    connection: Connection

    def __init__(self, seed: int, start: int, end: int) -> None:
        self._seed, self._next, self._end = seed, start, end
        self._start()

    @property
    def finished(self) -> bool:
        return self._next >= self._end

    def told(self) -> Judged:
        """What the process tells; if it died, that is the verdict on its input."""
        try:
            judged_one: Judged = self.connection.recv()
        except EOFError:
            self.process.join()
            return self._given_up(f"crash with status {self.process.exitcode}")
        self._heard = time.monotonic()
        self._next = judged_one[0] + 1
        return judged_one

    def stalled(self) -> Judged | None:
        """The verdict on an input that takes forever."""
        if time.monotonic() - self._heard < STALLED:
            return None
        return self._given_up(f"hang of more than {STALLED:g} s")

    def _given_up(self, kind: str) -> Judged:
        self.process.kill()
        self.process.join()
        index, self._next = self._next, self._next + 1
        if not self.finished:
            self._start()
        return index, trial(self._seed, index).format, Verdict(kind, failed=True)

    def _start(self) -> None:
        self.connection, theirs = _CONTEXT.Pipe(duplex=False)
        self.process = _CONTEXT.Process(
            target=_judge, args=(theirs, self._seed, self._next, self._end), daemon=True
        )
        self.process.start()
        theirs.close()
        self._heard = time.monotonic()


def verdicts(seed: int, inputs: int, processes: int) -> Iterator[Judged]:
    """Yield index, format and verdict of every input of a run, in no particular order."""
    ends = [inputs * part // processes for part in range(processes + 1)]
    workers = [_Worker(seed, start, end) for start, end in itertools.pairwise(ends) if start < end]
    try:
        while running := [worker for worker in workers if not worker.finished]:
            ready = wait([worker.connection for worker in running], timeout=1.0)
            for worker in running:
                if worker.connection in ready:
                    yield worker.told()
                elif stalled := worker.stalled():
                    yield stalled
    finally:
        for worker in workers:
            worker.process.kill()


def _judge(connection: Connection, seed: int, start: int, end: int) -> None:
    for index in range(start, end):
        case = trial(seed, index)
        connection.send((index, case.format, judged(case)))
